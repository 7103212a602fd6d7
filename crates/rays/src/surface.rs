//! Points on surfaces: position, normals, and a ray origin that cannot meet its own surface.
//!
//! **Ray origins.** No bias is set by a user. A sample's origin is moved along the geometric normal by a bound on the
//! rounding that a ray query can suffer, so that the own triangle and its coplanar neighbours are missed, and by no
//! more. The bound follows the arithmetic of a Plücker test as Embree and our obvhs test do it: corners are translated
//! to the origin, `T = v0 . (e1 x e2)` decides on which side the plane lies. With unit roundoff u = 2^-24, edges no
//! longer than the triangle's box (X, Y, Z), standard running error analysis (Higham, *Accuracy and Stability of
//! Numerical Algorithms*, 2002, section 3) gives `|error(T)| <= 78 u X Y Z`, so a distance of `78 u XYZ / |e1 x e2|`.
//! For an axis-aligned triangle the box is flat and the bound is exactly 0: the origin lies in the plane, where the
//! open end of the ray interval excludes it. Rounding of the origin itself adds `u |n_i o_i|` on the axes in which the
//! triangle has extent (twice: once for the height it may cost, once to stay above), and an instance's transform adds
//! its own rounding.
//!
//! The bound grows without end as a triangle gets narrow, and so does what its normal is off by. A triangle hides no
//! more than its width, and a point of it that is lifted by its width along that normal moves aside by no more than
//! corners are rounded. So the bound is at most the width. A sliver would else lift its own points, and those of its
//! neighbours, out of the scene.
//!
//! **Edges.** Where two faces meet, an origin that rounds onto or beyond the other face's plane would see through it.
//! Twice the rounding bound away from the edges a closed box stays exactly dark. At the outside of an edge that is too
//! little: a ray that leaves over the edge passes the other face's plane right beside that face, and for 2 % of the
//! directions Embree takes it for met. Texels of which an edge is all that is on the page would be dashed. So samples
//! keep [`AWAY`] times the bound away, where 0.04 % are left. That is some thousandths of a millimetre a metre from the
//! origin.

use crate::world::World;
use crate::world::lit::Lit;
use glam::DVec3;

/// Unit roundoff of f32.
const UNIT_ROUNDOFF: f64 = 1.0 / 16_777_216.0;

/// Factor of the running error bound of `T`, see the head of this file.
const PLANE_ERROR: f64 = 78.0;

/// How many times the rounding bound samples keep away from edges, and the least at which a closed box is dark.
const AWAY: f64 = 64.0;
const LEAST_AWAY: f64 = 2.0;

/// A sample's least corner weight never exceeds this, however thin its triangle.
const LARGEST_INSET: f64 = 0.25;

/// One triangle of an object, in world space, with what sampling it needs.
#[derive(Debug, Clone)]
pub struct Patch {
    /// Corners in the world.
    pub corners: [DVec3; 3],
    /// Corner shading normals; `None` shades flat.
    normals: Option<[DVec3; 3]>,
    /// Unit geometric normal on the side that is lit.
    pub geometric: DVec3,
    /// Twice its area, squared scene units.
    pub twice_area: f64,
    /// Lowest corner of its box.
    pub low: DVec3,
    /// Highest corner of its box.
    pub high: DVec3,
    /// Rounding bound of the plane test and of an instance's transform as a distance, over this triangle and its
    /// neighbours.
    query_error: f64,
    /// Rounding bound of an origin per unit of its absolute coordinates.
    origin_error: DVec3,
    /// Corner weights at the rounding bound from the edges.
    inset: DVec3,
}

/// Per-vertex bounds of the plane test over the incident triangles, for every geometry of a world.
#[derive(Debug)]
pub struct PlaneErrors(Vec<Vec<f32>>);

impl PlaneErrors {
    /// Bounds of all vertices. Neighbours are those that share a vertex index.
    pub fn of(world: &World) -> Self {
        Self(
            world
                .geometries
                .iter()
                .map(|geometry| {
                    let mut bounds = vec![0.0f32; geometry.positions.len()];
                    for triangle in geometry.triangles() {
                        let corners = triangle.map(|v| geometry.positions[v as usize].as_dvec3());
                        let bound = plane_error(&corners) as f32;
                        for &vertex in triangle {
                            let slot = &mut bounds[vertex as usize];
                            *slot = slot.max(bound);
                        }
                    }
                    bounds
                })
                .collect(),
        )
    }
}

