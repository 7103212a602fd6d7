//! Difference pictures: blue below, white at zero, red above, with a title and a legend of numbers.
//!
//! The colours run along straight lines in Oklab (Björn Ottosson, "A perceptual color space for image processing",
//! 2020) from white to lightness 0.5, so that equal steps of the difference look equally large on both sides.

use crate::compare::{differences, largest};
use crate::preview::Encoding;
use crate::{Error, Page, glyphs};
use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};

/// Colour steps on each side of zero: with zero, void and ink they fill a palette of 255 entries.
const STEPS: u8 = 126;
const ZERO: u8 = STEPS;
const VOID: u8 = 2 * STEPS + 1;
const INK: u8 = VOID + 1;

/// Lightness at the ends; chroma is the largest round number whose whole lines lie within sRGB.
const END_LIGHTNESS: f64 = 0.5;
const END_CHROMA: f64 = 0.2;
const BLUE_HUE_DEG: f64 = 264.0;
const RED_HUE_DEG: f64 = 29.0;

/// Small pages are enlarged to about this edge, in pixels, so that texels and legend can be seen.
const MIN_EDGE: usize = 512;

/// The limit of a scale that holds `maximum`: the next number of one digit at or above it, 1 for 0.
pub fn nice_limit(maximum: f64) -> f64 {
    if !(maximum > 0.0 && maximum.is_finite()) {
        return 1.0;
    }
    let decade = maximum.log10().floor() as i32;
    let numbers = (decade - 1..).flat_map(|e| (1..10).map(move |d| format!("{d}e{e}")));
    let mut numbers = numbers.map(|text| text.parse::<f64>().unwrap_or(f64::INFINITY));
    numbers
        .find(|&n| n >= maximum)
        .filter(|n| n.is_finite())
        .unwrap_or(f64::MAX)
}

/// The difference `a - b` of a page's two layers as a PNG file; of several channels the one that differs most.
///
/// * `limit`: the scale runs from `-limit` to `limit`, above 0; values beyond it get the end colours.
///
/// Texels of no chart, and those that hold a NaN, are grey. The bytes are a function of the arguments.
///
/// # Errors
/// [`Error::MissingLayer`] without one of the layers, [`Error::Mismatch`] where their channels differ.
///
/// # Panics
/// Where `limit` is not above 0: a bug of the caller.
pub fn difference_png(page: &Page, pair: (&str, &str), limit: f64) -> Result<Vec<u8>, Error> {
    let differences = differences(page, pair)?;
    let coverage = page.values("coverage");
    let value = |i: usize| {
        let values = differences(i);
        let known = values.iter().all(|v| v.is_finite());
        (known && coverage.is_none_or(|c| c[i] > 0.0)).then(|| largest(&values))
    };
    let title = format!("{} - {}", pair.0, pair.1);
    Ok(difference_picture([page.size; 2], &title, limit, value))
}

/// A picture of signed values, `size` texels wide and high, by texel number; `None` is void. Otherwise as
/// [`difference_png`].
pub fn difference_picture(
    size: [u32; 2],
    title: &str,
    limit: f64,
    value: impl Fn(usize) -> Option<f64>,
) -> Vec<u8> {
    assert!(limit > 0.0, "a scale needs a limit above 0, not {limit}");
    let [across, down] = size.map(|edge| edge as usize);
    let zoom = (MIN_EDGE / across.max(down)).max(1);
    let edge = across * zoom;
    let dot = (edge / MIN_EDGE).max(1);
    let margin = 8 * dot;
    let text = glyphs::HEIGHT * dot;
    let width = edge.max(glyphs::width(title) * dot).max(MIN_EDGE / 2) + 2 * margin;
    // From the top: title, texels, scale, ticks, numbers, each with a margin below.
    let top = text + 2 * margin;
    let scale = top + down * zoom + margin;
    let ticks = scale + 2 * text;
    let numbers = ticks + 4 * dot;
    let height = numbers + text + margin;

    let mut picture = Picture {
        width,
        pixels: vec![ZERO; width * height],
    };
    picture.text(margin, margin, dot, title);
    let left = (width - edge) / 2;
    for y in 0..down * zoom {
        let row = &mut picture.pixels[(top + y) * width + left..][..edge];
        for (x, texel) in row.chunks_exact_mut(zoom).enumerate() {
            texel.fill(value(y / zoom * across + x).map_or(VOID, |v| color_index(v / limit)));
        }
    }
    // The scale leaves room for half of the outer numbers on either side.
    let inset = margin + glyphs::width("-0.000015") * dot / 2;
    let length = width - 2 * inset;
    for y in scale..ticks {
        for x in 0..length {
            let unit = 2.0 * x as f64 / (length - 1) as f64 - 1.0;
            picture.pixels[y * width + inset + x] = color_index(unit);
        }
    }
    for (step, fraction) in [-1.0, -0.5, 0.0, 0.5, 1.0].into_iter().enumerate() {
        let x = inset + step * (length - dot) / 4;
        picture.fill([x, ticks], [dot, 3 * dot]);
        let label = number(fraction * limit);
        let half = glyphs::width(&label) * dot / 2;
        picture.text(x + dot / 2 - half.min(x), numbers, dot, &label);
    }
    picture.encode(height, title)
}

