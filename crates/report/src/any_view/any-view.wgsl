// The specular term of ambake for any view: 0 where the lobe is blocked, and at most what an open texel has.
//
// c       the texel's numbers: channels any-view.00 to any-view.14, or any-view.8.00 to any-view.8.44
// n, v    unit normal of the texel (layer `normal`) and unit vector to the eye, in world space
// kernel  STEM.any-view.exr, row 0 at y = 0; `linear` is a bilinear sampler that clamps
// row     4 log2(exponent + 1); with --model ggx 32 sqrt(alpha), which is 32 times glTF's roughness
//
// Multiply by the sky's radiance and the specular colour.
const ANY_VIEW_ORDER: i32 = 4; // 8 for any-view.8
const ANY_VIEW_COUNT: i32 = (ANY_VIEW_ORDER + 1) * (ANY_VIEW_ORDER + 2) / 2;

fn any_view(c: ptr<function, array<f32, ANY_VIEW_COUNT>>, n: vec3<f32>, v: vec3<f32>,
            kernel: texture_2d<f32>, linear: sampler, row: f32) -> f32 {
    let columns = 49.0;
    let rows = 33.0;
    let height = rows * f32((ANY_VIEW_ORDER + 2) * (ANY_VIEW_ORDER + 2) / 4);

    // The frame of the numbers: the shortest turn of a fixed axis onto the normal.
    let axis = vec3<f32>(2.0, 6.0, 3.0) / 7.0;
    let along = vec3<f32>(6.0, -3.0, 2.0) / 7.0;
    let tangent = along - (axis + n) * (dot(n, along) / (1.0 + dot(axis, n)));
    let bitangent = cross(n, tangent);

    // Angle and azimuth of the mirrored view.
    var turn = -vec2<f32>(dot(v, tangent), dot(v, bitangent));
    let sine = length(turn);
    turn = select(vec2<f32>(1.0, 0.0), turn / max(sine, 1e-6), sine > 1e-6);
    let twice = vec2<f32>(turn.x * turn.x - turn.y * turn.y, 2.0 * turn.x * turn.y);
    let angle = atan2(sine, max(dot(n, v), 0.0)) / 1.57079633;
    let x = (angle * (columns - 1.0) + 0.5) / columns;
    var y = clamp(row, 0.0, rows - 1.0) + 0.5;

    var open = 1.0;
    var sum = 0.0;
    for (var l = 0; l <= ANY_VIEW_ORDER; l++) {
        let first = l * (l + 1) / 2;
        var power = select(vec2<f32>(1.0, 0.0), turn, l % 2 == 1);
        for (var m = l % 2; m <= l; m += 2) {
            let k = textureSampleLevel(kernel, linear, vec2<f32>(x, y / height), 0.0).r;
            let odd = select(power.y * (*c)[first + (l - m) / 2], 0.0, m == 0);
            sum += k * (power.x * (*c)[first + (l + m) / 2] + odd);
            open = select(open, k, l == 0);
            power = vec2<f32>(power.x * twice.x - power.y * twice.y, power.x * twice.y + power.y * twice.x);
            y += rows;
        }
    }
    return clamp(sum, 0.0, open);
}
