// Runs fragment shaders in headless Chromium's WebGL 2 and prints what they give for each case.
//
//   node any-view.mjs INPUT.json
//
// INPUT.json: { kernel: { width, values }, cases: { width, values }, shaders: [{ source, kernel, cases }] }, a shader naming its two
// samplers. A case is a row of `cases`; a shader writes its number to the row's pixel. Prints one JSON object: a list of numbers for
// each shader, and complaints. Exit 77, with a reason, where a tool is absent.
import { readFileSync } from "node:fs";
import { launch } from "./browser.mjs";

const browser = await launch();
const page = await browser.newPage();
const found = await page.evaluate(({ kernel, cases, shaders }) => {
  const rows = cases.values.length / cases.width;
  const canvas = document.createElement("canvas");
  const gl = canvas.getContext("webgl2");
  for (const name of ["EXT_color_buffer_float", "OES_texture_float_linear"])
    if (!gl.getExtension(name)) return { complaints: [`there is no ${name}`] };
  const picture = (unit, { width, values }, filter) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R32F, width, values.length / width, 0, gl.RED, gl.FLOAT, new Float32Array(values));
    for (const key of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, key, filter);
    for (const key of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, key, gl.CLAMP_TO_EDGE);
  };
  picture(0, kernel, gl.LINEAR);
  picture(1, cases, gl.NEAREST);
  const target = gl.createTexture();
  gl.activeTexture(gl.TEXTURE2);
  gl.bindTexture(gl.TEXTURE_2D, target);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, 1, rows, 0, gl.RGBA, gl.FLOAT, null);
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
  gl.viewport(0, 0, 1, rows);
  const complaints = [], out = [];
  for (const { source, ...names } of shaders) {
    const program = gl.createProgram();
    const corner = "#version 300 es\nvoid main() { gl_Position = vec4(vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0, 0.0, 1.0); }";
    for (const [kind, text] of [[gl.VERTEX_SHADER, corner], [gl.FRAGMENT_SHADER, source]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) complaints.push(`${gl.getShaderInfoLog(shader)}\n${text}`);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    gl.useProgram(program);
    gl.uniform1i(gl.getUniformLocation(program, names.kernel), 0);
    gl.uniform1i(gl.getUniformLocation(program, names.cases), 1);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    const pixels = new Float32Array(4 * rows);
    gl.readPixels(0, 0, 1, rows, gl.RGBA, gl.FLOAT, pixels);
    out.push(Array.from({ length: rows }, (_, i) => pixels[4 * i]));
  }
  if (gl.getError()) complaints.push("WebGL has an error");
  return { complaints, out };
}, JSON.parse(readFileSync(process.argv[2], "utf8")));
await browser.close();
console.log(JSON.stringify(found));
