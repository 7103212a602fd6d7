//! The surfaces under sixteen lanes, and frames about their normals.

#![allow(
    clippy::needless_range_loop,
    reason = "a lane is one index into many arrays"
)]

use crate::options::View;
use crate::survey::{Cell, Cells, kept_in, place_in};
use ambient::ggx::LEAST_COS;
use ambient::sampling::{LANES, Wide};
use glam::DVec3;

/// f64 numbers of all lanes.
type Deep = [f64; LANES];

/// The surfaces under the lanes, as structures of arrays: see [`Cell`] for what each is.
#[derive(Clone)]
pub(super) struct LaneSurfaces {
    position: [[Deep; 3]; 3],
    /// Geometric normal times offset.
    lift: [Deep; 3],
    normal: [[Wide; 3]; 3],
    pub geometric: [Wide; 3],
    /// Start, inverse share and fold.
    place: [Wide; 3],
    /// Of lanes whose texels triangles cover wholly, the weights of the second and third corner over the unit square,
    /// and the least of all three.
    weights: [[Wide; 2]; 3],
    least: [Wide; 3],
    whole: u32,
    /// Lanes whose shading normal changes over their cell.
    pub smooth: u32,
}

/// Frames about the lanes' shading normals.
#[derive(Clone)]
pub(super) struct Frames {
    pub normal: [Wide; 3],
    tangent: [Wide; 3],
    bitangent: [Wide; 3],
}

impl LaneSurfaces {
    /// Nothing under any lane.
    pub fn none() -> Self {
        Self {
            position: [[[0.0; LANES]; 3]; 3],
            lift: [[0.0; LANES]; 3],
            normal: [[[0.0; LANES]; 3]; 3],
            geometric: [[0.0; LANES]; 3],
            place: [[0.0; LANES]; 3],
            weights: [[[0.0; LANES]; 2]; 3],
            least: [[0.0; LANES]; 3],
            whole: 0,
            smooth: 0,
        }
    }

    /// Puts a texel's first cell under lanes.
    #[inline(always)]
    pub fn set<const N: usize>(&mut self, lanes: [usize; N], cells: &Cells) {
        self.set_position(lanes, cells, 0);
        self.set_normal(lanes, cells.cell(0));
    }

    /// Puts a cell of a texel under lanes, but for its normals.
    #[inline(always)]
    pub fn set_position<const N: usize>(
        &mut self,
        lanes: [usize; N],
        cells: &Cells,
        number: usize,
    ) {
        let cell = cells.cell(number);
        for axis in 0..3 {
            for k in 0..3 {
                put(&mut self.position[k][axis], lanes, cell.position[k][axis]);
            }
            put(&mut self.lift[axis], lanes, cell.lift[axis]);
        }
        let own = lanes.into_iter().fold(0, |own, lane| own | 1 << lane);
        if cells.are_whole() {
            self.whole |= own;
            for (row, weights) in self.weights.iter_mut().zip(cells.weights(number)) {
                put(&mut row[0], lanes, weights[0]);
                put(&mut row[1], lanes, weights[1]);
            }
            for (row, least) in self.least.iter_mut().zip(cell.least) {
                put(row, lanes, least);
            }
        } else {
            self.whole &= !own;
            for (row, value) in self.place.iter_mut().zip(cell.placement()) {
                put(row, lanes, value);
            }
        }
    }

    #[inline(always)]
    pub fn set_normal<const N: usize>(&mut self, lanes: [usize; N], cell: &Cell) {
        for axis in 0..3 {
            for k in 0..3 {
                put(
                    &mut self.normal[k][axis],
                    lanes,
                    cell.normal[k][axis] as f32,
                );
            }
            put(
                &mut self.geometric[axis],
                lanes,
                cell.geometric[axis] as f32,
            );
        }
        let own = lanes.into_iter().fold(0, |own, lane| own | 1 << lane);
        self.smooth = match cell.is_smooth() {
            true => self.smooth | own,
            false => self.smooth & !own,
        };
    }

