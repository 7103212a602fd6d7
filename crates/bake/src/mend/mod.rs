//! Mends texels that are buried, wholly or in part, from their neighbours on the same surface.
//!
//! A texel that is seen in part holds the mean over that part, whose middle is not the texel's. A look-up between
//! texels takes the value for one at the texel's middle, and where light changes across the edge of a body that would
//! draw a ring around it. So what look-ups beside a contact read is solved for: they are to find the means where they
//! were measured ([`contact`]). That is tried for texels that are seen in part and for unseen ones beside seen ones.
//! Others, and those whose surface is too narrow to tell where on it they are, take the value of a plane through the
//! neighbours' values over their places on the surface ([`fit`]). A texel that has no seen texel within reach keeps
//! what its rays found: nobody looks there, and no light is invented.
//!
//! Everything is a sum of neighbours' values with weights that depend on geometry alone. So one set of weights serves
//! every term, a linear course of light is met exactly, and standard errors follow.

mod contact;
mod fit;
#[cfg(test)]
mod tests;

use contact::{Holds, Window};
use fit::Place;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Neighbours lie within so many texels along an axis.
const REACH: i32 = 3;

/// A neighbour's weight falls with its distance in texels as (1 - d / WIDTH)², and no further than to FAR². So a plane
/// leans on the texels next to a contact line, and those at a corner of the other body, two texels on, hardly bend it.
const WIDTH: f64 = 2.5;
const FAR: f64 = 0.02;

/// Neighbours are of one surface where their normals are within acos of this, some 37 degrees.
const NORMAL_AGREEMENT: f64 = 0.8;

