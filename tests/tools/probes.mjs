// Draws white balls in the light of a volume of probes with three.js in headless Chromium, and holds them against pictures.
//
// Usage: probes.mjs DIR STEM JOB.json [SHOT.png]   DIR has the files of `ambake probes --for three`
// JOB is a list of balls, { center, radius, eye, fov, size, wanted }: what a camera at `eye`, which looks at the middle, is to see, three bytes a
// pixel from the top, null where there is no ball. Prints one line of JSON: for each ball the mean and the largest difference in 1/255, and how
// many pixels were compared. Exit status 77 where a tool is absent.
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { threePage } from "./three-page.mjs";

const [dir, stem, list, shot] = process.argv.slice(2);
const report = JSON.parse(await readFile(path.join(dir, stem + ".probes.json"), "utf8"));
const file = (ending) => report.files.find((file) => file.engine === "three" && file.file.endsWith(ending));
const volume = file(".ktx2"), shader = await readFile(path.join(dir, file(".glsl").file), "utf8");

const script = `
import * as THREE from "three";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";
window.measure = async ({ volume, shader, balls }) => {
  const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
  const texture = await new KTX2Loader().detectSupport(renderer).loadAsync("/made/" + encodeURIComponent(volume.file));
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.generateMipmaps = false;
  texture.needsUpdate = true;
  const material = new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3,
    uniforms: {
      ambake_volume: { value: texture },
      ambake_center: { value: new THREE.Vector3(...volume.center) },
      ambake_size: { value: new THREE.Vector3(...volume.size) },
    },
    vertexShader: "out vec3 place, n; void main() { place = (modelMatrix * vec4(position, 1.0)).xyz; n = normal; gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0); }",
    fragmentShader: shader + "in vec3 place, n; out vec4 color; void main() { color = vec4(ambake_light(place, normalize(n)), 1.0); }",
  });
  const shown = (v) => 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * Math.min(v, 1) ** (1 / 2.4) - 0.055);
  const told = [], pictures = [];
  for (const { center, radius, eye, fov, size: [width, height], wanted } of balls) {
    const scene = new THREE.Scene(), ball = new THREE.Mesh(new THREE.SphereGeometry(radius, 128, 64), material);
    ball.position.fromArray(center);
    scene.add(ball);
    const camera = new THREE.PerspectiveCamera(fov, width / height, 0.01, 1e4);
    camera.position.fromArray(eye);
    camera.lookAt(...center);
    const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType });
    renderer.setRenderTarget(target);
    renderer.setClearColor(0, 0);
    renderer.render(scene, camera);
    const found = new Float32Array(4 * width * height);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, found);
    let sum = 0, most = 0, count = 0;
    const picture = [];
    for (let y = 0; y < height; y++) for (let x = 0; x < width; x++) {
      const i = (height - 1 - y) * width + x, j = y * width + x;
      const own = [0, 1, 2].map((c) => shown(Math.max(found[4 * i + c], 0)));
      picture.push(own);
      if (found[4 * i + 3] < 1 || wanted[3 * j] === null) continue;
      for (let c = 0; c < 3; c++) {
        const off = Math.abs(own[c] - wanted[3 * j + c]);
        sum += off; most = Math.max(most, off); count++;
      }
    }
    told.push({ mean: sum / count, most, pixels: count / 3 });
    pictures.push(picture);
  }
  // What was seen, above what was wanted.
  const [width, height] = balls[0].size, canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width * balls.length, 2 * height];
  const pen = canvas.getContext("2d");
  balls.forEach((ball, k) => [(i) => pictures[k][i], (i) => ball.wanted.slice(3 * i, 3 * i + 3).map((v) => v ?? 0)].forEach((pixel, row) => {
    const image = pen.createImageData(width, height);
    for (let i = 0; i < width * height; i++) image.data.set([...pixel(i), 255], 4 * i);
    pen.putImageData(image, k * width, row * height);
  }));
  return { balls: told, size: [texture.image.width, texture.image.height, texture.image.depth], picture: canvas.toDataURL() };
};`;

const { tab, errors, close } = await threePage(script, { made: dir });
try {
  const balls = JSON.parse(await readFile(list, "utf8"));
  const { picture, ...told } = await tab.evaluate((job) => window.measure(job), { volume, shader, balls });
  if (shot) await writeFile(shot, Buffer.from(picture.split(",")[1], "base64"));
  console.log(JSON.stringify({ ...told, errors }));
} finally {
  await close();
}
