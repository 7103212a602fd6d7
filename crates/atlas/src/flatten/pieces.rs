//! A mesh cut into pieces that can be seen whole from one side.

use glam::DVec3;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

pub(crate) const NONE: u32 = u32::MAX;
/// Cosine of the largest angle between a smoothed normal and its piece's mean normal while pieces are begun: 60
/// degrees. Flattening is easy below it.
const CONE: f64 = 0.5;
/// The same when pieces take what small pieces would be left beside them: 80 degrees.
const WIDE: f64 = 0.17;
/// Cosine of the angle at which a surface is folded, whatever its normals say, and at which it has an edge where the
/// file parts the normals.
const FOLD: f64 = 0.5;
const HARD: f64 = 0.866;
/// Two triangles are near each other within this many times their longest edges.
const NEAR: f64 = 2.0;
/// Rounds of smoothing: facets of a scan turn by tens of degrees from one to the next.
const ROUNDS: usize = 8;
/// Weights of what a triangle costs a piece: turning away from its mean normal, bending at the edges it would share,
/// and a bonus for filling a notch, which keeps borders straight.
const TURNING: f64 = 2.0;
const BENDING: f64 = 4.0;
const FILLING: f64 = 6.0;

/// A mesh whose corners at one place are one.
pub(crate) struct Welded {
    pub corners: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// Across the edge from each corner to the next, or [`NONE`] at borders.
    pub neighbours: Vec<[u32; 3]>,
    /// Of length 1, or zero for a triangle without area.
    pub normals: Vec<DVec3>,
    pub areas: Vec<f64>,
}

impl Welded {
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

    /// Length of an edge of a triangle.
    pub fn length(&self, t: usize, k: usize) -> f64 {
        let [a, b] = [self.triangles[t][k], self.triangles[t][(k + 1) % 3]];
        self.corners[a as usize].distance(self.corners[b as usize])
    }

    /// True where two triangles are at most a few triangles apart.
    pub fn are_near(&self, pair: [u32; 2]) -> bool {
        let reach = |t: u32| (0..3).fold(0.0, |l: f64, k| l.max(self.length(t as usize, k)));
        let [a, b] = pair.map(|t| self.corners[self.triangles[t as usize][0] as usize]);
        a.distance(b) <= NEAR * pair.map(reach).iter().sum::<f64>()
    }

    /// Connected pieces of at least `least` triangles and at most `most` area, of the triangles that are `left`. The
    /// other triangles are in none. Each piece has the flat `faces` whole that it has at all.
    pub fn pieces(&self, faces: &[u32], left: &[bool], least: usize, most: f64) -> Vec<Vec<u32>> {
        let units = Units::new(self, faces, left);
        let mut seeds: Vec<u32> = (0..units.members.len() as u32).collect();
        seeds.retain(|&u| units.normals[u as usize] != DVec3::ZERO);
        seeds.par_sort_unstable_by(|&a, &b| {
            let areas = units.areas[b as usize].total_cmp(&units.areas[a as usize]);
            areas.then(a.cmp(&b))
        });
        let mut growing = Growing {
            units: &units,
            piece_of: vec![NONE; units.members.len()],
            most,
            heap: BinaryHeap::new(),
        };
        let mut pieces = Vec::new();
        for seed in seeds {
            if growing.piece_of[seed as usize] == NONE {
                pieces.push(growing.grow(pieces.len() as u32, vec![seed], CONE));
            }
        }
        let count = |piece: &[u32]| -> usize {
            let sizes = piece.iter().map(|&u| units.members[u as usize].len());
            sizes.sum()
        };
        pieces.retain(|piece| count(piece) >= least);
        growing.piece_of.fill(NONE);
        for (piece, number) in pieces.iter().zip(0..) {
            piece
                .iter()
                .for_each(|&u| growing.piece_of[u as usize] = number);
        }
        let wider = |(piece, number)| growing.grow(number, piece, WIDE);
        let pieces: Vec<Vec<u32>> = pieces.into_iter().zip(0..).map(wider).collect();
        let triangles = |piece: &Vec<u32>| -> Vec<u32> {
            let members = piece.iter().flat_map(|&u| &units.members[u as usize]);
            members.copied().collect()
        };
        pieces.iter().map(triangles).collect()
    }
}

/// What a piece takes whole: a flat face, in most curved surfaces a single triangle.
struct Units {
    /// Triangles of each, numbered in the order of the first.
    members: Vec<Vec<u32>>,
    /// Mean of the smoothed normals, of length 1.
    normals: Vec<DVec3>,
    areas: Vec<f64>,
    /// Length of the border of each.
    borders: Vec<f64>,
    links: Vec<Vec<Link>>,
}

/// The border of a unit with another.
struct Link {
    other: u32,
    length: f64,
    /// Sum over its edges of length times one minus the cosine of the bend.
    bend: f64,
}

