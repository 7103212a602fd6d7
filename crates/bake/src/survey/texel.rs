//! What a texel's footprint is made of: its cells, its mean material and its mean position and normals.

use super::cell::{Cell, Sample};
use super::cells::{Cells, Ground};
use super::rims::{self, Ends};
use super::seen::{Seen, is_free, look};
use crate::labels;
use crate::plan::Plan;
use ambient::sampling::Stream;
use atlas::{Atlas, Footprint, Piece, Tile, triangle_uv};
use glam::DVec3;
use rays::{
    Covering, Overrides, Patch, PhongMaterial, PlaneErrors, Rim, Solids, World, is_mapped,
    material_at,
};
use std::ops::Range;
use std::sync::Arc;

/// Sample points over the footprint from which means of textured materials are taken.
const SURVEY_POINTS: u32 = 16;

/// A texel ready to be integrated.
#[derive(Debug)]
pub(crate) struct Texel {
    pub x: u32,
    pub y: u32,
    /// Covered share of its square.
    pub coverage: f32,
    pub cells: Cells,
    pub material: PhongMaterial,
    pub position: DVec3,
    pub normal: DVec3,
    pub geometric: DVec3,
    /// In the world, squared units.
    pub area: f64,
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
    /// The surface at a point of the unit square, spread over what can be seen.
    pub fn sample(&self, u: [f64; 2]) -> Sample {
        self.cells.sample(self.seen.place(u.map(|u| u as f32)))
    }

    /// The surface at a point of the unit square, spread over what can be seen, and the origin of rays that leave it
    /// there.
    pub fn start(&self, u: [f64; 2]) -> (Sample, [f32; 3]) {
        let (number, place) = self.cells.place(self.seen.place(u.map(|u| u as f32)));
        let cell = self.cells.cell(number);
        let sample = cell.sample(place);
        let origin = sample.position + cell.lift;
        (sample, origin.as_vec3().to_array())
    }