/// The rounding bound of a triangle's plane test as a distance, at most the triangle's width; 0 without area.
fn plane_error(&[a, b, c]: &[DVec3; 3]) -> f64 {
    let extent = a.max(b).max(c) - a.min(b).min(c);
    let volume = extent.element_product();
    let twice_area = (b - a).cross(c - a).length();
    if !(volume > 0.0 && twice_area > 0.0) {
        return 0.0;
    }
    let length = (b - a).length().max((c - b).length()).max((a - c).length());
    (PLANE_ERROR * UNIT_ROUNDOFF * volume / twice_area).min(twice_area / length)
}

impl Patch {
    /// The triangle as the rays see it.
    pub fn of(world: &World, errors: &PlaneErrors, instance: u32, triangle: u32) -> Self {
        let corners = world.corners(instance, triangle);
        let (part, geometry) = world.part(instance);
        let indices = geometry.triangles()[triangle as usize];
        let bounds = &errors.0[part.geometry as usize];
        let [a, b, c] = indices.map(|v| bounds[v as usize]);
        let bound = f64::from(a.max(b).max(c));
        let Lit { face, normals, .. } = world.lit(instance, triangle, &corners);
        let fallback = || {
            let sum = normals.map(|[a, b, c]: [DVec3; 3]| (a + b + c).try_normalize());
            sum.flatten().unwrap_or(DVec3::Z)
        };
        let twice_area = face.length();
        let geometric = match 1.0 / twice_area {
            inverse if inverse > 0.0 && inverse.is_finite() => face * inverse,
            _ => face.try_normalize().unwrap_or_else(fallback),
        };
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        let reach = low.abs().max(high.abs());
        let query_error = bound * part.stretch() + part.rounding(geometric, &corners);
        let extended = DVec3::select((high - low).cmpgt(DVec3::ZERO), DVec3::ONE, DVec3::ZERO);
        let origin_error = UNIT_ROUNDOFF * extended * geometric.abs();
        let bound =
            query_error + 2.0 * origin_error.dot(reach) + UNIT_ROUNDOFF * reach.max_element();
        let share = bound / twice_area;
        let inset = [0, 1, 2].map(|corner: usize| {
            (corners[(corner + 2) % 3] - corners[(corner + 1) % 3]).length() * share
        });
        Self {
            corners,
            normals,
            geometric,
            twice_area,
            low,
            high,
            query_error,
            origin_error,
            inset: inset.into(),
        }
    }

    /// True where the shading normal is the geometric normal all over the triangle.
    pub fn is_flat(&self) -> bool {
        self.normals
            .is_none_or(|[a, b, c]| a == b && a == c && a.dot(self.geometric) >= 1.0 - 1e-12)
    }

    /// How far above its plane rounding can put a point of this triangle, in scene units.
    pub fn rounding(&self) -> f64 {
        self.offset(self.low.abs().max(self.high.abs()))
    }

    /// True where corner weights are far enough from the edges for a sample.
    pub fn keeps(&self, weights: DVec3) -> bool {
        weights.cmpge(self.least(AWAY)).all()
    }

    /// Corner weights moved so far from the edges.
    pub fn kept(&self, weights: DVec3) -> DVec3 {
        let kept = weights.max(self.least(AWAY));
        kept / kept.element_sum()
    }

    /// Corner weights moved no farther from the edges than a closed box needs to be dark: for points that a camera
    /// sees, which are to stay where they are and are next to an edge by chance alone.
    pub fn kept_inside(&self, weights: DVec3) -> DVec3 {
        let kept = weights.max(self.least(LEAST_AWAY));
        kept / kept.element_sum()
    }

    /// The least corner weights that [`Patch::kept`] leaves.
    pub fn least_weights(&self) -> DVec3 {
        self.least(AWAY)
    }

    /// Least corner weights at so many times the bound.
    fn least(&self, times: f64) -> DVec3 {
        (self.inset * times).min(DVec3::splat(LARGEST_INSET))
    }

    /// The point with these corner weights. It stays in the triangle's box, so it is exact on an axis in which the
    /// triangle is flat.
    pub fn position(&self, weights: DVec3) -> DVec3 {
        let [a, b, c] = self.corners;
        (a * weights.x + b * weights.y + c * weights.z).clamp(self.low, self.high)
    }

