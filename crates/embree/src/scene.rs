//! A committed scene and its queries.

use crate::hit_test::{self, HitTest};
use crate::{Coherence, Device, Hit, Lanes, PacketWidth, Ray, RayPacket, check};
use embree4_sys as sys;
use std::fmt;
use std::mem::{MaybeUninit, offset_of};
use std::ptr;
use std::sync::Arc;

/// A committed, immutable scene. Clones share it; any number of threads may trace it at once.
#[derive(Clone)]
pub struct Scene(Arc<Inner>);

struct Inner {
    parts: SceneParts,
    /// What every query of this scene says besides its coherence.
    query: u32,
    /// A test of hits may run, here or in an instanced scene, and may have panicked.
    tested: bool,
    /// Rays whose coordinates are not below this meet nothing; see [`check::reach`].
    reach: f32,
    bounds: Option<[[f32; 3]; 2]>,
}

/// A scene handle and everything that Embree's scene points to. Fields drop in this order, after the handle.
pub(crate) struct SceneParts {
    pub(crate) raw: sys::RTCScene,
    pub(crate) robust: bool,
    pub(crate) placed: Vec<Placed>,
    pub(crate) hit_tests: Vec<HitTest>,
    pub(crate) device: Device,
}

/// An instance: its geometry id, its scene, kept alive, the inverse of its linear part, and its rays' reach.
pub(crate) struct Placed {
    pub(crate) id: u32,
    pub(crate) scene: Scene,
    pub(crate) inverse: [[f64; 3]; 3],
    pub(crate) reach: f32,
}

// SAFETY: an RTCScene may be used and released from any thread; what the parts hold besides is Send.
unsafe impl Send for SceneParts {}
// SAFETY: after `into_scene` the handle is only read by queries, which Embree allows from several threads at once on a
// committed scene. Filters are Sync.
unsafe impl Sync for SceneParts {}

impl Drop for SceneParts {
    fn drop(&mut self) {
        // SAFETY: this crate's own reference, released once. No query runs, since queries borrow the scene. Filters,
        // instanced scenes and the device are fields and go afterwards; an instancing scene holds a clone of its
        // instanced scenes, so their tests outlive it.
        unsafe { sys::rtcReleaseScene(self.raw) }
    }
}

impl SceneParts {
    /// The scene, once the handle is committed.
    pub(crate) fn into_scene(self) -> Scene {
        let tested = !self.hit_tests.is_empty() || self.placed.iter().any(|p| p.scene.0.tested);
        let mut b = [0.0; 6];
        // SAFETY: the scene is committed and alive; six floats are written.
        unsafe { sys::ambake_bounds(self.raw, b.as_mut_ptr()) };
        let is_empty = !(0..3).all(|axis| b[axis] <= b[axis + 3]);
        Scene(Arc::new(Inner {
            query: if self.robust {
                sys::AMBAKE_QUERY_ROBUST
            } else {
                0
            } | if tested {
                sys::AMBAKE_QUERY_TELL_RAYS
            } else {
                0
            },
            tested,
            reach: self
                .placed
                .iter()
                .map(|p| p.reach)
                .fold(check::LARGE, f32::min),
            bounds: (!is_empty).then_some([[b[0], b[1], b[2]], [b[3], b[4], b[5]]]),
            parts: self,
        }))
    }
}

// The shim's types and this crate's are the same memory.
const _: () = {
    assert!(size_of::<Ray>() == size_of::<sys::ambake_ray>());
    assert!(offset_of!(Ray, origin) == offset_of!(sys::ambake_ray, origin));
    assert!(offset_of!(Ray, direction) == offset_of!(sys::ambake_ray, direction));
    assert!(offset_of!(Ray, t_min) == offset_of!(sys::ambake_ray, t_min));
    assert!(offset_of!(Ray, t_max) == offset_of!(sys::ambake_ray, t_max));
    assert!(size_of::<RayPacket<8>>() == size_of::<sys::ambake_packet8>());
    assert!(align_of::<RayPacket<8>>() == align_of::<sys::ambake_packet8>());
    assert!(offset_of!(RayPacket<8>, direction) == offset_of!(sys::ambake_packet8, direction));
    assert!(offset_of!(RayPacket<8>, t_min) == offset_of!(sys::ambake_packet8, t_min));
    assert!(offset_of!(RayPacket<8>, t_max) == offset_of!(sys::ambake_packet8, t_max));
    assert!(size_of::<RayPacket<16>>() == size_of::<sys::ambake_packet16>());
    assert!(align_of::<RayPacket<16>>() == align_of::<sys::ambake_packet16>());
    assert!(offset_of!(RayPacket<16>, direction) == offset_of!(sys::ambake_packet16, direction));
    assert!(offset_of!(RayPacket<16>, t_min) == offset_of!(sys::ambake_packet16, t_min));
    assert!(offset_of!(RayPacket<16>, t_max) == offset_of!(sys::ambake_packet16, t_max));
};

