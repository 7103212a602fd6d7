// Colours. Heat maps run along cividis (Nuñez, Anderton and Renslow, PLoS ONE 2018), which people with any colour vision read alike;
// differences along the scale of `ambake compare`: blue below, white at zero, red above.

const CIVIDIS = ["00224e", "123570", "3b496c", "575d6d", "707173", "8a8678", "a59c74", "c3b369", "e1cc55", "fee838"]
  .map((text) => [0, 2, 4].map((at) => parseInt(text.slice(at, at + 2), 16)));

/** The heat colour of a share. */
function heat(x) {
  const at = Math.min(Math.max(x, 0), 1) * (CIVIDIS.length - 1), low = Math.min(Math.floor(at), CIVIDIS.length - 2);
  return [0, 1, 2].map((k) => CIVIDIS[low][k] + (CIVIDIS[low + 1][k] - CIVIDIS[low][k]) * (at - low));
}

/** The sRGB byte of a linear value. */
function byteOf(value) {
  const v = Math.min(Math.max(value, 0), 1);
  return 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
}

/** The colour of a signed share, -1 to 1: straight lines in Oklab from white. */
function signed(x) {
  const t = Math.min(Math.abs(x), 1), hue = (x < 0 ? 264 : 29) * Math.PI / 180;
  const lightness = 1 - 0.5 * t, a = 0.2 * t * Math.cos(hue), b = 0.2 * t * Math.sin(hue);
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ].map(byteOf);
}

/** Two rows of 256 colours: heat, then signed. */
function palettes() {
  const bytes = new Uint8Array(2 * 256 * 4);
  for (let i = 0; i < 256; i++) {
    const rows = [heat(i / 255), signed(2 * i / 255 - 1)];
    rows.forEach((color, row) => bytes.set([...color.map(Math.round), 255], 4 * (256 * row + i)));
  }
  return bytes;
}

// What can be shown. `kind` is color, grey, vector, heat, difference, density or live; `layers` are the indices that it reads.
function views() {
  const list = [];
  const models = ["traditional", "lambert", "ggx", "phong"].map((name) => ({ name, layer: layerIndex(name) }))
    .filter((model) => model.layer >= 0);
  if (models.length > 1) list.push({ name: "lit", label: "Lit: compare models", kind: "models", models, layers: [] });
  for (const model of models.slice(1)) {
    if (models[0].name !== "traditional") break;
    const label = `Difference: traditional - ${model.name}`;
    list.push({ name: `difference.${model.name}`, label, kind: "difference", layers: [models[0].layer, model.layer] });
  }
  head.layers.forEach((layer, index) => {
    const kind = layer.kind;
    const label = kind === "heat" ? `Heat map: ${layer.name}` : layer.name;
    list.push({ name: layer.name, label, kind, layers: [index] });
  });
  const live = liveView();
  if (live) list.push(live);
  const rank = (view) => view.name === "error" ? 0 : view.kind === "heat" ? 1 : 2;
  const fixed = list.filter((view) => ["models", "difference", "live"].includes(view.kind));
  const others = list.filter((view) => !fixed.includes(view)).sort((a, b) => rank(a) - rank(b));
  fixed.push(...others.filter((view) => rank(view) === 0));
  fixed.push({ name: "density", label: "Heat map: density (texels per unit)", kind: "density", layers: [] });
  fixed.push(...others.filter((view) => rank(view) > 0));
  // First what looks like the scene.
  const first = ["models", "color", "grey"].map((kind) => fixed.find((view) => view.kind === kind)).find(Boolean) || fixed[0];
  return [first, ...fixed.filter((view) => view !== first)];
}
