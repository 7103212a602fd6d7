//! A scene under construction. `commit` consumes it, so nothing changes a scene that is traced.

use crate::hit_test::HitTest;
use crate::scene::{Placed, Scene, SceneParts};
use crate::{Device, Error, Keep, check};
use embree4_sys as sys;
use std::fmt;
use std::ptr;

/// Bytes that the system must be able to give before a tree is built. TBB, on which Embree builds, ends the program
/// where memory is refused amid its tasks, so what they take is asked for beforehand.
const ROOM: usize = 32 << 20;

/// Collects meshes and instances, each with the next geometry id, and becomes a [`Scene`].
pub struct SceneBuilder {
    geometries: Vec<Geometry>,
    hit_tests: Vec<HitTest>,
    placed: Vec<Placed>,
    robust: bool,
    compact: bool,
    // Last: the others are released while the device is alive.
    device: Device,
}

/// A geometry handle that this crate owns.
struct Geometry(sys::RTCGeometry);

// SAFETY: a geometry belongs to one builder and is used by the thread that has the builder; Embree ties no handle to
// a thread. Without Sync, so never by two at once.
unsafe impl Send for Geometry {}

impl Drop for Geometry {
    fn drop(&mut self) {
        // SAFETY: the handle is this crate's own reference, released once. A scene it is attached to has its own.
        unsafe { sys::rtcReleaseGeometry(self.0) }
    }
}

impl SceneBuilder {
    /// An empty builder: not robust, not compact.
    pub fn new(device: &Device) -> SceneBuilder {
        SceneBuilder {
            device: device.clone(),
            geometries: Vec::new(),
            hit_tests: Vec::new(),
            placed: Vec::new(),
            robust: false,
            compact: false,
        }
    }

    /// Sets whether traversal is watertight along shared edges, at about 0.8 of the speed.
    #[must_use]
    pub fn robust(mut self, on: bool) -> SceneBuilder {
        self.robust = on;
        self
    }

    /// Sets whether the hierarchy is stored compactly: half the memory at about 0.7 of the speed.
    #[must_use]
    pub fn compact(mut self, on: bool) -> SceneBuilder {
        self.compact = on;
        self
    }

