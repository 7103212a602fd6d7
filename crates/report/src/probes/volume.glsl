// Light from a volume of probes that ambake wrote: E / pi on a surface, linear RGB. Multiply it by the albedo.
//
// The texture STEM.probes.three.ktx2 holds nine slabs along z, a coefficient each of
// 1; y, z, x; xy, yz, 3z^2 - 1, xz, x^2 - y^2 of the normal. STEM.probes.json has the box: center and size.
// Linear filters, clamped to the edge.
precision highp sampler3D;
uniform sampler3D ambake_volume;
uniform vec3 ambake_center;
uniform vec3 ambake_size;

vec3 ambake_light(vec3 position, vec3 normal) {
  vec3 texels = vec3(textureSize(ambake_volume, 0)) / vec3(1.0, 1.0, 9.0);
  vec3 place = (position - ambake_center) / ambake_size + 0.5;
  // Within the middles of the outermost texels, so that no slab is mixed with the next.
  place = clamp(place, 0.5 / texels, 1.0 - 0.5 / texels);
  vec3 n = normal;
  float terms[9] = float[9](1.0, n.y, n.z, n.x, n.x * n.y, n.y * n.z, 3.0 * n.z * n.z - 1.0, n.x * n.z, n.x * n.x - n.y * n.y);
  vec3 light = vec3(0.0);
  for (int k = 0; k < 9; k++) {
    light += terms[k] * texture(ambake_volume, vec3(place.xy, (float(k) + place.z) / 9.0)).rgb;
  }
  return max(light, vec3(0.0));
}
