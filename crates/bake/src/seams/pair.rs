//! Which borders are one seam.

use super::SeamPoint;
use super::border::Border;
use crate::options::Seams as Scope;
use glam::DVec3;
use rayon::prelude::*;
use rays::Boxes;

/// Two borders that run along one another, and from where to where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pair {
    /// Their numbers.
    pub borders: [u32; 2],
    /// The common part, as shares of the way from each border's first end to its second; both spans begin at the same
    /// point in space.
    pub spans: [[f64; 2]; 2],
}

/// The shares of the common part of a pair on which something stands, from where to where.
pub(super) type Walls = Vec<[f64; 2]>;

impl Pair {
    /// Points on the common part, so many a texel of its length, but for those on which something stands.
    pub fn points<'a>(
        &self,
        borders: &[Border],
        walls: &'a Walls,
    ) -> impl Iterator<Item = SeamPoint> + use<'a> {
        let [first, second] = self.borders.map(|border| &borders[border as usize]);
        let run =
            |border: &Border, [from, to]: [f64; 2]| [border.texels_at(from), border.texels_at(to)];
        let runs = [run(first, self.spans[0]), run(second, self.spans[1])];
        let length = runs.map(|[from, to]| from.distance(to)).into_iter();
        let length = length.fold(0.0, f64::max);
        let count = (length * POINTS_PER_TEXEL).ceil().max(1.0);
        let charts = [first.chart, second.chart];
        let inward = [first, second].map(|border| border.inward_texels.as_vec2());
        let at = (0..count as u32).map(move |k| (f64::from(k) + 0.5) / count);
        let is_free = |t: &f64| !walls.iter().any(|[from, to]| (from..=to).contains(&t));
        at.filter(is_free).map(move |t| SeamPoint {
            sides: runs.map(|[from, to]| from.lerp(to, t)),
            inward,
            charts,
            length: length / count,
        })
    }
}

/// Points of a seam on each texel of its length, on the chart that has more.
const POINTS_PER_TEXEL: f64 = 2.0;

/// Borders lie together where they are no farther apart than this, in texels of the finer one.
const APART: f64 = 0.1;

/// Coordinates of the same point, computed through two transforms, agree to this share of their size.
const ROUNDING: f64 = 1e-6;

/// Cosine of the largest angle between the shading normals of one surface: 3 degrees. Facets of a flat-shaded body that
/// differ by more are meant to; those that differ by less should look as smooth across charts as they do within one.
const SAME_SURFACE: f64 = 0.998_629_534_754_574;

/// Texels of one side are at most so many times as large as those of the other: a texel that spans much more cannot
/// hold what the finer side shows, which would only be spoilt.
const UNLIKE: f64 = 8.0;

/// Borders and common parts below this many texels are no seam.
const SHORTEST: f64 = 1e-3;

/// All pairs of borders that are seams.
pub(super) fn pairs(borders: &[Border], scope: Scope) -> Vec<Pair> {
    let lengths: Vec<f64> = borders.iter().map(Border::length).collect();
    let reaches: Vec<f64> = borders.iter().map(reach).collect();
    let heaps = Heaps::of(borders, &reaches);
    let boxes = Boxes::of((1..heaps.starts.len()).map(|end| {
        let members = heaps.members(end - 1).iter();
        let spaces = members.map(|&border| space(&borders[border as usize]));
        let around = |[low, high]: [DVec3; 2], [l, h]: [DVec3; 2]| [low.min(l), high.max(h)];
        let [low, high] = spaces.reduce(around).expect("a heap has members");
        (end as u32 - 1, low, high)
    }));
    // What is shorter on the page than in space by far would reach for all that there is.
    let is_seam = |border: &u32| borders[*border as usize].texels_across() >= SHORTEST;
    let owns = (0..borders.len() as u32).into_par_iter().filter(is_seam);
    let found = owns.map(|own| {
        let ([low, high], reach) = (space(&borders[own as usize]), reaches[own as usize]);
        let mut near: Vec<u32> = Vec::new();
        // Both have to reach the other: the one that reaches less far looks.
        let is_mine = |other: u32| {
            let than = reaches[other as usize];
            reach < than || (reach == than && own < other)
        };
        boxes.any(low - reach, high + reach, |heap| {
            let others = heaps.beside(own, heap).iter().copied();
            near.extend(others.filter(|&other| is_mine(other)));
            false
        });
        near.sort_unstable();
        // The shorter one comes first: all of it has to lie along the other, not a corner alone.
        let pair = |other: u32| {
            let numbers = match lengths[other as usize] < lengths[own as usize] {
                true => [other, own],
                false => [own, other],
            };
            let [first, second] = numbers.map(|number| &borders[number as usize]);
            common(numbers, first, second, scope)
        };
        near.into_iter().filter_map(pair).collect::<Vec<_>>()
    });
    found.flatten_iter().collect()
}

