"""The table and the picture of rows that run.py measured."""

import math
import os
import platform
import statistics

# Error of the peer, error of ambake, title, and the modes of ambake that are read.
ERRORS = [
    ("rmse_area", "rmse_area", "Error against averages over the texels' areas", ["default", "diffuse", "plain"]),
    ("rmse_centre", "rmse_centre", "Error against values at texel centres", ["centre", "centre plain"]),
    ("rmse_own", "rmse_area", "The peer's sampling error alone, ambake's whole error against areas", ["default", "diffuse", "plain"]),
]


def at_rmse(points, target):
    """Cost at an RMSE, logarithms interpolated between ray counts, and whether it was reached by fewer rays than were measured.

    None where it was not reached."""
    points = sorted(points, reverse=True)
    if points[0][0] <= target:
        return points[0][1], True
    for (e0, c0), (e1, c1) in zip(points, points[1:]):
        if e0 >= target >= e1:
            t = math.log(target / e0) / math.log(e1 / e0)
            return c0 ** (1 - t) * c1**t, False
    return None


def summarise(rows, bias, names, arguments):
    cells, rays, repeats = {}, {}, {}
    for row in rows:
        repeats[row["scene"]] = range(max(row["repeat"] + 1, len(repeats.get(row["scene"], ()))))
        cells[row["scene"], row["baker"], row["rays"], row["repeat"]] = row
        rays.setdefault((row["scene"], row["baker"]), set()).add(row["rays"])

    def median(scene, kind, count, column):
        return statistics.median(cells[scene, kind, count, k][column] for k in repeats[scene])

    lines = ["# CPU seconds at equal RMSE", "",
             "User + system, medians of the repeats. `bake` is the bake alone, `process` the whole program with reading, layout and writing.",
             "A ratio is the peer's seconds over ambake's in the same repeat, with the least and the largest in brackets. \"At least\" stands",
             "where ambake's fewest rays already have a smaller error than the peer; a dash where its most rays do not."]  # fmt: skip
    for theirs, ours, title, modes in ERRORS:
        lines += ["", f"{title}:", "",
                  f"| scene | peer, {arguments.rays} rays | RMSE | bake s | process s | ambake | rays | bake s | ratio | process s | ratio |",
                  "|---|---|---|---|---|---|---|---|---|---|---|"]  # fmt: skip
        for scene, kind in bias:
            count = arguments.rays
            target = median(scene, kind, count, theirs)
            peer = [scene, names[kind], f"{target:.5f}"] + [f"{median(scene, kind, count, c):.2f}" for c in ("cpu_bake", "cpu_process")]
            for mode in modes:
                def reach(column, k):
                    points = [(cells[scene, mode, n, k][ours], cells[scene, mode, n, k][column]) for n in rays[scene, mode]]
                    return at_rmse(points, cells[scene, kind, count, k][theirs])

                own = [reach("rays", k) for k in repeats[scene]]
                if None in own:
                    lines.append("| " + " | ".join([*peer, names[mode], *["-"] * 5]) + " |")
                    continue
                least = any(bounded for _, bounded in own)
                line = [*peer, names[mode], f"{statistics.median(n for n, _ in own):.0f}"]
                for column in ("cpu_bake", "cpu_process"):
                    costs = [reach(column, k)[0] for k in repeats[scene]]
                    ratios = [cells[scene, kind, count, k][column] / cost for k, cost in zip(repeats[scene], costs)]
                    ratio = f"{statistics.median(ratios):.1f} ({min(ratios):.1f} to {max(ratios):.1f})"
                    line += [f"{statistics.median(costs):.2f}", f"at least {ratio}" if least else ratio]
                lines.append("| " + " | ".join(line) + " |")
    lines += ["", "Every bake:", "", "| scene | baker | rays | against areas | against centres | sampling error | bake s | process s |",
              "|---|---|---|---|---|---|---|---|"]  # fmt: skip
    for scene, kind in rays:
        for n in sorted(rays[scene, kind]):
            values = [median(scene, kind, n, c) for c in ("rmse_area", "rmse_centre", "rmse_own", "cpu_bake", "cpu_process")]
            values = [f"{value:.5f}" for value in values[:3]] + [f"{value:.2f}" for value in values[3:]]
            lines.append(f"| {scene} | {names[kind]} | {n} | " + " | ".join(values) + " |")
    lines += ["", "What the peers converge to, minus ambake, over the texels that are wholly inside a chart:", "",
              "| scene | peer | areas: mean | RMS | centres: mean | RMS |", "|---|---|---|---|---|---|"]  # fmt: skip
    for (scene, kind), (mean, spread, at_centre, spread_centre) in bias.items():
        lines.append(f"| {scene} | {names[kind]} | {mean:+.5f} | {spread:.4f} | {at_centre:+.5f} | {spread_centre:.4f} |")
    versions = "; ".join(sorted({row["version"] for row in rows}))
    lines += ["", f"Python {platform.python_version()}, {os.cpu_count()} CPUs, {arguments.size}x{arguments.size} texels. {versions}."]
    return "\n".join(lines) + "\n"


