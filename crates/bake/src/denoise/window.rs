//! Which texels around a texel belong to its surface.
//!
//! Two texels side by side are *linked* when nothing suggests that their surfaces differ: both are covered, they belong
//! to one object, their normals turn by less than a crease, and they are as near in space as their neighbours. A window
//! holds the texels that a chain of links reaches without a step back toward the centre's row or column, so that no chart's
//! border, void or crease is crossed or gone around.

use super::field::Field;
use glam::DVec3;

/// Largest window: texels within this Chebyshev distance of the centre.
pub(super) const REACH: usize = 5;

/// Texels of the largest window.
pub(super) const TEXELS: usize = (2 * REACH + 1) * (2 * REACH + 1);

/// Cosine of the turn of the normal between neighbours that counts as a crease: 20 degrees.
const CREASE: f64 = 0.939_692_620_785_908_4;

/// Cosine of the largest turn of the normal between a window's centre and its texels: 45 degrees.
const TURN: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Neighbours farther apart than this many times the steps beside theirs lie on different surfaces.
const JUMP: f64 = 3.0;

/// Bits of a texel's links to its right and lower neighbour.
const RIGHT: u8 = 1;
const DOWN: u8 = 2;

/// The links of a page.
pub(super) struct Links {
    size: usize,
    bits: Vec<u8>,
}

impl Links {
    pub fn of(field: &Field<'_>) -> Self {
        use rayon::prelude::*;
        let size = field.size;
        let mut bits = vec![0; size * size];
        bits.par_chunks_mut(size).enumerate().for_each(|(y, row)| {
            for (x, bits) in row.iter_mut().enumerate() {
                let texel = y * size + x;
                if x + 1 < size && linked(field, texel, texel + 1) {
                    *bits |= RIGHT;
                }
                if y + 1 < size && linked(field, texel, texel + size) {
                    *bits |= DOWN;
                }
            }
        });
        Self { size, bits }
    }

    fn right(&self, texel: usize) -> bool {
        self.bits[texel] & RIGHT != 0
    }

    fn down(&self, texel: usize) -> bool {
        self.bits[texel] & DOWN != 0
    }
}

fn linked(field: &Field<'_>, a: usize, b: usize) -> bool {
    if !(field.covered(a) && field.covered(b)) || field.object[a] != field.object[b] {
        return false;
    }
    if field.normal(a).dot(field.normal(b)) < CREASE {
        return false;
    }
    let step = field.position(a).distance(field.position(b));
    step <= JUMP * usual_step(field, a, b)
}

/// The shorter of the steps that continue the step from `a` to `b` on either side; where both lead into void, the
/// shortest step across it.
fn usual_step(field: &Field<'_>, a: usize, b: usize) -> f64 {
    let size = field.size;
    let (along, across) = if b - a == 1 { (1, size) } else { (size, 1) };
    let step = |from: usize, stride: usize, forward: bool| -> f64 {
        let room = if stride == 1 {
            from % size
        } else {
            from / size
        };
        let to = match forward {
            true if room + 1 < size => from + stride,
            false if room > 0 => from - stride,
            _ => return f64::INFINITY,
        };
        if field.covered(to) && field.object[to] == field.object[from] {
            field.position(from).distance(field.position(to))
        } else {
            f64::INFINITY
        }
    };
    let usual = step(a, along, false).min(step(b, along, true));
    if usual.is_finite() {
        return usual;
    }
    [(a, false), (a, true), (b, false), (b, true)]
        .into_iter()
        .map(|(from, forward)| step(from, across, forward))
        .fold(f64::INFINITY, f64::min)
}

/// An offset of the window with the offsets from which it is reached.
struct Place {
    dx: isize,
    dy: isize,
    ring: usize,
    /// Indices of the places one step nearer in x and in y.
    from: [Option<usize>; 2],
}

/// The order in which windows are walked: ring by ring, nearer places first.
pub(super) struct Walk {
    places: Vec<Place>,
}

/// The texels of one window in the walk's order, centre first.
pub(super) struct Window {
    pub texels: Vec<usize>,
    /// Texels within each radius, `0..=REACH`.
    pub within: [usize; REACH + 1],
}

impl Walk {
    pub fn new() -> Self {
        let reach = REACH as isize;
        let mut offsets: Vec<(isize, isize)> = (-reach..=reach)
            .flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy)))
            .collect();
        offsets.sort_by_key(|&(dx, dy)| (dx.abs().max(dy.abs()), dx.abs() + dy.abs(), dy, dx));
        let find = |x: isize, y: isize| offsets.iter().position(|&o| o == (x, y));
        let places = offsets
            .iter()
            .map(|&(dx, dy)| Place {
                dx,
                dy,
                ring: dx.unsigned_abs().max(dy.unsigned_abs()),
                from: [
                    (dx != 0).then(|| find(dx - dx.signum(), dy)).flatten(),
                    (dy != 0).then(|| find(dx, dy - dy.signum())).flatten(),
                ],
            })
            .collect();
        Self { places }
    }

    /// Gathers the window of `centre`, which is covered.
    pub fn gather(
        &self,
        field: &Field<'_>,
        links: &Links,
        centre: usize,
        radius: usize,
        window: &mut Window,
    ) {
        let size = links.size;
        let (cx, cy) = ((centre % size) as isize, (centre / size) as isize);
        let normal: DVec3 = field.normal(centre);
        let mut reached = [false; TEXELS];
        window.texels.clear();
        window.within = [0; REACH + 1];
        for (index, place) in self.places.iter().enumerate() {
            if place.ring > radius {
                break;
            }
            let (x, y) = (cx + place.dx, cy + place.dy);
            if x < 0 || y < 0 || x >= size as isize || y >= size as isize {
                continue;
            }
            let texel = y as usize * size + x as usize;
            let left = place.dx < 0;
            let up = place.dy < 0;
            let from_x = place.from[0]
                .is_some_and(|p| reached[p] && links.right(if left { texel } else { texel - 1 }));
            let from_y = place.from[1]
                .is_some_and(|p| reached[p] && links.down(if up { texel } else { texel - size }));
            if index == 0 || (from_x || from_y) && normal.dot(field.normal(texel)) >= TURN {
                reached[index] = true;
                window.texels.push(texel);
                window.within[place.ring] = window.texels.len();
            }
        }
        for ring in 1..=REACH {
            window.within[ring] = window.within[ring].max(window.within[ring - 1]);
        }
    }
}
