//! Sums over the texels about each texel of a tile that are of the same surface.

use crate::survey::Texel;
use atlas::TILE;
use pulp::{Arch, Simd, WithSimd};

/// Neighbours pool where their normals are within acos of this, some 37 degrees.
const NORMAL_AGREEMENT: f64 = 0.8;

/// Most steps to a neighbour along an axis.
const FARTHEST: usize = 2;

const INNER: usize = TILE as usize;

/// A tile's edge with a border in which nothing lies, so that each texel has all its neighbours.
const EDGE: usize = INNER + 2 * FARTHEST;

/// A number of each texel of a tile, 0 where there is none.
pub(super) type Plane = [f64; EDGE * EDGE];

/// What says which texels of a tile are of one surface.
pub(super) struct Pool {
    arch: Arch,
    object: [u32; EDGE * EDGE],
    normal: [Plane; 3],
}

/// A texel's place in a plane.
fn place(texel: &Texel) -> usize {
    let [x, y] = [texel.x, texel.y].map(|at| (at % TILE) as usize + FARTHEST);
    y * EDGE + x
}

impl Pool {
    /// Of the texels of one tile.
    pub fn of(arch: Arch, texels: &[Texel]) -> Self {
        let mut pool = Self {
            arch,
            object: [u32::MAX; EDGE * EDGE],
            normal: [[0.0; EDGE * EDGE]; 3],
        };
        for texel in texels {
            let place = place(texel);
            pool.object[place] = texel.object;
            for (plane, axis) in pool.normal.iter_mut().zip(texel.normal.to_array()) {
                plane[place] = axis;
            }
        }
        pool
    }

    /// Sums of what `of` says of texels, over each of them and those that are no more than `radius` away along an
    /// axis and of its surface.
    pub fn sums<const N: usize>(
        &self,
        radius: usize,
        texels: &[Texel],
        of: impl Fn(usize) -> [f64; N],
    ) -> Vec<[f64; N]> {
        assert!(radius <= FARTHEST, "{radius} steps");
        let mut planes = [[0.0; EDGE * EDGE]; N];
        for (i, texel) in texels.iter().enumerate() {
            let place = place(texel);
            for (plane, value) in planes.iter_mut().zip(of(i)) {
                plane[place] = value;
            }
        }
        let mut sums = [[0.0; EDGE * EDGE]; N];
        self.arch.dispatch(Sum {
            pool: self,
            radius,
            planes: &planes,
            sums: &mut sums,
        });
        let sum = |texel: &Texel| sums.each_ref().map(|plane| plane[place(texel)]);
        texels.iter().map(sum).collect()
    }
}

struct Sum<'a, const N: usize> {
    pool: &'a Pool,
    radius: usize,
    planes: &'a [Plane; N],
    sums: &'a mut [Plane; N],
}

impl<const N: usize> WithSimd for Sum<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Pool { object, normal, .. } = self.pool;
        let row = |at: usize| at..at + INNER;
        for y in FARTHEST..FARTHEST + INNER {
            let own = y * EDGE + FARTHEST;
            let mut sums = [[0.0; INNER]; N];
            for ny in y - self.radius..=y + self.radius {
                for nx in FARTHEST - self.radius..=FARTHEST + self.radius {
                    let other = ny * EDGE + nx;
                    let mut agree = [0.0; INNER];
                    let dot =
                        |axis: usize, x: usize| normal[axis][own + x] * normal[axis][other + x];
                    let (a, b) = (&object[row(own)], &object[row(other)]);
                    for x in 0..INNER {
                        let is_one =
                            (a[x] == b[x]) & (dot(0, x) + dot(1, x) + dot(2, x) > NORMAL_AGREEMENT);
                        agree[x] = f64::from(u8::from(is_one));
                    }
                    for (sum, plane) in sums.iter_mut().zip(self.planes) {
                        for (x, value) in plane[row(other)].iter().enumerate() {
                            sum[x] += agree[x] * value;
                        }
                    }
                }
            }
            for (sum, plane) in sums.iter().zip(self.sums.iter_mut()) {
                plane[row(own)].copy_from_slice(sum);
            }
        }
    }
}