/// Of borders that as good as coincide each is paired with so many before it and after it: those of copies of a mesh
/// at one place, or of bodies nested in each other, are as many as these.
const BESIDE: usize = 16;

/// Borders by their ends: those of a heap have theirs in the same cells, which are about as large as the borders reach.
struct Heaps {
    /// The numbers of all borders, heap by heap, ascending in each.
    borders: Vec<u32>,
    /// Where each heap begins, and the end.
    starts: Vec<usize>,
    /// Of each border, its place in its heap.
    places: Vec<usize>,
}

impl Heaps {
    fn of(borders: &[Border], reaches: &[f64]) -> Self {
        let cells = |(border, reach): (&Border, &f64)| {
            let size = reach.log2().ceil();
            let cell = |end: DVec3| (end / size.exp2()).to_array().map(|x| x.floor() as i64);
            let mut cells = border.ends.map(cell);
            cells.sort_unstable();
            (size as i64, cells)
        };
        let mut keyed: Vec<_> = borders.iter().zip(reaches).map(cells).zip(0u32..).collect();
        keyed.par_sort_unstable();
        let (mut starts, mut places) = (vec![0], vec![0; borders.len()]);
        for heap in keyed.chunk_by(|a, b| a.0 == b.0) {
            starts.push(starts[starts.len() - 1] + heap.len());
            let numbered = heap.iter().enumerate();
            numbered.for_each(|(place, (_, border))| places[*border as usize] = place);
        }
        Self {
            borders: keyed.into_iter().map(|(_, border)| border).collect(),
            starts,
            places,
        }
    }

    fn members(&self, heap: usize) -> &[u32] {
        &self.borders[self.starts[heap]..self.starts[heap + 1]]
    }

    /// Those of a heap that a border may be paired with: all, unless they are many.
    fn beside(&self, own: u32, heap: u32) -> &[u32] {
        let members = self.members(heap as usize);
        let place = self.places[own as usize].min(members.len() - 1);
        &members[place.saturating_sub(BESIDE)..members.len().min(place + BESIDE + 1)]
    }
}

/// The box around a border.
fn space(border: &Border) -> [DVec3; 2] {
    let [a, b] = border.ends;
    [a.min(b), a.max(b)]
}

/// How far a border reaches for others, in scene units.
fn reach(border: &Border) -> f64 {
    let size = border.ends[0].abs().max(border.ends[1].abs());
    APART * border.texel() + ROUNDING * size.max_element()
}

