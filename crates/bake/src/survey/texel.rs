//! What a texel's footprint is made of: its cells, its mean material and its mean position and normals.

use super::cell::{Cell, Sample};
use super::rims::{self, Ends};
use super::seen::Seen;
use crate::labels;
use crate::plan::Plan;
use ambient::sampling::Stream;
use atlas::{Footprint, Piece, Tile};
use glam::DVec3;
use rays::{Overrides, Patch, PhongMaterial, PlaneErrors, Solids, World, is_mapped, material_at};
use rustc_hash::FxHashMap;

/// Sample points over the footprint from which means of textured materials are taken.
const SURVEY_POINTS: u32 = 16;

/// A texel ready to be integrated.
#[derive(Debug)]
pub(crate) struct Texel {
    pub x: u32,
    pub y: u32,
    /// Covered share of its square.
    pub coverage: f32,
    /// Never empty.
    pub cells: Vec<Cell>,
    /// Shares of the footprint's area at which the cells end, but for the last.
    ends: Vec<f32>,
    pub material: PhongMaterial,
    pub position: DVec3,
    pub normal: DVec3,
    pub geometric: DVec3,
    /// Object with the largest share of the footprint.
    pub object: u32,
    /// Nothing stands above the footprint: no ray is needed.
    pub open: bool,
    /// The shading normal leaves the geometric one somewhere.
    pub tilted: bool,
    /// What does not lie inside of a solid: samples are drawn from it, and the means above are taken over it.
    pub seen: Seen,
}

impl Texel {
    /// Where the cells end along the first coordinate of a point of the unit square, but for the last.
    pub fn ends(&self) -> &[f32] {
        &self.ends
    }

    /// The cell that the first coordinate of a point of the unit square chooses by area.
    #[inline]
    pub fn choose(&self, u0: f32) -> usize {
        self.ends.partition_point(|&end| u0 >= end)
    }

    /// Area in the world, squared units.
    pub fn world_area(&self) -> f64 {
        self.cells.iter().map(Cell::world_area).sum()
    }

    /// The surface at a point of the unit square, spread over what can be seen.
    pub fn sample(&self, u: [f64; 2]) -> Sample {
        let [u, v] = self.seen.place(u.map(|u| u as f32));
        self.sample_of([u.into(), v.into()])
    }

    /// The surface at a point of the unit square, spread over what can be seen, and the origin of rays that leave it there.
    pub fn start(&self, u: [f64; 2]) -> (Sample, [f32; 3]) {
        let placed = self.seen.place(u.map(|u| u as f32));
        let cell = &self.cells[self.choose(placed[0])];
        let sample = cell.sample(cell.place(placed));
        let side = sample.geometric.dot(cell.geometric).signum();
        let origin = sample.position + cell.lift * side;
        (sample, origin.as_vec3().to_array())
    }

    /// The surface at a point of the unit square of the whole footprint.
    fn sample_of(&self, u: [f64; 2]) -> Sample {
        let u = u.map(|u| u as f32);
        let cell = &self.cells[self.choose(u[0])];
        cell.sample(cell.place(u))
    }

    /// Looks for what can be seen, and takes the means over it.
    fn look(&mut self, solids: &Solids, near: &[u32]) {
        if self.seen == Seen::NONE {
            return;
        }
        self.seen = Seen::of(&self.cells, |u| self.choose(u), solids, near);
        if !self.seen.is_part() {
            return;
        }
        let (mut position, mut normal, mut geometric) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        let mut count = 0.0;
        for middle in self.seen.middles() {
            let sample = self.sample_of(middle);
            position += sample.position;
            normal += sample.normal;
            geometric += sample.geometric;
            count += 1.0;
        }
        self.position = position / count;
        self.normal = normal.try_normalize().unwrap_or(self.normal);
        self.geometric = geometric.try_normalize().unwrap_or(self.geometric);
    }
}

/// What is known about a triangle of a tile.
struct Known<'a> {
    patch: Patch,
    open: bool,
    /// The closed surface that it is part of.
    body: Option<u32>,
    /// What walls cut off from its surface, and sheets cover of it.
    ends: Ends<'a>,
}

/// What the texels of a tile have in common.
#[derive(Default)]
struct Shared<'a> {
    /// By instance and triangle.
    triangles: FxHashMap<(u32, u32), Known<'a>>,
    /// Of the last instance that was asked for, one without maps.
    material: Option<(u32, PhongMaterial)>,
}

impl Shared<'_> {
    /// The material of an instance that has no maps.
    fn plain(&mut self, world: &World, instance: u32, triangle: u32) -> PhongMaterial {
        match self.material {
            Some((known, material)) if known == instance => material,
            _ => {
                let material = material_at(world.scene(), instance, triangle, [1.0, 0.0, 0.0]);
                self.material = Some((instance, material));
                material
            }
        }
    }
}

/// Makes the texels of tiles.
pub(crate) struct Surveyor<'a> {
    pub world: &'a World,
    pub errors: &'a PlaneErrors,
    pub overrides: &'a Overrides,
    pub plan: &'a Plan,
    /// What may bury samples; `None` where nothing can.
    pub solids: Option<&'a Solids>,
}

