"use strict";
// What the file carries: a JSON head, the geometry, and for every page a coverage mask and its layers as 16-bit floats.

const $ = (id) => document.getElementById(id);
/** What the file says of itself; known once the browser has read it to the end. */
let head;

/** The bytes of an embedded blob. */
async function bytesOf(id) {
  const text = $(id).textContent;
  let packed;
  if (Uint8Array.fromBase64) {
    packed = Uint8Array.fromBase64(text);
  } else {
    const raw = atob(text);
    packed = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) packed[i] = raw.charCodeAt(i);
  }
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The number that 16 bits stand for. */
const HALVES = (() => {
  const table = new Float32Array(65536);
  for (let bits = 0; bits < 65536; bits++) {
    const exponent = (bits >> 10) & 31, fraction = bits & 1023;
    const size = exponent === 0 ? fraction * 2 ** -24
      : exponent === 31 ? Infinity : (1 + fraction / 1024) * 2 ** (exponent - 15);
    table[bits] = bits >> 15 ? -size : size;
  }
  return table;
})();

const planeCache = new Map();
/** A plane of a page as 16-bit floats; undone: high and low bytes apart, differences along rows. */
function planeOn(page, plane) {
  const id = `p${page}.${plane}`;
  if (!planeCache.has(id)) {
    planeCache.set(id, bytesOf(id).then((bytes) => {
      const texels = bytes.length / 2, values = new Uint16Array(texels);
      let last = 0;
      for (let i = 0; i < texels; i++) {
        last = (last + (bytes[i] << 8 | bytes[texels + i])) & 65535;
        values[i] = last;
      }
      return values;
    }));
  }
  return planeCache.get(id);
}

/** The channels of a layer on a page. */
const layerOn = (page, layer) => Promise.all(head.pages[page].planes[layer].map((plane) => planeOn(page, plane)));

const coverCache = new Map();
/** Which texels of a page charts touch. */
function coverOn(page) {
  if (!coverCache.has(page)) coverCache.set(page, bytesOf(`c${page}`));
  return coverCache.get(page);
}

const layerIndex = (name) => head.layers.findIndex((layer) => layer.name === name);

/** Positions, page coordinates and triangles of every mesh. */
async function geometry() {
  const bytes = await bytesOf("geometry");
  let at = 0;
  const take = (type, count) => {
    const values = new type(bytes.buffer, at, count);
    at += count * type.BYTES_PER_ELEMENT;
    at = (at + 3) & ~3;
    return values;
  };
  return head.meshes.map((mesh) => {
    const positions = take(Float32Array, mesh.vertices * 3);
    const uvs = take(Uint16Array, mesh.vertices * 2);
    const triangles = take(Uint32Array, mesh.triangles * 3);
    const alphas = mesh.cutout ? take(Float32Array, mesh.vertices * 3) : null;
    const box = { min: [Infinity, Infinity, Infinity], max: [-Infinity, -Infinity, -Infinity] };
    for (let i = 0; i < positions.length; i++) {
      const axis = i % 3;
      box.min[axis] = Math.min(box.min[axis], positions[i]);
      box.max[axis] = Math.max(box.max[axis], positions[i]);
    }
    return { positions, uvs, triangles, alphas, box, page: mesh.page, cutout: mesh.cutout };
  });
}

/** The alpha pictures, one byte a pixel. */
const alphaPictures = () => Promise.all(head.alphas.map(async (picture, k) => ({ ...picture, bytes: await bytesOf(`a${k}`) })));

/** The pixel of an axis of a picture that a coordinate falls in. */
function pixelAt(t, size, wrap) {
  const i = Math.floor(t * size);
  if (wrap === "CLAMP_TO_EDGE") return Math.min(Math.max(i, 0), size - 1);
  const period = wrap === "REPEAT" ? size : 2 * size, at = ((i % period) + period) % period;
  return at < size ? at : period - 1 - at;
}

/** True where a surface is there at a point of a triangle: not in the holes of a cut-out, nor where it is clear. */
function solidAt(mesh, pictures, corners, weights) {
  if (!mesh.cutout) return true;
  const [u, v, own] = [0, 1, 2].map((k) => corners.reduce((sum, corner, i) => sum + weights[i] * mesh.alphas[3 * corner + k], 0));
  const picture = pictures[mesh.cutout.picture];
  let alpha = own;
  if (picture) {
    const [x, y] = [u, v].map((t, axis) => pixelAt(t, picture.size[axis], picture.wrap[axis]));
    alpha *= picture.bytes[y * picture.size[0] + x] / 255;
  }
  return mesh.cutout.cutoff < 0 ? alpha > 0 : alpha >= mesh.cutout.cutoff - 1e-6;
}

/** A number with four digits. */
function digits(value) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-4 ? value.toExponential(2) : String(Number(value.toPrecision(4)));
}
