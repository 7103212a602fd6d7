//! Where the hemisphere rays of a dark tile go: to the directions that are open.
//!
//! In a room that sees little of the sky, nearly all rays end at walls, and the few that find the window are left to
//! chance. Some of the texels of a surface are therefore baked first, spread over the tile: a quarter, or fewer where
//! they have many rays. Where they show that little is open, and that it is in like directions from texel to texel, the
//! whole surface is baked by points warped to these directions ([`Guide`]). Every ray then weighs the inverse of its
//! density. The warped points are independent of those that the guide was made of, so that no texel's mean moves; what
//! does not gain much stays as it was. The same where what is rare is blocked was tried, and gained nothing after
//! denoising.

use crate::survey::Texel;
use ambient::sampling::{Counts, Guide};

/// Texels of one surface that share a guide, at least.
const FEWEST: usize = 32;

/// Surfaces that are told apart in a tile; few of more could be large.
const MOST: usize = 12;

/// One in so many blocks of texels is baked first, where `x + step * y` of the block's place is a multiple of it:
/// blocks stand apart in rows and columns.
const PROBED: [Probed; 3] = [
    Probed { one_in: 4, step: 2 },
    Probed { one_in: 8, step: 3 },
    Probed {
        one_in: 16,
        step: 6,
    },
];

/// Rays of the texels that are baked first, all together and at least, but where a quarter of them has fewer.
const LEARNT: usize = 8192;

/// Points of a replicate below which no texel is baked twice.
pub(super) const FEWEST_POINTS: u32 = 8;

/// Cosine of the angle by which normals of one surface turn at most.
const ALIKE: f64 = 0.95;

/// Share of directions that are open, at most.
const RARE: f64 = 0.25;

/// How much less variance a guide promises, at least.
const WORTH: f64 = 2.0;

struct Probed {
    one_in: u32,
    step: u32,
}

/// The texels `which` that may share guides, surface by surface, and the rest.
pub(super) fn surfaces(texels: &[Texel], which: &[usize]) -> (Vec<Vec<usize>>, Vec<usize>) {
    let mut surfaces: Vec<Vec<usize>> = Vec::new();
    let mut rest = Vec::new();
    for &i in which {
        let alike = |surface: &Vec<usize>| {
            let (a, b) = (&texels[surface[0]], &texels[i]);
            a.object == b.object && a.normal.dot(b.normal) > ALIKE
        };
        match surfaces.iter().position(alike) {
            Some(surface) => surfaces[surface].push(i),
            None if surfaces.len() < MOST => surfaces.push(vec![i]),
            None => rest.push(i),
        }
    }
    let (large, small): (Vec<_>, Vec<_>) = surfaces
        .into_iter()
        .partition(|surface| surface.len() >= FEWEST);
    rest.extend(small.concat());
    (large, rest)
}

/// Parts a surface, whose texels take so many rays each, into those that are baked first and the others. Blocks have an
/// edge of `edge` texels.
pub(super) fn probes(texels: &[Texel], surface: &[usize], rays: u32, edge: u32) -> [Vec<usize>; 2] {
    let enough =
        |probed: &&Probed| surface.len() * rays as usize >= LEARNT * probed.one_in as usize;
    let [quarter, ..] = &PROBED;
    let Probed { one_in, step } = PROBED.iter().rfind(enough).unwrap_or(quarter);
    let probed = |&i: &usize| {
        let (x, y) = (texels[i].x / edge, texels[i].y / edge);
        (x + step * y).is_multiple_of(*one_in)
    };
    let (probes, others) = surface.iter().partition(|i| probed(i));
    [probes, others]
}

/// The guide of a surface, where it is worth one.
pub(super) fn guide(counts: &Counts) -> Option<Guide> {
    if counts.share() > RARE || counts.hits() == 0 {
        return None;
    }
    let guide = Guide::new(counts);
    (guide.gain() >= WORTH).then_some(guide)
}