impl<'a> Surveyor<'a> {
    /// All texels of a tile. `stream` labels a texel's own points by its column and row.
    pub fn texels(&self, tile: &Tile, stream: impl Fn(u32, u32, u32) -> Stream) -> Vec<Texel> {
        let mut shared = Shared::default();
        let texels = tile.footprints.iter().map(|footprint| {
            let stream = stream(footprint.x, footprint.y, labels::SURVEY);
            self.texel(tile, footprint, &mut shared, &stream)
        });
        let mut texels: Vec<Texel> = texels.collect();
        if let Some(solids) = self.solids {
            let limits = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let cells = texels.iter().flat_map(|texel| &texel.cells);
            let corners = cells.flat_map(Cell::corners);
            let (low, high) = corners.fold(limits, |(low, high), p| (low.min(p), high.max(p)));
            let near = solids.about(low, high);
            if !near.is_empty() {
                texels
                    .iter_mut()
                    .for_each(|texel| texel.look(solids, &near));
            }
        }
        texels
    }

    fn texel(
        &self,
        tile: &Tile,
        footprint: &Footprint,
        shared: &mut Shared<'a>,
        stream: &Stream,
    ) -> Texel {
        let pieces = &tile.pieces[footprint.pieces.start as usize..footprint.pieces.end as usize];
        let mut cells = Vec::with_capacity(pieces.len());
        // The same with what rims take and sheets cover, where there is some.
        let (mut whole, mut lost) = (Vec::new(), 0.0);
        let mut upward = None;
        let (mut open, mut before) = (true, 0.0);
        let mut largest = (0.0, 0);
        for piece in pieces {
            let key = (piece.instance, piece.triangle);
            let known = shared.triangles.entry(key).or_insert_with(|| Known {
                patch: Patch::of(self.world, self.errors, key.0, key.1),
                open: self.plan.open.contains(key.0, key.1),
                body: self.solids.and_then(|solids| solids.own(key.0, key.1)),
                ends: Ends {
                    rims: self.solids.map_or(&[], |solids| solids.rims(key.0, key.1)),
                    covers: self.solids.and_then(|solids| solids.covers(key.0, key.1)),
                },
            });
            upward.get_or_insert_with(|| known.patch.upward());
            open &= known.open;
            if piece.cumulative - before > largest.0 {
                largest = (piece.cumulative - before, piece.instance);
            }
            let surface = (&known.patch, known.body);
            let bent = self
                .world
                .bent_normal(key.0, key.1, piece.corners, piece.square);
            let push = |cells: &mut Vec<Cell>, piece: &Piece, area: f64| {
                let first = cells.len();
                Cell::push(cells, surface, piece, area);
                if let Some(normal) = bent {
                    cells[first..].iter_mut().for_each(|cell| cell.bend(normal));
                }
            };
            let area = piece.cumulative - before;
            if known.ends.are_none() {
                push(&mut cells, piece, area);
            } else {
                let mut left = 0.0;
                rims::without((&known.patch, known.ends), piece, area, |part, area| {
                    push(&mut cells, part, area);
                    left += area;
                });
                lost += area - left;
                push(&mut whole, piece, area);
            }
            before = piece.cumulative;
        }
        let is_rim = cells.is_empty();
        if is_rim {
            (cells, lost) = (whole, 0.0);
        }
        Cell::share(&mut cells);
        let (mut position, mut normal, mut geometric) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        for cell in &cells {
            let centre = cell.sample(cell.centre());
            position += centre.position * cell.area;
            normal += centre.normal * cell.area;
            geometric += centre.geometric * cell.area;
        }
        let upward = upward.unwrap_or(DVec3::Z);
        Texel {
            x: footprint.x,
            y: footprint.y,
            coverage: footprint.coverage,
            material: self.material(tile, footprint, shared, stream),
            position: position / (before - lost),
            normal: normal.try_normalize().unwrap_or(upward),
            geometric: geometric.try_normalize().unwrap_or(upward),
            object: largest.1,
            open,
            tilted: !cells.iter().all(Cell::is_flat),
            ends: cells[1..].iter().map(|cell| cell.start).collect(),
            cells,
            seen: if is_rim { Seen::NONE } else { Seen::ALL },
        }
    }

    /// The mean material: by area where no map is looked up, else from points over the footprint.
    fn material(
        &self,
        tile: &Tile,
        footprint: &Footprint,
        shared: &mut Shared<'a>,
        stream: &Stream,
    ) -> PhongMaterial {
        let scene = self.world.scene();
        let pieces = &tile.pieces[footprint.pieces.start as usize..footprint.pieces.end as usize];
        let mut sum = PhongMaterial::default();
        let mut add = |material: PhongMaterial, weight: f64| {
            sum.albedo += material.albedo * weight;
            sum.specular += material.specular * weight;
            sum.exponent += material.exponent * weight;
        };
        if pieces.iter().any(|piece| is_mapped(scene, piece.instance)) {
            for index in 0..SURVEY_POINTS {
                let [_, _, u, v] = stream.point(index);
                let point = tile.sample(footprint, [u, v]);
                add(
                    material_at(scene, point.instance, point.triangle, point.weights),
                    1.0 / f64::from(SURVEY_POINTS),
                );
            }
        } else {
            let (area, mut before) = (tile.area(footprint), 0.0);
            for piece in pieces {
                add(
                    shared.plain(self.world, piece.instance, piece.triangle),
                    (piece.cumulative - before) / area,
                );
                before = piece.cumulative;
            }
        }
        self.overrides.applied(sum)
    }
}
