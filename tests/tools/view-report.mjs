// Opens report files in headless Chromium, without any network, and says what a person would find there.
//
//   node view-report.mjs REPORT.html [SHOT.png]   one JSON object on standard output; exit 1 where the page complains
//
// Exit 77, with a reason, where there is no Chromium or no playwright-core.
import { pathToFileURL } from "node:url";
import { resolve } from "node:path";
import { launch } from "./browser.mjs";

const [report, shot] = process.argv.slice(2);
const browser = await launch();
const page = await browser.newPage({ viewport: shot ? { width: 1200, height: 760 } : { width: 820, height: 420 } });
const complaints = [], requests = [];
page.on("console", (message) => { if (["error", "warning"].includes(message.type())) complaints.push(message.text()); });
page.on("pageerror", (error) => complaints.push(String(error)));
page.on("dialog", (dialog) => { complaints.push(`dialog ${dialog.message()}`); dialog.dismiss(); });
page.on("request", (request) => requests.push(request.url()));
const file = pathToFileURL(resolve(report)).href;
await page.goto(file);
const found = await page.evaluate(async () => {
  const app = window.ambake, pixels = (id) => {
    const canvas = document.getElementById(id), copy = document.createElement("canvas");
    [copy.width, copy.height] = [canvas.width, canvas.height];
    const pen = copy.getContext("2d");
    pen.drawImage(canvas, 0, 0);
    return pen.getImageData(0, 0, canvas.width, canvas.height).data;
  };
  const drawn = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  const colors = () => {
    const seen = new Set(), data = pixels("scene");
    for (let i = 0; i < data.length; i += 4) seen.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
    return seen.size;
  };
  const ready = await app.ready;
  await drawn();
  const first = pixels("scene"), out = { ready, first: app.state.first, colors: colors(), views: {} };
  out.picks = [];
  for (const [x, y] of [[0, 0], [0.1, -0.2], [-0.15, -0.1], [0.2, 0.1]]) out.picks.push(await app.pickAt(x, y));
  out.texel = document.getElementById("texel").innerText;
  // What lies under a grid of places, and what is said of a benchmark.
  out.grid = [];
  for (const x of [-0.4, -0.2, 0, 0.2, 0.4]) for (const y of [-0.3, -0.15, 0, 0.15, 0.3]) out.grid.push(await app.pickAt(x, y));
  const benchmark = document.getElementById("benchmark");
  out.benchmark = benchmark.hidden ? "" : benchmark.innerText;
  for (const view of app.views) {
    await app.show(view.name);
    await drawn();
    out.views[view.name] = colors();
  }
  await app.show(app.views[0].name);
  const balls = app.balls();
  if (balls) {
    const changed = (a, b) => a.reduce((sum, value, i) => sum + (value !== b[i]), 0);
    const press = async (id) => { document.getElementById(id).click(); await drawn(); return pixels("scene"); };
    const with_all = pixels("scene"), without = await press("balls"), none = await press("moved");
    out.balls = { shown: changed(with_all, without), moved: changed(without, none), at: [...balls.at] };
    await press("balls");
    await press("moved");
    const { low, size, counts } = balls.volume;
    // Light at the places of probes, and half way between two.
    const place = (at) => at.map((k, axis) => low[axis] + (k + 0.5) / counts[axis] * size[axis]);
    out.balls.light = [[0, 0, 0], [1, 0, 1], [0.5, 0, 0]].map((at) => [...balls.lightAt(place(at))]);
    // Where the ball is on the screen.
    const c = app.camera(), box = document.getElementById("scene").getBoundingClientRect(), slope = Math.tan(c.fov / 2);
    const along = (axis) => axis.reduce((sum, x, k) => sum + x * (balls.at[k] - c.eye[k]), 0), depth = along(c.forward);
    const [x, y] = [along(c.right) / (depth * slope * box.width / box.height), along(c.upright) / (depth * slope)];
    out.balls.screen = [box.left + (x + 1) / 2 * box.width, box.top + (1 - y) / 2 * box.height];
  }
  const eye = [...app.camera().eye];
  document.getElementById("scene").focus();
  out.eye = eye;
  await drawn();
  out.same = pixels("scene").every((value, i) => value === first[i]);
  return out;
});
if (found.balls) {
  const [x, y] = found.balls.screen;
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 30, y - 10, { steps: 4 });
  await page.mouse.up();
  found.balls.dragged = await page.evaluate(() => [...window.ambake.balls().at]);
}
await page.keyboard.press("ArrowRight");
await page.keyboard.press("1");
await page.mouse.move(400, 400);
await page.mouse.down();
await page.mouse.move(460, 380, { steps: 4 });
await page.mouse.up();
found.turned = await page.evaluate((eye) => Math.hypot(...window.ambake.camera().eye.map((x, k) => x - eye[k])), found.eye);
await page.evaluate(() => { window.ambake.press("Home"); window.ambake.press("3"); });
await page.waitForTimeout(200);
if (shot) await page.screenshot({ path: shot });
found.complaints = complaints;
found.requests = requests.filter((url) => url !== file && !url.startsWith("data:"));
await browser.close();
console.log(JSON.stringify(found));
process.exit(complaints.length || found.requests.length ? 1 : 0);
