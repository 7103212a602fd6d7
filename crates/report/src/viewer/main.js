// The page: what is shown, what is picked, and the tables beside it.

const state = { view: null, part: 0, picked: null, page: 0, ranges: new Map(), first: null };
let list, painter, meshes, pictures, instances, camera, balls = null;

/** The layers and the numbers that a view asks of the painter. */
function look() {
  const view = state.view, factor = 2 ** Number($("exposure").value);
  const base = { part: 0, factor, low: 0, high: 1, first: 0, second: 0, kind: view.kind };
  if (view.kind === "models") {
    const slide = Math.min(Number($("model").value) / 2 * (view.models.length - 1), view.models.length - 1);
    const left = Math.min(Math.floor(slide), view.models.length - 2);
    // At an end of the slider one model is enough.
    const [first, second] = [left + (slide - left === 1), left + (slide > left)].map((at) => view.models[at].layer);
    return { ...base, first, second, part: slide - left };
  }
  const [low, high] = state.ranges.get(view.name) || [0, 1];
  const first = view.layers[0] ?? 0;
  if (view.kind === "live") Object.assign(base, { layers: view.layers, coloured: view.coloured, sky: view.sky });
  return { ...base, first, second: view.layers[1] ?? first, low, high };
}

/** The value that a view shows of a texel, a number or a triple. */
function valueOf(view, channels, i) {
  const triple = (planes) => (planes.length >= 3 ? planes.slice(0, 3) : [planes[0], planes[0], planes[0]]).map((plane) => HALVES[plane[i]]);
  if (view.kind === "difference") {
    const d = sub(triple(channels[0]), triple(channels[1]));
    return d.reduce((most, x) => Math.abs(x) > Math.abs(most) ? x : most, 0);
  }
  if (view.kind === "heat" || view.kind === "grey") return HALVES[channels[0][0][i]];
  if (view.kind !== "models") return triple(channels[0]);
  const [a, b] = [triple(channels[0]), triple(channels[1])], part = look().part;
  return a.map((x, k) => x + (b[k] - x) * part);
}

/** The bytes of a value's colour. */
function colorOf(view, value, current) {
  if (view.kind === "difference") return signed(value / current.high);
  if (view.kind === "heat") return heat((value - current.low) / (current.high - current.low));
  if (view.kind === "vector") return value.map((x) => 127.5 * (x + 1));
  return [value].flat().concat(value, value).slice(0, 3).map((x) => byteOf(x * current.factor));
}

/** Every layer that a view reads on a page. */
function channelsOf(view, page) {
  const current = look();
  const layers = view.kind === "models" || view.kind === "difference" ? [current.first, current.second] : [current.first];
  return Promise.all(layers.map((layer) => layerOn(page, layer)));
}

/** The limits of a scale: what 99 % of the texels of all pages stay below. */
async function measure(view) {
  if (state.ranges.has(view.name) || !["heat", "difference", "density"].includes(view.kind)) return;
  if (view.kind === "density") {
    const known = (head.bake.layout && head.bake.layout.texels_per_unit) || {};
    const middle = Math.log2(known.median || 1);
    state.ranges.set(view.name, [middle - 2, middle + 2]);
    return;
  }
  const values = [];
  for (let page = 0; page < head.pages.length; page++) {
    const [cover, channels] = [await coverOn(page), await channelsOf(view, page)];
    for (let i = 0; i < cover.length; i += 1 + (cover.length >> 18)) if (cover[i]) values.push(Math.abs(valueOf(view, channels, i)));
  }
  values.sort((a, b) => a - b);
  const most = values[Math.floor(0.99 * (values.length - 1))] || values[values.length - 1] || 1;
  state.ranges.set(view.name, [0, most]);
}

let asked = false;
/** Draws soon, once. */
function redraw() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => { asked = false; paint(); });
}

function paint() {
  const canvas = $("scene"), over = $("over"), sharp = Math.min(window.devicePixelRatio || 1, 2);
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((n) => Math.max(1, Math.round(n * sharp)));
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [over.width, over.height] = [width, height];
  const current = look();
  painter.draw(camera, instances, head.radius, current, $("backs").checked);
  if (balls) balls.draw(camera.matrix(width / height, head.radius), current.factor);
  state.first ??= performance.now();
  const pen = over.getContext("2d");
  pen.clearRect(0, 0, width, height);
  if (state.picked) {
    const [x, y, z] = state.picked.point, m = camera.matrix(width / height, head.radius);
    const clip = [0, 1, 2, 3].map((r) => m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r]);
    if (clip[3] > 0) cross2d(pen, (clip[0] / clip[3] + 1) / 2 * width, (1 - clip[1] / clip[3]) / 2 * height, 9 * sharp);
  }
  if (walking()) cross2d(pen, width / 2, height / 2, 4 * sharp);
}