impl Scene {
    /// Whether something lies in the ray's interval.
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        // SAFETY: the scene is committed and alive; the ray is of the shim's layout (asserted above) and is only read
        // during the call, which makes its own aligned copy. A committed scene may be traced by several threads.
        let blocked = unsafe {
            sys::ambake_occluded1(
                self.0.parts.raw,
                ptr::from_ref(ray).cast(),
                self.0.query,
                self.0.reach,
            )
        };
        self.resume();
        blocked != 0
    }

    /// The lanes of `active` in whose interval something lies.
    #[inline]
    pub fn occluded_packet<const N: usize>(
        &self,
        packet: &RayPacket<N>,
        active: u32,
        coherence: Coherence,
    ) -> u32
    where
        Lanes<N>: PacketWidth,
    {
        let mut blocked = [0];
        self.occluded_packets(
            std::slice::from_ref(packet),
            &[active],
            &mut blocked,
            coherence,
        );
        blocked[0]
    }

    /// As [`Scene::occluded_packet`] for each packet: `blocked[i]` gets the blocked lanes among `active[i]`.
    ///
    /// # Panics
    /// Where the three slices are not of one length.
    #[inline]
    pub fn occluded_packets<const N: usize>(
        &self,
        packets: &[RayPacket<N>],
        active: &[u32],
        blocked: &mut [u32],
        coherence: Coherence,
    ) where
        Lanes<N>: PacketWidth,
    {
        let count = packets.len();
        assert!(
            active.len() == count && blocked.len() == count,
            "{count} packets, {} active masks, {} blocked masks",
            active.len(),
            blocked.len()
        );
        let query = match coherence {
            Coherence::Incoherent => self.0.query,
            // Embree 3.13.5 on AVX-512 never returns from a coherent packet of 16 that meets an instance.
            Coherence::Coherent if self.has_instances() => self.0.query,
            Coherence::Coherent => self.0.query | sys::AMBAKE_QUERY_COHERENT,
        };
        let (scene, first) = (self.0.parts.raw, packets.as_ptr());
        let (active, blocked) = (active.as_ptr(), blocked.as_mut_ptr());
        // SAFETY: the scene is committed and alive, and may be traced by several threads. All three pointers are good
        // for `count` items (checked above) during the call. `N` is 8 or 16 (sealed trait) and selects the shim's type
        // of the same layout (asserted above). The shim copies each packet, and its mask, to aligned locals.
        unsafe {
            if N == 8 {
                sys::ambake_occluded8(
                    scene,
                    first.cast(),
                    active,
                    blocked,
                    count,
                    query,
                    self.0.reach,
                );
            } else {
                sys::ambake_occluded16(
                    scene,
                    first.cast(),
                    active,
                    blocked,
                    count,
                    query,
                    self.0.reach,
                );
            }
        }
        self.resume();
    }

    /// The closest thing in the ray's interval.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        self.closest_told(ray, if self.0.tested { ray.id() } else { 0 })
    }

    /// The closest thing in the ray's interval, for hit tests that are told this number in the place of
    /// [`Ray::id`].
    pub fn closest_told(&self, ray: &Ray, id: u32) -> Option<Hit> {
        let mut hit = MaybeUninit::<sys::ambake_hit>::uninit();
        // SAFETY: as for `occluded`; the shim fills `hit` where it returns 1.
        let found = unsafe {
            sys::ambake_closest(
                self.0.parts.raw,
                ptr::from_ref(ray).cast(),
                self.0.query,
                self.0.reach,
                id,
                hit.as_mut_ptr(),
            )
        };
        self.resume();
        if found == 0 {
            return None;
        }
        // SAFETY: the call returned 1, so every field is written.
        let hit = unsafe { hit.assume_init() };
        let placed = (hit.instance != sys::AMBAKE_NO_INSTANCE).then(|| self.placed(hit.instance));
        let direction = match placed {
            Some(placed) => check::apply(&placed.inverse, ray.direction),
            None => ray.direction.map(f64::from),
        };
        Some(Hit {
            // Embree compares before it divides, so the quotient may be off by a rounding step.
            t: hit.t.max(ray.t_min.max(0.0).next_up()).min(ray.t_max),
            geometry: hit.geometry,
            primitive: hit.primitive,
            instance: placed.map(|p| p.id),
            barycentric: [hit.u, hit.v],
            normal: hit.normal,
            front: check::dot(direction, hit.normal.map(f64::from)) < 0.0,
        })
    }

    /// Lower and upper corner of everything in the scene; `None` where it is empty.
    pub fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        self.0.bounds
    }

    pub(crate) fn raw(&self) -> sys::RTCScene {
        self.0.parts.raw
    }

    pub(crate) fn device(&self) -> &Device {
        &self.0.parts.device
    }

    pub(crate) fn is_robust(&self) -> bool {
        self.0.parts.robust
    }

    pub(crate) fn has_instances(&self) -> bool {
        !self.0.parts.placed.is_empty()
    }

    /// The instance with a geometry id; ids grow along the list.
    fn placed(&self, id: u32) -> &Placed {
        let placed = &self.0.parts.placed;
        match placed.binary_search_by_key(&id, |p| p.id) {
            Ok(index) => &placed[index],
            Err(_) => panic!(
                "Embree names instance {id}, which is none of {}",
                placed.len()
            ),
        }
    }

    /// What every query of this scene says besides its coherence.
    pub(crate) fn query(&self) -> u32 {
        self.0.query
    }

    /// Rays whose coordinates are not below this meet nothing.
    pub(crate) fn reach(&self) -> f32 {
        self.0.reach
    }

    #[inline]
    pub(crate) fn resume(&self) {
        if self.0.tested {
            hit_test::resume();
        }
    }
}

impl fmt::Debug for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Scene")
            .field("bounds", &self.0.bounds)
            .field("robust", &self.0.parts.robust)
            .field("instances", &self.0.parts.placed.len())
            .field("hit_tests", &self.0.parts.hit_tests.len())
            .finish()
    }
}
