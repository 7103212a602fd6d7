//! The shaders for any view, run by a browser, against the same numbers evaluated here.

use crate::support::{Page, bake, exr_layer, node, scene, skip};
use ambient::any_view::{Coefficients, Lobe, count};
use glam::DVec3;
use serde_json::{Value, json};
use std::path::Path;

/// Columns of a case: the numbers, the normal, the vector to the eye, and the row of the kernels.
const COLUMNS: usize = 45 + 3 + 3 + 1;

/// The function in GLSL, as it is written, in a fragment shader.
fn from_glsl(text: &str) -> Value {
    let source = format!(
        "#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D kernels, cases;
out vec4 found;
{text}
float at(int k) {{ return texelFetch(cases, ivec2(k, int(gl_FragCoord.y)), 0).r; }}
void main() {{
    float c[ANY_VIEW_COUNT];
    for (int k = 0; k < ANY_VIEW_COUNT; ++k) c[k] = at(k);
    found = vec4(anyView(c, vec3(at(45), at(46), at(47)), vec3(at(48), at(49), at(50)), kernels, at(51)));
}}
"
    );
    json!({ "source": source, "kernel": "kernels", "cases": "cases" })
}

/// The function in WGSL, as it is written, in a fragment shader that naga translates for WebGL.
fn from_wgsl(text: &str) -> Value {
    use naga::back::glsl::{Options, PipelineOptions, Version, Writer, WriterFlags};
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    let source = format!(
        "@group(0) @binding(0) var kernels: texture_2d<f32>;
@group(0) @binding(1) var linear_filter: sampler;
@group(0) @binding(2) var cases: texture_2d<f32>;
{text}
fn at(k: i32, y: i32) -> f32 {{ return textureLoad(cases, vec2<i32>(k, y), 0).r; }}
@fragment fn main(@builtin(position) place: vec4<f32>) -> @location(0) vec4<f32> {{
    let y = i32(place.y);
    var c: array<f32, ANY_VIEW_COUNT>;
    for (var k = 0; k < ANY_VIEW_COUNT; k++) {{ c[k] = at(k, y); }}
    let n = vec3<f32>(at(45, y), at(46, y), at(47, y));
    let v = vec3<f32>(at(48, y), at(49, y), at(50, y));
    return vec4<f32>(any_view(&c, n, v, kernels, linear_filter, at(51, y)));
}}
"
    );
    let module = naga::front::wgsl::parse_str(&source)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
    let options = Options {
        version: Version::Embedded {
            version: 300,
            is_webgl: true,
        },
        writer_flags: WriterFlags::empty(),
        ..Options::default()
    };
    let pipeline = PipelineOptions {
        shader_stage: naga::ShaderStage::Fragment,
        entry_point: "main".into(),
        multiview: None,
    };
    let mut glsl = String::new();
    let policies = naga::proc::BoundsCheckPolicies::default();
    let named = Writer::new(&mut glsl, &module, &info, &options, &pipeline, policies)
        .and_then(|mut writer| writer.write())
        .expect("WebGL has all that the shader uses");
    let name = |wanted: &str| {
        let mut textures = named.texture_mapping.iter();
        let found = textures.find(|(_, mapping)| {
            module.global_variables[mapping.texture].name.as_deref() == Some(wanted)
        });
        found.map(|(name, _)| name.clone()).expect("it is used")
    };
    json!({ "source": glsl, "kernel": name("kernels"), "cases": name("cases") })
}

/// The texels of a page as numbers, normal.
fn texels(page: &Page, layer: &str, order: usize) -> Vec<(Coefficients, DVec3)> {
    let coverage = page.plane("coverage");
    let covered = (0..coverage.len()).filter(|&at| coverage[at] > 0.0);
    let texel = |at: usize| {
        let mut numbers = Coefficients::default();
        for k in 0..count(order) {
            numbers.0[k] = f64::from(page.plane(&format!("{layer}.{k:02}"))[at]);
        }
        let axes = ["X", "Y", "Z"].map(|a| f64::from(page.plane(&format!("normal.{a}"))[at]));
        (numbers, DVec3::from(axes))
    };
    covered.map(texel).collect()
}