/** A mark that is seen on light and dark. */
function cross2d(pen, x, y, r) {
  for (const [style, wide] of [["#000", 4], ["#ffd24a", 2]]) {
    pen.strokeStyle = style;
    pen.lineWidth = wide;
    pen.beginPath();
    pen.moveTo(x - r, y); pen.lineTo(x + r, y);
    pen.moveTo(x, y - r); pen.lineTo(x, y + r);
    pen.stroke();
  }
}

const walking = () => document.querySelector("input[name=move]:checked").value === "walk";

/** Shows another view: its textures, scale, page and histogram. */
async function show() {
  state.view = list.find((view) => view.name === $("view").value) || list[0];
  const view = state.view;
  $("modelRow").hidden = $("models").hidden = view.kind !== "models";
  await measure(view);
  const current = look();
  const used = new Set(meshes.map((mesh) => mesh.page).filter((page) => page >= 0));
  if (view.kind !== "density") {
    const layers = new Set([current.first, current.second, ...(current.layers || [])]);
    if (view.kind === "live") await Promise.all([...used].map((page) => painter.live.need(page)));
    await Promise.all([...used].flatMap((page) => [...layers].map((layer) => painter.need(page, layer))));
  }
  legend(view, current);
  redraw();
  // The picture comes before what stands beside it.
  await new Promise((drawn) => requestAnimationFrame(drawn));
  await Promise.all([sheet(), histogram()]);
}

function legend(view, current) {
  const scaled = ["heat", "difference", "density"].includes(view.kind);
  $("legend").hidden = !scaled;
  if (!scaled) return;
  const pen = $("ramp").getContext("2d");
  for (let x = 0; x < 256; x++) {
    const color = view.kind === "difference" ? signed(2 * x / 255 - 1) : heat(x / 255);
    pen.fillStyle = `rgb(${color.map(Math.round)})`;
    pen.fillRect(x, 0, 1, 12);
  }
  const shown = (x) => digits(view.kind === "density" ? 2 ** x : x);
  $("low").textContent = view.kind === "difference" ? `-${shown(current.high)}` : shown(current.low);
  $("high").textContent = shown(current.high);
  $("what").textContent = view.kind === "density" ? "texels per scene unit" : view.name;
}

/** Draws the page with the picked texel. */
async function sheet() {
  const canvas = $("sheet"), pen = canvas.getContext("2d"), edge = canvas.width;
  const page = state.page, size = head.pages[page].size, view = ["density", "live"].includes(state.view.kind) ? list[0] : state.view;
  const [cover, channels] = await Promise.all([coverOn(page), channelsOf(view, page)]);
  const picture = pen.createImageData(edge, edge), current = look();
  for (let y = 0; y < edge; y++) for (let x = 0; x < edge; x++) {
    const i = Math.floor((y + 0.5) * size / edge) * size + Math.floor((x + 0.5) * size / edge);
    const color = cover[i] ? colorOf(view, valueOf(view, channels, i), current) : [40, 42, 46];
    picture.data.set([...color, 255], 4 * (y * edge + x));
  }
  pen.putImageData(picture, 0, 0);
  if (state.picked && state.picked.page === page) cross2d(pen, state.picked.uv[0] * edge, state.picked.uv[1] * edge, 8);
}

/** Draws how many texels of all pages have which value. */
async function histogram() {
  const view = ["density", "live"].includes(state.view.kind) ? list[0] : state.view, bins = new Float64Array(85), values = [];
  for (let page = 0; page < head.pages.length; page++) {
    const [cover, channels] = [await coverOn(page), await channelsOf(view, page)];
    for (let i = 0; i < cover.length; i += 1 + (cover.length >> 18)) {
      if (!cover[i]) continue;
      const value = valueOf(view, channels, i);
      values.push(Array.isArray(value) ? 0.2126 * value[0] + 0.7152 * value[1] + 0.0722 * value[2] : value);
    }
  }
  const sorted = Float64Array.from(values).sort(), last = sorted.length - 1;
  const low = Math.min(0, sorted[Math.floor(0.001 * last)] || 0), high = sorted[Math.floor(0.999 * last)] || 1;
  for (const value of values) bins[Math.min(Math.max(Math.floor((value - low) / (high - low || 1) * 85), 0), 84)] += 1;
  const pen = $("bars").getContext("2d"), most = Math.max(...bins, 1);
  pen.clearRect(0, 0, 340, 110);
  pen.fillStyle = "#ffd24a";
  bins.forEach((count, k) => pen.fillRect(4 * k, 110 - 108 * count / most, 3, 108 * count / most));
  const mean = values.reduce((a, b) => a + b, 0) / Math.max(values.length, 1);
  $("range").textContent = `${view.label}: ${digits(low)} to ${digits(high)}, mean ${digits(mean)}, median ${digits(sorted[last >> 1] || 0)}`;
}

