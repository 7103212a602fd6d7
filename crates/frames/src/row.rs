//! Shading of one row of pixels, a block of [`LANES`] in step.

use crate::antialias::Lookup;
use crate::gbuffer::GBuffer;
use crate::index::{Index, combine};
use crate::shader::{COAT, Shader};
use crate::surfel::Mirrored;
use crate::table::{LANES, Lanes, Table};
use pulp::NullaryFnOnce;
use std::ops::Range;

/// One row of a picture, compiled for every width of vectors.
pub(super) struct Row<'a, 'b> {
    pub shaders: &'a [Shader<'b>],
    pub buffer: &'a GBuffer,
    pub lookup: Lookup,
    /// What each material of the buffer shows of each of its shader's glosses.
    pub shares: &'a [Vec<f32>],
    pub y: usize,
    /// What is behind, and the result.
    pub pixels: &'a mut [[f32; 3]],
}

/// Normals and views of a block.
type NormalsAndViews = [[Lanes; 3]; 2];

/// What a block adds up: red, green, blue and nothing.
type Sums = [[f32; 4]; LANES];

impl NullaryFnOnce for Row<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        let end = self.buffer.rows[self.y + 1];
        let mut start = self.buffer.rows[self.y];
        while start < end {
            let next = end.min(start + LANES);
            self.block(start..next);
            start = next;
        }
    }
}

impl Row<'_, '_> {
    #[inline(always)]
    fn block(&mut self, range: Range<usize>) {
        let buffer = self.buffer;
        let lanes = range.start..range.start + LANES;
        let load = |lists: &[Vec<f32>; 3]| -> [Lanes; 3] {
            std::array::from_fn(|c| {
                let mut loaded = [0.0; LANES];
                loaded.copy_from_slice(&lists[c][lanes.clone()]);
                loaded
            })
        };
        let middle = [load(&buffer.normal), load(&buffer.view)];
        let corners = match self.lookup.needs_corners() {
            true => Some(buffer.footprints(range.clone(), self.y)),
            false => None,
        };
        let mut sums = [[0.0; 4]; LANES];
        let reading = Reading {
            lookup: self.lookup,
            count: range.len(),
            middle: &middle,
            corners: corners.as_ref(),
        };
        for number in 0..self.shaders.len() {
            let mut mine = [1.0; LANES];
            if self.shaders.len() > 1 {
                for (k, material) in buffer.material[lanes.clone()].iter().enumerate() {
                    let own = buffer.shaders[*material as usize] as usize == number;
                    mine[k] = f32::from(u8::from(own));
                }
                if mine[..range.len()].iter().all(|m| *m == 0.0) {
                    continue;
                }
            }
            self.add(number, range.clone(), &mine, &reading, &mut sums);
        }
        for (at, [r, g, b, _]) in range.zip(sums) {
            let pixel = &mut self.pixels[usize::from(buffer.columns[at])];
            let coverage = buffer.coverage[at];
            *pixel = match coverage == 1.0 {
                true => [r, g, b],
                false => combine(coverage, [r, g, b], 1.0 - coverage, *pixel),
            };
        }
    }

    /// Adds what a shader shows in the lanes in which `mine` is 1; it is 0 in the others.
    #[inline(always)]
    fn add(
        &self,
        number: usize,
        range: Range<usize>,
        mine: &Lanes,
        reading: &Reading<'_>,
        sums: &mut Sums,
    ) {
        let (shader, buffer) = (&self.shaders[number], self.buffer);
        let lanes = range.start..range.start + LANES;
        let [n, e] = reading.middle;
        let mut cosines = [0.0; LANES];
        let (mut wd, mut ws) = ([[0.0; 4]; LANES], [[0.0; 4]; LANES]);
        for k in 0..LANES {
            let cosine = n[0][k] * e[0][k] + n[1][k] * e[1][k] + n[2][k] * e[2][k];
            cosines[k] = cosine;
            let scaled = |[r, g, b]: [f32; 3]| [mine[k] * r, mine[k] * g, mine[k] * b, 0.0];
            wd[k] = scaled(shader.diffuse_weight.at(cosine));
            ws[k] = scaled(shader.specular_weight.at(cosine));
        }
        // Weights times shares times reflectances; `which` is 0 for kd and 1 for ks.
        let factors = |weights: &Sums, shares: &Lanes, which: usize| {
            let mut factors = [[0.0; 4]; LANES];
            for (k, material) in buffer.material[lanes.clone()].iter().enumerate() {
                let reflectance = buffer.palette[*material as usize][which];
                factors[k] = std::array::from_fn(|c| shares[k] * weights[k][c] * reflectance[c]);
            }
            factors
        };
        let whole = [1.0; LANES];
        if let Some(table) = shader.diffuse {
            let t = shader.translucency;
            let front = factors(&wd, &[1.0 - t; LANES], 0);
            reading.add(table, Side::Normal, &front, sums);
            if t > 0.0 {
                let through = factors(&wd, &[t; LANES], 0);
                reading.add(table, Side::Behind, &through, sums);
            }
        }
        if shader.index == Index::Traced {
            self.glimpses(number, range.clone(), &factors(&ws, &whole, 1), sums);
        } else if let Some(table) = shader.specular {
            let side = Side::Index(shader.index);
            reading.add(table, side, &factors(&ws, &whole, 1), sums);
        }
        for (gloss, (_, tables)) in shader.glosses.iter().enumerate() {
            for (which, table) in tables.iter().enumerate() {
                let mut shares = [0.0; LANES];
                for (k, material) in buffer.material[lanes.clone()].iter().enumerate() {
                    if mine[k] == 1.0 {
                        shares[k] = self.shares[*material as usize][gloss]
                            * shader.incidence_share(which, cosines[k]);
                    }
                }
                if shares[..range.len()].iter().any(|share| *share != 0.0) {
                    let side = Side::Index(shader.index);
                    reading.add(table, side, &factors(&ws, &shares, 1), sums);
                }
            }
        }
        if let Some(table) = shader.coat {
            let coats = mine.map(|own| [own * COAT; 4]);
            reading.add(table, Side::Index(Index::Mirror), &coats, sums);
        }
    }