#[test]
fn shaders_give_the_numbers_of_this_program_at_thirty_views() {
    for (layer, order) in [("any-view", 4), ("any-view.8", 8)] {
        let only = format!("{layer},normal,coverage");
        let small = ["--size", "32", "--rays", "64", "--only", &only];
        let path = scene("wall_long.obj");
        let (folder, page) = bake(&path, &small);
        let file = |ending: &str| folder.path().join(format!("wall_long.any-view.{ending}"));
        let text = |ending: &str| std::fs::read_to_string(file(ending)).expect("written");
        let kernel = kernels(&file("exr"));

        let all = texels(&page, layer, order);
        let (mut rows, mut expected) = (Vec::new(), Vec::new());
        for (numbers, normal) in all.iter().step_by(all.len() / 40) {
            let (along, across) = normal.any_orthonormal_pair();
            for view in 0..30 {
                // Every third view lies halfway between two of the table's 49 columns, the others on one; all lie on a
                // row.
                let between = view % 3 == 0;
                let column = f64::from(view * 3 / 2) + if between { 0.5 } else { 0.0 };
                let (sine, cosine) = (column * std::f64::consts::FRAC_PI_2 / 48.0).sin_cos();
                let (s, c) = (2.4 * f64::from(view)).sin_cos();
                let eye = *normal * cosine + (along * c + across * s) * sine;
                let row = f64::from(view % 5) * 4.0;
                let exponent = (row / 4.0).exp2() - 1.0;
                let mut case = numbers.0[..45].to_vec();
                case.extend(normal.to_array());
                case.extend(eye.to_array());
                case.push(row);
                assert_eq!(case.len(), COLUMNS);
                rows.extend(case);
                let exact = numbers.specular(order, Lobe::Phong(exponent), *normal, eye);
                expected.push((exact, between));
            }
        }
        let input = json!({
            "kernel": { "width": 49, "values": kernel },
            "cases": { "width": COLUMNS, "values": rows },
            "shaders": [from_glsl(&text("glsl")), from_wgsl(&text("wgsl"))],
        });
        let Some(found) = in_browser(folder.path(), &input) else {
            return;
        };
        for (language, values) in ["GLSL", "WGSL"].iter().zip(found.as_array().expect("two")) {
            let values: Vec<f64> = values
                .as_array()
                .expect("numbers")
                .iter()
                .map(|v| v.as_f64().expect("a number"))
                .collect();
            assert_eq!(values.len(), expected.len());
            let mut worst = [0.0f64; 2];
            for (value, (exact, between)) in values.iter().zip(&expected) {
                let worst = &mut worst[usize::from(*between)];
                *worst = worst.max((value - exact).abs());
            }
            println!("{language}, order {order}: {worst:?}");
            // On a column of the table a filter still misses its place by up to 1/256 of a column: that of order 8
            // changes by at most 8 x 1.9 degrees / 256 = 0.001 there, and numbers add up to about 1.
            assert!(worst[0] < 0.002, "{language}, order {order}: {worst:?}");
            // Halfway between columns a straight line misses a wave of order l by l (l + 1) h^2 / 8, 0.0096 for order
            // 8.
            assert!(worst[1] < 0.0096, "{language}, order {order}: {worst:?}");
        }
    }
}

/// The picture of the kernels, rows from the top.
fn kernels(path: &Path) -> Vec<f32> {
    let channel = &exr_layer(path).channel_data.list[0];
    channel.sample_data.values_as_f32().collect()
}

/// What the shaders give, a list each; `None` where there is no browser.
fn in_browser(folder: &Path, input: &Value) -> Option<Value> {
    let path = folder.join("input.json");
    std::fs::write(&path, input.to_string()).expect("written");
    let found = node("any-view.mjs", &[path.as_os_str()]);
    let found = found.map_err(|reason| skip(&reason)).ok()?;
    assert_eq!(found["complaints"], json!([]), "{found}");
    Some(found["out"].clone())
}