    /// The shading normal with these corner weights, not of unit length between corners.
    pub fn normal(&self, weights: DVec3) -> DVec3 {
        match self.normals {
            None => self.geometric,
            Some([a, b, c]) if a == b && a == c => a,
            Some([a, b, c]) => a * weights.x + b * weights.y + c * weights.z,
        }
    }

    /// The shading normals at the corners, of unit length.
    pub fn normals(&self) -> [DVec3; 3] {
        self.normals.unwrap_or([self.geometric; 3])
    }

    /// How far an origin must stand off where coordinates are no larger than `reach` in magnitude, in scene units.
    pub fn offset(&self, reach: DVec3) -> f64 {
        self.query_error + 2.0 * self.origin_error.dot(reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::{Ray, TreeKind};
    use crate::build::{BackendKind, build, has_embree};
    use crate::fixture;
    use glam::{DAffine3, Vec3};
    use scene::Mesh;

    fn kinds() -> Vec<BackendKind> {
        let mut kinds = vec![
            BackendKind::Obvhs(TreeKind::Bvh2),
            BackendKind::Obvhs(TreeKind::Cwbvh),
        ];
        kinds.extend(has_embree().then_some(BackendKind::Embree));
        kinds
    }

    /// A ray from a point of a patch to the side of a unit normal.
    fn ray(patch: &Patch, weights: DVec3, normal: DVec3, dice: &mut fixture::Dice) -> Ray {
        let position = patch.position(patch.kept(weights));
        let turned = dice.point().as_dvec3();
        let lifted = position + normal * patch.offset(position.abs());
        Ray {
            origin: lifted.as_vec3().to_array(),
            direction: (turned * turned.dot(normal).signum()).as_vec3().to_array(),
            t_min: 0.0,
            t_max: f32::INFINITY,
        }
    }

    /// The normal on the side of the origin.
    fn within(patch: &Patch) -> DVec3 {
        -patch.corners[0].dot(patch.geometric).signum() * patch.geometric
    }

    #[test]
    fn the_outside_of_an_edge_meets_nothing_of_its_own_box() {
        // Coordinates of many bits, so that nothing is exact by chance.
        for (origin, size) in [
            (Vec3::new(7.0, 0.1, 1.0), 1.0),
            (Vec3::new(123.4, -0.37, 61.7), 0.9),
            (Vec3::new(0.013, 2.71, -0.77), 0.031),
        ] {
            let half = Vec3::splat(0.5 * size);
            let mesh = fixture::block(origin + half, half, false);
            let triangles = mesh.triangles.len() as u32;
            let world = fixture::world(fixture::scene(vec![mesh]));
            let errors = PlaneErrors::of(&world);
            for kind in kinds() {
                let backend = build(kind, &world, 1).expect("a backend");
                let mut dice = fixture::Dice(crate::mix::Mix(9));
                let (mut met, mut cast) = (0, 0);
                for triangle in 0..triangles {
                    let patch = Patch::of(&world, &errors, 0, triangle);
                    for edge in 0..3 {
                        for _ in 0..400 {
                            let mut weights = DVec3::ZERO;
                            weights[(edge + 1) % 3] = f64::from(dice.roll());
                            weights[(edge + 2) % 3] = 1.0 - weights[(edge + 1) % 3];
                            let ray = ray(&patch, weights, patch.geometric, &mut dice);
                            cast += 1;
                            met += u32::from(backend.occluded(&ray));
                        }
                    }
                }
                println!("{kind:?} at {origin}: {met} of {cast}");
                assert!(met * 200 <= cast, "{kind:?} at {origin}: {met} of {cast}");
            }
        }
    }

    /// A ball that is seen from within, whose poles are rings of corners a few ulps apart, as R sin(pi) makes them.
    fn ball_with_ringed_poles() -> Mesh {
        let (rings, around) = (12_u32, 24_u32);
        let mut mesh = fixture::soup(&[]);
        for ring in 0..=rings {
            let (sin, cos) = (ring as f32 / rings as f32 * std::f32::consts::PI).sin_cos();
            let place = |k: u32| {
                let (s, c) = (k as f32 / around as f32 * std::f32::consts::TAU).sin_cos();
                3.0 * Vec3::new(sin * c, cos, sin * s)
            };
            mesh.positions.extend((0..around).map(place));
        }
        for ring in 0..rings {
            for k in 0..around {
                let [a, b] = [k, (k + 1) % around].map(|k| ring * around + k);
                let quad = [[a, b, b + around], [a, b + around, a + around]];
                mesh.triangles.extend(quad.map(|[a, b, c]| [a, c, b]));
            }
        }
        mesh
    }

    #[test]
    fn a_sliver_lifts_its_neighbours_by_no_more_than_its_width() {
        let mesh = ball_with_ringed_poles();
        let narrow = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
            (b - a).length().min((c - b).length()).min((a - c).length()) < 1e-5
        };
        let is_narrow: Vec<bool> = mesh.triangles.iter().map(narrow).collect();
        let world = fixture::world(fixture::scene(vec![mesh.clone()]));
        let errors = PlaneErrors::of(&world);
        let backend = build(BackendKind::Obvhs(TreeKind::Bvh2), &world, 1).expect("a backend");
        let mut dice = fixture::Dice(crate::mix::Mix(7));
        let (mut open, mut cast) = (0, 0);
        let wide = is_narrow.iter().enumerate().filter(|(_, narrow)| !**narrow);
        for (triangle, _) in wide {
            let triangle = triangle as u32;
            let patch = Patch::of(&world, &errors, 0, triangle);
            // Without its neighbours: an edge of 0.8 at 3 units from the origin.
            assert!(patch.rounding() < 1e-5, "{triangle}: {}", patch.rounding());
            for _ in 0..64 {
                let weights = DVec3::new(0.2, 0.3, 0.5);
                let ray = ray(&patch, weights, within(&patch), &mut dice);
                cast += 1;
                open += u32::from(!backend.occluded(&ray));
            }
        }
        assert!(
            cast > 30_000 && open == 0,
            "{open} of {cast} rays leave a closed ball"
        );
    }

    /// A closed box whose upright edges are cut off by so much: of each cut the two triangles are slivers.
    fn chamfered(cut: f32) -> Mesh {
        let mut mesh = fixture::soup(&[]);
        // Out of line with the axes, so that no box about a triangle is flat.
        let turn = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.4, 0.3, 0.2);
        let (size, inner) = (3.0, 3.0 - cut);
        let ring = [
            [size, inner],
            [inner, size],
            [-inner, size],
            [-size, inner],
            [-size, -inner],
            [-inner, -size],
            [inner, -size],
            [size, -inner],
        ];
        for y in [-2.0, 2.0] {
            mesh.positions
                .extend(ring.map(|[x, z]| turn * Vec3::new(x, y, z)));
        }
        for k in 0..8 {
            let next = (k + 1) % 8;
            mesh.triangles
                .extend([[k, k + 8, next], [next, k + 8, next + 8]]);
        }
        mesh.triangles
            .extend((1..7).flat_map(|k| [[0, k, k + 1], [8, k + 9, k + 8]]));
        mesh
    }