    /// Adds what mirrored rays of a traced shader meet.
    fn glimpses(&self, number: usize, range: Range<usize>, factors: &Sums, sums: &mut Sums) {
        let list = &self.buffer.mirrored;
        let start = list.partition_point(|glimpse| (glimpse.pixel as usize) < range.start);
        for glimpse in &list[start..] {
            let Some(k) = (glimpse.pixel as usize)
                .checked_sub(range.start)
                .filter(|k| *k < range.len())
            else {
                break;
            };
            let value = match &glimpse.met {
                Mirrored::Environment(direction) => self.shaders[number]
                    .specular
                    .map_or([0.0; 3], |i| i.bilinear(direction.as_vec3().to_array())),
                Mirrored::Surface(surface) => {
                    let shader = &self.shaders[surface.shader as usize];
                    let [normal, view] =
                        [surface.normal, surface.view].map(|v| v.as_vec3().to_array());
                    let reflectances = surface.reflectances.map(|v| v.as_vec3().to_array());
                    shader.at(normal, view, reflectances, surface.exponent)
                }
            };
            for c in 0..3 {
                sums[k][c] += glimpse.share * factors[k][c] * value[c];
            }
        }
    }
}

/// Where a block reads its tables.
struct Reading<'a> {
    lookup: Lookup,
    /// Pixels of the block.
    count: usize,
    middle: &'a NormalsAndViews,
    /// For antialiased look-ups.
    corners: Option<&'a [NormalsAndViews; 4]>,
}

impl Reading<'_> {
    /// Adds what a table holds for each pixel, times its factor.
    #[inline(always)]
    fn add(&self, table: &Table, side: Side, factors: &Sums, sums: &mut Sums) {
        let Some(corners) = self.corners else {
            let nearest = self.lookup == Lookup::Nearest;
            table.add(&directions(side, self.middle), nearest, factors, sums);
            return;
        };
        let mut quads = [[[0.0; LANES]; 3]; 4];
        let mut places = [[[0.0; LANES]; 2]; 4];
        for q in 0..4 {
            quads[q] = directions(side, &corners[q]);
            places[q] = table.block(&quads[q]);
        }
        for k in 0..self.count {
            if factors[k] == [0.0; 4] {
                continue;
            }
            let (mut quad, mut place) = ([[0.0; 3]; 4], [[0.0; 2]; 4]);
            for q in 0..4 {
                quad[q] = [quads[q][0][k], quads[q][1][k], quads[q][2][k]];
                place[q] = [places[q][0][k], places[q][1][k]];
            }
            let value = self.lookup.read_at(table, quad, place);
            for c in 0..3 {
                sums[k][c] += factors[k][c] * value[c];
            }
        }
    }
}

/// What indexes a table.
#[derive(Clone, Copy)]
enum Side {
    /// N.
    Normal,
    /// −N.
    Behind,
    /// A direction of N and E.
    Index(Index),
}

/// The directions that index a table.
#[inline(always)]
fn directions(side: Side, [n, e]: &NormalsAndViews) -> [Lanes; 3] {
    let index = match side {
        Side::Normal => return *n,
        Side::Behind => return n.map(|lanes| lanes.map(|v| -v)),
        Side::Index(index) => index,
    };
    let mut found = [[0.0; LANES]; 3];
    for k in 0..LANES {
        let [x, y, z] = index.direction([n[0][k], n[1][k], n[2][k]], [e[0][k], e[1][k], e[2][k]]);
        (found[0][k], found[1][k], found[2][k]) = (x, y, z);
    }
    found
}

impl GBuffer {
    /// Normals and views at the corners of pixels, in a turn. Where a corner misses the pixel's object, the pixel's
    /// own stand.
    fn footprints(&self, range: Range<usize>, y: usize) -> [NormalsAndViews; 4] {
        let width = self.camera.size[0] as usize + 1;
        let mut found = [[[[0.0; LANES]; 3]; 2]; 4];
        for (k, at) in range.enumerate() {
            let x = usize::from(self.columns[at]);
            let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
            for (corner, (x, y)) in found.iter_mut().zip(corners) {
                let mut surface = self.corners[y * width + x];
                if surface[0] == [0.0; 3] || self.corner_objects[y * width + x] != self.objects[at]
                {
                    surface =
                        [&self.normal, &self.view].map(|l| [0, 1, 2].map(|c: usize| l[c][at]));
                }
                for (lanes, vector) in corner.iter_mut().zip(surface) {
                    (0..3).for_each(|c| lanes[c][k] = vector[c]);
                }
            }
        }
        found
    }
}
