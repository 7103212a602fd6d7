// The specular term of ambake for any view: 0 where the lobe is blocked, and at most what an open texel has.
//
// c       the texel's numbers: channels any-view.00 to any-view.14, or any-view.8.00 to any-view.8.44
// n, v    unit normal of the texel (layer `normal`) and unit vector to the eye, in world space
// kernel  STEM.any-view.exr, row 0 at y = 0, bilinear, without mip levels
// row     4 log2(exponent + 1); with --model ggx 32 sqrt(alpha), which is 32 times glTF's roughness
//
// Multiply by the sky's radiance and the specular colour.
const int ANY_VIEW_ORDER = 4; // 8 for any-view.8
const int ANY_VIEW_COUNT = (ANY_VIEW_ORDER + 1) * (ANY_VIEW_ORDER + 2) / 2;

float anyView(float c[ANY_VIEW_COUNT], vec3 n, vec3 v, sampler2D kernel, float row) {
    const float columns = 49.0;
    const float rows = 33.0;
    float height = rows * float((ANY_VIEW_ORDER + 2) * (ANY_VIEW_ORDER + 2) / 4);

    // The frame of the numbers: the shortest turn of a fixed axis onto the normal.
    vec3 axis = vec3(2.0, 6.0, 3.0) / 7.0;
    vec3 along = vec3(6.0, -3.0, 2.0) / 7.0;
    vec3 tangent = along - (axis + n) * (dot(n, along) / (1.0 + dot(axis, n)));
    vec3 bitangent = cross(n, tangent);

    // Angle and azimuth of the mirrored view.
    vec2 turn = -vec2(dot(v, tangent), dot(v, bitangent));
    float sine = length(turn);
    turn = sine > 1e-6 ? turn / sine : vec2(1.0, 0.0);
    vec2 twice = vec2(turn.x * turn.x - turn.y * turn.y, 2.0 * turn.x * turn.y);
    float angle = atan(sine, max(dot(n, v), 0.0)) / 1.57079633;
    float x = (angle * (columns - 1.0) + 0.5) / columns;
    float y = clamp(row, 0.0, rows - 1.0) + 0.5;

    float open = 1.0;
    float sum = 0.0;
    for (int l = 0; l <= ANY_VIEW_ORDER; ++l) {
        int first = l * (l + 1) / 2;
        vec2 power = l % 2 == 1 ? turn : vec2(1.0, 0.0);
        for (int m = l % 2; m <= l; m += 2) {
            float k = textureLod(kernel, vec2(x, y / height), 0.0).r;
            float odd = m == 0 ? 0.0 : power.y * c[first + (l - m) / 2];
            sum += k * (power.x * c[first + (l + m) / 2] + odd);
            open = l == 0 ? k : open;
            power = vec2(power.x * twice.x - power.y * twice.y, power.x * twice.y + power.y * twice.x);
            y += rows;
        }
    }
    return clamp(sum, 0.0, open);
}
