//! What a device is asked for and what it answers: plain data that works without the library.

use crate::Error;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

/// Decides whether a hit on a masked triangle counts: `keep(primitive, barycentric, ray)`, with the weights of the
/// second and third corner and [`Ray::id`](crate::Ray::id). Called from any thread that traces, also several times for
/// one hit.
pub type Keep = Arc<dyn Fn(u32, [f32; 2], u32) -> bool + Send + Sync>;

/// What a device is asked for. The default uses every core, the CPU's best kernels and no memory limit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DeviceConfig {
    /// Threads that build scenes, 0 for all cores. Tracing always runs on the caller's thread.
    pub threads: usize,
    /// Kernels of this instruction set instead of the CPU's best.
    pub isa: Option<Isa>,
    /// Bytes the device may allocate for scenes; more is [`Error::OutOfMemory`].
    pub memory_limit: Option<u64>,
}

/// An instruction set that Embree has kernels for, lowest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Isa {
    /// SSE2, or the baseline of a CPU other than x86-64.
    Sse2,
    /// SSE4.2.
    Sse42,
    /// AVX.
    Avx,
    /// AVX2 with FMA.
    Avx2,
    /// AVX-512 of the server cores (F, DQ, CD, BW, VL).
    Avx512,
}

impl Isa {
    const ALL: [Isa; 5] = [Isa::Sse2, Isa::Sse42, Isa::Avx, Isa::Avx2, Isa::Avx512];

    /// Name in Embree's configuration: `sse2`, `sse4.2`, `avx`, `avx2`, `avx512`.
    pub fn name(self) -> &'static str {
        match self {
            Isa::Sse2 => "sse2",
            Isa::Sse42 => "sse4.2",
            Isa::Avx => "avx",
            Isa::Avx2 => "avx2",
            Isa::Avx512 => "avx512",
        }
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Isa {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        Isa::ALL
            .into_iter()
            .find(|isa| isa.name() == name)
            .ok_or_else(|| Error::UnknownIsa(name.to_owned()))
    }
}

/// An Embree version.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version {
    /// 3 or 4.
    pub major: u32,
    /// Second number.
    pub minor: u32,
    /// Third number.
    pub patch: u32,
}

impl Version {
    /// From Embree's packed number, `40303` for 4.3.3.
    #[cfg_attr(not(embree), allow(dead_code))]
    pub(crate) fn from_packed(packed: u32) -> Self {
        Version {
            major: packed / 10000,
            minor: packed / 100 % 100,
            patch: packed % 100,
        }
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// What runs Embree's build tasks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tasking {
    /// Embree's own scheduler.
    Internal,
    /// Threading Building Blocks (Debian's builds).
    Tbb,
    /// Microsoft's Parallel Patterns Library.
    Ppl,
    /// Another, by its number.
    Other(i64),
}

impl fmt::Display for Tasking {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Tasking::Internal => f.write_str("internal"),
            Tasking::Tbb => f.write_str("TBB"),
            Tasking::Ppl => f.write_str("PPL"),
            Tasking::Other(number) => write!(f, "number {number}"),
        }
    }
}

/// Versions and abilities of the library that was really loaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Version of the loaded library.
    pub library: Version,
    /// Version of the headers this was built with; its major equals the library's.
    pub headers: Version,
    /// What runs build tasks.
    pub tasking: Tasking,
    /// Packets of 4 rays run as packets.
    pub native_packet_4: bool,
    /// Packets of 8 rays run as packets (false below AVX: they are split).
    pub native_packet_8: bool,
    /// Packets of 16 rays run as packets (false below AVX-512: they are split).
    pub native_packet_16: bool,
    /// Filters work: without them [`crate::SceneBuilder::masked_triangles`] is an error.
    pub filter_functions: bool,
    /// Ray masks are compiled in.
    pub ray_mask: bool,
    /// Back faces are culled: such a build misses one side of every triangle and is unusable here.
    pub backface_culling: bool,
    /// Instruction set of the kernels: the one asked for, else worked out from the CPU and the native widths, since
    /// Embree does not tell.
    pub isa: Isa,
}

/// Bytes that Embree holds for a device's scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// Now.
    pub current: u64,
    /// At most so far.
    pub peak: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_unpack_as_embree_packs_them() {
        assert_eq!(Version::from_packed(31305).to_string(), "3.13.5");
        assert_eq!(Version::from_packed(40303).to_string(), "4.3.3");
    }

    #[test]
    fn instruction_sets_read_back_from_their_names() {
        for isa in Isa::ALL {
            assert_eq!(isa.name().parse::<Isa>().ok(), Some(isa));
        }
        assert!("avx1024".parse::<Isa>().is_err());
    }
}
