//! A mesh cut into pieces that can be seen whole from one side.

use glam::DVec3;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

pub(super) const NONE: u32 = u32::MAX;
/// Cosine of the largest angle between a smoothed normal and its piece's mean normal while pieces are begun: 60 degrees. Flattening is easy
/// below it.
const CONE: f64 = 0.5;
/// The same when pieces take what small pieces would be left beside them: 80 degrees.
const WIDE: f64 = 0.17;
/// Cosine of the angle at which a surface is folded, whatever its normals say, and at which it has an edge where the file parts the normals.
const FOLD: f64 = 0.5;
const HARD: f64 = 0.866;
/// Two triangles are near each other within this many times their longest edges.
const NEAR: f64 = 2.0;
/// Rounds of smoothing: facets of a scan turn by tens of degrees from one to the next.
const ROUNDS: usize = 8;
/// Weights of what a triangle costs a piece: turning away from its mean normal, bending at the edges it would share, and a bonus for
/// filling a notch, which keeps borders straight.
const TURNING: f64 = 2.0;
const BENDING: f64 = 4.0;
const FILLING: f64 = 6.0;

/// A mesh whose corners at one place are one.
pub(crate) struct Surface {
    pub corners: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Across the edge from each corner to the next, or [`NONE`] at borders.
    pub neighbours: Vec<[u32; 3]>,
    /// Of length 1, or zero for a triangle without area.
    pub normals: Vec<DVec3>,
    pub areas: Vec<f64>,
}

impl Surface {
    /// `shading` tells corners apart that the file parts at one place, as hard edges do.
    pub fn new(corners: Vec<DVec3>, triangles: Vec<[u32; 3]>, shading: &[[u32; 3]]) -> Self {
        let cross: Vec<DVec3> = triangles
            .par_iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| corners[v as usize]);
                (b - a).cross(c - a)
            })
            .collect();
        let normals: Vec<DVec3> = cross.par_iter().map(|c| c.normalize_or_zero()).collect();
        let areas = cross.par_iter().map(|c| 0.5 * c.length()).collect();
        let mut edges: Vec<([u32; 2], u32, u32)> = triangles
            .par_iter()
            .enumerate()
            .flat_map_iter(|(t, corners)| {
                (0..3).map(move |k| {
                    let (a, b) = (corners[k], corners[(k + 1) % 3]);
                    ([a.min(b), a.max(b)], t as u32, k as u32)
                })
            })
            .collect();
        edges.par_sort_unstable();
        let mut neighbours = vec![[NONE; 3]; triangles.len()];
        for shared in edges.chunk_by(|a, b| a.0 == b.0) {
            let [(_, t, k), (_, u, l)] = *shared else {
                continue;
            };
            let (t, k, u, l) = (t as usize, k as usize, u as usize, l as usize);
            // One surface passes the edge once in each direction.
            if triangles[t][k] != triangles[u][(l + 1) % 3] {
                continue;
            }
            let bend = normals[t].dot(normals[u]);
            let parted = shading[t][k] != shading[u][(l + 1) % 3]
                || shading[t][(k + 1) % 3] != shading[u][l];
            if bend > FOLD && !(parted && bend < HARD) {
                neighbours[t][k] = u as u32;
                neighbours[u][l] = t as u32;
            }
        }
        Self {
            corners,
            triangles,
            neighbours,
            normals,
            areas,
        }
    }

    fn smoothed(&self) -> Vec<DVec3> {
        let mut sums: Vec<DVec3> = self
            .normals
            .par_iter()
            .zip(&self.areas)
            .map(|(n, a)| n * *a)
            .collect();
        for _ in 0..ROUNDS {
            sums = sums
                .par_iter()
                .zip(&self.neighbours)
                .map(|(own, beside)| {
                    let beside = beside.iter().filter(|&&t| t != NONE);
                    beside.fold(*own, |sum, &t| sum + sums[t as usize])
                })
                .collect();
        }
        let unit = |(sum, own): (&DVec3, &DVec3)| sum.try_normalize().unwrap_or(*own);
        sums.par_iter().zip(&self.normals).map(unit).collect()
    }

    fn length(&self, t: usize, k: usize) -> f64 {
        let [a, b] = [self.triangles[t][k], self.triangles[t][(k + 1) % 3]];
        self.corners[a as usize].distance(self.corners[b as usize])
    }

    /// True where two triangles are at most a few triangles apart.
    pub fn are_near(&self, pair: [u32; 2]) -> bool {
        let reach = |t: u32| (0..3).fold(0.0, |l: f64, k| l.max(self.length(t as usize, k)));
        let [a, b] = pair.map(|t| self.corners[self.triangles[t as usize][0] as usize]);
        a.distance(b) <= NEAR * pair.map(reach).iter().sum::<f64>()
    }

    /// Connected pieces of at least `least` triangles and at most `most` area. The other triangles are in none.
    pub fn pieces(&self, least: usize, most: f64) -> Vec<Vec<u32>> {
        let smoothed = self.smoothed();
        let mut seeds: Vec<u32> = (0..self.triangles.len() as u32).collect();
        seeds.retain(|&t| self.normals[t as usize] != DVec3::ZERO);
        seeds.par_sort_unstable_by(|&a, &b| {
            let areas = self.areas[b as usize].total_cmp(&self.areas[a as usize]);
            areas.then(a.cmp(&b))
        });
        let mut growing = Growing {
            surface: self,
            smoothed: &smoothed,
            piece_of: vec![NONE; self.triangles.len()],
            most,
            heap: BinaryHeap::new(),
        };
        let mut pieces = Vec::new();
        for seed in seeds {
            if growing.piece_of[seed as usize] == NONE {
                pieces.push(growing.grow(pieces.len() as u32, vec![seed], CONE));
            }
        }
        pieces.retain(|piece| piece.len() >= least);
        growing.piece_of.fill(NONE);
        for (piece, number) in pieces.iter().zip(0..) {
            piece
                .iter()
                .for_each(|&t| growing.piece_of[t as usize] = number);
        }
        let wider = |(piece, number)| growing.grow(number, piece, WIDE);
        pieces.into_iter().zip(0..).map(wider).collect()
    }
}

