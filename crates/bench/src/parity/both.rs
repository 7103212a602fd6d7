//! Two backends in one: every ray of a bake goes to both, and each difference is kept for the referee.

use super::{Answer, Disagreement, rule};
use rays::{Coherence, Ray, RayBackend, RayPacket, SurfaceHit, World};
use std::sync::{Mutex, PoisonError};

/// Answers as its first backend, and keeps every occlusion ray on which the second differs.
pub struct BothBackends<'a> {
    world: &'a World,
    a: &'a dyn RayBackend,
    b: &'a dyn RayBackend,
    differing: Mutex<Vec<Disagreement>>,
}

impl<'a> BothBackends<'a> {
    /// Both backends over one world.
    pub fn new(world: &'a World, a: &'a dyn RayBackend, b: &'a dyn RayBackend) -> Self {
        Self {
            world,
            a,
            b,
            differing: Mutex::default(),
        }
    }

    /// Every occlusion ray so far on which the two differed, each ruled on by the referee, in no fixed order.
    pub fn disagreements(self) -> Vec<Disagreement> {
        let mut found = self
            .differing
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        for disagreement in &mut found {
            rule(self.world, disagreement);
        }
        found
    }

    fn keep(&self, ray: Ray, a: bool, b: bool) {
        let (a, b) = (Answer::Occluded(a), Answer::Occluded(b));
        self.differing
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(Disagreement {
                ray,
                a,
                b,
                margin: None,
            });
    }
}

impl RayBackend for BothBackends<'_> {
    fn occluded16(&self, packet: &RayPacket<16>, active: u32, coherence: Coherence) -> u32 {
        let a = self.a.occluded16(packet, active, coherence);
        let b = self.b.occluded16(packet, active, coherence);
        for lane in (0..16).filter(|lane| (a ^ b) >> lane & 1 == 1) {
            self.keep(packet.get(lane), a >> lane & 1 == 1, b >> lane & 1 == 1);
        }
        a
    }

    fn occluded(&self, ray: &Ray) -> bool {
        let (a, b) = (self.a.occluded(ray), self.b.occluded(ray));
        if a != b {
            self.keep(*ray, a, b);
        }
        a
    }

    fn closest(&self, ray: &Ray) -> Option<SurfaceHit> {
        self.a.closest(ray)
    }

    fn closest_that(&self, ray: &Ray, stops: rays::Stops) -> Option<SurfaceHit> {
        self.a.closest_that(ray, stops)
    }

    fn name(&self) -> &'static str {
        "both"
    }

    fn describe(&self) -> String {
        format!("{} beside {}", self.a.describe(), self.b.describe())
    }

    fn memory_bytes(&self) -> u64 {
        self.a.memory_bytes() + self.b.memory_bytes()
    }
}