/// Palette entry of a difference in units of the limit.
fn color_index(unit: f64) -> u8 {
    let steps = (unit.clamp(-1.0, 1.0) * f64::from(STEPS)).round();
    (steps + f64::from(ZERO)) as u8
}

/// A tick's number: signed, short, with an exponent where the plain digits would be many.
fn number(value: f64) -> String {
    let sign = if value > 0.0 { "+" } else { "" };
    if value == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&value.abs()) {
        format!("{sign}{value}")
    } else {
        format!("{sign}{value:e}")
    }
}

/// The colours of all palette entries, sRGB.
fn palette() -> Vec<u8> {
    let mut colors = Vec::with_capacity(3 * usize::from(INK) + 3);
    for entry in 0..VOID {
        let unit = (f64::from(entry) - f64::from(ZERO)) / f64::from(STEPS);
        colors.extend(linear_color(unit).map(|c| Encoding::Srgb.byte(c as f32)));
    }
    colors.extend([128; 3]);
    colors.extend([0; 3]);
    colors
}

/// Linear sRGB of a difference in units of the limit.
fn linear_color(unit: f64) -> [f64; 3] {
    let hue = if unit < 0.0 {
        BLUE_HUE_DEG
    } else {
        RED_HUE_DEG
    };
    let (sin, cos) = hue.to_radians().sin_cos();
    let lightness = 1.0 - (1.0 - END_LIGHTNESS) * unit.abs();
    let chroma = END_CHROMA * unit.abs();
    oklab_to_linear([lightness, chroma * cos, chroma * sin])
}

/// Oklab to linear sRGB, with the matrices of the paper.
fn oklab_to_linear([l, a, b]: [f64; 3]) -> [f64; 3] {
    let cube = |v: f64| v * v * v;
    let long = cube(l + 0.396_337_777_4 * a + 0.215_803_757_3 * b);
    let medium = cube(l - 0.105_561_345_8 * a - 0.063_854_172_8 * b);
    let short = cube(l - 0.089_484_177_5 * a - 1.291_485_548 * b);
    [
        4.076_741_662_1 * long - 3.307_711_591_3 * medium + 0.230_969_929_2 * short,
        -1.268_438_004_6 * long + 2.609_757_401_1 * medium - 0.341_319_396_5 * short,
        -0.004_196_086_3 * long - 0.703_418_614_7 * medium + 1.707_614_701 * short,
    ]
}

/// Palette entries, rows from the top.
struct Picture {
    width: usize,
    pixels: Vec<u8>,
}

impl Picture {
    fn fill(&mut self, [x, y]: [usize; 2], [width, height]: [usize; 2]) {
        for row in y..y + height {
            self.pixels[row * self.width + x..][..width].fill(INK);
        }
    }

    fn text(&mut self, left: usize, top: usize, dot: usize, text: &str) {
        glyphs::draw(text, |x, y| {
            self.fill([left + x * dot, top + y * dot], [dot, dot]);
        });
    }