/// Pieces while triangles are added to them, the cheapest first.
struct Growing<'a> {
    surface: &'a Surface,
    smoothed: &'a [DVec3],
    piece_of: Vec<u32>,
    most: f64,
    heap: BinaryHeap<Offer>,
}

/// What is known of one piece.
struct State {
    number: u32,
    /// Of the smoothed normals times areas.
    normal: DVec3,
    area: f64,
    /// Cosine of the largest angle to the mean normal.
    cone: f64,
}

impl Growing<'_> {
    /// The triangles of a piece that begins with `members`.
    fn grow(&mut self, number: u32, mut members: Vec<u32>, cone: f64) -> Vec<u32> {
        let mut state = State {
            number,
            normal: DVec3::ZERO,
            area: 0.0,
            cone,
        };
        self.heap.clear();
        for &t in &members {
            self.add(t, &mut state);
        }
        for &t in &members {
            self.offer_beside(t, &state);
        }
        while let Some(offer) = self.heap.pop() {
            let t = offer.triangle;
            if self.piece_of[t as usize] != NONE {
                continue;
            }
            // The piece has grown since the offer was made.
            match self.cost(t, &state) {
                Some(cost) if cost > offer.cost + 1e-9 => self.heap.push(Offer { cost, ..offer }),
                Some(_) => {
                    self.add(t, &mut state);
                    members.push(t);
                    self.offer_beside(t, &state);
                }
                None => {}
            }
        }
        members
    }

    fn add(&mut self, t: u32, state: &mut State) {
        let (t, area) = (t as usize, self.surface.areas[t as usize]);
        self.piece_of[t] = state.number;
        state.normal += self.smoothed[t] * area;
        state.area += area;
    }

    fn offer_beside(&mut self, t: u32, state: &State) {
        for triangle in self.surface.neighbours[t as usize] {
            if triangle == NONE || self.piece_of[triangle as usize] != NONE {
                continue;
            }
            if let Some(cost) = self.cost(triangle, state) {
                self.heap.push(Offer { cost, triangle });
            }
        }
    }

    /// `None` for a triangle that the piece may not have.
    fn cost(&self, t: u32, state: &State) -> Option<f64> {
        let t = t as usize;
        let turned = self.smoothed[t].dot(state.normal.normalize_or_zero());
        if turned < state.cone || state.area + self.surface.areas[t] > self.most {
            return None;
        }
        let (mut inside, mut whole, mut bend) = (0.0, 0.0, 0.0);
        for (k, &other) in self.surface.neighbours[t].iter().enumerate() {
            let length = self.surface.length(t, k);
            whole += length;
            if other != NONE && self.piece_of[other as usize] == state.number {
                inside += length;
                let other = self.surface.normals[other as usize];
                bend += length * (1.0 - self.surface.normals[t].dot(other));
            }
        }
        let filled = (1.0 - 2.0 * inside / whole).min(0.0);
        Some(TURNING * (1.0 - turned) + BENDING * bend / inside + FILLING * filled)
    }
}

/// A triangle that a piece could take.
struct Offer {
    cost: f64,
    triangle: u32,
}

impl Ord for Offer {
    /// The cheapest is the greatest: a heap gives it first.
    fn cmp(&self, other: &Self) -> Ordering {
        let costs = other.cost.total_cmp(&self.cost);
        costs.then(other.triangle.cmp(&self.triangle))
    }
}

impl PartialOrd for Offer {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Offer {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Offer {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_costs_what_it_bends_and_less_the_more_of_its_rim_is_inside() {
        // Two right triangles that share a hypotenuse, and one beside the second, turned by acos 0.8.
        let flat = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let mut corners = flat.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        corners.push(DVec3::new(0.0, 1.8, 0.6));
        let triangles = vec![[0, 1, 2], [0, 2, 3], [3, 2, 4]];
        let surface = Surface::new(corners, triangles.clone(), &triangles);
        let smoothed = vec![DVec3::Z; 3];
        let cost = |members: &[usize]| {
            let mut piece_of = vec![NONE; 3];
            members.iter().for_each(|&t| piece_of[t] = 7);
            let growing = Growing {
                surface: &surface,
                smoothed: &smoothed,
                piece_of,
                most: f64::INFINITY,
                heap: BinaryHeap::new(),
            };
            let state = State {
                number: 7,
                normal: DVec3::Z,
                area: 0.5,
                cone: CONE,
            };
            growing.cost(1, &state).expect("a triangle that may be had")
        };
        let (side, hypotenuse) = (1.0, 2f64.sqrt());
        // Less than half of the rim is inside, on a flat surface.
        assert!(cost(&[0]).abs() < 1e-12, "{}", cost(&[0]));
        // More than half, of which the side bends.
        let inside = side + hypotenuse;
        let filled = 1.0 - 2.0 * inside / (2.0 * side + hypotenuse);
        let expected = BENDING * side * 0.2 / inside + FILLING * filled;
        assert!(
            (cost(&[0, 2]) - expected).abs() < 1e-12,
            "{}",
            cost(&[0, 2])
        );
    }
}
