// The specular term for the view that is looked from: harmonics of the open directions, evaluated by the function that a bake writes
// for shaders.

/** That function; empty where the bake has no layer for any view. */
const ANY_VIEW = `{{anyView}}`;
const LIVE_HEAD = ANY_VIEW && `uniform highp sampler2DArray harmonics; uniform sampler2D normals, exponents, kernel;
uniform vec3 eye, sky; uniform bool coloured;
${ANY_VIEW}`;
const LIVE_BODY = ANY_VIEW && `
  else if (kind == 7) {
    float numbers[ANY_VIEW_COUNT];
    for (int i = 0; i < ANY_VIEW_COUNT; ++i) numbers[i] = texture(harmonics, vec3(at, float(i / 4)))[i % 4];
    vec3 n = normalize(texture(normals, at).rgb);
    float lobe = 4.0 * log2(texture(exponents, at).r + 1.0);
    float term = anyView(numbers, n, normalize(eye - world), kernel, lobe);
    c = srgb((coloured ? a + b * sky * term : vec3(term)) * factor);
  }`;

/** The layers that the view reads: lambert and reflectance where the bake has both, then normal and exponent. */
const LIVE_LAYERS = ["lambert", "reflectance", "normal", "exponent"];

/** The view, where the file holds what it needs. Colours need one radiance of the sky; of a map the term alone is shown. */
function liveView() {
  const [lambert, reflectance, normal, exponent] = LIVE_LAYERS.map(layerIndex);
  if (!ANY_VIEW || normal < 0 || exponent < 0 || !head.pages.some((page) => page.harmonics.length)) return null;
  const sky = (head.bake.options || {}).sky, coloured = lambert >= 0 && reflectance >= 0 && Array.isArray(sky);
  return {
    name: "live", kind: "live", label: coloured ? "Live: Phong for the view" : "Live: specular term for the view", coloured, sky: coloured ? sky : [1, 1, 1],
    layers: coloured ? [lambert, reflectance, normal, exponent] : [normal, normal, normal, exponent],
  };
}

class Live {
  constructor(painter) {
    const gl = painter.gl;
    Object.assign(this, { painter, gl, pages: new Map() });
    // Without filtered floats the kernels are looked up at their nearest texel.
    this.filters = gl.getExtension("OES_texture_float_linear") ? gl.LINEAR : gl.NEAREST;
    const names = ["harmonics", "normals", "exponents", "kernel", "eye", "sky", "coloured"];
    this.places = Object.fromEntries(names.map((name) => [name, gl.getUniformLocation(painter.program, name)]));
    this.none = this.array(1, 1, new Uint16Array(4));
    names.slice(0, 4).forEach((name, k) => gl.uniform1i(this.places[name], 4 + k));
  }

  /** An array of pictures of four half floats. */
  array(size, layers, values) {
    const gl = this.gl, texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
    gl.texImage3D(gl.TEXTURE_2D_ARRAY, 0, gl.RGBA16F, size, size, layers, 0, gl.RGBA, gl.HALF_FLOAT, values);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D_ARRAY, filter, gl.LINEAR);
    for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D_ARRAY, wrap, gl.CLAMP_TO_EDGE);
    return texture;
  }

  /** Makes what a page needs, where it is not there yet. */
  async need(page) {
    const gl = this.gl;
    if (!this.kernel) {
      const values = new Float32Array((await bytesOf("kernel")).buffer), columns = head.kernel.columns;
      this.kernel = this.painter.texture(gl.R32F, gl.RED, columns, values.length / columns, gl.FLOAT, values);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, this.filters);
    }
    if (this.pages.has(page)) return;
    const planes = await Promise.all(head.pages[page].harmonics.map((plane) => planeOn(page, plane)));
    if (this.pages.has(page) || !planes.length) return;
    const size = head.pages[page].size, texels = size * size, layers = Math.ceil(planes.length / 4);
    const values = new Uint16Array(4 * texels * layers);
    planes.forEach((plane, k) => {
      const first = 4 * texels * (k >> 2) + k % 4;
      for (let i = 0; i < texels; i++) values[first + 4 * i] = plane[i];
    });
    this.pages.set(page, this.array(size, layers, values));
  }

  /** Binds what a page needs; every draw call of the program needs something there. */
  bind(look, camera, page) {
    const { gl, places, painter } = this;
    const live = look.kind === "live" && this.pages.has(page);
    const texture = (layer) => (painter.textures.get(`${page}.${layer}`) || { texture: painter.palette }).texture;
    const flat = live ? [texture(look.layers[2]), texture(look.layers[3]), this.kernel] : [painter.palette, painter.palette, painter.palette];
    gl.activeTexture(gl.TEXTURE4);
    gl.bindTexture(gl.TEXTURE_2D_ARRAY, live ? this.pages.get(page) : this.none);
    flat.forEach((texture, k) => {
      gl.activeTexture(gl.TEXTURE5 + k);
      gl.bindTexture(gl.TEXTURE_2D, texture);
    });
    if (!live) return;
    gl.uniform3fv(places.eye, camera.eye);
    gl.uniform3fv(places.sky, look.sky);
    gl.uniform1i(places.coloured, look.coloured);
  }
}