/// The part that two borders have in common; `None` where they are no seam.
fn common(numbers: [u32; 2], a: &Border, b: &Border, scope: Scope) -> Option<Pair> {
    if (scope == Scope::Object && a.chart[0] != b.chart[0]) || a.inward.dot(b.inward) > 0.0 {
        return None;
    }
    let sizes = [a.coarseness(), b.coarseness()];
    if sizes[0].max(sizes[1]) > UNLIKE * sizes[0].min(sizes[1]) {
        return None;
    }
    let apart = reach(a).min(reach(b));
    let place = |on: &Border, p: DVec3| {
        let way = on.ends[1] - on.ends[0];
        (p - on.ends[0]).dot(way) / way.length_squared()
    };
    let ends = b.ends.map(|end| place(a, end));
    let from = ends[0].min(ends[1]).max(0.0);
    let to = ends[0].max(ends[1]).min(1.0);
    if (to - from) * a.texels_across() < SHORTEST {
        return None;
    }
    let span = [from, to];
    let other = span.map(|t| place(b, a.at(t)).clamp(0.0, 1.0));
    let together = span.iter().zip(other).all(|(&t, u)| {
        a.at(t).distance(b.at(u)) <= apart && a.normal_at(t).dot(b.normal_at(u)) >= SAME_SURFACE
    });
    together.then_some(Pair {
        borders: numbers,
        spans: [span, other],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    fn along_x(from: f64, to: f64, inward: DVec3) -> Border {
        Border {
            page: 0,
            chart: [0, 0],
            ends: [DVec3::new(from, 0.0, 0.0), DVec3::new(to, 0.0, 0.0)],
            texels: [DVec2::ZERO, DVec2::new((to - from).abs() * 10.0, 0.0)],
            normals: [DVec3::Z; 2],
            inward,
            depth: 0.1,
            inward_texels: DVec2::new(0.0, 10.0 * inward.y.signum()),
        }
    }

    #[test]
    fn a_long_border_shares_with_a_short_one_what_they_have_in_common() {
        let (long, short) = (along_x(0.0, 4.0, DVec3::Y), along_x(3.0, 2.0, -DVec3::Y));
        let pair = common([0, 1], &long, &short, Scope::Scene).unwrap();
        assert_eq!(pair.spans, [[0.5, 0.75], [1.0, 0.0]]);
    }

    #[test]
    fn borders_on_one_side_apart_or_of_unlike_normals_are_no_seam() {
        let a = along_x(0.0, 1.0, DVec3::Y);
        let b = along_x(0.0, 1.0, -DVec3::Y);
        assert!(common([0, 1], &a, &a, Scope::Scene).is_none());
        let mut far = b.clone();
        far.ends = far.ends.map(|end| end + 0.02 * DVec3::Z);
        assert!(common([0, 1], &a, &far, Scope::Scene).is_none());
        let mut bent = b.clone();
        bent.normals = [DVec3::new(0.0, 0.2, 0.98).normalize(); 2];
        assert!(common([0, 1], &a, &bent, Scope::Scene).is_none());
        let mut other = b.clone();
        other.chart[0] = 1;
        assert!(common([0, 1], &a, &other, Scope::Object).is_none());
        assert!(common([0, 1], &a, &other, Scope::Scene).is_some());
    }

    #[test]
    fn borders_that_coincide_are_paired_in_proportion_to_their_number() {
        let count = |copies: u32| {
            let sides = [DVec3::Y, -DVec3::Y].into_iter().cycle();
            let borders = sides
                .take(2 * copies as usize)
                .map(|side| along_x(0.0, 1.0, side));
            let pairs = pairs(&borders.collect::<Vec<_>>(), Scope::Scene);
            // Both sides of every copy, whatever else.
            let is_own = |copy: u32| {
                pairs
                    .iter()
                    .any(|pair| pair.borders == [2 * copy, 2 * copy + 1])
            };
            assert!((0..copies).all(is_own), "{copies}");
            pairs.len()
        };
        // Each copy's one side with the other side of each.
        assert_eq!([1, 2, 8].map(count), [1, 4, 64]);
        let most = |copies: usize| 2 * copies * (BESIDE + 1);
        assert!(count(200) <= most(200) && count(800) <= most(800));
    }

    #[test]
    fn borders_that_as_good_as_coincide_are_paired_in_proportion_to_their_number() {
        // A hundredth of a texel and less apart, of bodies nested in each other.
        let count = |copies: u32| {
            let nested = |k: u32| {
                let side = [DVec3::Y, -DVec3::Y][k as usize % 2];
                let mut border = along_x(0.0, 1.0, side);
                border.ends = border
                    .ends
                    .map(|end| end + f64::from(k / 2) * 1e-6 * DVec3::Z);
                border
            };
            let borders: Vec<Border> = (0..2 * copies).map(nested).collect();
            let pairs = pairs(&borders, Scope::Scene);
            let is_own = |copy: u32| {
                let own = [2 * copy, 2 * copy + 1];
                pairs.iter().any(|pair| pair.borders == own)
            };
            assert!((0..copies).all(is_own), "{copies}");
            pairs.len()
        };
        assert_eq!([1, 2, 8].map(count), [1, 4, 64]);
        let most = |copies: usize| 2 * copies * (BESIDE + 1);
        assert!(count(200) <= most(200) && count(800) <= most(800));
    }

    #[test]
    fn a_long_border_is_paired_with_short_ones_along_it_but_not_at_a_sharp_corner() {
        let mut borders = vec![along_x(0.0, 8.0, DVec3::Y)];
        borders.extend((0..8).map(|k| along_x(f64::from(k + 1), f64::from(k), -DVec3::Y)));
        let found = |borders: &[Border]| -> Vec<[u32; 2]> {
            let pairs = pairs(borders, Scope::Scene);
            let mut found: Vec<[u32; 2]> = pairs.iter().map(|pair| pair.borders).collect();
            found.sort_unstable();
            found
        };
        let expected: Vec<[u32; 2]> = (1..=8).map(|short| [short, 0]).collect();
        assert_eq!(found(&borders), expected);
        // Of one twentieth of a texel's rise over its whole length, at the end of the long one.
        let mut corner = along_x(8.0, 7.97, -DVec3::Y);
        corner.ends[1] += 0.012 * DVec3::Z;
        let at_corner = [borders[0].clone(), corner];
        assert_eq!(found(&at_corner), Vec::<[u32; 2]>::new());
    }
}
