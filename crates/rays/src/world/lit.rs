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

/// A triangle as it is lit.
pub(crate) struct Lit {
    /// See [`World::face`].
    pub face: DVec3,
    /// See [`World::normals`].
    pub normals: Option<[DVec3; 3]>,
    /// The file's normals point away from the lit side, though it is known, or have none and it is not the winding's.
    pub is_reversed: bool,
}

impl World {
    /// Lights closed bodies that look inward from behind where nobody is within, and sheets that look at something
    /// close ([`Solids::backs`](crate::Solids::backs)): normals point to the other side, and nothing else changes. So
    /// do those that point into a body which looks outward, or away from where their surface looks
    /// ([`Solids::averse`](crate::Solids::averse)).
    ///
    /// * `places`: where lights and eyes are, in the coordinates of the file.
    pub fn turn_over(&mut self, places: impl Iterator<Item = DVec3>) {
        [self.backs, self.averse] = self.backs_by(places);
    }

    /// True where [`World::turn_over`] with these places would change nothing.
    pub fn is_turned_by(&self, places: impl Iterator<Item = DVec3>) -> bool {
        let [backs, averse] = self.backs_by(places);
        backs == self.backs && averse == self.averse
    }

    /// By mesh, the triangles whose backs are lit, and those whose normals alone turn round.
    fn backs_by(&self, places: impl Iterator<Item = DVec3>) -> [HashMap<u32, HashSet<u32>>; 2] {
        let places: Vec<DVec3> = places.map(|place| place - self.origin).collect();
        let solids = self.solids();
        [solids.backs(&places), solids.averse(&places)].map(|found| {
            let found = found.into_iter();
            found
                .map(|(mesh, of)| (mesh, of.into_iter().collect()))
                .collect()
        })
    }

    /// True where a triangle is lit from behind.
    #[inline]
    pub fn is_turned_over(&self, instance: u32, triangle: u32) -> bool {
        !self.backs.is_empty() && {
            let mesh = self.part(instance).1.mesh;
            (self.backs.get(&mesh)).is_some_and(|of| of.contains(&triangle))
        }
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

    /// A direction by the normals of the file, reversed where these are reversed.
    pub(crate) fn on_lit_side(&self, by_file: DVec3, instance: u32, triangle: u32) -> DVec3 {
        let corners = self.corners(instance, triangle);
        match self.lit(instance, triangle, &corners).is_reversed {
            true => -by_file,
            false => by_file,
        }
    }

    /// A triangle with these corners as it is lit. Its lit side is that of its winding, which mirroring objects and
    /// [`World::turn_over`] turn round; or that of the file's normals, where they clearly look to the other side and
    /// nothing is known of a body. Normals that then point away are reversed where the side is known, and none leans
    /// farther than [`LOWEST`] allows.
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
            };
        };
        let lean = (normals[0] + normals[1] + normals[2]).dot(face);
        let mut is_reversed = false;
        if lean < 0.0 {
            if is_turned_over || self.is_averse(instance, triangle) {
                is_reversed = true;
                normals = normals.map(|normal| -normal);
            } else if lean < -3.0 * CLEARLY * face.length()
                && normals.iter().all(|normal| normal.dot(face) < 0.0)
            {
                face = -face;
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

    #[inline]
    fn is_averse(&self, instance: u32, triangle: u32) -> bool {
        !self.averse.is_empty() && {
            let mesh = self.part(instance).1.mesh;
            (self.averse.get(&mesh)).is_some_and(|of| of.contains(&triangle))
        }
    }
}
