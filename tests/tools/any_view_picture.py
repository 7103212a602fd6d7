"""The picture of docs/layers.md: a body by bakes of single views, by one bake for any view, and four times the difference.

    python tests/tools/any_view_picture.py target/release/ambake ../shared/models/suzi.glb docs/any-view.jpg

Needs the packages OpenEXR, numpy and Pillow. For each eye the Phong layer of a bake for that eye is replaced by what the numbers of the bake
for any view give, by the steps of STEM.any-view.glsl, and `ambake render --bake` draws both.
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image

EYES = ["1.6,1.0,4.0", "-3.5,1.5,2.0", "0.5,4.0,2.0"]
EXPONENT = 20.0
MATERIAL = ["--exponent", "20", "--albedo", "0.1,0.1,0.1", "--specular", "0.6,0.6,0.6"]
PLAIN = ["--size", "512", "--rays", "128", "--seams", "off", "--quiet"]


def channels(path):
    return {name: c.pixels for name, c in OpenEXR.File(str(path), separate_channels=True).channels().items()}


def vectors(page, layer):
    return np.stack([page[f"{layer}.{axis}"] for axis in "XYZ"], -1).astype(float)


def unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-9)


def any_view(page, kernel, view, order=8):
    """The specular term of each texel for the unit vectors to the eye."""
    normal = unit(vectors(page, "normal"))
    axis, along = np.array([2, 6, 3]) / 7, np.array([6, -3, 2]) / 7
    tangent = along - (axis + normal) * ((normal @ along) / (1 + normal @ axis))[..., None]
    bitangent = np.cross(normal, tangent)
    turn = -(view * tangent).sum(-1) - 1j * (view * bitangent).sum(-1)
    sine = np.abs(turn)
    turn = np.where(sine > 1e-6, turn / np.maximum(sine, 1e-9), 1)
    column = np.arctan2(sine, np.maximum((normal * view).sum(-1), 0)) / (np.pi / 2) * 48
    left = np.clip(column.astype(int), 0, 47)
    right, row = column - left, 4 * np.log2(EXPONENT + 1)
    low = row - int(row)
    total, open_term, block = 0, None, 0
    for l in range(order + 1):
        for m in range(l % 2, l + 1, 2):
            rows = kernel[block + int(row)] * (1 - low) + kernel[block + int(row) + 1] * low
            k = rows[left] * (1 - right) + rows[left + 1] * right
            even, odd = (page[f"any-view.8.{l * (l + 1) // 2 + (l + s * m) // 2:02d}"] for s in (1, -1))
            total = total + k * ((turn**m).real * even + (m > 0) * (turn**m).imag * odd)
            open_term = k if l == 0 else open_term
            block += 33
    return np.clip(total, 0, open_term)


def srgb(x):
    x = np.clip(x, 0, 1)
    return np.where(x < 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def main(ambake, scene, out):
    def run(*words):
        subprocess.run([ambake, *map(str, words)], check=True)

    with tempfile.TemporaryDirectory() as folder:
        folder, stem, columns = Path(folder), Path(scene).stem, []
        run("bake", scene, "-o", folder / "any", *PLAIN, *MATERIAL, "--layers", "any-view.8,normal,position")
        page = channels(folder / "any" / f"{stem}.0.exr")
        kernel = channels(folder / "any" / f"{stem}.any-view.exr")["Y"]
        for eye in EYES:
            single, both = folder / "single", folder / "both"
            shutil.rmtree(both, ignore_errors=True)
            run("bake", scene, "-o", single, *PLAIN, *MATERIAL, "--only", "phong,lambert,specular,reflectance,coverage", f"--view={eye}")
            shutil.copytree(single, both)
            file = OpenEXR.File(str(single / f"{stem}.0.exr"), separate_channels=True)
            own = file.channels()
            view = unit(np.array([float(x) for x in eye.split(",")]) - vectors(page, "position"))
            term, covered = any_view(page, kernel, view), page["coverage"] > 0
            faces = covered & ((vectors(page, "normal") * view).sum(-1) > 0.1)
            off = (term - own["specular"].pixels)[faces]
            print(f"{eye}: {faces.sum()} texels that face the eye, root mean square {np.sqrt((off**2).mean()):.3f}, mean {off.mean():+.4f}")
            for c in "RGB":
                shown = own[f"lambert.{c}"].pixels + own[f"reflectance.{c}"].pixels * term
                own[f"phong.{c}"].pixels = np.where(covered, shown, own[f"phong.{c}"].pixels).astype(np.float32)
            file.write(str(both / f"{stem}.0.exr"))
            pictures = []
            for bake in (single, both):
                camera = ["--eye=" + eye, "--look", "0,0,0", "--fov-deg", "27", "--size", "300x240", "--background", "0.1,0.13,0.2"]
                run("render", scene, "-o", folder / "x.exr", "--bake", bake, *camera, "--quiet")
                found = channels(folder / "x.exr")
                pictures.append(np.stack([found[c] for c in "RGB"], -1))
            difference = pictures[1] - pictures[0]
            print(f"  picture: root mean square {np.sqrt((difference**2).mean()):.4f}, largest {np.abs(difference).max():.2f}")
            columns.append(np.concatenate([*map(srgb, pictures), np.clip(0.5 + 4 * difference, 0, 1)]))
    sheet = (255 * np.concatenate(columns, 1) + 0.5).astype(np.uint8)
    Image.fromarray(sheet).save(out, quality=82, optimize=True)


main(*sys.argv[1:])
