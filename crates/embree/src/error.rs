//! Everything that can go wrong, one sentence a variant.

use crate::{Isa, Version};

/// Why a device, a mesh, an instance or a scene could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Embree was not there when this crate was built.
    #[error(
        "ambake was built without Embree: install libembree-dev and libclang-dev and build again, or use obvhs"
    )]
    NotBuilt,
    /// The loaded library has another major than the headers: its calls mean something else.
    #[error(
        "built for Embree {headers}, but Embree {library} was loaded: build again or correct the library path"
    )]
    VersionMismatch {
        /// Version of the headers.
        headers: Version,
        /// Version of the library.
        library: Version,
    },
    /// This CPU cannot run the kernels.
    #[error("this CPU has no kernels of the instruction set asked for ({}): choose a lower one",
        isa.map_or("the default", Isa::name))]
    UnsupportedCpu {
        /// What [`crate::DeviceConfig::isa`] said.
        isa: Option<Isa>,
    },
    /// A name that is no [`Isa`].
    #[error("unknown instruction set {0:?}: use sse2, sse4.2, avx, avx2 or avx512")]
    UnknownIsa(String),
    /// The library abilities lack something needed here.
    #[error("this build of Embree {0}: install the distribution's package")]
    UnusableLibrary(&'static str),
    /// Memory ran out, or [`crate::DeviceConfig::memory_limit`] was reached.
    #[error("out of memory while {during}: bake fewer triangles at once or raise the limit")]
    OutOfMemory {
        /// What was being done.
        during: &'static str,
    },
    /// Embree reported something that this crate does not expect.
    #[error("Embree reported error {code} while {during}: please report this")]
    Embree {
        /// The `RTCError`.
        code: i32,
        /// What was being done.
        during: &'static str,
    },
    /// A mesh without triangles.
    #[error("the mesh has no triangles: leave it out")]
    EmptyMesh,
    /// More items than 32-bit indices can count.
    #[error("{count} {what} are more than 32-bit indices can count: split the mesh")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many.
        count: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error(
        "triangle {triangle} names vertex {vertex}, but there are {vertices}: correct the indices"
    )]
    IndexOutOfRange {
        /// Which triangle.
        triangle: usize,
        /// What it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A vertex that Embree would silently drop with its triangles.
    #[error("vertex {vertex} is at {position:?}: coordinates must be finite and within 1.8e18")]
    VertexOutOfRange {
        /// Which vertex.
        vertex: usize,
        /// Where it is.
        position: [f32; 3],
    },
    /// A transform that has no usable inverse in single precision.
    #[error(
        "the transform flattens space (determinant {determinant:e}): it must be invertible in single precision"
    )]
    SingularTransform {
        /// Determinant of its linear part.
        determinant: f64,
    },
    /// A transform with a NaN or an infinity.
    #[error("the transform holds a number that is not finite: {0:?}")]
    TransformNotFinite([[f32; 3]; 4]),
    /// An instance that Embree would silently drop.
    #[error("the instance reaches {0:e} from the origin: coordinates must stay within 1.8e18")]
    InstanceOutOfRange(f64),
    /// An instance so far away for its size that no ray can be carried into its space.
    #[error(
        "the instance is too far away for its size ({0:?}): place its vertices instead, or scale the scene"
    )]
    InstanceOutOfReach([[f32; 3]; 4]),
    /// An instance of a scene that itself holds instances.
    #[error(
        "the instanced scene holds instances itself: only one level is supported, flatten the transforms"
    )]
    NestedInstance,
    /// An instance of a scene of another device.
    #[error("the instanced scene belongs to another device: build both with one device")]
    OtherDevice,
    /// An instance whose scene was built with another robust setting; their intervals end differently.
    #[error("instance {instance} differs from its scene in the robust setting: build both alike")]
    RobustMismatch {
        /// Geometry id of the instance.
        instance: u32,
    },
}
