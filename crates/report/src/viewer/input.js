// Pointer, keys and the start.

const KEYS = [
  ["arrows", "turn"], ["W A S D, Q E", "move, down and up"], ["+ -", "nearer, farther"], ["O, P", "orbit, walk"], ["1 2 3", "traditional, Lambert, Phong"],
  ["[ ]", "darker, brighter"], ["V", "next view"], ["B", "hide back faces"], ["N", "probes"], ["Enter", "pick the middle"], ["Home", "first view"], ["?", "these keys"],
];

function press(key) {
  const orbit = !walking(), turn = 0.06, step = 0.05;
  const model = (at) => { $("view").value = list[0].name; $("model").value = at; show(); };
  const actions = {
    ArrowLeft: () => camera.turn(orbit ? turn : -turn, 0, orbit), ArrowRight: () => camera.turn(orbit ? -turn : turn, 0, orbit),
    ArrowUp: () => camera.turn(0, orbit ? -turn : turn, orbit), ArrowDown: () => camera.turn(0, orbit ? turn : -turn, orbit),
    w: () => camera.move(0, 0, step), s: () => camera.move(0, 0, -step), a: () => camera.move(-step, 0, 0), d: () => camera.move(step, 0, 0),
    q: () => camera.move(0, -step, 0), e: () => camera.move(0, step, 0), "+": () => camera.zoom(0.9), "=": () => camera.zoom(0.9), "-": () => camera.zoom(1 / 0.9),
    o: () => { document.querySelector("input[value=orbit]").checked = true; }, p: () => { document.querySelector("input[value=walk]").checked = true; },
    1: () => model(0), 2: () => model(1), 3: () => model(2), "[": () => expose(-0.5), "]": () => expose(0.5),
    v: () => { $("view").selectedIndex = ($("view").selectedIndex + 1) % list.length; show(); },
    b: () => { $("backs").checked = !$("backs").checked; }, n: () => { $("balls").checked = !$("balls").checked; }, Enter: () => pickAt(0, 0), Home: () => camera.reset(), "?": () => { $("keys").hidden = !$("keys").hidden; },
  };
  const action = actions[key.length === 1 ? key.toLowerCase() : key];
  if (action) { action(); redraw(); }
  return Boolean(action);
}

function expose(stops) {
  $("exposure").value = Number($("exposure").value) + stops;
  $("stops").textContent = $("exposure").value;
  sheet();
  redraw();
}

function listen() {
  const canvas = $("scene");
  let last = null, moved = 0, held = null;
  // What the pointer shows: the camera's ray.
  const rayOf = (event) => {
    const box = canvas.getBoundingClientRect();
    return camera.ray(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height, box.width / box.height);
  };
  canvas.addEventListener("pointerdown", (event) => {
    [last, moved] = [event, 0];
    const ray = rayOf(event), along = balls && event.button === 0 ? balls.meets(camera.eye, ray) : null;
    // The ball keeps its distance from the plane of the picture, and its place under the pointer.
    held = along === null ? null : { depth: dot(sub(balls.at, camera.eye), camera.forward), off: sub(balls.at, add(camera.eye, ray, along)) };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!last) return;
    const [x, y] = [event.clientX - last.clientX, event.clientY - last.clientY];
    moved += Math.abs(x) + Math.abs(y);
    if (moved <= 4) return;
    if (held) {
      const ray = rayOf(event);
      balls.move(add(add(camera.eye, ray, held.depth / dot(ray, camera.forward)), held.off));
      last = event;
      return redraw();
    }
    const scale = 2 * Math.tan(camera.fov / 2) / canvas.clientHeight;
    if (event.buttons > 1 || event.shiftKey) camera.move(-x * scale, y * scale, 0);
    else if (walking()) camera.turn(-x * scale, y * scale, false);
    else camera.turn(x * 0.006, -y * 0.006, true);
    last = event;
    redraw();
  });
  canvas.addEventListener("pointerup", (event) => {
    last = null;
    if (moved > 4 || event.button !== 0) return;
    const box = canvas.getBoundingClientRect();
    pickAt(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    if (walking()) camera.move(0, 0, -event.deltaY * 0.001);
    else camera.zoom(Math.exp(event.deltaY * 0.001));
    redraw();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    if (!event.ctrlKey && !event.metaKey && !event.altKey && press(event.key)) event.preventDefault();
  });
  $("controls").addEventListener("submit", (event) => event.preventDefault());
  $("view").addEventListener("change", show);
  $("model").addEventListener("input", () => { redraw(); });
  $("model").addEventListener("change", show);
  $("exposure").addEventListener("input", () => expose(0));
  $("home").addEventListener("click", () => { camera.reset(); redraw(); });
  ["backs", "balls", "moved"].forEach((id) => $(id).addEventListener("change", redraw));
  ["ballX", "ballY", "ballZ"].forEach((id, axis) => $(id).addEventListener("input", (event) => {
    const { low, size } = balls.volume, at = [...balls.at];
    at[axis] = low[axis] + Number(event.target.value) * size[axis];
    balls.move(at);
    redraw();
  }));
  document.querySelectorAll("input[name=move]").forEach((box) => box.addEventListener("change", redraw));
  $("page").addEventListener("change", () => { state.page = Number($("page").value); sheet(); });
  window.addEventListener("resize", redraw);
}

function option(parent, value, label) {
  const made = document.createElement("option");
  made.value = value;
  made.textContent = label;
  parent.append(made);
}

async function start() {
  painter = new Painter($("scene"));
  if (document.readyState === "loading") await new Promise((read) => document.addEventListener("DOMContentLoaded", read, { once: true }));
  head = JSON.parse($("head").textContent);
  list = views();
  document.title = `${head.title} - ambake`;
  $("title").textContent = head.title;
  list.forEach((view) => option($("view"), view.name, view.label));
  head.pages.forEach((_, page) => option($("page"), page, page));
  (list[0].models || []).forEach((model) => { const name = document.createElement("span"); name.textContent = model.name; $("models").append(name); });
  $("hint").textContent = "drag to turn, shift-drag to pan, wheel to zoom, click to pick, ? for keys";
  for (const [key, what] of KEYS) for (const [tag, text] of [["dt", key], ["dd", what]]) {
    const made = document.createElement(tag);
    made.textContent = text;
    $("keys").append(made);
  }
  $("exposure").value = head.stops;
  $("stops").textContent = $("exposure").value;
  [meshes, pictures] = await Promise.all([geometry(), alphaPictures()]);
  instances = head.instances.map((instance) => ({ ...instance, undo: inverse(instance.matrix) }));
  painter.take(meshes, pictures);
  if (head.probes) {
    balls = new Balls(painter, await bytesOf("probes"));
    $("probesRow").hidden = false;
    $("ballRow").hidden = !head.probes.volume;
  }
  camera = new Camera(head.camera);
  listen();
  await show();
  tables();
  plot();
  return performance.now();
}

const ready = start().catch((error) => {
  $("problem").hidden = false;
  $("problem").textContent = `This report cannot be shown: ${error.message}. It needs WebGL 2 and DecompressionStream, as in browsers since 2023.`;
  throw error;
});
// For scripts and tests.
window.ambake = { ready, pickAt, press, state, get views() { return list; }, camera: () => camera, balls: () => balls, show: (name) => { $("view").value = name; return show(); } };
