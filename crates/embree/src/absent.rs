//! The API without Embree: nothing can be made, so nothing else can be reached.

use crate::{
    Coherence, DeviceConfig, DeviceInfo, Error, Hit, Keep, Lanes, Memory, PacketWidth, Ray,
    RayPacket, Version,
};
use std::convert::Infallible;

/// `None`: this was built without Embree.
pub fn header_version() -> Option<Version> {
    None
}

/// An Embree device; has no values in this build.
#[derive(Debug, Clone)]
pub struct Device(Infallible);

impl Device {
    /// # Errors
    /// Always [`Error::NotBuilt`].
    pub fn new(_: &DeviceConfig) -> Result<Device, Error> {
        Err(Error::NotBuilt)
    }

    /// Versions and abilities.
    pub fn info(&self) -> DeviceInfo {
        match self.0 {}
    }

    /// Bytes held for scenes.
    pub fn memory(&self) -> Memory {
        match self.0 {}
    }
}

/// A scene under construction; has no values in this build.
#[derive(Debug)]
pub struct SceneBuilder(Infallible);

impl SceneBuilder {
    /// A builder.
    pub fn new(device: &Device) -> SceneBuilder {
        match device.0 {}
    }

    /// Sets robust traversal.
    #[must_use]
    pub fn robust(self, _: bool) -> SceneBuilder {
        match self.0 {}
    }

    /// Sets compact storage.
    #[must_use]
    pub fn compact(self, _: bool) -> SceneBuilder {
        match self.0 {}
    }

    /// Adds a mesh.
    ///
    /// # Errors
    /// None in this build.
    pub fn triangles(&mut self, _: &[[f32; 3]], _: &[[u32; 3]]) -> Result<u32, Error> {
        match self.0 {}
    }

    /// Adds a mesh with a test of its hits.
    ///
    /// # Errors
    /// None in this build.
    pub fn masked_triangles(
        &mut self,
        _: &[[f32; 3]],
        _: &[[u32; 3]],
        _: Keep,
    ) -> Result<u32, Error> {
        match self.0 {}
    }

    /// Adds an instance.
    ///
    /// # Errors
    /// None in this build.
    pub fn instance(&mut self, _: &Scene, _: [[f32; 3]; 4]) -> Result<u32, Error> {
        match self.0 {}
    }

    /// The finished scene.
    ///
    /// # Errors
    /// None in this build.
    pub fn commit(self) -> Result<Scene, Error> {
        match self.0 {}
    }
}

/// A finished scene; has no values in this build.
#[derive(Debug, Clone)]
pub struct Scene(Infallible);

/// Recorded packets; has no values in this build.
pub struct Recording<'a>(Infallible, std::marker::PhantomData<&'a ()>);

impl Recording<'_> {
    /// Traces every packet.
    pub fn replay(&self) -> u64 {
        match self.0 {}
    }
}

impl Scene {
    /// A recording.
    pub fn recording<'a>(&'a self, _: &'a [RayPacket<16>], _: &'a [u32]) -> Recording<'a> {
        match self.0 {}
    }

    /// Whether something lies in the ray's interval.
    pub fn occluded(&self, _: &Ray) -> bool {
        match self.0 {}
    }

    /// Occlusion of a packet.
    pub fn occluded_packet<const N: usize>(&self, _: &RayPacket<N>, _: u32, _: Coherence) -> u32
    where
        Lanes<N>: PacketWidth,
    {
        match self.0 {}
    }

    /// Occlusion of many packets.
    pub fn occluded_packets<const N: usize>(
        &self,
        _: &[RayPacket<N>],
        _: &[u32],
        _: &mut [u32],
        _: Coherence,
    ) where
        Lanes<N>: PacketWidth,
    {
        match self.0 {}
    }

    /// The closest hit.
    pub fn closest(&self, _: &Ray) -> Option<Hit> {
        match self.0 {}
    }

    /// See [`Scene::closest`].
    pub fn closest_told(&self, _: &Ray, _: u32) -> Option<Hit> {
        match self.0 {}
    }

    /// Lower and upper corner of everything.
    pub fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        match self.0 {}
    }
}