/** Picks what is at a place of the canvas, -1 to 1 to the right and up. */
async function pickAt(x, y) {
  const aspect = $("scene").clientWidth / $("scene").clientHeight;
  const hit = pick(meshes, pictures, instances, camera.eye, camera.ray(x, y, aspect), $("backs").checked);
  state.picked = hit;
  redraw();
  if (!hit) {
    $("texel").textContent = "Nothing is there.";
    return null;
  }
  const rows = [["object", instances[hit.instance].name], ["triangle", hit.triangle], ["position", add(hit.point, head.origin).map(digits).join(", ")]];
  if (hit.page < 0) {
    table($("texel"), null, [...rows, ["texel", "none: the object takes no texels"]]);
    return { object: rows[0][1], page: -1, point: add(hit.point, head.origin) };
  }
  const { size, texels } = head.pages[hit.page];
  const place = (edge) => hit.uv.map((t) => Math.min(Math.floor(t * edge), edge - 1));
  const [column, row] = place(size), found = { object: instances[hit.instance].name, page: hit.page, texel: place(texels), uv: hit.uv, point: add(hit.point, head.origin), values: {} };
  const i = row * size + column;
  rows.push(["page", hit.page], ["texel", found.texel.join(", ")], ["u, v", hit.uv.map((t) => t.toFixed(5)).join(", ")]);
  state.page = hit.page;
  $("page").value = hit.page;
  const read = async (name) => (await layerOn(hit.page, layerIndex(name))).map((plane) => HALVES[plane[i]]);
  for (const layer of head.layers) {
    if (layer.name === "error" || layer.name.startsWith("error.")) continue;
    const values = await read(layer.name);
    const error = layer.name === "diffuse" ? "error" : `error.${layer.name}`;
    const spread = layerIndex(error) >= 0 ? ` ± ${digits((await read(error))[0])}` : "";
    found.values[layer.name] = values;
    rows.push([layer.name, values.map(digits).join(", ") + spread]);
  }
  table($("texel"), null, rows);
  await sheet();
  return found;
}

/** A table of rows in an element; texts are texts, whatever they hold. */
function table(parent, heads, rows) {
  const made = document.createElement("table");
  for (const cells of [heads, ...rows].filter(Boolean)) {
    const row = made.insertRow();
    for (const cell of cells) {
      const box = document.createElement(cells === heads ? "th" : "td");
      box.textContent = typeof cell === "number" ? (Number.isInteger(cell) ? cell.toLocaleString("en") : digits(cell)) : String(cell ?? "");
      if (typeof cell === "number") box.className = "number";
      row.append(box);
    }
  }
  parent.replaceChildren(made);
}

function tables() {
  const bake = head.bake, layout = bake.layout || {};
  const fold = (name, heads, rows, open) => {
    if (!rows.length) return;
    const details = document.createElement("details"), summary = document.createElement("summary"), box = document.createElement("div");
    summary.textContent = `${name} (${rows.length})`;
    details.open = Boolean(open);
    table(box, heads, rows.slice(0, 500));
    details.append(summary, box);
    $("tables").append(details);
  };
  const text = (value) => typeof value === "string" ? value : JSON.stringify(value);
  fold("Warnings", ["what", "times", "where"], (bake.warnings || []).map((w) => [w.message, w.count, w.place].map((cell) => typeof cell === "string" ? cell.replaceAll("`", "") : cell)), true);
  fold("Plan", ["term", "how", "why"], (bake.plan || []).map((p) => [p.decision, p.method || (p.modelled ? "modelled" : "left out"), p.reason]));
  fold("Pages", ["page", "texels", "use", "RMSE", "worst"], (bake.pages || []).map((p) => [p.page, p.texels, `${(100 * p.coverage_used).toFixed(1)} %`, p.rmse, p.max_error]));
  fold("Objects", ["name", "texels", "per unit", "share"], (layout.objects || []).map((o) => [o.name, o.texels, o.density, o.share]));
  fold("Options", null, Object.entries(bake.options || {}).filter(([, value]) => value !== null).map(([name, value]) => [name, text(value)]));
  fold("Times", ["phase", "seconds"], (bake.timings || []).map((t) => [t.phase, t.seconds]));
  fold("Notes", null, (bake.notes || []).map((note) => [note]));
}