impl Units {
    fn new(surface: &Welded, faces: &[u32], left: &[bool]) -> Self {
        let smoothed = surface.smoothed();
        let mut number_of = vec![NONE; faces.len()];
        let mut of = vec![NONE; faces.len()];
        let mut members: Vec<Vec<u32>> = Vec::new();
        for t in (0..faces.len()).filter(|&t| left[t]) {
            let number = &mut number_of[faces[t] as usize];
            if *number == NONE {
                *number = members.len() as u32;
                members.push(Vec::new());
            }
            of[t] = *number;
            members[*number as usize].push(t as u32);
        }
        let areas = members
            .iter()
            .map(|m| m.iter().map(|&t| surface.areas[t as usize]).sum())
            .collect();
        let normal = |m: &Vec<u32>| match m[..] {
            [only] => smoothed[only as usize],
            _ => {
                let weighted = |&t: &u32| smoothed[t as usize] * surface.areas[t as usize];
                m.iter().map(weighted).sum::<DVec3>().normalize_or_zero()
            }
        };
        let normals = members.iter().map(normal).collect();
        let around = |(own, members): (u32, &Vec<u32>)| {
            let mut border = 0.0;
            let mut links: Vec<Link> = Vec::new();
            for &t in members {
                for (k, &beside) in surface.neighbours[t as usize].iter().enumerate() {
                    let other = if beside == NONE {
                        NONE
                    } else {
                        of[beside as usize]
                    };
                    if other == own {
                        continue;
                    }
                    let length = surface.length(t as usize, k);
                    border += length;
                    if other != NONE {
                        let turned =
                            surface.normals[t as usize].dot(surface.normals[beside as usize]);
                        let bend = length * (1.0 - turned);
                        links.push(Link {
                            other,
                            length,
                            bend,
                        });
                    }
                }
            }
            links.sort_by_key(|link| link.other);
            links.dedup_by(|next, first| {
                let one = next.other == first.other;
                if one {
                    first.length += next.length;
                    first.bend += next.bend;
                }
                one
            });
            (border, links)
        };
        let (borders, links) = (0..).zip(&members).map(around).unzip();
        Self {
            members,
            normals,
            areas,
            borders,
            links,
        }
    }
}

/// Pieces while units are added to them, the cheapest first.
struct Growing<'a> {
    units: &'a Units,
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
    /// The units of a piece that begins with `members`.
    fn grow(&mut self, number: u32, mut members: Vec<u32>, cone: f64) -> Vec<u32> {
        let mut state = State {
            number,
            normal: DVec3::ZERO,
            area: 0.0,
            cone,
        };
        self.heap.clear();
        for &unit in &members {
            self.add(unit, &mut state);
        }
        for &unit in &members {
            self.offer_beside(unit, &state);
        }
        while let Some(offer) = self.heap.pop() {
            let unit = offer.unit;
            if self.piece_of[unit as usize] != NONE {
                continue;
            }
            // The piece has grown since the offer was made.
            match self.cost(unit, &state) {
                Some(cost) if cost > offer.cost + 1e-9 => self.heap.push(Offer { cost, ..offer }),
                Some(_) => {
                    self.add(unit, &mut state);
                    members.push(unit);
                    self.offer_beside(unit, &state);
                }
                None => {}
            }
        }
        members
    }

    fn add(&mut self, unit: u32, state: &mut State) {
        let unit = unit as usize;
        let area = self.units.areas[unit];
        self.piece_of[unit] = state.number;
        state.normal += self.units.normals[unit] * area;
        state.area += area;
    }

    fn offer_beside(&mut self, unit: u32, state: &State) {
        for link in &self.units.links[unit as usize] {
            if self.piece_of[link.other as usize] != NONE {
                continue;
            }
            if let Some(cost) = self.cost(link.other, state) {
                self.heap.push(Offer {
                    cost,
                    unit: link.other,
                });
            }
        }
    }

    /// `None` for a unit that the piece may not have.
    fn cost(&self, unit: u32, state: &State) -> Option<f64> {
        let unit = unit as usize;
        let turned = self.units.normals[unit].dot(state.normal.normalize_or_zero());
        if turned < state.cone || state.area + self.units.areas[unit] > self.most {
            return None;
        }
        let links = self.units.links[unit].iter();
        let shared = links.filter(|link| self.piece_of[link.other as usize] == state.number);
        let (inside, bend) = shared.fold((0.0, 0.0), |(length, bend), link| {
            (length + link.length, bend + link.bend)
        });
        let filled = (1.0 - 2.0 * inside / self.units.borders[unit]).min(0.0);
        Some(TURNING * (1.0 - turned) + BENDING * bend / inside + FILLING * filled)
    }
}

/// A unit that a piece could take.
struct Offer {
    cost: f64,
    unit: u32,
}

impl Ord for Offer {
    /// The cheapest is the greatest: a heap gives it first.
    fn cmp(&self, other: &Self) -> Ordering {
        let costs = other.cost.total_cmp(&self.cost);
        costs.then(other.unit.cmp(&self.unit))
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
        let surface = Welded::new(corners, triangles.clone(), &triangles);
        let mut units = Units::new(&surface, &[0, 1, 2], &[true; 3]);
        units.normals = vec![DVec3::Z; 3];
        let cost = |members: &[usize]| {
            let mut piece_of = vec![NONE; 3];
            members.iter().for_each(|&t| piece_of[t] = 7);
            let growing = Growing {
                units: &units,
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