    /// Geometry id of a new mesh. The data are copied.
    ///
    /// * `positions`: vertices, finite and within 1.8e18.
    /// * `triangles`: vertex indices, at least one triangle. Degenerate triangles are never hit.
    ///
    /// # Errors
    /// [`Error::EmptyMesh`], [`Error::TooMany`], [`Error::IndexOutOfRange`] or [`Error::VertexOutOfRange`] for the
    /// data; [`Error::OutOfMemory`].
    pub fn triangles(
        &mut self,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<u32, Error> {
        let geometry = self.mesh(positions, triangles)?;
        self.add(geometry)
    }

    /// Geometry id of a new mesh of which only those hits count that `keep` keeps, for occlusion and closest hits.
    ///
    /// `keep` slows every ray that reaches the mesh: give it only the triangles that need it. A panic in it ends the
    /// query and passes to the query's caller.
    ///
    /// # Errors
    /// As [`SceneBuilder::triangles`]; [`Error::UnusableLibrary`] where the library is built without filter functions.
    pub fn masked_triangles(
        &mut self,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        keep: Keep,
    ) -> Result<u32, Error> {
        if !self.device.info().filter_functions {
            return Err(Error::UnusableLibrary("has no filter functions"));
        }
        let geometry = self.mesh(positions, triangles)?;
        let test = HitTest::new(keep);
        // SAFETY: the geometry is alive and not yet attached. Embree keeps the record's address: the test goes to
        // `hit_tests`, then to the scene's parts, and is dropped after the scene that could call it is released.
        unsafe { sys::ambake_set_filter(geometry.0, test.record()) };
        self.hit_tests.push(test);
        self.add(geometry)
    }

    /// Geometry id of a new instance of a scene, which it keeps alive.
    ///
    /// * `transform`: columns of the affine map from the scene's space to this one, translation last. Mirroring and
    ///   non-uniform scales are allowed.
    ///
    /// # Errors
    /// [`Error::OtherDevice`], [`Error::NestedInstance`]; [`Error::TransformNotFinite`], [`Error::SingularTransform`],
    /// [`Error::InstanceOutOfReach`] or [`Error::InstanceOutOfRange`] for the transform; [`Error::OutOfMemory`].
    pub fn instance(&mut self, scene: &Scene, transform: [[f32; 3]; 4]) -> Result<u32, Error> {
        if !scene.device().same(&self.device) {
            return Err(Error::OtherDevice);
        }
        if scene.has_instances() {
            return Err(Error::NestedInstance);
        }
        let inverse = check::inverse(&transform)?;
        let reach = check::reach(&inverse, transform[3]);
        if reach <= 1.0 {
            return Err(Error::InstanceOutOfReach(transform));
        }
        if let Some(bounds) = scene.bounds() {
            check::placed(&transform, bounds)?;
        }
        let geometry = self.geometry(sys::RTC_GEOMETRY_TYPE_INSTANCE)?;
        // SAFETY: geometry and scene are alive and of one device; Embree retains the scene and copies the 12 floats,
        // which are columns without padding.
        unsafe {
            sys::rtcSetGeometryInstancedScene(geometry.0, scene.raw());
            sys::rtcSetGeometryTransform(
                geometry.0,
                0,
                sys::RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                ptr::from_ref(&transform).cast(),
            );
        }
        let id = self.add(geometry)?;
        self.placed.push(Placed {
            id,
            scene: scene.clone(),
            inverse,
            reach,
        });
        Ok(id)
    }

    /// The finished scene; an empty builder becomes a scene that nothing hits.
    ///
    /// Embree's own threads build it, so call it outside of parallel loops where that is easy.
    ///
    /// # Errors
    /// [`Error::RobustMismatch`], [`Error::OutOfMemory`].
    pub fn commit(self) -> Result<Scene, Error> {
        if let Some(other) = self
            .placed
            .iter()
            .find(|p| p.scene.is_robust() != self.robust)
        {
            return Err(Error::RobustMismatch { instance: other.id });
        }
        const MAKING: &str = "making a scene";
        if Vec::<u8>::new().try_reserve_exact(ROOM).is_err() {
            return Err(Error::OutOfMemory { during: MAKING });
        }
        // SAFETY: the device is alive; the new reference passes to `parts`, which releases it.
        let raw = unsafe { sys::rtcNewScene(self.device.raw()) };
        if raw.is_null() {
            self.device.check(MAKING)?;
            return Err(Error::OutOfMemory { during: MAKING });
        }
        let parts = SceneParts {
            raw,
            robust: self.robust,
            placed: self.placed,
            hit_tests: self.hit_tests,
            device: self.device,
        };
        // Bound after `parts`, so that an error below releases geometries before the device.
        let geometries = self.geometries;
        let mut flags = sys::RTC_SCENE_FLAG_NONE;
        if self.robust {
            flags |= sys::RTC_SCENE_FLAG_ROBUST;
        }
        if self.compact {
            flags |= sys::RTC_SCENE_FLAG_COMPACT;
        }
        // SAFETY: the scene is new and known to this thread only; `add` committed the geometries, which the scene
        // retains, and counted them, so ids fit.
        unsafe {
            sys::rtcSetSceneFlags(raw, flags);
            for (id, geometry) in geometries.iter().enumerate() {
                sys::rtcAttachGeometryByID(raw, geometry.0, id as u32);
            }
        }
        parts.device.check(MAKING)?;
        // SAFETY: as above; this is the only commit of this scene, and nothing changes it afterwards.
        unsafe { sys::rtcCommitScene(raw) };
        parts.device.check("building the hierarchy of a scene")?;
        Ok(parts.into_scene())
    }

    /// A new geometry of one kind.
    fn geometry(&self, kind: sys::RTCGeometryType) -> Result<Geometry, Error> {
        const MAKING: &str = "making a geometry";
        // SAFETY: the device is alive; the new reference passes to the wrapper.
        let raw = unsafe { sys::rtcNewGeometry(self.device.raw(), kind) };
        if raw.is_null() {
            self.device.check(MAKING)?;
            return Err(Error::OutOfMemory { during: MAKING });
        }
        Ok(Geometry(raw))
    }

    /// A checked mesh in buffers that Embree owns, and pads for its 16-byte loads.
    fn mesh(&self, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Geometry, Error> {
        check::mesh(positions, triangles)?;
        let geometry = self.geometry(sys::RTC_GEOMETRY_TYPE_TRIANGLE)?;
        self.fill(
            &geometry,
            sys::RTC_BUFFER_TYPE_VERTEX,
            sys::RTC_FORMAT_FLOAT3,
            positions,
        )?;
        self.fill(
            &geometry,
            sys::RTC_BUFFER_TYPE_INDEX,
            sys::RTC_FORMAT_UINT3,
            triangles,
        )?;
        Ok(geometry)
    }

    /// Copies items of three 32-bit numbers into a new buffer of the geometry.
    fn fill<T: Copy>(
        &self,
        geometry: &Geometry,
        kind: sys::RTCBufferType,
        format: sys::RTCFormat,
        items: &[[T; 3]],
    ) -> Result<(), Error> {
        const { assert!(size_of::<T>() == 4) };
        const COPYING: &str = "copying a mesh";
        let stride = size_of::<[T; 3]>();
        // SAFETY: the geometry is alive and not committed; kind and format are a pair that triangle meshes have.
        let buffer = unsafe {
            sys::rtcSetNewGeometryBuffer(geometry.0, kind, 0, format, stride, items.len())
        }
        .cast::<[T; 3]>();
        self.device.check(COPYING)?;
        if buffer.is_null() {
            return Err(Error::OutOfMemory { during: COPYING });
        }
        // SAFETY: Embree allocated `stride * len` bytes or more, aligned to 16 at least; the memory is new, so it does
        // not overlap `items`, and nothing reads it before the geometry is committed.
        unsafe { ptr::copy_nonoverlapping(items.as_ptr(), buffer, items.len()) };
        Ok(())
    }

    /// Commits a geometry and gives it the next id.
    fn add(&mut self, geometry: Geometry) -> Result<u32, Error> {
        let id = check::count("geometries", self.geometries.len())?;
        // SAFETY: the geometry is alive and this thread's alone; its buffers are filled.
        unsafe { sys::rtcCommitGeometry(geometry.0) };
        self.device.check("setting up a geometry")?;
        self.geometries.push(geometry);
        Ok(id)
    }
}

impl fmt::Debug for SceneBuilder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SceneBuilder")
            .field("geometries", &self.geometries.len())
            .field("robust", &self.robust)
            .field("compact", &self.compact)
            .finish_non_exhaustive()
    }
}
