//! How wide gutters must be, so that no look-up mixes charts.
//!
//! A look-up on mip level l reads whole texels of that level, each the mean of 2^l x 2^l texels of the page. At x
//! texels from the page's edge a bicubic look-up reads the four level texels from `floor(x / 2^l - 1/2) - 1` on, so no
//! page texel further than 5/2 2^l from x. Where x lies in the last texel of a chart, at most `5 * 2^(l-1) - 1` texels
//! beside the chart are read on level l >= 1, and 2 on the page itself. Bilinear look-ups read fewer, trilinear ones
//! mix two levels. Every void texel within a gutter is filled from its own chart alone: the next chart's gutter lies
//! between.

/// Texels beside a chart that bilinear, trilinear and bicubic look-ups at its points can read, on the page and its
/// first `mips` mip levels (box-filtered, each half as large as the one before).
pub fn reach(mips: u32) -> u32 {
    match mips {
        0 => 2,
        _ => 5 * (1 << (mips - 1)) - 1,
    }
}

/// The gutter that a layout needs, in texels: see [`crate::Options::gutter`].
///
/// * `gutter`: what was asked for.
/// * `mips`: mip levels whose look-ups must not mix charts; 0 leaves `gutter` as it is.
/// * `align`: edge of the blocks in which a texture is compressed, in texels, at least 1. Then no aligned block touches
///   the gutters of two charts: two gutters stay `align - 1` texels apart, whatever their place on the page.
pub fn needed(gutter: u32, mips: u32, align: u32) -> u32 {
    let filled = match mips {
        0 => gutter,
        _ => gutter.max(reach(mips)),
    };
    filled + (align - 1).div_ceil(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The page texels that a bicubic look-up at `x` reads on a level: first, and one past the last.
    fn read(x: f64, level: u32) -> (i64, i64) {
        let edge = f64::from(1u32 << level);
        let first = (x / edge - 0.5).floor() - 1.0;
        ((first * edge) as i64, ((first + 4.0) * edge) as i64)
    }

    #[test]
    fn no_bicubic_look_up_reads_further_than_the_reach_and_one_reads_as_far() {
        for mips in 0..=6 {
            let mut furthest = 0;
            for texel in 1000..1200 {
                for part in [0.0, 0.25, 0.5, 0.75, 0.999] {
                    for level in 0..=mips {
                        let (from, to) = read(f64::from(texel) + part, level);
                        let texel = i64::from(texel);
                        furthest = furthest.max(texel - from).max(to - 1 - texel);
                    }
                }
            }
            assert_eq!(furthest, i64::from(reach(mips)), "{mips} levels");
        }
    }

    #[test]
    fn blocks_add_to_the_gutter_what_an_unlucky_place_costs() {
        assert_eq!(needed(2, 0, 1), 2);
        assert_eq!(needed(2, 0, 4), 4);
        assert_eq!(needed(0, 1, 1), 4);
        assert_eq!(needed(12, 2, 1), 12);
        assert_eq!(needed(2, 3, 4), 21);
    }
}