    /// Takes what can be seen, and the means over it.
    fn see(&mut self, seen: Seen) {
        self.seen = seen.left(self.seen.share);
        if !self.seen.is_part() {
            return;
        }
        let (mut position, mut normal, mut geometric) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        let mut count = 0.0;
        for middle in self.seen.middles() {
            let sample = self.cells.sample(middle.map(|u| u as f32));
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
struct Known {
    open: bool,
    /// `None` where it varies.
    material: Option<PhongMaterial>,
    /// Its cell where texels hold it whole, and its place among those that are cut where texels have pieces of it.
    cell: u32,
    cut: u32,
}

/// A triangle of which texels have pieces.
struct Cut<'a> {
    patch: Patch,
    /// The closed surface that it is part of.
    body: Option<u32>,
    /// How far off it rays begin at least.
    level: f64,
    /// What walls cut off from its surface, and sheets cover of it.
    ends: Ends<'a>,
}

/// Makes the texels of tiles.
pub(crate) struct Surveyor<'a> {
    pub world: &'a World,
    pub atlas: &'a Atlas,
    pub errors: &'a PlaneErrors,
    pub overrides: &'a Overrides,
    pub plan: &'a Plan,
    /// What may bury samples; `None` where nothing can.
    pub solids: Option<&'a Solids>,
    /// How far above a surface sheets may lie that take no light from it, see
    /// [`Options::under`](crate::Options::under).
    pub under: Option<f64>,
    /// What covers what so far above it; `None` where `under` is.
    pub covering: Option<&'a Covering>,
}

impl<'a> Surveyor<'a> {
    /// All texels of a tile. `stream` labels a texel's own points by its column and row.
    pub fn texels(&self, tile: &Tile, stream: impl Fn(u32, u32, u32) -> Stream) -> Vec<Texel> {
        let mut known = Vec::with_capacity(tile.triangles.len());
        let mut cuts = Vec::new();
        // Most pieces become one cell, and no triangle that is held more.
        let mut ground = Ground {
            cells: Vec::with_capacity(tile.triangles.len() + tile.pieces.len()),
            wholes: Vec::with_capacity(tile.held.len()),
        };
        let (mut is_held, mut is_cut) = (vec![false; tile.triangles.len()], Vec::new());
        is_cut.resize(is_held.len(), false);
        (tile.held.iter()).for_each(|&number| is_held[number as usize] = true);
        (tile.pieces.iter()).for_each(|piece| is_cut[piece.number as usize] = true);
        let mut of_instance = (u32::MAX, None);
        for (number, &[instance, triangle]) in tile.triangles.iter().enumerate() {
            // Most follow one of the same instance.
            if of_instance.0 != instance {
                of_instance = (instance, self.material_of(instance));
            }
            known.push(Known {
                open: self.plan.open.contains(instance, triangle),
                material: of_instance.1,
                cell: ground.cells.len() as u32,
                cut: cuts.len() as u32,
            });
            let patch = Patch::of(self.world, self.errors, instance, triangle);
            let body = self.solids.and_then(|of| of.own(instance, triangle));
            let level = self.solids.filter(|_| !self.world.keeps_buried(instance));
            let level = level.map_or(0.0, |of| of.level(patch.corners, patch.geometric, body));
            if is_held[number] {
                let weights = |at| tile.weights[number].at(at);
                let mut cell = Cell::whole((&patch, body), weights);
                cell.lift_to(level);
                ground.cells.push(cell);
            }
            if is_cut[number] {
                let ends = self.ends(instance, triangle);
                cuts.push(Cut {
                    patch,
                    body,
                    level,
                    ends,
                });
            }
        }
        let held = tile.held.iter();
        (ground.wholes).extend(held.map(|&number| known[number as usize].cell));
        let mut cut = |footprint: &Footprint| {
            if footprint.is_whole {
                return (footprint.parts.clone(), 1.0);
            }
            let start = ground.cells.len() as u32;
            let left = self.cut(
                tile.pieces_of(footprint),
                (&known, &cuts),
                &mut ground.cells,
            );
            (start..ground.cells.len() as u32, left)
        };
        let found: Vec<_> = tile.footprints.iter().map(&mut cut).collect();
        let ground = Arc::new(ground);
        let texel = |(footprint, (own, left)): (&Footprint, (Range<u32>, f64))| {
            let corner = [footprint.x - tile.x0, footprint.y - tile.y0].map(|at| at as f32);
            let whole = footprint.is_whole.then_some(corner);
            let cells = Cells::new(Arc::clone(&ground), own, whole);
            let seen = Seen::ALL.left(left as f32);
            self.texel((tile, footprint), &known, (cells, seen), &stream)
        };
        let mut texels: Vec<Texel> = tile.footprints.iter().zip(found).map(texel).collect();
        if let Some(solids) = self.solids.filter(|of| !is_free(of, &ground)) {
            let footprints = texels.iter().map(|texel| &texel.cells).enumerate();
            // What rims take is not looked at, nor what is kept.
            let left = footprints.filter(|&(index, _)| {
                let texel: &Texel = &texels[index];
                texel.seen != Seen::NONE && !self.world.keeps_buried(texel.object)
            });
            for (index, seen) in look(solids, left) {
                texels[index].see(seen);
            }
        }
        texels
    }

    /// True where texels may hold a triangle uncut: nothing ends it, and its normals are its own.
    pub fn keeps_whole(&self, [instance, triangle]: [u32; 2]) -> bool {
        !self.world.bends_normals(instance) && self.ends(instance, triangle).are_none()
    }

    /// What may end footprints on a triangle.
    fn ends(&self, instance: u32, triangle: u32) -> Ends<'a> {
        let ending = self.solids.filter(|_| !self.world.keeps_buried(instance));
        Ends {
            rims: ending.map_or(&[], |of| of.rims(instance, triangle)),
            covers: (ending.filter(|_| self.under != Some(0.0))).and_then(|of| {
                let under = || {
                    self.under
                        .unwrap_or(Rim::THIN * self.texel_edge(instance, triangle))
                };
                of.covers(self.covering, (instance, triangle), || 2.0 * under())
            }),
            under: self.under,
        }
    }

    /// The edge of a texel on a triangle, in scene units.
    fn texel_edge(&self, instance: u32, triangle: u32) -> f64 {
        let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length();
        let (uvs, _) = triangle_uv(self.world.scene(), self.atlas, instance, triangle);
        let on_page = uvs.map(|uv| uv.as_dvec2().extend(0.0) * f64::from(self.atlas.page_size));
        (area(self.world.corners(instance, triangle)) / area(on_page)).sqrt()
    }

    /// The material of an instance; `None` where it varies.
    fn material_of(&self, instance: u32) -> Option<PhongMaterial> {
        let scene = self.world.scene();
        let varies = is_mapped(scene, instance);
        (!varies).then(|| material_at(scene, instance, 0, [1.0, 0.0, 0.0]))
    }

