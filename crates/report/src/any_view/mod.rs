//! The files beside pages of harmonics: the kernels as a picture, and functions for shaders.

use crate::exr_write::plain_exr;
use crate::{Error, Output};
use exr::image::{AnyChannel, FlatSamples};

const GLSL: &str = include_str!("any-view.glsl");
const WGSL: &str = include_str!("any-view.wgsl");

/// The names of the files: kernels, GLSL, WGSL.
pub fn any_view_files(stem: &str) -> [String; 3] {
    ["exr", "glsl", "wgsl"].map(|ending| format!("{stem}.any-view.{ending}"))
}

/// Stages the files for harmonics up to `order`, with a picture of kernels `columns` wide, rows from the top.
///
/// # Errors
/// A file that cannot be written.
pub fn stage_any_view(
    output: &mut Output,
    stem: &str,
    order: u32,
    columns: usize,
    kernels: Vec<f32>,
) -> Result<(), Error> {
    let [kernel, glsl, wgsl] = any_view_files(stem);
    output.stage_bytes(&kernel, &encode(columns, kernels))?;
    for (name, text) in [(glsl, GLSL), (wgsl, WGSL)] {
        output.stage_bytes(&name, shader(text, order).as_bytes())?;
    }
    Ok(())
}

/// The function for GLSL, for an order, without the lines of comment above it.
pub fn glsl(order: u32) -> String {
    let text = shader(GLSL, order);
    let code = text.lines().filter(|line| !line.starts_with("//"));
    code.map(|line| format!("{line}\n")).collect()
}

/// A shader's text for an order.
fn shader(text: &str, order: u32) -> String {
    text.replace("= 4; // 8 for any-view.8", &format!("= {order};"))
}

/// One channel, `Y`, 32-bit floats.
fn encode(columns: usize, values: Vec<f32>) -> Vec<u8> {
    let size = (columns, values.len() / columns);
    plain_exr(size, [AnyChannel::new("Y", FlatSamples::F32(values))])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shaders_are_short_take_their_order_and_say_the_same() {
        for text in [GLSL, WGSL] {
            assert!(text.lines().count() < 60);
            let eighth = shader(text, 8);
            assert!(eighth.contains("= 8;") && !eighth.contains("= 4;"));
        }
        // The same steps, whatever the language calls its types.
        let plain = |text: &str| {
            let body = &text[text.find("axis =").expect("a frame")..];
            let words = [
                "vec3<f32>",
                "vec2<f32>",
                "vec3",
                "vec2",
                "let",
                "var",
                "float",
                " ",
            ];
            let mut body = body.replace("(*c)", "c");
            for word in words {
                body = body.replace(word, "");
            }
            body
        };
        let (glsl, wgsl) = (plain(GLSL), plain(WGSL));
        for step in [
            "tangent=along-(axis+n)*(dot(n,along)/(1.0+dot(axis,n)));",
            "twice=(turn.x*turn.x-turn.y*turn.y,2.0*turn.x*turn.y);",
            "x=(angle*(columns-1.0)+0.5)/columns;",
            "sum+=k*(power.x*c[first+(l+m)/2]+odd);",
            "power=(power.x*twice.x-power.y*twice.y,power.x*twice.y+power.y*twice.x);",
            "returnclamp(sum,0.0,open);",
        ] {
            assert!(glsl.contains(step) && wgsl.contains(step), "{step}");
        }
    }
}
