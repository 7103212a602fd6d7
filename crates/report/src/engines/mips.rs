//! The page and its smaller levels. Texels beside charts repeat the nearest of their own chart, and no level mixes
//! charts that the layout keeps apart.

use super::{LightLevel, PageLight};
use atlas::Dilation;

/// The light of a page: as it is, and each level half as large up to those that the layout allows. No texel is void.
pub fn levels(page: &PageLight<'_>) -> Vec<LightLevel> {
    levels_of(page, |i| [0, 1, 2].map(|c: usize| page.light[c][i]))
}

/// The same of the diffuse term, which all three channels have.
pub fn occlusion(page: &PageLight<'_>) -> Vec<LightLevel> {
    levels_of(page, |i| [page.diffuse[i]; 3])
}

fn levels_of(page: &PageLight<'_>, value: impl Fn(usize) -> [f32; 3]) -> Vec<LightLevel> {
    // A half float ends here; E / pi of nothing real comes near.
    let clamp = |v: f32| v.clamp(0.0, half::f16::MAX.to_f32());
    let texel = |i: usize| value(i).map(clamp);
    let pixels = (0..page.coverage.len()).map(texel).collect();
    let mut level = LightLevel {
        size: page.size,
        pixels,
    };
    let mut weights = page.coverage.to_vec();
    let mut filled = is_filled(&weights, page.size, page.rings);
    let mut levels = Vec::new();
    for _ in 0..page.mips {
        if !level.size.is_multiple_of(2) {
            break;
        }
        let smaller = halve(&level, &mut weights);
        fill(&mut level.pixels, level.size, &filled);
        levels.push(std::mem::replace(&mut level, smaller));
        filled = grow(&mut level, &weights);
    }
    fill(&mut level.pixels, level.size, &filled);
    levels.push(level);
    levels
}

/// True for texels of charts and of the gutters that the bake filled.
pub fn is_filled(coverage: &[f32], size: u32, rings: u32) -> Vec<bool> {
    let mut filled: Vec<bool> = coverage.iter().map(|&c| c > 0.0).collect();
    for &texel in Dilation::new(coverage, size, rings).targets() {
        filled[texel as usize] = true;
    }
    filled
}

/// The level half as large: means weighted by what charts cover, which becomes the weight of the smaller texels.
fn halve(level: &LightLevel, weights: &mut Vec<f32>) -> LightLevel {
    let (edge, half) = (level.size as usize, level.size as usize / 2);
    let mut pixels = Vec::with_capacity(half * half);
    let mut sums = Vec::with_capacity(half * half);
    for i in 0..half * half {
        let first = i / half * 2 * edge + i % half * 2;
        let from = [first, first + 1, first + edge, first + edge + 1];
        let weight: f64 = from.iter().map(|&f| f64::from(weights[f])).sum();
        let mean = |c: usize| {
            let sum: f64 = from
                .iter()
                .map(|&f| f64::from(weights[f]) * f64::from(level.pixels[f][c]))
                .sum();
            if weight > 0.0 {
                (sum / weight) as f32
            } else {
                0.0
            }
        };
        pixels.push([0, 1, 2].map(mean));
        sums.push((weight / 4.0) as f32);
    }
    *weights = sums;
    LightLevel {
        size: level.size / 2,
        pixels,
    }
}

/// Fills rings around charts from their nearest texels, and tells which texels are filled then.
fn grow(level: &mut LightLevel, weights: &[f32]) -> Vec<bool> {
    let dilation = Dilation::new(weights, level.size, atlas::RINGS);
    for c in 0..3 {
        let mut plane: Vec<f32> = level.pixels.iter().map(|p| p[c]).collect();
        dilation.apply(&mut plane);
        for (pixel, value) in level.pixels.iter_mut().zip(plane) {
            pixel[c] = value;
        }
    }
    is_filled(weights, level.size, atlas::RINGS)
}

