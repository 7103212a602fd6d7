//! Which side of a triangle is lit, and where its shading normals point.

use super::World;
use glam::DVec3;
use std::collections::{HashMap, HashSet};

/// Mean cosine between shading normals and the winding's below which they clearly look to the other side.
const CLEARLY: f64 = 0.5;

/// Least cosine between a shading normal and the surface's: one degree above it.
const LOWEST: f64 = 0.017_452_406_437_283_51;

/// A unit shading normal, that leans no farther from the unit normal of its surface than it may.
pub fn above(normal: DVec3, up: DVec3) -> DVec3 {
    if normal.dot(up) >= LOWEST {
        return normal;
    }
    let along = (normal - up * normal.dot(up)).try_normalize();
    along.map_or(up, |along| {
        up * LOWEST + along * (1.0 - LOWEST * LOWEST).sqrt()
    })
}

/// By mesh, some of its triangles.
pub(super) type Triangles = HashMap<u32, HashSet<u32>>;

/// A triangle as it is lit.
pub(crate) struct Lit {
    /// See [`World::face`].
    pub face: DVec3,
    /// See [`World::normals`].
    pub normals: Option<[DVec3; 3]>,
    /// The file's normals point away from the lit side, though it is known, or have none and it is not the winding's.
    pub is_reversed: bool,
    /// The file's normals point behind the lit side of a fold, and are mirrored in its plane.
    is_mirrored: bool,
}

/// The mirror image of a direction behind a plane of the normal `face`, of any length.
fn mirrored(direction: DVec3, face: DVec3) -> DVec3 {
    direction - face * (2.0 * direction.dot(face).min(0.0) / face.length_squared())
}

impl World {
    /// Lights closed bodies that look inward from behind where nobody is within, and sheets that look at something
    /// close ([`Solids::backs`](crate::Solids::backs)): normals point to the other side, and nothing else changes. So
    /// do those that point into a body which looks outward, or away from where their surface looks
    /// ([`Solids::averse`](crate::Solids::averse)), and no fold of a sheet counts as wound the wrong way
    /// ([`Solids::folds`](crate::Solids::folds)).
    ///
    /// * `places`: where lights and eyes are, in the coordinates of the file.
    pub fn turn_over(&mut self, places: impl Iterator<Item = DVec3>) {
        [self.backs, self.averse] = self.backs_by(places);
        self.folds = by_mesh(self.solids().folds());
    }

    /// True where [`World::turn_over`] with these places would change nothing.
    pub fn is_turned_by(&self, places: impl Iterator<Item = DVec3>) -> bool {
        let [backs, averse] = self.backs_by(places);
        backs == self.backs && averse == self.averse
    }

    /// By mesh, the triangles whose backs are lit, and those whose normals alone turn round.
    fn backs_by(&self, places: impl Iterator<Item = DVec3>) -> [Triangles; 2] {
        let places: Vec<DVec3> = places.map(|place| place - self.origin).collect();
        let solids = self.solids();
        [solids.backs(&places), solids.averse(&places)].map(by_mesh)
    }

    /// True where a triangle is lit from behind.
    #[inline]
    pub fn is_turned_over(&self, instance: u32, triangle: u32) -> bool {
        self.is_of(&self.backs, instance, triangle)
    }

    /// True where some of an instance is lit from behind.
    pub fn has_turned_over(&self, instance: u32) -> bool {
        self.backs.contains_key(&self.part(instance).1.mesh)
    }

    /// The share of an instance's surface, 0..=1, of which the normals alone point to the other side than the one that
    /// is lit.
    pub fn averse_share(&self, instance: u32) -> f64 {
        let geometry = self.part(instance).1;
        let Some(averse) = self.averse.get(&geometry.mesh) else {
            return 0.0;
        };
        let (mut all, mut own) = (0.0, 0.0);
        for triangle in 0..geometry.triangles().len() as u32 {
            let [a, b, c] = self.corners(instance, triangle);
            let area = (b - a).cross(c - a).length();
            all += area;
            own += if averse.contains(&triangle) {
                area
            } else {
                0.0
            };
        }
        own / f64::max(all, f64::MIN_POSITIVE)
    }