    /// Adds the cells of a footprint to others: of what rims and layers leave of it, or of all where they leave
    /// nothing. What comes back is the share that layers leave of what rims do.
    fn cut(
        &self,
        pieces: &[Piece],
        (known, cuts): (&[Known], &[Cut]),
        cells: &mut Vec<Cell>,
    ) -> f64 {
        let start = cells.len();
        for all in [false, true] {
            let (mut before, mut buried) = (0.0, 0.0);
            for piece in pieces {
                let Cut {
                    patch,
                    body,
                    level,
                    ends,
                } = &cuts[known[piece.number as usize].cut as usize];
                let (triangle, corners) = (piece.triangle, piece.corners);
                let bent =
                    (self.world).bent_normal(piece.instance, triangle, corners, piece.square);
                let mut push = |part: &Piece, area, lift: f64| {
                    let first = cells.len();
                    Cell::push(cells, (patch, *body), part, area);
                    for cell in &mut cells[first..] {
                        cell.lift_to(*level);
                        cell.lift += lift * cell.geometric;
                    }
                    if let Some(normal) = bent {
                        cells[first..].iter_mut().for_each(|cell| cell.bend(normal));
                    }
                };
                let area = piece.cumulative - before;
                before = piece.cumulative;
                match all || ends.are_none() {
                    true => push(piece, area, 0.0),
                    false => buried += rims::without((patch, *ends), piece, area, push),
                }
            }
            if cells.len() > start {
                Cell::share(&mut cells[start..]);
                let kept: f64 = cells[start..].iter().map(|cell| cell.area).sum();
                return if all { 0.0 } else { kept / (kept + buried) };
            }
        }
        unreachable!("a footprint is never empty")
    }

    fn texel(
        &self,
        (tile, footprint): (&Tile, &Footprint),
        known: &[Known],
        (cells, seen): (Cells, Seen),
        stream: &impl Fn(u32, u32, u32) -> Stream,
    ) -> Texel {
        let (first, open, plain) = match footprint.is_whole {
            // All are of one object.
            true => {
                let held = tile.held_of(footprint);
                let first = held[0] as usize;
                let open = held.iter().all(|&number| known[number as usize].open);
                (first, open, known[first].material)
            }
            false => shared(tile.pieces_of(footprint), known),
        };
        let stream = || stream(footprint.x, footprint.y, labels::SURVEY);
        let material = plain.unwrap_or_else(|| self.material(tile, footprint, &stream()));
        let means = cells.means();
        let tilted = !cells.iter().all(|cell| cell.is_flat);
        let upward = || {
            let [instance, triangle] = tile.triangles[first];
            Patch::of(self.world, self.errors, instance, triangle).geometric
        };
        Texel {
            x: footprint.x,
            y: footprint.y,
            coverage: footprint.coverage,
            material: self.overrides.applied(material),
            position: means.position,
            normal: means.normal.try_normalize().unwrap_or_else(upward),
            geometric: means.geometric.try_normalize().unwrap_or_else(upward),
            area: means.area,
            object: tile.triangles[first][0],
            open,
            tilted,
            cells,
            seen,
        }
    }

    /// The mean material from points over the footprint.
    fn material(&self, tile: &Tile, footprint: &Footprint, stream: &Stream) -> PhongMaterial {
        let mut sum = PhongMaterial::default();
        for index in 0..SURVEY_POINTS {
            let [_, _, u, v] = stream.point(index);
            let at = tile.sample(footprint, [u, v]);
            let scene = self.world.scene();
            let material = material_at(scene, at.instance, at.triangle, at.weights);
            add(&mut sum, &material, 1.0 / f64::from(SURVEY_POINTS));
        }
        sum
    }
}

/// Of pieces the triangle with the largest share of the area, whether all are open, and the mean material by area where
/// it varies over none of them.
fn shared(pieces: &[Piece], known: &[Known]) -> (usize, bool, Option<PhongMaterial>) {
    let (mut first, mut largest, mut open) = (0, f64::NEG_INFINITY, true);
    let mut plain = Some(PhongMaterial::default());
    let area = pieces.last().map_or(1.0, |last| last.cumulative);
    let mut before = 0.0;
    for piece in pieces {
        let share = (piece.cumulative - before) / area;
        before = piece.cumulative;
        let known = &known[piece.number as usize];
        if share > largest {
            (first, largest) = (piece.number as usize, share);
        }
        open &= known.open;
        plain = plain.zip(known.material).map(|(mut sum, own)| {
            add(&mut sum, &own, share);
            sum
        });
    }
    (first, open, plain)
}

fn add(sum: &mut PhongMaterial, material: &PhongMaterial, weight: f64) {
    sum.albedo += material.albedo * weight;
    sum.specular += material.specular * weight;
    sum.exponent += material.exponent * weight;
}
