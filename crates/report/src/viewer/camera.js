// The camera: an eye, two angles about the upward y, and the distance of the point that it orbits.

const add = (a, b, scale = 1) => [a[0] + b[0] * scale, a[1] + b[1] * scale, a[2] + b[2] * scale];
const sub = (a, b) => add(a, b, -1);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(a[0], a[1], a[2]);

/** Column-major product of two 4 x 4 matrices. */
function product(a, b) {
  const out = new Array(16);
  for (let c = 0; c < 4; c++) for (let r = 0; r < 4; r++) {
    out[4 * c + r] = a[r] * b[4 * c] + a[4 + r] * b[4 * c + 1] + a[8 + r] * b[4 * c + 2] + a[12 + r] * b[4 * c + 3];
  }
  return out;
}

/** The inverse of an affine matrix. */
function inverse(m) {
  const columns = [m.slice(0, 3), m.slice(4, 7), m.slice(8, 11)], shift = m.slice(12, 15);
  const rows = [cross(columns[1], columns[2]), cross(columns[2], columns[0]), cross(columns[0], columns[1])];
  const scale = 1 / dot(columns[0], rows[0]);
  const out = rows.map((row) => row.map((value) => value * scale));
  return { rows: out, point: (p) => out.map((row) => dot(row, sub(p, shift))), vector: (v) => out.map((row) => dot(row, v)) };
}

class Camera {
  constructor(home) {
    this.home = home;
    this.reset();
  }

  reset() {
    const toward = sub(this.home.look, this.home.eye);
    this.eye = [...this.home.eye];
    this.distance = length(toward);
    this.yaw = Math.atan2(toward[0], -toward[2]);
    this.pitch = Math.asin(toward[1] / this.distance);
    this.fov = this.home.fov;
  }

  get forward() {
    const flat = Math.cos(this.pitch);
    return [Math.sin(this.yaw) * flat, Math.sin(this.pitch), -Math.cos(this.yaw) * flat];
  }

  get right() { return [Math.cos(this.yaw), 0, Math.sin(this.yaw)]; }

  get upright() { return cross(this.right, this.forward); }

  turn(yaw, pitch, orbit) {
    const target = add(this.eye, this.forward, this.distance);
    this.yaw += yaw;
    this.pitch = Math.min(Math.max(this.pitch + pitch, -1.55), 1.55);
    if (orbit) this.eye = add(target, this.forward, -this.distance);
  }

  /** Moves by parts of the distance. */
  move(right, up, forward) {
    const d = this.distance;
    this.eye = add(add(add(this.eye, this.right, right * d), this.upright, up * d), this.forward, forward * d);
  }

  zoom(factor) {
    const target = add(this.eye, this.forward, this.distance);
    this.distance *= factor;
    this.eye = add(target, this.forward, -this.distance);
  }

  /** The matrix from the world to the clip space of a canvas. */
  matrix(aspect, radius) {
    const [r, u, f, e] = [this.right, this.upright, this.forward, this.eye];
    const near = 0.01 * this.distance, far = length(e) + 2 * radius + near;
    const y = 1 / Math.tan(this.fov / 2), x = y / aspect;
    const depth = (far + near) / (far - near), shift = 2 * far * near / (far - near);
    const view = [r[0], u[0], -f[0], 0, r[1], u[1], -f[1], 0, r[2], u[2], -f[2], 0, -dot(r, e), -dot(u, e), dot(f, e), 1];
    return product([x, 0, 0, 0, 0, y, 0, 0, 0, 0, -depth, -1, 0, 0, -shift, 0], view);
  }

  /** The direction through a point of the canvas, -1 to 1 to the right and up. */
  ray(x, y, aspect) {
    const slope = Math.tan(this.fov / 2);
    return add(add(this.forward, this.right, x * slope * aspect), this.upright, y * slope);
  }
}

/** The first triangle on a ray: { instance, triangle, point, uv }, or null. */
function pick(meshes, pictures, instances, eye, toward, fronts) {
  let best = null, nearest = Infinity;
  for (let index = 0; index < instances.length; index++) {
    const { mesh: number, undo } = instances[index];
    const mesh = meshes[number];
    const o = undo.point(eye), d = undo.vector(toward);
    let low = 0, high = nearest;
    for (let axis = 0; axis < 3; axis++) {
      const a = (mesh.box.min[axis] - o[axis]) / d[axis], b = (mesh.box.max[axis] - o[axis]) / d[axis];
      if (Number.isNaN(a) || Number.isNaN(b)) continue;
      low = Math.max(low, Math.min(a, b));
      high = Math.min(high, Math.max(a, b));
    }
    if (low > high * (1 + 1e-6)) continue;
    const p = mesh.positions, t = mesh.triangles;
    for (let k = 0; k < t.length; k += 3) {
      const a = 3 * t[k], b = 3 * t[k + 1], c = 3 * t[k + 2];
      const x1 = p[b] - p[a], y1 = p[b + 1] - p[a + 1], z1 = p[b + 2] - p[a + 2];
      const x2 = p[c] - p[a], y2 = p[c + 1] - p[a + 1], z2 = p[c + 2] - p[a + 2];
      const px = d[1] * z2 - d[2] * y2, py = d[2] * x2 - d[0] * z2, pz = d[0] * y2 - d[1] * x2;
      const det = x1 * px + y1 * py + z1 * pz;
      if (det === 0 || (fronts && det < 0)) continue;
      const ox = o[0] - p[a], oy = o[1] - p[a + 1], oz = o[2] - p[a + 2];
      const u = (ox * px + oy * py + oz * pz) / det;
      if (u < 0 || u > 1) continue;
      const qx = oy * z1 - oz * y1, qy = oz * x1 - ox * z1, qz = ox * y1 - oy * x1;
      const v = (d[0] * qx + d[1] * qy + d[2] * qz) / det;
      if (v < 0 || u + v > 1) continue;
      const at = (x2 * qx + y2 * qy + z2 * qz) / det;
      if (at > 1e-4 && at < nearest && solidAt(mesh, pictures, [t[k], t[k + 1], t[k + 2]], [1 - u - v, u, v])) {
        nearest = at;
        best = { instance: index, triangle: k / 3, u, v };
      }
    }
  }
  if (!best) return null;
  const mesh = meshes[instances[best.instance].mesh];
  const corner = (k) => mesh.triangles[3 * best.triangle + k];
  const weights = [1 - best.u - best.v, best.u, best.v];
  const uv = [0, 1].map((axis) => weights.reduce((sum, w, k) => sum + w * mesh.uvs[2 * corner(k) + axis] / 65535, 0));
  return { ...best, point: add(eye, toward, nearest), uv, page: mesh.page };
}