    /// (s, t) in the cells of points of the unit square.
    #[inline(always)]
    pub fn places(&self, v0: &Wide, v1: &Wide) -> [Wide; 2] {
        let mut at = [[0.0; LANES]; 2];
        for l in 0..LANES {
            let place = [self.place[0][l], self.place[1][l], self.place[2][l]];
            [at[0][l], at[1][l]] = place_in(place, [v0[l], v1[l]]);
        }
        if self.whole == 0 {
            return at;
        }
        let ([a, b, c], least) = (&self.weights, &self.least);
        for l in 0..LANES {
            let weight = |k: usize| a[k][l] + b[k][l] * v0[l] + c[k][l] * v1[l];
            let [s, t] = kept_in(
                [least[0][l], least[1][l], least[2][l]],
                [weight(0), weight(1)],
            );
            let is_whole = self.whole >> l & 1 == 1;
            at[0][l] = if is_whole { s } else { at[0][l] };
            at[1][l] = if is_whole { t } else { at[1][l] };
        }
        at
    }

    /// Unit shading normals.
    #[inline(always)]
    pub fn normals(&self, [s, t]: &[Wide; 2]) -> [Wide; 3] {
        let mut unit = [[0.0; LANES]; 3];
        let ([n0, ns, nt], g) = (&self.normal, &self.geometric);
        for l in 0..LANES {
            let n = axes(|a| n0[a][l] + ns[a][l] * s[l] + nt[a][l] * t[l]);
            let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
            // Corner normals that cancel: the geometric normal stands in.
            let has_length = square > 1e-20;
            let scale = 1.0 / (if has_length { square } else { 1.0 }).sqrt();
            for a in 0..3 {
                unit[a][l] = if has_length { n[a] * scale } else { g[a][l] };
            }
        }
        unit
    }

    /// Ray origins: positions in f64, lifted off the surface, rounded once.
    #[inline(always)]
    pub fn origins(&self, [s, t]: &[Wide; 2], out: &mut [Wide; 3]) {
        for a in 0..3 {
            let [p0, ps, pt] = &self.position;
            for l in 0..LANES {
                let (s, t) = (f64::from(s[l]), f64::from(t[l]));
                let p = p0[a][l] + ps[a][l] * s + pt[a][l] * t;
                out[a][l] = (p + self.lift[a][l]) as f32;
            }
        }
    }
}

impl Frames {
    /// Frames about unit axes. T. Duff and others, "Building an Orthonormal Basis, Revisited", JCGT 2017.
    #[inline(always)]
    pub fn about(axis: [Wide; 3]) -> Self {
        let (mut tangent, mut bitangent) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for l in 0..LANES {
            let [x, y, z] = [axis[0][l], axis[1][l], axis[2][l]];
            let sign = 1.0_f32.copysign(z);
            let a = -1.0 / (sign + z);
            let b = x * y * a;
            tangent[0][l] = 1.0 + sign * x * x * a;
            tangent[1][l] = sign * b;
            tangent[2][l] = -sign * x;
            bitangent[0][l] = b;
            bitangent[1][l] = sign + y * y * a;
            bitangent[2][l] = -y;
        }
        Self {
            normal: axis,
            tangent,
            bitangent,
        }
    }

    /// Unit views from places: along the normals, or to an eye.
    #[inline(always)]
    pub fn views_of(&self, view: View, origin: &[Wide; 3]) -> [Wide; 3] {
        match view {
            View::Normal => self.normal,
            View::Eye(eye) => self.views(origin, eye),
        }
    }

