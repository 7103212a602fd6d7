//! Light by direction for engines: spherical harmonics of order 1 in the packings of Godot and, as plain numbers, for
//! shaders of one's own.
//!
//! The layer `sh` holds m = (1/4pi) times the integral of L over the sphere, and v, the same times each axis of the
//! direction, so that |v| is at most m. Light on a surface with the normal n is about E/pi = m + 2 v.n, exact where
//! nothing or a half-space is in the way.

use super::mips::{fill, is_filled};
use super::{LightLevel, PageLight, half_exr, ktx2};

/// Numbers of a texel: mean, x, y, z of red, green and blue.
const NUMBERS: usize = 12;

/// Godot's packing of directional lightmaps, a slice under the other: m; then 1/2 + v / 4m along y, z and x. Godot
/// computes slice 0 times (1 + 8 (slice - 1/2).n) of it.
pub fn slices(page: &PageLight<'_>) -> Option<Vec<u8>> {
    let texels = texels(page)?;
    let ratio = |texel: &[f32; NUMBERS], axis: usize| {
        [0, 1, 2].map(|c| ratio(texel[c], texel[3 * axis + c]))
    };
    let mut pixels: Vec<[f32; 3]> = texels.iter().map(|t| [t[0], t[1], t[2]]).collect();
    for axis in [2, 3, 1] {
        pixels.extend(texels.iter().map(|texel| ratio(texel, axis)));
    }
    Some(half_exr::encode([page.size, 4 * page.size], &pixels))
}

/// 1/2 + v / 4m, and 1/2 where no light comes from anywhere.
fn ratio(mean: f32, vector: f32) -> f32 {
    match mean > 0.0 {
        true => 0.5 + vector / (4.0 * mean),
        false => 0.5,
    }
}

/// An array of four pictures: m, and v along x, y and z, as they are.
pub fn array(page: &PageLight<'_>) -> Option<Vec<u8>> {
    let texels = texels(page)?;
    let of = |k: usize| {
        texels
            .iter()
            .map(move |t| [t[3 * k], t[3 * k + 1], t[3 * k + 2]])
    };
    let level = LightLevel {
        size: page.size,
        pixels: (0..4).flat_map(of).collect(),
    };
    Some(ktx2::encode(&[level], 4))
}

/// The numbers of each texel, what lies between charts filled; `None` where the page has no layer `sh`.
fn texels(page: &PageLight<'_>) -> Option<Vec<[f32; NUMBERS]>> {
    let planes = page.sh.as_ref()?;
    let most = half::f16::MAX.to_f32();
    let texel = |i: usize| std::array::from_fn(|k| planes[k][i].clamp(-most, most));
    let mut pixels: Vec<[f32; NUMBERS]> = (0..page.coverage.len()).map(texel).collect();
    let filled = is_filled(&page.coverage, page.size, page.rings);
    fill(&mut pixels, page.size, &filled);
    Some(pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_light_has_no_direction_and_light_from_one_has_half_of_the_range() {
        assert_eq!([ratio(0.0, 0.0), ratio(2.0, 0.0)], [0.5; 2]);
        assert_eq!([ratio(2.0, 2.0), ratio(2.0, -2.0)], [0.75, 0.25]);
    }
}