/// What of a page decides how it is mended. Planes of `size * size` values, row 0 on top.
pub(crate) struct MendedPlanes<'a> {
    pub size: usize,
    /// Share of a texel inside charts; 0 in the void.
    pub coverage: &'a [f32],
    /// Share of a footprint that can be seen.
    pub validity: &'a [f32],
    /// Middle of what can be seen, of all where nothing can.
    pub position: [&'a [f32]; 3],
    pub normal: [&'a [f32]; 3],
    pub object: &'a [f32],
    /// Texels that are seen in part hold the value at their middle by now, not the mean over what is seen.
    pub moved: bool,
}

/// How the texels of a page are mended.
#[derive(Debug, Default)]
pub(crate) struct Mends(Vec<Mend>);

/// One texel as a sum of others.
#[derive(Debug)]
struct Mend {
    texel: usize,
    terms: Vec<(usize, f64)>,
}

impl Mends {
    /// What a page needs.
    pub fn of(surface: &MendedPlanes<'_>) -> Self {
        Self::up_to(surface, 1.0)
    }

    /// What the texels of which nothing can be seen need once the others have changed, whose values stand for their
    /// middles by then.
    pub fn of_unseen(surface: &MendedPlanes<'_>) -> Self {
        Self::up_to(surface, f32::MIN_POSITIVE)
    }

    /// What texels need of which less than this share can be seen.
    fn up_to(surface: &MendedPlanes<'_>, share: f32) -> Self {
        let texels = surface.size * surface.size;
        let needs =
            |&texel: &usize| surface.coverage[texel] > 0.0 && surface.validity[texel] < share;
        let surface = &MendedPlanes {
            moved: share < 1.0,
            ..*surface
        };
        let mend = |texel| {
            let terms = surface.terms(texel)?;
            Some(Mend { texel, terms })
        };
        let wanted: Vec<usize> = (0..texels).filter(needs).collect();
        Self(wanted.into_par_iter().filter_map(mend).collect())
    }

    /// Mends a plane of values of at least `least` and at most `most`. A value stays within half the span of those it
    /// is made of. Returns each one's span.
    pub fn apply(&self, plane: &mut [f32], least: f64, most: f64) -> Vec<f64> {
        let mended = self.0.par_iter().map(|mend| {
            let (mut sum, mut low, mut high) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
            for &(texel, weight) in &mend.terms {
                let value = f64::from(plane[texel]);
                sum += weight * value;
                (low, high) = (low.min(value), high.max(value));
            }
            let room = 0.5 * (high - low);
            let value = sum.clamp(low - room, high + room).clamp(least, most);
            (value as f32, high - low)
        });
        let (values, spans): (Vec<f32>, Vec<f64>) = mended.unzip();
        for (mend, value) in self.0.iter().zip(values) {
            plane[mend.texel] = value;
        }
        spans
    }

    /// Standard errors of the mended values from those of a plane, whose texels are independent. What is kept within
    /// two spans has a standard deviation of one at most (T. Popoviciu, 1935).
    pub fn apply_to_errors(&self, plane: &mut [f32], spans: &[f64]) {
        let error = |(mend, span): (&Mend, &f64)| {
            let squares = mend.terms.iter().map(|&(texel, weight)| {
                let error = f64::from(plane[texel]);
                (weight * error * weight * error, error)
            });
            let (sum, most) = squares.fold((0.0, 0.0f64), |(sum, most), (square, error)| {
                (sum + square, most.max(error))
            });
            sum.sqrt().min(span.max(most)) as f32
        };
        let errors: Vec<f32> = self.0.par_iter().zip(spans).map(error).collect();
        for (mend, error) in self.0.iter().zip(errors) {
            plane[mend.texel] = error;
        }
    }
}

impl MendedPlanes<'_> {
    /// The sum that a texel becomes; `None` where its neighbours do not say.
    fn terms(&self, texel: usize) -> Option<Vec<(usize, f64)>> {
        if !self.is_near_seen(texel) {
            return None;
        }
        let neighbours = self.neighbours(texel);
        if let Some(terms) = self.at_contact(texel, &neighbours) {
            return Some(terms);
        }
        // Texels whose place on the surface is their middle, to tell where this one's is.
        let places: Vec<(Place, DVec3)> = neighbours
            .iter()
            .filter(|(near, _)| self.coverage[*near] > 0.999 && self.is_whole(*near))
            .map(|&(near, at)| (Place { at, weight: 1.0 }, self.position(near)))
            .collect();
        let own = self.position(texel);
        let middle = match self.validity[texel] > 0.0 {
            true => fit::middle(&places)?,
            false => own,
        };
        let normal = self.normal(texel);
        let (u, v) = normal.try_normalize()?.any_orthonormal_pair();
        let flat = |position: DVec3| DVec2::new(u.dot(position - middle), v.dot(position - middle));
        let seen: Vec<(usize, Place)> = neighbours
            .iter()
            .filter(|(near, _)| self.validity[*near] > 0.0)
            .map(|&(near, at)| {
                let near_by = (1.0 - at.length() / WIDTH).max(FAR);
                let weight =
                    f64::from(self.coverage[near] * self.validity[near]) * near_by * near_by;
                let at = flat(self.position(near));
                (near, Place { at, weight })
            })
            .collect();
        let places: Vec<Place> = seen.iter().map(|(_, place)| *place).collect();
        match self.validity[texel] > 0.0 {
            false => {
                let weights = fit::value(&places)?;
                Some(seen.iter().map(|(near, _)| *near).zip(weights).collect())
            }
            true => {
                let weights = fit::slope(&places, -flat(own))?;
                let moved = |((near, _), weight): (&(usize, Place), f64)| {
                    let itself = if *near == texel { 1.0 } else { 0.0 };
                    (*near, weight + itself)
                };
                Some(seen.iter().zip(weights).map(moved).collect())
            }
        }
    }

    /// The sum for a texel that look-ups beside a contact read: one that is seen in part, or beside one that is seen.
    fn at_contact(&self, texel: usize, neighbours: &[(usize, DVec2)]) -> Option<Vec<(usize, f64)>> {
        let is_beside = |&(near, at): &(usize, DVec2)| {
            self.validity[near] > 0.0 && at.abs().max_element() < 1.5
        };
        if !neighbours.iter().any(is_beside) {
            return None;
        }
        let whole: Vec<(Place, DVec3)> = neighbours
            .iter()
            .filter(|(near, _)| self.coverage[*near] > 0.999 && self.is_whole(*near))
            .map(|&(near, at)| (Place { at, weight: 1.0 }, self.position(near)))
            .collect();
        let chart = fit::Chart::of(&whole)?;
        let holds = |&(near, at): &(usize, DVec2)| {
            let holds = match self.validity[near] {
                0.0 => Holds::Nothing,
                share if self.coverage[near] > 0.999 && (share == 1.0 || self.moved) => {
                    Holds::Value
                }
                _ => {
                    let half = DVec2::splat(0.5);
                    Holds::Mean(chart.place(self.position(near)).clamp(at - half, at + half))
                }
            };
            (at.as_ivec2(), holds)
        };
        let sum = Window::of(neighbours.iter().map(holds)).middle()?;
        let size = self.size as i64;
        let terms = sum.into_iter().map(|(at, weight)| {
            let near = texel as i64 + i64::from(at.y) * size + i64::from(at.x);
            (near as usize, weight)
        });
        Some(terms.collect())
    }

    /// The texels that hang together with this one on its surface within reach, itself too, and where they stand from
    /// it in texels.
    fn neighbours(&self, texel: usize) -> Vec<(usize, DVec2)> {
        const EDGE: usize = (2 * REACH + 1) as usize;
        let (x, y) = ((texel % self.size) as i32, (texel / self.size) as i32);
        let normal = self.normal(texel);
        let size = self.size as i32;
        let place = |dx: i32, dy: i32| (dy + REACH) as usize * EDGE + (dx + REACH) as usize;
        let index = |dx: i32, dy: i32| ((y + dy) * size + x + dx) as usize;
        let (mut looked, mut agrees) = ([false; EDGE * EDGE], [false; EDGE * EDGE]);
        let mut pending = [(0i32, 0i32); 4 * EDGE * EDGE + 1];
        let mut last = 1;
        while last > 0 {
            last -= 1;
            let (dx, dy) = pending[last];
            let is_new = !std::mem::replace(&mut looked[place(dx, dy)], true);
            if !is_new || !(0..size).contains(&(x + dx)) || !(0..size).contains(&(y + dy)) {
                continue;
            }
            let near = index(dx, dy);
            if self.coverage[near] > 0.0
                && self.object[near] == self.object[texel]
                && self.normal(near).dot(normal) > NORMAL_AGREEMENT
            {
                agrees[place(dx, dy)] = true;
                for (dx, dy) in [(dx - 1, dy), (dx + 1, dy), (dx, dy - 1), (dx, dy + 1)] {
                    if dx.abs() <= REACH && dy.abs() <= REACH && !looked[place(dx, dy)] {
                        pending[last] = (dx, dy);
                        last += 1;
                    }
                }
            }
        }
        let mut found = Vec::with_capacity(EDGE * EDGE);
        let steps = (-REACH..=REACH).flat_map(|dy| (-REACH..=REACH).map(move |dx| (dx, dy)));
        for (dx, dy) in steps.filter(|&(dx, dy)| agrees[place(dx, dy)]) {
            found.push((index(dx, dy), DVec2::new(f64::from(dx), f64::from(dy))));
        }
        found
    }

    /// True where some texel within reach can be seen, on whatever surface.
    fn is_near_seen(&self, texel: usize) -> bool {
        let near =
            |at: usize| at.saturating_sub(REACH as usize)..(at + REACH as usize + 1).min(self.size);
        let columns = near(texel % self.size);
        let rows = near(texel / self.size);
        rows.flat_map(|y| &self.validity[y * self.size..][columns.clone()])
            .any(|share| *share > 0.0)
    }

    /// True where the position is the middle of the whole footprint.
    fn is_whole(&self, texel: usize) -> bool {
        self.validity[texel] == 0.0 || self.validity[texel] == 1.0
    }

    fn position(&self, texel: usize) -> DVec3 {
        DVec3::from(self.position.map(|plane| f64::from(plane[texel])))
    }

    fn normal(&self, texel: usize) -> DVec3 {
        DVec3::from(self.normal.map(|plane| f64::from(plane[texel])))
    }
}
