//! The one trait in the ray path, and what it speaks in.

pub use embree::{Coherence, Lanes, PacketWidth, Ray, RayPacket};

/// Answers ray queries on a [`World`](crate::World).
///
/// A ray meets surfaces at `t_min < t <= t_max`, in lengths of its direction, which may have any length but 0; a
/// negative `t_min` means 0. Both sides of a surface are met. A hit on a masked surface counts where its alpha test
/// keeps it. A ray that is not finite meets nothing.
pub trait RayBackend: Send + Sync {
    /// The lanes of `active` (bit i is lane i) whose rays meet a surface.
    fn occluded16(&self, packet: &RayPacket<16>, active: u32, coherence: Coherence) -> u32;

    /// True where the ray meets a surface.
    fn occluded(&self, ray: &Ray) -> bool;

    /// The first surface on the ray. Of opaque triangles with the same corners it is the first in the order of the
    /// scene whose front faces the ray, else the first.
    fn closest(&self, ray: &Ray) -> Option<SurfaceHit>;

    /// The same with see-through surfaces that stop as much, in the place of those that stop this very ray: what a
    /// picture asks. A backend that knows no alpha test has no other answer than [`RayBackend::closest`].
    fn closest_that(&self, ray: &Ray, stops: Stops) -> Option<SurfaceHit> {
        let _ = stops;
        self.closest(ray)
    }

    /// The word for it on the command line.
    fn name(&self) -> &'static str;

    /// Library, version and layout, for reports.
    fn describe(&self) -> String;

    /// Bytes that the structure holds beside the world.
    fn memory_bytes(&self) -> u64;
}

/// How much of the light a surface stops at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stops {
    /// Some of it.
    Any,
    /// All of it.
    All,
}

impl Stops {
    /// What an alpha test is told in the place of [`Ray::id`]. A ray whose hash is one of the two numbers, one of two
    /// thousand million, is taken so as well.
    pub(crate) fn id(self) -> u32 {
        match self {
            Stops::Any => 0,
            Stops::All => u32::MAX,
        }
    }
}

/// A point where a ray meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceHit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Index of the scene's instance.
    pub instance: u32,
    /// Index into the triangles of the instance's mesh.
    pub triangle: u32,
    /// Weights of the triangle's second and third corners.
    pub barycentric: [f32; 2],
    /// The ray comes from the side from which the mesh's triangle turns counter-clockwise; a mirroring placement
    /// changes nothing about it.
    pub front: bool,
}

/// Trees that obvhs builds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TreeKind {
    /// Eight quantised children a node.
    #[default]
    Cwbvh,
    /// Two children a node.
    Bvh2,
}
