//! The bare loop: recorded packets through `rtcOccluded16` and nothing else, to measure other loops against.

use crate::{RayPacket, Scene};
use embree4_sys as sys;

/// Packets of one scene that were checked when they were recorded, so that replaying them costs only the tracing.
pub struct Recording<'a> {
    scene: &'a Scene,
    packets: &'a [RayPacket<16>],
    active: &'a [u32],
    query: u32,
}

impl Scene {
    /// A recording of packets with their active lanes.
    ///
    /// # Panics
    /// Where the slices differ in length, a packet has no active lane, a lane holds a ray that is not finite or out of
    /// the scene's reach, an active lane has `t_min` other than 0 or an empty interval, or another lane `t_max` above
    /// 0.
    pub fn recording<'a>(
        &'a self,
        packets: &'a [RayPacket<16>],
        active: &'a [u32],
    ) -> Recording<'a> {
        assert_eq!(packets.len(), active.len(), "packets and masks");
        for (index, (packet, &lanes)) in packets.iter().zip(active).enumerate() {
            assert!(lanes & 0xffff != 0, "packet {index} has no active lane");
            for lane in 0..16 {
                let ray = packet.get(lane);
                let coordinates = ray.origin.iter().chain(&ray.direction);
                let on = lanes >> lane & 1 == 1;
                let sound = coordinates.copied().all(|x| x.abs() < self.reach())
                    && ray.t_min == 0.0
                    && (ray.t_max > 0.0) == on;
                assert!(sound, "packet {index}, lane {lane}: {ray:?}");
            }
        }
        Recording {
            scene: self,
            packets,
            active,
            query: self.query(),
        }
    }
}

impl Recording<'_> {
    /// Traces every packet, incoherent, and returns how many rays were blocked.
    pub fn replay(&self) -> u64 {
        // SAFETY: the scene is committed and alive, and may be traced by several threads. Both pointers are good for as
        // many items as `packets` has, checked when it was recorded, as every ray was. The shim copies each packet to
        // an aligned local; Embree keeps no pointer to it.
        let blocked = unsafe {
            sys::ambake_bare16(
                self.scene.raw(),
                self.packets.as_ptr().cast(),
                self.active.as_ptr(),
                self.packets.len(),
                self.query,
            )
        };
        self.scene.resume();
        blocked
    }
}
