// Opens a report in headless Chromium and holds its live view against pictures of `ambake render`.
//
//   node view-live.mjs REPORT.html WIDTH HEIGHT VIEWS.json
//
// VIEWS.json: a list of { eye, look, fov, bytes }, fov in degrees, bytes the sRGB picture as RGB from the top, null where nothing is.
// Prints one JSON object: for each view the pixels that both show, the mean of their difference's size and of the difference itself, in 255ths. Exit 77, with a reason, where a tool is absent.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { resolve } from "node:path";
import { launch } from "./browser.mjs";

const [report, width, height, list] = process.argv.slice(2);
const browser = await launch();
const page = await browser.newPage({ viewport: { width: 820, height: 420 } });
const complaints = [];
page.on("console", (message) => { if (["error", "warning"].includes(message.type())) complaints.push(message.text()); });
page.on("pageerror", (error) => complaints.push(String(error)));
await page.goto(pathToFileURL(resolve(report)).href);
const views = JSON.parse(readFileSync(list, "utf8"));
const found = await page.evaluate(async ([views, width, height]) => {
  const app = window.ambake, canvas = document.getElementById("scene"), origin = JSON.parse(document.getElementById("head").textContent).origin;
  await app.ready;
  Object.assign(canvas.style, { position: "fixed", width: `${width}px`, height: `${height}px` });
  document.getElementById("exposure").value = 0;
  const live = app.views.find((view) => view.kind === "live");
  if (!live) return { missing: app.views.map((view) => view.name) };
  const out = [];
  for (const { eye, look, fov, bytes } of views) {
    const camera = app.camera(), toward = look.map((x, k) => x - eye[k]);
    camera.eye = eye.map((x, k) => x - origin[k]);
    camera.distance = Math.hypot(...toward);
    camera.yaw = Math.atan2(toward[0], -toward[2]);
    camera.pitch = Math.asin(toward[1] / camera.distance);
    camera.fov = fov * Math.PI / 180;
    await app.show(live.name);
    await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [width, height];
    const pen = copy.getContext("2d");
    pen.drawImage(canvas, 0, 0);
    const shown = pen.getImageData(0, 0, width, height).data, empty = [187, 210, 237];
    const there = (x, y) => bytes[3 * (y * width + x)] !== null && empty.some((c, k) => Math.abs(shown[4 * (y * width + x) + k] - c) > 1);
    let [sum, pixels, bias] = [0, 0, 0];
    for (let y = 1; y < height - 1; y++) for (let x = 1; x < width - 1; x++) {
      // Edges are smoothed here and not there.
      if (![[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]].every(([u, v]) => there(x + u, y + v))) continue;
      const i = y * width + x;
      pixels += 1;
      for (const k of [0, 1, 2]) {
        const difference = (shown[4 * i + k] - bytes[3 * i + k]) / 3;
        sum += Math.abs(difference);
        bias += difference;
      }
    }
    out.push({ pixels, mean: sum / Math.max(pixels, 1), bias: bias / Math.max(pixels, 1) });
  }
  return { size: [canvas.width, canvas.height], views: out };
}, [views, Number(width), Number(height)]);
await browser.close();
console.log(JSON.stringify({ ...found, complaints }));
