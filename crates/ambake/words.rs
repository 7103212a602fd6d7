//! The words of options that have a few values, as flags, `bake.json` and Python say them.

use crate::choices::{Backend, Uv};
use ::bake::{Buried, Denoise, Footprint, Model, Seams, Shading};
use environment::Up;

/// Values that have words.
pub trait Words: Copy + PartialEq + Send + Sync + 'static {
    /// Each word, its value, and what the word alone does not say.
    const ALL: &'static [(&'static str, Self, &'static str)];

    /// The word of a value.
    fn word(self) -> &'static str {
        let found = Self::ALL.iter().find(|(_, value, _)| *value == self);
        found.map_or("", |(word, ..)| word)
    }
}

/// The words of types.
macro_rules! words {
    ($($kind:ident { $($word:literal = $value:ident$(($bits:literal))? $($help:literal)?,)* })*) => {$(
        impl Words for $kind {
            const ALL: &'static [(&'static str, Self, &'static str)] =
                &[$(($word, Self::$value$(($bits))?, concat!($($help)?))),*];
        }
    )*};
}
#[cfg(feature = "cli")]
pub(crate) use words;

words! {
    Backend {
        "embree" = Embree "Debian's Embree",
        "obvhs" = Obvhs "Pure Rust: obvhs, 8-wide compressed BVH",
        "obvhs-bvh2" = ObvhsBvh2 "Pure Rust: obvhs, binary BVH",
    }
    Buried {
        "drop" = Drop "They do not count, and texels without others are filled from their neighbours",
        "keep" = Keep "They count as what they are, dark",
    }
    Denoise {
        "off" = Off,
        "regression" = Regression,
        "oidn" = Oidn,
    }
    Footprint {
        "texel" = Texel "All over its area",
        "centre" = Centre "At its centre",
    }
    Model {
        "phong" = Phong,
        "ggx" = Ggx,
    }
    Seams {
        "off" = Off,
        "object" = Object,
        "scene" = Scene,
    }
    Shading {
        "production" = Production "What its mirror image in the facet's plane sees: convex bodies do not darken \
         themselves",
        "exact" = Exact "Nothing: the facet hides it",
    }
    Up {
        "y" = Y,
        "z" = Z,
    }
    Uv {
        "auto" = Auto,
        "keep" = Keep,
        "unwrap" = Unwrap,
    }
}
