// Probes as white balls in their light, and one that is moved through their volume.

/** Probes in a row of the texture of lights. */
const BALL_ROW = 64;

const BALL_VERTEX = `#version 300 es
in vec3 normal; in vec4 place;
uniform mat4 camera; uniform int first;
out vec3 n; flat out int probe;
void main() { n = normal; probe = first + gl_InstanceID; gl_Position = camera * vec4(place.xyz + place.w * normal, 1.0); }`;

const BALL_FRAGMENT = `#version 300 es
precision highp float;
in vec3 n; flat in int probe;
uniform highp sampler2D lights; uniform float factor;
out vec4 color;
void main() {
  vec3 m = normalize(n), light = vec3(0.0);
  float terms[9] = float[9](1.0, m.y, m.z, m.x, m.x * m.y, m.y * m.z, 3.0 * m.z * m.z - 1.0, m.x * m.z, m.x * m.x - m.y * m.y);
  for (int k = 0; k < 9; k++) light += terms[k] * texelFetch(lights, ivec2(probe % ${BALL_ROW} * 9 + k, probe / ${BALL_ROW}), 0).rgb;
  vec3 v = clamp(light * factor, 0.0, 1.0);
  color = vec4(mix(12.92 * v, 1.055 * pow(v, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, v)), 1.0);
}`;

class Balls {
  /** Of the painter's canvas and the embedded probes: positions, sizes, and nine coefficients of E / pi by the normal each. */
  constructor(painter, bytes) {
    const gl = painter.gl, { count, volume, radius } = head.probes;
    const positions = new Float32Array(bytes.buffer, 0, 3 * count);
    this.light = new Float32Array(bytes.buffer, 12 * count, 27 * count);
    const isValid = new Uint8Array(bytes.buffer, 120 * count, count);
    Object.assign(this, { painter, gl, count, volume, radius });
    this.program = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, BALL_VERTEX], [gl.FRAGMENT_SHADER, BALL_FRAGMENT]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
    }
    ["normal", "place"].forEach((name, at) => gl.bindAttribLocation(this.program, at, name));
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(this.program));
    this.places = Object.fromEntries(["camera", "first", "lights", "factor"].map((name) => [name, gl.getUniformLocation(this.program, name)]));
    // The moved ball is the last one.
    const rows = Math.ceil((count + 1) / BALL_ROW), texels = new Float32Array(4 * 9 * BALL_ROW * rows);
    for (let k = 0; k < 9 * count; k++) texels.set(this.light.subarray(3 * k, 3 * k + 3), 4 * k);
    this.texture = painter.texture(gl.RGBA32F, gl.RGBA, 9 * BALL_ROW, rows, gl.FLOAT, texels);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    const spheres = new Float32Array(4 * (count + 1));
    for (let k = 0; k < count; k++) spheres.set([...positions.subarray(3 * k, 3 * k + 3), isValid[k] ? radius : 0], 4 * k);
    this.shape(spheres);
    if (volume) this.move(add(volume.low, volume.size, 0.5));
  }

  shape(spheres) {
    const gl = this.gl, normals = [], triangles = [], [across, down] = [32, 16];
    for (let row = 0; row <= down; row++) for (let column = 0; column <= across; column++) {
      const [a, b] = [Math.PI * row / down, 2 * Math.PI * column / across];
      normals.push(Math.sin(a) * Math.cos(b), Math.cos(a), Math.sin(a) * Math.sin(b));
      if (row === down || column === across) continue;
      const at = row * (across + 1) + column;
      triangles.push(at, at + 1, at + across + 1, at + 1, at + across + 2, at + across + 1);
    }
    this.triangles = triangles.length;
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    this.spheres = gl.createBuffer();
    for (const [buffer, values, size] of [[gl.createBuffer(), new Float32Array(normals), 3], [this.spheres, spheres, 4]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(size - 3);
      gl.vertexAttribPointer(size - 3, size, gl.FLOAT, false, 0, 0);
    }
    gl.vertexAttribDivisor(1, 1);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint16Array(triangles), gl.STATIC_DRAW);
    gl.bindVertexArray(null);
  }

  /** The light at a place: linear between the eight probes around it, as engines look it up. */
  lightAt(point) {
    const { counts, low, size } = this.volume, sum = new Float32Array(27), cells = [], parts = [];
    for (let k = 0; k < 3; k++) {
      const at = Math.min(Math.max((point[k] - low[k]) / size[k] * counts[k] - 0.5, 0), counts[k] - 1) || 0;
      cells[k] = Math.floor(at);
      parts[k] = at - cells[k];
    }
    for (let corner = 0; corner < 8; corner++) {
      const step = [corner & 1, corner >> 1 & 1, corner >> 2];
      const weight = step.reduce((w, s, k) => w * (s ? parts[k] : 1 - parts[k]), 1);
      const [x, y, z] = step.map((s, k) => Math.min(cells[k] + s, counts[k] - 1));
      const first = 27 * (x + counts[0] * (y + counts[1] * z));
      for (let k = 0; k < 27; k++) sum[k] += weight * this.light[first + k];
    }
    return sum;
  }

  /** Puts the ball somewhere in the box of the volume. */
  move(point) {
    const gl = this.gl, { low, size } = this.volume;
    this.at = point.map((x, k) => Math.min(Math.max(x, low[k]), low[k] + size[k]));
    const light = this.lightAt(this.at), texels = new Float32Array(36);
    for (let k = 0; k < 9; k++) texels.set(light.subarray(3 * k, 3 * k + 3), 4 * k);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, this.count % BALL_ROW * 9, Math.floor(this.count / BALL_ROW), 9, 1, gl.RGBA, gl.FLOAT, texels);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.spheres);
    gl.bufferSubData(gl.ARRAY_BUFFER, 16 * this.count, new Float32Array([...this.at, 2 * this.radius]));
    ["ballX", "ballY", "ballZ"].forEach((id, k) => { $(id).value = size[k] > 0 ? (this.at[k] - low[k]) / size[k] : 0; });
    // What is rounding beside the volume is 0.
    const least = 1e-6 * Math.max(...size);
    $("ballAt").textContent = add(this.at, head.origin).map((x) => digits(Math.abs(x) < least ? 0 : x)).join(", ");
  }

  /** Where a ray meets the ball: how far along the ray its middle is, or null. */
  meets(eye, ray) {
    if (!this.volume || !$("moved").checked) return null;
    const toward = sub(this.at, eye), along = dot(toward, ray) / dot(ray, ray);
    return along > 0 && length(sub(toward, ray.map((x) => x * along))) < 2 * this.radius ? along : null;
  }

  draw(matrix, factor) {
    const gl = this.gl, p = this.places;
    gl.useProgram(this.program);
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    gl.uniformMatrix4fv(p.camera, false, matrix);
    gl.uniform1f(p.factor, factor);
    gl.uniform1i(p.lights, 0);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.bindVertexArray(this.array);
    const draw = (first, count) => {
      gl.uniform1i(p.first, first);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.spheres);
      gl.vertexAttribPointer(1, 4, gl.FLOAT, false, 0, 16 * first);
      gl.drawElementsInstanced(gl.TRIANGLES, this.triangles, gl.UNSIGNED_SHORT, 0, count);
    };
    if ($("balls").checked) draw(0, this.count);
    if (this.volume && $("moved").checked) draw(this.count, 1);
    gl.bindVertexArray(null);
    gl.useProgram(this.painter.program);
  }
}
