//! Closed surfaces whose faces look inward though they are no rooms: which, and which of them are to be turned over.

use super::{Body, Inside, Solids};
use glam::DVec3;
use std::collections::HashMap;

/// A surface of a shape: their numbers.
type Key = (u32, u32);

impl Solids {
    /// An instance and a triangle of each closed surface whose faces look inward though it is no room.
    pub fn inside_out(&self) -> Vec<(u32, u32)> {
        let first = |placement: u32, body: &Body| {
            let shape = &self.shapes[body.shape as usize];
            let start = self.firsts[placement as usize];
            let mut instances = (start..).zip(&self.instances[start as usize..]);
            instances.find_map(|(instance, of)| {
                let mut surfaces = shape.surface_of[of.1 as usize].iter();
                let triangle = surfaces.position(|surface| *surface == body.surface)?;
                (of.2 == placement).then_some((instance, triangle as u32))
            })
        };
        let mut found: Vec<(u32, u32)> = (self.placements.iter())
            .map(|(&(placement, _), &body)| (placement, &self.bodies[body as usize]))
            .filter(|(_, body)| self.is_inside_out(body))
            .filter_map(|(placement, body)| first(placement, body))
            .collect();
        found.sort_unstable();
        found
    }

    /// Triangles of each mesh whose back is what one sees, ascending: those of closed surfaces that are drawn from both
    /// sides and look inward wherever they are placed, though nothing is in them, none of these places and no lamp of
    /// their own. From within nobody looks at them, and nothing would be seen there. None where a scene has no other
    /// surfaces: then they are all that there is to be seen, and empty rooms.
    pub fn backs(&self, places: &[DVec3]) -> Vec<(u32, Vec<u32>)> {
        let is_inside_out = |body: &u32| self.is_inside_out(&self.bodies[*body as usize]);
        if !self.placements.values().any(is_inside_out) || self.surfaces_but(is_inside_out) == 0 {
            return Vec::new();
        }
        let mut is_back: HashMap<Key, bool> = HashMap::new();
        for body in self.placements.values() {
            let body = &self.bodies[*body as usize];
            let is_empty = || !places.iter().any(|&place| self.holds(body, place));
            let found = self.is_inside_out(body) && is_empty();
            *is_back.entry((body.shape, body.surface)).or_insert(true) &= found;
        }
        for (&(shape, surface), is_back) in &mut is_back {
            let faces = &self.shapes[shape as usize].surfaces[surface as usize].faces;
            *is_back &= faces.iter().all(|face| {
                let mesh = &self.scene.meshes[face.mesh as usize];
                let material = &self.scene.materials[mesh.material as usize];
                material.double_sided && material.emission == glam::Vec3::ZERO
            });
        }
        let mut found: HashMap<u32, Vec<bool>> = HashMap::new();
        for (instance, &(shape, mesh, _)) in self.scene.instances.iter().zip(&self.instances) {
            let surface_of = &self.shapes[shape as usize].surface_of[mesh as usize];
            let backs = found
                .entry(instance.mesh)
                .or_insert_with(|| vec![true; surface_of.len()]);
            for (back, &surface) in backs.iter_mut().zip(surface_of) {
                *back &= is_back.get(&(shape, surface)).copied().unwrap_or(false);
            }
        }
        let listed = |(mesh, backs): (u32, Vec<bool>)| {
            let backs = (0..).zip(backs).filter(|(_, back)| *back);
            (mesh, backs.map(|(triangle, _)| triangle).collect())
        };
        let mut found: Vec<(u32, Vec<u32>)> = found.into_iter().map(listed).collect();
        found.retain(|(_, triangles)| !triangles.is_empty());
        found.sort_unstable();
        found
    }

    /// How many placed surfaces are none of these bodies.
    fn surfaces_but(&self, but: impl Fn(&u32) -> bool) -> usize {
        let shapes = self
            .firsts
            .iter()
            .map(|&first| self.instances[first as usize].0);
        let all: usize = shapes
            .map(|shape| self.shapes[shape as usize].surfaces.len())
            .sum();
        all - self.placements.values().filter(|&body| but(body)).count()
    }

    fn is_inside_out(&self, body: &Body) -> bool {
        body.inside == Inside::Solid && self.surface(body).volume < 0.0
    }
}
