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

/// What says which texels of a tile are of one surface.
pub(super) struct Pool {
    arch: Arch,
    /// Below 0 where there is no texel.
    object: Vec<f64>,
    normal: [Vec<f64>; 3],
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
            object: vec![-1.0; EDGE * EDGE],
            normal: [0; 3].map(|_| vec![0.0; EDGE * EDGE]),
        };
        for texel in texels {
            let place = place(texel);
            pool.object[place] = f64::from(texel.object);
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
        let mut sums = Vec::with_capacity(texels.len());
        self.arch.dispatch(Sum {
            pool: self,
            radius,
            texels,
            planes: &planes,
            sums: &mut sums,
        });
        sums
    }
}

struct Sum<'a, const N: usize> {
    pool: &'a Pool,
    radius: usize,
    texels: &'a [Texel],
    /// Numbers of each texel of the tile, 0 where there is none.
    planes: &'a [[f64; EDGE * EDGE]; N],
    sums: &'a mut Vec<[f64; N]>,
}

impl<const N: usize> WithSimd for Sum<'_, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Pool { object, normal, .. } = self.pool;
        let row = |at: usize| at..at + INNER;
        let [x, y, z] = normal;
        let facing = |at: usize| [&x[row(at)], &y[row(at)], &z[row(at)]];
        for texels in self.texels.chunk_by(|a, b| a.y == b.y) {
            let y = (texels[0].y % TILE) as usize + FARTHEST;
            let own = y * EDGE + FARTHEST;
            let mut sums = [[0.0; INNER]; N];
            for ny in y - self.radius..=y + self.radius {
                for nx in FARTHEST - self.radius..=FARTHEST + self.radius {
                    let other = ny * EDGE + nx;
                    let mut agree = [0.0; INNER];
                    // Of sixteen numbers each, so that the loop has no bound to look at.
                    let ([x0, y0, z0], [x1, y1, z1]) = (facing(own), facing(other));
                    let (a, b) = (&object[row(own)], &object[row(other)]);
                    for x in 0..INNER {
                        let cos = x0[x] * x1[x] + y0[x] * y1[x] + z0[x] * z1[x];
                        let is_one = (a[x] == b[x]) & (cos > NORMAL_AGREEMENT);
                        agree[x] = if is_one { 1.0 } else { 0.0 };
                    }
                    for (sum, plane) in sums.iter_mut().zip(self.planes) {
                        for (x, value) in plane[row(other)].iter().enumerate() {
                            sum[x] += agree[x] * value;
                        }
                    }
                }
            }
            for texel in texels {
                let x = (texel.x % TILE) as usize;
                self.sums.push(sums.each_ref().map(|sum| sum[x]));
            }
        }
    }
}