    #[test]
    fn a_box_with_slivers_for_edges_stays_all_but_closed_from_within() {
        // At 1e-6, four roundings of a coordinate, a sliver's own normal is noise.
        for cut in [1e-2, 1e-3, 1e-4, 1e-5] {
            let mesh = chamfered(cut);
            let triangles = mesh.triangles.len() as u32;
            let world = fixture::world(fixture::scene(vec![mesh]));
            let errors = PlaneErrors::of(&world);
            for kind in kinds() {
                let backend = build(kind, &world, 1).expect("a backend");
                let mut dice = fixture::Dice(crate::mix::Mix(5));
                let (mut left, mut cast) = (0, 0);
                for triangle in 0..triangles {
                    let patch = Patch::of(&world, &errors, 0, triangle);
                    for _ in 0..2000 {
                        let [a, b] = [dice.roll(), dice.roll()].map(|roll| f64::from(roll).powi(3));
                        let weights = DVec3::new(1.0 - a, a * (1.0 - b), a * b);
                        let ray = ray(&patch, weights, within(&patch), &mut dice);
                        cast += 1;
                        left += u32::from(!backend.occluded(&ray));
                    }
                }
                println!("{kind:?}, cut {cut}: {left} of {cast} leave");
                assert!(
                    left * 10_000 <= cast,
                    "{kind:?}, cut {cut}: {left} of {cast} leave"
                );
            }
        }
    }