    fn encode(&self, height: usize, title: &str) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, self.width as u32, height as u32);
        encoder.set_color(ColorType::Indexed);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_palette(palette());
        encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
        let why = "a PNG in memory with matching sizes";
        let text = title.to_owned();
        encoder.add_itxt_chunk("Title".into(), text).expect(why);
        let mut writer = encoder.write_header().expect(why);
        writer.write_image_data(&self.pixels).expect(why);
        writer.finish().expect(why);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PageLayer;
    use crate::preview::decoded;

    #[test]
    fn zero_is_white_and_both_sides_lie_within_srgb_to_lightness_half() {
        let palette = palette();
        assert_eq!(palette.len(), 255 * 3);
        let color = |unit: f64| &palette[usize::from(color_index(unit)) * 3..][..3];
        assert_eq!(color(0.0), [255; 3]);
        assert_eq!((color_index(-7.0), color_index(1.0)), (0, 2 * STEPS));
        for step in 1..=STEPS {
            for unit in [-1.0, 1.0].map(|sign| sign * f64::from(step) / f64::from(STEPS)) {
                let color = linear_color(unit);
                assert!(
                    color.iter().all(|c| (0.0..=1.0).contains(c)),
                    "{unit}: {color:?}"
                );
            }
        }
        assert!(color(1.0)[0] > 3 * color(1.0)[2], "{:?}", color(1.0));
        assert!(color(-1.0)[2] > 2 * color(-1.0)[0], "{:?}", color(-1.0));
    }

    #[test]
    fn limits_are_the_next_number_of_one_digit() {
        let limits = [0.0, 0.3, 0.31, 0.95, 1.0, 1.2, 7e-5, 4096.0].map(nice_limit);
        assert_eq!(limits, [1.0, 0.3, 0.4, 1.0, 1.0, 2.0, 7e-5, 5000.0]);
        assert_eq!(
            [0.35, -0.2, 0.0, 7e-5].map(number),
            ["+0.35", "-0.2", "0", "+7e-5"]
        );
        assert!(nice_limit(f64::MAX) >= f64::MAX);
    }

    #[test]
    fn texels_stand_under_the_title_enlarged_and_void_is_grey() {
        let page = Page {
            size: 2,
            layers: vec![
                PageLayer::scalar("coverage", vec![1.0, 0.5, 0.0, 0.5]),
                PageLayer::scalar("a", vec![1.0, 0.5, 9.0, 0.25]),
                PageLayer::scalar("b", vec![0.5, 0.5, 0.0, 0.75]),
            ],
        };
        let bytes = difference_png(&page, ("a", "b"), 0.5).unwrap();
        assert_eq!(bytes, difference_png(&page, ("a", "b"), 0.5).unwrap());
        let (width, pixels) = decoded(&bytes);
        let at = |x: usize, y: usize| pixels[(23 + y) * width + 8 + x];
        assert_eq!([at(0, 0), at(255, 255)], [2 * STEPS; 2]);
        assert_eq!([at(256, 0), at(0, 256), at(511, 511)], [ZERO, VOID, 0]);
        assert!(pixels[..8 * width].iter().all(|&p| p == ZERO));
    }

    #[test]
    fn the_scale_runs_from_end_to_end_over_its_ticks() {
        // Wider than its texels, so that these stand in the middle.
        let title = "a title that is wider than the texels of this picture ".repeat(4);
        let bytes = difference_picture([4, 2], &title, 2.0, |i| Some(i as f64 / 2.0));
        let (width, pixels) = decoded(&bytes);
        let height = pixels.len() / width;
        let row = |y: usize| &pixels[y * width..][..width];
        let text = glyphs::HEIGHT;
        assert_eq!(width, glyphs::width(&title) + 16);
        let (top, left) = (text + 16, (width - 512) / 2);
        for (i, column) in [0, 128, 256, 384].into_iter().enumerate() {
            for line in [0, 1] {
                let entry = color_index((i + 4 * line) as f64 / 4.0);
                for texel in [left + column, left + column + 127] {
                    assert_eq!(row(top + 128 * line)[texel], entry, "{i} {line}");
                    assert_eq!(row(top + 128 * line + 127)[texel], entry, "{i} {line}");
                }
            }
        }
        assert_eq!([row(top)[left - 1], row(top - 1)[left]], [ZERO; 2]);
        // Below them a margin, the scale, its ticks and their numbers.
        let scale = top + 256 + 8;
        let inset = 8 + glyphs::width("-0.000015") / 2;
        let (first, last) = (inset, width - inset - 1);
        assert!(row(scale - 1).iter().all(|&p| p == ZERO));
        for y in [scale, scale + 2 * text - 1] {
            let line = row(y);
            assert!(line[..first].iter().all(|&p| p == ZERO));
            assert!(line[last + 1..].iter().all(|&p| p == ZERO));
            assert_eq!([line[first], line[last]], [0, 2 * STEPS]);
            assert!(line[first..=last].is_sorted());
            assert_eq!(line[(first + last) / 2], ZERO);
        }
        let ticks = scale + 2 * text;
        let inked = |y: usize| (0..width).filter(move |&x| row(y)[x] == INK);
        for y in [ticks, ticks + 2] {
            let quarters = (0..5).map(|step| first + step * (last - first) / 4);
            assert!(inked(y).eq(quarters), "{:?}", inked(y).collect::<Vec<_>>());
        }
        assert_eq!(inked(ticks + 3).count(), 0);
        let numbers = ticks + 4;
        assert_eq!(height, numbers + text + 8);
        // Each number stands under its tick.
        let mut marks: Vec<usize> = (numbers..numbers + text).flat_map(inked).collect();
        marks.sort_unstable();
        for (step, label) in ["-2", "-1", "0", "+1", "+2"].into_iter().enumerate() {
            let (tick, half) = (first + step * (last - first) / 4, glyphs::width(label) / 2);
            let own = marks.iter().filter(|x| x.abs_diff(tick) <= half + 1);
            assert!(own.count() > 8, "{label}: {tick} {marks:?}");
        }
    }

    #[test]
    fn half_a_step_down_is_lighter_than_the_end() {
        // Entries run from the blue end over white to the red one; grey and black follow.
        let palette = palette();
        let sum = |entry: u8| -> u32 {
            let at = usize::from(entry) * 3;
            palette[at..at + 3].iter().map(|&c| u32::from(c)).sum()
        };
        for entry in 0..ZERO {
            assert!(sum(entry) <= sum(entry + 1), "{entry}");
            assert!(
                sum(2 * ZERO - entry) <= sum(2 * ZERO - entry - 1),
                "{entry}"
            );
        }
        assert!(sum(0) + 100 < sum(ZERO / 2) && sum(ZERO / 2) + 100 < sum(ZERO));
        assert_eq!([sum(VOID), sum(INK)], [3 * 128, 0]);
    }
}