    /// Unit views from an eye point, at least [`LEAST_COS`] above the surface, as [`ambient::ggx::Ggx`] keeps them. V =
    /// N where the eye stands on the surface.
    #[inline(always)]
    fn views(&self, origin: &[Wide; 3], eye: DVec3) -> [Wide; 3] {
        let mut out = [[0.0; LANES]; 3];
        for l in 0..LANES {
            let n = [self.normal[0][l], self.normal[1][l], self.normal[2][l]];
            let v = axes(|a| (eye[a] - f64::from(origin[a][l])) as f32);
            let largest = v[0].abs().max(v[1].abs()).max(v[2].abs());
            let has_length = largest > 0.0;
            let v = axes(|a| if has_length { v[a] / largest } else { n[a] });
            let square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
            let cos = (n[0] * v[0] + n[1] * v[1] + n[2] * v[2]) / square.sqrt();
            let kept = cos.clamp(LEAST_COS as f32, 1.0);
            let height = cos * square.sqrt();
            let along = axes(|a| v[a] - height * n[a]);
            let length = along[0] * along[0] + along[1] * along[1] + along[2] * along[2];
            // Straight above or below there is no side to lean to: any serves.
            let leans = length > 1e-12 * square;
            let scale = (1.0 - kept * kept).sqrt() / (if leans { length } else { 1.0 }).sqrt();
            for a in 0..3 {
                let side = if leans { along[a] } else { self.tangent[a][l] };
                out[a][l] = kept * n[a] + scale * side;
            }
        }
        out
    }

    /// Local directions in the world.
    #[inline(always)]
    pub fn to_world(&self, local: &[Wide; 3]) -> [Wide; 3] {
        let mut out = [[0.0; LANES]; 3];
        for a in 0..3 {
            for l in 0..LANES {
                out[a][l] = self.tangent[a][l] * local[0][l]
                    + self.bitangent[a][l] * local[1][l]
                    + self.normal[a][l] * local[2][l];
            }
        }
        out
    }
}

/// Writes a number for lanes.
#[inline(always)]
fn put<T: Copy, const N: usize>(plane: &mut [T; LANES], lanes: [usize; N], value: T) {
    for lane in lanes {
        plane[lane] = value;
    }
}

/// The value of each axis. The array's own `map` is not always inlined, and a loop that calls it is no vector code.
#[inline(always)]
fn axes(of: impl Fn(usize) -> f32) -> [f32; 3] {
    [of(0), of(1), of(2)]
}

/// R = 2 (N.V) N - V for an eye point: the axes of the specular lobes. V = N where the eye stands on the surface.
#[inline(always)]
pub(super) fn mirrored(normal: &[Wide; 3], origin: &[Wide; 3], eye: DVec3) -> [Wide; 3] {
    let mut out = [[0.0; LANES]; 3];
    for l in 0..LANES {
        let v = axes(|a| (eye[a] - f64::from(origin[a][l])) as f32);
        let n = [normal[0][l], normal[1][l], normal[2][l]];
        let largest = v[0].abs().max(v[1].abs()).max(v[2].abs());
        let has_length = largest > 0.0;
        let v = axes(|a| v[a] / if has_length { largest } else { 1.0 });
        let square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let scale = 1.0 / (if has_length { square } else { 1.0 }).sqrt();
        let v = axes(|a| v[a] * scale);
        let twice = 2.0 * (n[0] * v[0] + n[1] * v[1] + n[2] * v[2]);
        for a in 0..3 {
            out[a][l] = if has_length {
                twice * n[a] - v[a]
            } else {
                n[a]
            };
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::survey::fixture;

    #[test]
    fn a_lane_is_smooth_as_the_last_cell_under_it() {
        let piece = fixture::piece(false, [[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]]);
        let up = [0.0, 0.0, 1.0];
        let [flat, smooth] = [[up; 3], [up, [0.6, 0.0, 0.8], up]]
            .map(|normals| fixture::cells(&fixture::patch(normals), &[(piece, 1.0)]));
        let [flat, smooth] = [flat.cell(0), smooth.cell(0)];
        assert_eq!([flat.is_smooth(), smooth.is_smooth()], [false, true]);
        let mut surfaces = LaneSurfaces::none();
        let mut expected = 0u32;
        for turn in 0..3 * LANES {
            let (lane, is_smooth) = (turn * 7 % LANES, turn % 3 != 1);
            surfaces.set_normal([lane], if is_smooth { smooth } else { flat });
            expected = expected & !(1 << lane) | u32::from(is_smooth) << lane;
            assert_eq!(surfaces.smooth, expected, "after {turn}");
        }
    }
}
