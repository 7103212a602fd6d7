// Opens a bake's files with three.js' own loaders in headless Chromium and prints what they give as one JSON line.
//
// Usage: three.mjs DIR STEM PICTURE.exr EYE LOOK FOV   (EYE and LOOK as X,Y,Z; FOV vertical, in degrees)
// PICTURE.exr is ambake's own render of the view from the same bake. For each loader: edge, levels and the mean and the largest
// difference of the scene, lit by that lightmap as bake.json says, to the picture, away from silhouettes; both in 1/255.
// Exit status 77 where playwright-core, three or Chromium is absent (`npm install` in this folder; Debian's package chromium).

import { existsSync } from "node:fs";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { threePage } from "./three-page.mjs";

const [dir, stem, picture, eye, look, fov] = process.argv.slice(2);
const point = (text) => text.split(",").map(Number);

const script = `
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";
import { DDSLoader } from "three/addons/loaders/DDSLoader.js";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";
let HDR;
try { HDR = (await import("three/addons/loaders/HDRLoader.js")).HDRLoader; }
catch { HDR = (await import("three/addons/loaders/RGBELoader.js")).RGBELoader; }

// What three.js' GLTFLightMapLoaderExtension and Mozilla Hubs do; release 187 of three has it not yet.
const lightMaps = (parser) => ({
  name: "MOZ_lightmap",
  async loadMaterial(index) {
    const own = parser.json.materials[index].extensions?.MOZ_lightmap;
    if (!own) return null;
    const material = await parser.loadMaterial(index);
    await parser.assignTexture(material, "lightMap", own, THREE.LinearSRGBColorSpace);
    material.lightMapIntensity = own.intensity;
    return material;
  },
});

window.measure = async ({ picture, stem, eye, look, fov, pages, scale, instanced, compressed }) => {
  const renderer = new THREE.WebGLRenderer();
  const at = (name) => "/bake/" + encodeURIComponent(name);
  const wanted = await new EXRLoader().setDataType(THREE.FloatType).loadAsync("/picture/" + encodeURIComponent(picture));
  const { width, height, data } = wanted.image;
  const camera = new THREE.PerspectiveCamera(fov, width / height, 0.001, 1e5);
  camera.position.fromArray(eye);
  camera.lookAt(...look);
  const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType, colorSpace: THREE.LinearSRGBColorSpace });
  const loaders = {
    exr: [new EXRLoader(), true], hdr: [new HDR(), false], ktx2: [new KTX2Loader().detectSupport(renderer), false],
    "bc6h.dds": [new DDSLoader(), false],
    moz: [null], copies: [new EXRLoader(), true],
  };
  const plain = (await new GLTFLoader().loadAsync(at(stem + ".glb"))).scene;
  const lit = (await new GLTFLoader().register(lightMaps).loadAsync(at(stem + ".lightmap.glb"))).scene;
  const copies = instanced ? (await new GLTFLoader().loadAsync(at(stem + ".instanced.glb"))).scene : null;
  const told = {};
  for (const [ending, [loader, flip]] of Object.entries(loaders)) {
    const maps = [];
    const scene = ending === "copies" ? copies : loader ? plain : lit;
    if (!scene || ending === (compressed ? "ktx2" : "bc6h.dds")) continue;
    const file = ending === "copies" ? "exr" : ending;
    for (let page = 0; page < (loader ? pages : 0); page++) {
      const map = await loader.loadAsync(at(stem + "." + page + ".lightmap." + file));
      map.channel = 1;
      map.flipY = flip;
      // KTX2Loader leaves pictures without compression unfiltered.
      map.magFilter = THREE.LinearFilter;
      map.minFilter = map.mipmaps.length > 1 ? THREE.LinearMipmapLinearFilter : THREE.LinearFilter;
      map.generateMipmaps = false;
      map.needsUpdate = true;
      maps.push(map);
    }
    scene.traverse((object) => {
      if (!loader && object.isMesh && object.material.aoMap) throw new Error("occlusion beside a lightmap");
      if (!loader && object.isMesh && object.material.lightMap) maps.push(object.material.lightMap);
      if (!loader || !object.isMesh || (!object.material.aoMap && !object.material.lightMap)) return;
      if (object.isInstancedMesh) {
        object.material = object.material.clone();
        object.material.onBeforeCompile = (shader) => {
          shader.vertexShader = "attribute vec4 _LIGHTMAP_RECT;\\n" + shader.vertexShader.replace("#include <uv_vertex>",
            "#include <uv_vertex>\\nvLightMapUv = vLightMapUv * _LIGHTMAP_RECT.xy + _LIGHTMAP_RECT.zw;");
        };
      }
      const material = object.material;
      material.userData.page ??= Number(material.aoMap.name.split(".").at(-2));
      material.aoMap = null;
      material.lightMap = maps[material.userData.page];
      material.lightMapIntensity = scale;
      material.needsUpdate = true;
    });
    renderer.setRenderTarget(target);
    renderer.setClearColor(0xff00ff, 1);
    renderer.render(scene, camera);
    const found = new Float32Array(width * height * 4);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, found);
    // EXRLoader keeps the last row first, as the render target does.
    const sky = (i) => found[4 * i] === 1 && found[4 * i + 1] === 0 && found[4 * i + 2] === 1;
    let sum = 0, most = 0, count = 0;
    for (let y = 1; y < height - 1; y++) for (let x = 1; x < width - 1; x++) {
      const i = y * width + x;
      // Edges are drawn with other sampling: away from them neighbours agree.
      let edge = false;
      for (const j of [i - 1, i + 1, i - width, i + width, i]) {
        edge ||= sky(j);
        for (let c = 0; c < 3; c++) edge ||= Math.abs(data[4 * i + c] - data[4 * j + c]) > 0.1;
      }
      if (edge) continue;
      for (let c = 0; c < 3; c++) {
        const difference = 255 * Math.abs(found[4 * i + c] - data[4 * i + c]);
        sum += difference; most = Math.max(most, difference); count++;
      }
    }
    const middle = 4 * (Math.floor(height / 2) * width + Math.floor(width / 2));
    let drawn = 0;
    scene.traverse((object) => { drawn += object.isMesh ? 1 : 0; });
    told[ending] = {
      drawn,
      size: maps[0].image.width, levels: Math.max(1, maps[0].mipmaps?.length ?? 1), pixels: count / 3,
      mean: sum / count, most, middle: [...found.slice(middle, middle + 3)], wanted: [...data.slice(middle, middle + 3)],
    };
  }
  return told;
};`;

const bake = JSON.parse(await readFile(path.join(dir, "bake.json"), "utf8"));
const scale = bake.lightmaps.find((map) => map.engine === "three").scale;
const { tab, errors, close } = await threePage(script, { bake: dir, picture: path.dirname(picture) });
try {
  const told = await tab.evaluate((job) => window.measure(job), {
    picture: path.basename(picture), stem, eye: point(eye), look: point(look), fov: Number(fov), pages: bake.pages.length, scale,
    compressed: bake.lightmaps.some((map) => map.compression),
    instanced: existsSync(path.join(dir, stem + ".instanced.glb")),
  });
  console.log(JSON.stringify({ ...told, errors }));
} finally {
  await close();
}
