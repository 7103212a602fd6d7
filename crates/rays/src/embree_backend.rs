//! Rays through Embree, built robust: watertight along shared edges.

use crate::backend::{Coherence, Ray, RayBackend, RayPacket, Stops, SurfaceHit};
use crate::coincident::Coincident;
use crate::error::Error;
use crate::geometry::Geometry;
use crate::world::World;
use embree::{Device, DeviceConfig, Scene, SceneBuilder};

/// Embree over a world.
pub struct EmbreeBackend {
    device: Device,
    scene: Scene,
    /// By geometry id of the traced scene.
    traced: Vec<Traced>,
    coincident: Coincident,
}

struct Traced {
    instance: u32,
    /// The triangles turn the other way than in the mesh.
    reversed: bool,
}

impl EmbreeBackend {
    /// Builds with at most `threads` of Embree's own threads, 0 for all cores.
    ///
    /// # Errors
    /// Embree is absent, unusable or refuses the world.
    pub fn build(world: &World, threads: usize) -> Result<Self, Error> {
        let device = Device::new(&DeviceConfig {
            threads,
            ..DeviceConfig::default()
        })?;
        let mut builder = SceneBuilder::new(&device).robust(true);
        let mut shared: Vec<Option<Scene>> = vec![None; world.geometries.len()];
        let mut traced = Vec::with_capacity(world.parts.len());
        for (instance, part) in world.parts.iter().enumerate() {
            let geometry = &world.geometries[part.geometry as usize];
            if geometry.triangles().is_empty() || !world.casts(instance as u32) {
                continue;
            }
            let id = match part.transform {
                None => add(&mut builder, geometry)?,
                Some(transform) => {
                    let slot = &mut shared[part.geometry as usize];
                    if slot.is_none() {
                        let mut inner = SceneBuilder::new(&device).robust(true);
                        add(&mut inner, geometry)?;
                        *slot = Some(inner.commit()?);
                    }
                    let scene = slot.as_ref().expect("filled above");
                    builder.instance(scene, transform.to_cols_array_2d())?
                }
            };
            assert_eq!(id as usize, traced.len(), "geometry ids count the calls");
            let reversed = part.transform.is_none() && part.mirrors();
            traced.push(Traced {
                instance: instance as u32,
                reversed,
            });
        }
        let scene = builder.commit()?;
        Ok(Self {
            device,
            scene,
            traced,
            coincident: Coincident::of(world),
        })
    }
}

impl EmbreeBackend {
    /// The scene that rays are traced through, for measurements.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    fn resolved(&self, hit: embree::Hit) -> SurfaceHit {
        let traced = &self.traced[hit.instance.unwrap_or(hit.geometry) as usize];
        self.coincident.resolved(SurfaceHit {
            t: hit.t,
            instance: traced.instance,
            triangle: hit.primitive,
            barycentric: hit.barycentric,
            front: hit.front != traced.reversed,
        })
    }
}

fn add(builder: &mut SceneBuilder, geometry: &Geometry) -> Result<u32, embree::Error> {
    let positions: Vec<[f32; 3]> = geometry
        .positions
        .iter()
        .map(|position| position.to_array())
        .collect();
    match geometry.alpha.clone() {
        None => builder.triangles(&positions, geometry.triangles()),
        Some(alpha) => {
            let keep = std::sync::Arc::new(move |primitive, barycentric, ray| {
                alpha.keep(primitive, barycentric, ray)
            });
            builder.masked_triangles(&positions, geometry.triangles(), keep)
        }
    }
}

impl RayBackend for EmbreeBackend {
    fn occluded16(&self, packet: &RayPacket<16>, active: u32, coherence: Coherence) -> u32 {
        self.scene.occluded_packet(packet, active, coherence)
    }

    fn occluded(&self, ray: &Ray) -> bool {
        self.scene.occluded(ray)
    }

    fn closest(&self, ray: &Ray) -> Option<SurfaceHit> {
        Some(self.resolved(self.scene.closest(ray)?))
    }

    fn closest_that(&self, ray: &Ray, stops: Stops) -> Option<SurfaceHit> {
        Some(self.resolved(self.scene.closest_told(ray, stops.id())?))
    }

    fn name(&self) -> &'static str {
        "embree"
    }

    fn describe(&self) -> String {
        let info = self.device.info();
        format!("Embree {} robust, {}", info.library, info.isa.name())
    }

    fn memory_bytes(&self) -> u64 {
        self.device.memory().current
    }
}