/// Fills what is left between charts with smooth means of what surrounds it, so that an engine's own mip levels and
/// compression meet no black: means of filled texels over ever larger squares, taken from the smallest that has one.
pub fn fill<const N: usize>(pixels: &mut [[f32; N]], size: u32, filled: &[bool]) {
    if filled.iter().all(|&filled| filled) || !filled.contains(&true) {
        return;
    }
    let edge = size as usize;
    let half = edge.div_ceil(2);
    let mut coarse = vec![[0.0; N]; half * half];
    let mut known = vec![false; half * half];
    for (i, (mean, known)) in coarse.iter_mut().zip(&mut known).enumerate() {
        let (x, y) = (i % half * 2, i / half * 2);
        let square =
            (y..(y + 2).min(edge)).flat_map(|y| (x..(x + 2).min(edge)).map(move |x| y * edge + x));
        let mut count = 0.0;
        for texel in square.filter(|&texel| filled[texel]) {
            count += 1.0;
            for c in 0..N {
                mean[c] += pixels[texel][c];
            }
        }
        *known = count > 0.0;
        *mean = mean.map(|sum| if count > 0.0 { sum / count } else { 0.0 });
    }
    fill(&mut coarse, half as u32, &known);
    for texel in (0..pixels.len()).filter(|&texel| !filled[texel]) {
        pixels[texel] = coarse[texel / edge / 2 * half + texel % edge / 2];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::borrow::Cow;

    /// Two charts of different light, `gap` texels apart, on a page of 32.
    fn page(gap: usize, mips: u32) -> PageLight<'static> {
        let side = |i: usize| match i % 32 {
            x if x < 16 - gap / 2 => Some(1.0),
            x if x >= 16 + gap / 2 => Some(3.0),
            _ => None,
        };
        let coverage: Vec<f32> = (0..1024)
            .map(|i| f32::from(u8::from(side(i).is_some())))
            .collect();
        let mut light: Vec<f32> = (0..1024).map(|i| side(i).unwrap_or(0.0)).collect();
        let rings = gap as u32 / 2;
        Dilation::new(&coverage, 32, rings).apply(&mut light);
        PageLight {
            page: 0,
            size: 32,
            rings,
            mips,
            coverage: Cow::Owned(coverage),
            diffuse: Cow::Owned(light.clone()),
            light: [0, 1, 2].map(|_| Cow::Owned(light.clone())),
            lit: None,
            sh: None,
        }
    }

    #[test]
    fn levels_do_not_mix_charts_that_the_gutter_keeps_apart() {
        let levels = levels(&page(8, 2));
        assert_eq!(
            levels.iter().map(|l| l.size).collect::<Vec<_>>(),
            [32, 16, 8]
        );
        for level in &levels {
            let middle = level.size as usize / 2;
            for (i, pixel) in level.pixels.iter().enumerate() {
                let x = i % level.size as usize;
                let expected = if x < middle { 1.0 } else { 3.0 };
                assert_eq!(*pixel, [expected; 3], "level of {}, column {x}", level.size);
            }
        }
    }

    #[test]
    fn what_no_gutter_reaches_is_filled_too_and_charts_stay() {
        let mut page = page(8, 0);
        page.rings = 1;
        let pixels = levels(&page).remove(0).pixels;
        assert!(
            pixels.iter().all(|p| p[0] >= 1.0 && p[0] <= 3.0),
            "no black"
        );
        for (pixel, coverage) in pixels.iter().zip(page.coverage.iter()) {
            assert!(*coverage == 0.0 || pixel[0] == 1.0 || pixel[0] == 3.0);
        }
    }

    #[test]
    fn an_empty_page_stays_black_and_odd_pages_have_one_level() {
        let mut void = page(8, 3);
        void.coverage = Cow::Owned(vec![0.0; 1024]);
        void.light = [0, 1, 2].map(|_| Cow::Owned(vec![0.0; 1024]));
        assert_eq!(levels(&void).len(), 4);
        let odd = PageLight {
            size: 1,
            coverage: Cow::Owned(vec![1.0]),
            light: [0, 1, 2].map(|_| Cow::Owned(vec![1e9])),
            ..void
        };
        let levels = levels(&odd);
        assert_eq!((levels.len(), levels[0].pixels[0]), (1, [65504.0; 3]));
    }

    #[test]
    fn a_void_takes_the_mean_of_the_smallest_square_that_has_light() {
        // One texel in each quarter of a page of 16, and none but one in an eighth.
        let mut pixels = vec![[0.0f32]; 256];
        let mut filled = vec![false; 256];
        for (x, y, value) in [(0, 0, 1.0), (15, 0, 2.0), (15, 15, 4.0), (4, 4, 9.0)] {
            pixels[y * 16 + x] = [value];
            filled[y * 16 + x] = true;
        }
        fill(&mut pixels, 16, &filled);
        let at = |x: usize, y: usize| pixels[y * 16 + x][0];
        assert_eq!([at(0, 0), at(1, 1), at(3, 3)], [1.0; 3]);
        assert_eq!([at(4, 4), at(5, 5), at(7, 7)], [9.0; 3]);
        // Two squares of four have light in the first quarter.
        assert_eq!([at(3, 4), at(7, 0)], [5.0; 2]);
        assert_eq!([at(8, 7), at(15, 7)], [2.0; 2]);
        assert_eq!([at(8, 8), at(15, 9)], [4.0; 2]);
        // The last quarter has none: means of quarters.
        assert_eq!([at(0, 8), at(7, 15)], [(5.0 + 2.0 + 4.0) / 3.0; 2]);
    }
}