    #[test]
    fn normals_of_a_mirrored_triangle_are_mirrored_and_up_is_where_shading_normals_point() {
        let mut mesh = fixture::soup(&[[Vec3::ZERO, Vec3::X, Vec3::Y]]);
        let of = |mesh: &Mesh, place| {
            let world = fixture::world(fixture::placed_scene(vec![mesh.clone()], &[(0, place)]));
            Patch::of(&world, &PlaneErrors::of(&world), 0, 0)
        };
        let (plain, mirrored) = (
            DAffine3::IDENTITY,
            DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)),
        );
        // Counter-clockwise before and clockwise after, the front of a mirrored mesh stays its front.
        assert_eq!(of(&mesh, plain).geometric, DVec3::Z);
        assert_eq!(of(&mesh, mirrored).geometric, DVec3::Z);
        mesh.normals = vec![Vec3::NEG_Z; 3];
        assert_eq!(of(&mesh, plain).geometric, DVec3::NEG_Z);
        let [x, y, z] = [0.6, 0.64, 0.8].map(|z: f32| (1.0 - z * z).sqrt());
        mesh.normals = vec![
            Vec3::new(x, 0.0, 0.6),
            Vec3::new(0.0, y, 0.64),
            Vec3::new(-z, 0.0, 0.8),
        ];
        let weights = DVec3::new(0.5, 0.25, 0.125);
        let mixed = mesh.normals.iter().zip(weights.to_array());
        let mixed: DVec3 = mixed
            .map(|(normal, weight)| normal.as_dvec3() * weight)
            .sum();
        assert!(of(&mesh, plain).normal(weights).abs_diff_eq(mixed, 1e-7));
    }

    #[test]
    fn normals_that_lean_away_a_little_are_no_word_about_the_side() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let of = |normal: Vec3| {
            let mut mesh = fixture::soup(&[corners]);
            mesh.normals = vec![normal; 3];
            let world = fixture::world(fixture::scene(vec![mesh]));
            Patch::of(&world, &PlaneErrors::of(&world), 0, 0)
        };
        for (height, side) in [(1e-9f32, 1.0), (-1e-9, 1.0), (-0.4, 1.0), (-0.6, -1.0)] {
            let normal = Vec3::new((1.0 - height * height).sqrt(), 0.0, height);
            let patch = of(normal);
            assert_eq!(patch.geometric, side * DVec3::Z, "{height}");
            let lean = patch.normals()[0].dot(patch.geometric);
            let right = f64::from(height.abs()).max(1f64.to_radians().sin());
            let right = if side < 0.0 {
                right
            } else {
                1f64.to_radians().sin()
            };
            assert!((lean - right).abs() < 1e-6, "{height}: {lean}");
            assert!((patch.normals()[0].length() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_patch_with_the_normals_of_its_plane_is_flat_and_keeps_off_its_edges() {
        let corners = [Vec3::ZERO, Vec3::X * 8.0, Vec3::Y * 8.0];
        let of = |normals: &[Vec3]| {
            let mut mesh = fixture::soup(&[corners]);
            mesh.normals = normals.to_vec();
            let world = fixture::world(fixture::scene(vec![mesh]));
            Patch::of(&world, &PlaneErrors::of(&world), 0, 0)
        };
        let bent = Vec3::new(0.6, 0.0, 0.8);
        assert!(of(&[]).is_flat());
        assert!(of(&[Vec3::Z; 3]).is_flat());
        assert!(of(&[Vec3::NEG_Z; 3]).is_flat());
        assert!(!of(&[Vec3::Z, Vec3::Z, bent]).is_flat());
        assert!(!of(&[Vec3::Z, bent, Vec3::Z]).is_flat());
        assert!(!of(&[bent; 3]).is_flat());
        // A sample is off an edge by what a coordinate is rounded by at least, and by little more.
        let patch = of(&[]);
        let heights = [8.0 / 2f64.sqrt(), 8.0, 8.0];
        for (inset, height) in patch.inset.to_array().into_iter().zip(heights) {
            let off = inset * height / (8.0 * UNIT_ROUNDOFF);
            assert!((1.0..64.0).contains(&off), "{off} roundings");
        }
    }
}