def picture(rows, names):
    """RMSE against area averages over CPU seconds of the bake, one frame a scene: ambake lines, each peer a dot."""
    rows = [row for row in rows if not row["baker"].startswith("centre")]
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    kinds = list(dict.fromkeys(row["baker"] for row in rows))
    colours = dict(zip(kinds, ["#d1495b", "#edae49", "#66a182", "#a0713d", "#1b6ca8", "#7b5ea7", "#333", "#2aa198"]))
    edge, pad = 300, 50
    points = {}
    for row in rows:
        points.setdefault((row["scene"], row["baker"], row["rays"]), []).append((row["cpu_bake"], row["rmse_area"]))
    points = {key: [statistics.median(axis) for axis in zip(*values)] for key, values in points.items()}
    spans = [[min(axis), max(axis)] for axis in zip(*points.values())]

    def place(axis, value):
        low, high = (math.log10(max(v, 1e-9)) for v in spans[axis])
        share = (math.log10(max(value, 1e-9)) - low) / max(high - low, 1e-9)
        return pad + (edge - 2 * pad) * (share if axis == 0 else 1 - share)

    parts = []
    for column, scene in enumerate(scenes):
        parts.append(f'<g transform="translate({column * edge})"><text x="{pad}" y="20">{scene}</text>')
        parts.append(f'<rect x="{pad - 8}" y="{pad - 8}" width="{edge - 2 * pad + 16}" height="{edge - 2 * pad + 16}" fill="none" stroke="#888"/>')
        parts.append(f'<text x="{pad}" y="{edge - 14}">CPU s, {spans[0][0]:.2g} to {spans[0][1]:.2g}</text>')
        parts.append(f'<text x="{pad}" y="36">RMSE, {spans[1][0]:.2g} to {spans[1][1]:.2g}</text>')
        for kind in kinds:
            at = sorted([place(0, c), place(1, e)] for (s, k, _), (c, e) in points.items() if (s, k) == (scene, kind))
            line = " ".join(f"{x:.1f},{y:.1f}" for x, y in at)
            parts.append(f'<polyline points="{line}" fill="none" stroke="{colours[kind]}"/>')
            parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colours[kind]}"/>' for x, y in at]
        parts.append("</g>")
    for row, kind in enumerate(kinds):
        parts.append(f'<text x="{pad + 150 * row}" y="{edge + 14}" fill="{colours[kind]}">{names[kind]}</text>')
    width = max(edge * len(scenes), pad + 150 * len(kinds))
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{edge + 24}" font-family="sans-serif" font-size="11">'
    return "\n".join([head, f'<rect width="{width}" height="{edge + 24}" fill="white"/>', *parts, "</svg>"]) + "\n"
