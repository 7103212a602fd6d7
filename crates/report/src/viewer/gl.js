// Drawing with WebGL 2: one vertex array for each mesh, one texture for each page and layer.

const VERTEX = `#version 300 es
in vec3 position, hole; in vec2 uv;
uniform mat4 camera, place;
out vec2 at; out vec3 world; centroid out vec3 cut;
void main() { vec4 p = place * vec4(position, 1.0); world = p.xyz; at = uv; cut = hole; gl_Position = camera * p; }`;

const FRAGMENT = `#version 300 es
precision highp float;
in vec2 at; in vec3 world; centroid in vec3 cut;
uniform sampler2D first, second, palette, alphas;
uniform int kind, grey; uniform float part, factor, low, high, size, cutoff;
out vec4 color;
${LIVE_HEAD}
vec3 srgb(vec3 v) {
  v = clamp(v, 0.0, 1.0);
  return mix(12.92 * v, 1.055 * pow(v, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, v));
}
vec3 ramp(float x, float row) { return texture(palette, vec2(clamp(x, 0.0, 1.0) * 255.0 / 256.0 + 0.5 / 256.0, row)).rgb; }
void main() {
  vec3 a = texture(first, at).rgb, b = texture(second, at).rgb;
  if ((grey & 1) == 1) a = a.rrr;
  if ((grey & 2) == 2) b = b.rrr;
  // Texels per unit: areas on the page and in the world, both per pixel of the screen.
  vec2 ux = dFdx(at), uy = dFdy(at);
  float texels = abs(ux.x * uy.y - ux.y * uy.x) * size * size;
  float area = max(length(cross(dFdx(world), dFdy(world))), 1e-30);
  vec3 d = a - b;
  float most = abs(d.g) >= abs(d.r) ? d.g : d.r;
  most = abs(d.b) > abs(most) ? d.b : most;
  vec3 c;
  if (kind == 0) c = srgb(mix(a, b, part) * factor);
  else if (kind == 1) c = srgb(a.rrr * factor);
  else if (kind == 2) c = a * 0.5 + 0.5;
  else if (kind == 3) c = ramp((a.r - low) / (high - low), 0.25);
  else if (kind == 4) c = ramp(most / high * 0.5 + 0.5, 0.75);
  else if (kind == 5) c = ramp((0.5 * log2(texels / area) - low) / (high - low), 0.25);${LIVE_BODY}
  else c = vec3(0.45);
  // A cut-out has holes below its cutoff; a see-through surface, whose cutoff is negative, covers its share of a pixel.
  float alpha = cut.z * texture(alphas, cut.xy).r;
  if (alpha < cutoff - 1e-6) discard;
  color = vec4(c, cutoff < 0.0 ? alpha : 1.0);
}`;
const KINDS = { models: 0, color: 0, grey: 1, vector: 2, heat: 3, difference: 4, density: 5, none: 6, live: 7 };

