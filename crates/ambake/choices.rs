//! What a bake chooses among that no crate below this one names: lightmap coordinates and the library of rays.

use rays::{BackendKind, TreeKind};

/// Lightmap coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Uv {
    /// Keep the file's where they are usable as a lightmap, else unwrap.
    #[default]
    Auto,
    /// Keep the file's; an error where they are not usable.
    Keep,
    /// Always unwrap.
    Unwrap,
}

/// Which library answers rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Backend {
    /// Debian's Embree.
    Embree,
    /// Pure Rust: obvhs, 8-wide compressed tree.
    Obvhs,
    /// Pure Rust: obvhs, binary tree.
    ObvhsBvh2,
}

impl Backend {
    /// Embree where it is built in, else obvhs.
    pub fn best() -> Self {
        match ::rays::has_embree() {
            true => Self::Embree,
            false => Self::Obvhs,
        }
    }

    /// As the ray crate calls it.
    pub fn kind(self) -> BackendKind {
        match self {
            Self::Embree => BackendKind::Embree,
            Self::Obvhs => BackendKind::Obvhs(TreeKind::Cwbvh),
            Self::ObvhsBvh2 => BackendKind::Obvhs(TreeKind::Bvh2),
        }
    }
}