    /// The normal of a triangle on its lit side, to which texels send their rays, of twice its area's length.
    pub fn face(&self, instance: u32, triangle: u32) -> DVec3 {
        self.lit(instance, triangle, &self.corners(instance, triangle))
            .face
    }

    /// Unit shading normals at a triangle's corners in world space, on its lit side; `None` where the mesh has none.
    pub fn normals(&self, instance: u32, triangle: u32) -> Option<[DVec3; 3]> {
        self.lit(instance, triangle, &self.corners(instance, triangle))
            .normals
    }

    /// A shading normal of the file, reversed or mirrored where those of its triangle are.
    pub(crate) fn on_lit_side(&self, by_file: DVec3, instance: u32, triangle: u32) -> DVec3 {
        let lit = self.lit(instance, triangle, &self.corners(instance, triangle));
        match lit.is_mirrored {
            _ if lit.is_reversed => -by_file,
            true => mirrored(by_file, lit.face),
            false => by_file,
        }
    }

    /// True where a triangle is drawn with its normals and tangents reversed.
    pub(crate) fn reverses(&self, instance: u32, triangle: u32) -> bool {
        (self.lit(instance, triangle, &self.corners(instance, triangle))).is_reversed
    }

    /// A triangle with these corners as it is lit. Its lit side is that of its winding, which mirroring objects and
    /// [`World::turn_over`] turn round; or that of the file's normals, where they clearly look to the other side,
    /// nothing is known of a body, it is no fold of a sheet, and both sides of it are drawn. Normals that then point
    /// away are reversed where the side is known, else mirrored where they do so clearly, as rays below a surface are,
    /// and none leans farther than [`LOWEST`] allows.
    #[inline]
    pub(crate) fn lit(&self, instance: u32, triangle: u32, [a, b, c]: &[DVec3; 3]) -> Lit {
        let is_turned_over = self.is_turned_over(instance, triangle);
        let mut face = (*b - *a).cross(*c - *a);
        if self.part(instance).0.mirrors() != is_turned_over {
            face = -face;
        }
        let Some(mut normals) = self.normals_by_file(instance, triangle) else {
            return Lit {
                face,
                normals: None,
                is_reversed: is_turned_over,
                is_mirrored: false,
            };
        };
        let lean = (normals[0] + normals[1] + normals[2]).dot(face);
        let (mut is_reversed, mut is_mirrored) = (false, false);
        if lean < 0.0 {
            if is_turned_over || self.is_of(&self.averse, instance, triangle) {
                is_reversed = true;
                normals = normals.map(|normal| -normal);
            } else if lean < -3.0 * CLEARLY * face.length()
                && normals.iter().all(|normal| normal.dot(face) < 0.0)
            {
                is_mirrored =
                    !self.is_double_sided(instance) || self.is_of(&self.folds, instance, triangle);
                match is_mirrored {
                    true => normals = normals.map(|normal| mirrored(normal, face)),
                    false => face = -face,
                }
            }
        }
        let leans_far = |normal: &DVec3| normal.dot(face) < LOWEST * face.length();
        if normals.iter().any(leans_far)
            && let Some(up) = face.try_normalize()
        {
            normals = normals.map(|normal| above(normal, up));
        }
        Lit {
            face,
            normals: Some(normals),
            is_reversed,
            is_mirrored,
        }
    }

    #[inline]
    fn normals_by_file(&self, instance: u32, triangle: u32) -> Option<[DVec3; 3]> {
        let (part, geometry) = self.part(instance);
        let mesh = geometry.mesh();
        (!mesh.normals.is_empty()).then(|| {
            mesh.triangles[triangle as usize].map(|vertex| {
                (part.carry_normal(mesh.normals[vertex as usize].as_dvec3())).normalize_or_zero()
            })
        })
    }

    /// True where a triangle is one of these of its mesh.
    #[inline]
    fn is_of(&self, of: &Triangles, instance: u32, triangle: u32) -> bool {
        !of.is_empty() && {
            let mesh = self.part(instance).1.mesh;
            of.get(&mesh).is_some_and(|of| of.contains(&triangle))
        }
    }
}

fn by_mesh(found: Vec<(u32, Vec<u32>)>) -> Triangles {
    let found = found.into_iter();
    found
        .map(|(mesh, of)| (mesh, of.into_iter().collect()))
        .collect()
}