class Painter {
  /** Sets the graphics to work. Nothing is asked of them yet, so that the browser reads on while they compile. */
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error("this browser has no WebGL 2");
    this.gl = gl;
    this.program = gl.createProgram();
    this.shaders = [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]].map(([type, text]) => {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
      return shader;
    });
    ["position", "uv", "hole"].forEach((name, at) => gl.bindAttribLocation(this.program, at, name));
    gl.linkProgram(this.program);
  }

  /** Waits for the graphics, and gives them what all views need. */
  take(meshes, pictures) {
    const gl = this.gl;
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS)) {
      throw new Error([gl.getProgramInfoLog(this.program), ...this.shaders.map((shader) => gl.getShaderInfoLog(shader))].join(" "));
    }
    gl.useProgram(this.program);
    this.places = Object.fromEntries(["camera", "place", "first", "second", "palette", "alphas", "kind", "grey", "part", "factor", "low", "high", "size", "cutoff"]
      .map((name) => [name, gl.getUniformLocation(this.program, name)]));
    this.textures = new Map();
    this.palette = this.texture(gl.RGBA8, gl.RGBA, 256, 2, gl.UNSIGNED_BYTE, palettes());
    this.pictures = pictures.map(({ size: [width, height], wrap: [u, v], linear, bytes }) => {
      const texture = this.texture(gl.R8, gl.RED, width, height, gl.UNSIGNED_BYTE, bytes);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl[u]);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl[v]);
      if (!linear) for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
      return texture;
    });
    this.live = ANY_VIEW && new Live(this);
    this.whole = this.texture(gl.R8, gl.RED, 1, 1, gl.UNSIGNED_BYTE, new Uint8Array([255]));
    gl.enable(gl.DEPTH_TEST);
    gl.clearColor(0.735, 0.825, 0.93, 1);
    this.meshes = meshes.map((mesh) => {
      const array = gl.createVertexArray();
      gl.bindVertexArray(array);
      const fill = (target, values) => {
        gl.bindBuffer(target, gl.createBuffer());
        gl.bufferData(target, values, gl.STATIC_DRAW);
      };
      fill(gl.ARRAY_BUFFER, mesh.positions);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
      fill(gl.ARRAY_BUFFER, mesh.uvs);
      gl.enableVertexAttribArray(1);
      gl.vertexAttribPointer(1, 2, gl.UNSIGNED_SHORT, true, 0, 0);
      if (mesh.alphas) {
        fill(gl.ARRAY_BUFFER, mesh.alphas);
        gl.enableVertexAttribArray(2);
        gl.vertexAttribPointer(2, 3, gl.FLOAT, false, 0, 0);
      }
      fill(gl.ELEMENT_ARRAY_BUFFER, mesh.triangles);
      return { array, count: mesh.triangles.length, page: mesh.page, cutout: mesh.cutout };
    });
    gl.vertexAttrib3f(2, 0, 0, 1);
  }

  texture(format, channels, width, height, type, values) {
    const gl = this.gl, texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage2D(gl.TEXTURE_2D, 0, format, width, height, 0, channels, type, values);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
    for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
    return texture;
  }

  /** Makes the texture of a layer on a page, where it is not there yet. */
  async need(page, layer) {
    const key = `${page}.${layer}`;
    if (this.textures.has(key)) return;
    const channels = await layerOn(page, layer);
    if (this.textures.has(key)) return;
    const gl = this.gl, size = head.pages[page].size, texels = size * size;
    const [r, g, b] = channels;
    // One channel, and colours that are grey everywhere, take a quarter of the memory.
    if (channels.length < 3 || (r === g && g === b)) {
      this.textures.set(key, { grey: 1, texture: this.texture(gl.R16F, gl.RED, size, size, gl.HALF_FLOAT, r) });
      return;
    }
    const values = new Uint16Array(4 * texels);
    for (let i = 0; i < texels; i++) {
      values[4 * i] = r[i];
      values[4 * i + 1] = g[i];
      values[4 * i + 2] = b[i];
      values[4 * i + 3] = 0x3c00;
    }
    this.textures.set(key, { grey: 0, texture: this.texture(gl.RGBA16F, gl.RGBA, size, size, gl.HALF_FLOAT, values) });
  }

  /** Draws a look: { kind, first, second, part, factor, low, high }; false where a texture is not there yet. */
  draw(camera, instances, radius, look, cull) {
    const gl = this.gl, canvas = gl.canvas, p = this.places;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(p.camera, false, camera.matrix(canvas.width / canvas.height, radius));
    for (const name of ["part", "factor", "low", "high"]) gl.uniform1f(p[name], look[name]);
    const bind = (unit, place, texture) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.uniform1i(place, unit);
    };
    bind(2, p.palette, this.palette);
    (cull ? gl.enable : gl.disable).call(gl, gl.CULL_FACE);
    for (const instance of instances) {
      const mesh = this.meshes[instance.mesh];
      const [a, b] = [look.first, look.second].map((layer) => this.textures.get(`${mesh.page}.${layer}`));
      const lit = mesh.page >= 0 && (look.kind === "density" || (a && b));
      gl.uniform1i(p.kind, lit ? KINDS[look.kind] : KINDS.none);
      bind(0, p.first, a ? a.texture : this.palette);
      bind(1, p.second, b ? b.texture : this.palette);
      gl.uniform1i(p.grey, lit && a ? a.grey + 2 * b.grey : 0);
      const cutout = mesh.cutout, clear = cutout && cutout.cutoff < 0;
      if (this.live) this.live.bind(look, camera, mesh.page);
      bind(3, p.alphas, cutout && cutout.picture >= 0 ? this.pictures[cutout.picture] : this.whole);
      gl.uniform1f(p.cutoff, cutout ? cutout.cutoff : 0);
      (clear ? gl.enable : gl.disable).call(gl, gl.SAMPLE_ALPHA_TO_COVERAGE);
      gl.uniform1f(p.size, mesh.page >= 0 ? head.pages[mesh.page].texels : 1);
      gl.uniformMatrix4fv(p.place, false, instance.matrix);
      gl.frontFace(instance.mirrored ? gl.CW : gl.CCW);
      gl.bindVertexArray(mesh.array);
      gl.drawElements(gl.TRIANGLES, mesh.count, gl.UNSIGNED_INT, 0);
    }
  }
}
