// Speed against error: the medians of a benchmark's repeats, both axes logarithmic.

// Colours that people with any colour vision tell apart (Okabe and Ito, 2008); dashes and numbers say the same.
const LINES = ["#f0e442", "#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#d55e00", "#ffffff"];
const DASHES = [[], [8, 4], [2, 4], [8, 4, 2, 4]];

/** Rows of `bench.csv` as objects. Only names are quoted; none holds a quote. */
function rowsOf(text) {
  const [names, ...rows] = text.trim().split("\n").map((line) => line.match(/"[^"]*"|[^,]+/g).map((cell) => cell.replaceAll('"', "")));
  return rows.map((row) => Object.fromEntries(names.map((name, k) => [name, row[k]])));
}

/** For each technique its points, seconds and error, by rising seconds. */
function curvesOf(rows) {
  const middle = (values) => values.sort((a, b) => a - b)[values.length >> 1];
  const curves = new Map();
  for (const { technique, effort } of rows) {
    if (!curves.has(technique)) curves.set(technique, new Map());
    curves.get(technique).set(effort, null);
  }
  return [...curves].map(([name, efforts]) => {
    const points = [...efforts.keys()].map((effort) => {
      const own = rows.filter((row) => row.technique === name && row.effort === effort);
      return { effort, seconds: middle(own.map((row) => Number(row.cpu_seconds))), rmse: middle(own.map((row) => Number(row.rmse))) };
    });
    return { name, points: points.filter((p) => p.seconds > 0 && p.rmse > 0).sort((a, b) => a.seconds - b.seconds) };
  }).filter((curve) => curve.points.length);
}

function plot() {
  const curves = head.bench ? curvesOf(rowsOf(head.bench)) : [];
  $("benchmark").hidden = !curves.length;
  if (!curves.length) return;
  const pen = $("curves").getContext("2d"), { width, height } = $("curves");
  const box = { left: 100, right: width - 16, top: 16, bottom: height - 48 };
  const scale = (of, from, to) => {
    const all = curves.flatMap((curve) => curve.points.map(of)), low = Math.log(Math.min(...all) / 1.3), high = Math.log(Math.max(...all) * 1.3);
    const at = (value) => from + (to - from) * (Math.log(value) - low) / (high - low);
    // Powers of ten, and 2 and 5 times them where fewer than three fall inside.
    const decades = (steps) => Array.from({ length: 40 }, (_, k) => k - 20).flatMap((e) => steps.map((s) => Number(`${s}e${e}`)))
      .filter((value) => Math.log(value) > low && Math.log(value) < high);
    const tens = decades([1]);
    return { at, ticks: tens.length > 2 ? tens : decades([1, 2, 5]) };
  };
  const x = scale((p) => p.seconds, box.left, box.right), y = scale((p) => p.rmse, box.bottom, box.top);
  pen.font = "22px system-ui, sans-serif";
  pen.strokeStyle = "#36383d";
  pen.fillStyle = "#e8e8e8";
  const line = (points, style) => {
    Object.assign(pen, style);
    pen.beginPath();
    points.forEach(([a, b], k) => (k ? pen.lineTo(a, b) : pen.moveTo(a, b)));
    pen.stroke();
  };
  pen.textAlign = "center";
  for (const tick of x.ticks) { line([[x.at(tick), box.top], [x.at(tick), box.bottom]], { lineWidth: 1 }); pen.fillText(digits(tick), x.at(tick), box.bottom + 28); }
  pen.textAlign = "right";
  for (const tick of y.ticks) { line([[box.left, y.at(tick)], [box.right, y.at(tick)]], { lineWidth: 1 }); pen.fillText(digits(tick), box.left - 8, y.at(tick) + 8); }
  const legend = document.createElement("ol");
  curves.forEach((curve, k) => {
    const color = LINES[k % LINES.length], places = curve.points.map((p) => [x.at(p.seconds), y.at(p.rmse)]);
    pen.setLineDash(DASHES[k % DASHES.length]);
    line(places, { strokeStyle: color, lineWidth: 3 });
    pen.setLineDash([]);
    pen.fillStyle = color;
    for (const [a, b] of places) { pen.beginPath(); pen.arc(a, b, 6, 0, 7); pen.fill(); }
    const [endX, endY] = places[places.length - 1];
    pen.textAlign = "left";
    pen.fillText(k + 1, Math.min(endX + 10, box.right), endY + 8);
    const item = document.createElement("li"), best = curve.points[curve.points.length - 1];
    item.style.color = color;
    item.textContent = `${curve.name}: ${digits(best.rmse)} after ${digits(best.seconds)} s`;
    legend.append(item);
  });
  $("axes").textContent = "Root mean square error (up) against CPU seconds of the bake (right), from bench.csv beside the bake.";
  $("axes").after(legend);
}
