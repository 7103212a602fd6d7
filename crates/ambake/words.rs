//! The words of options that have a few values, as flags, `bake.json` and Python say them.

use crate::choices::{Backend, Uv};
use ::bake::{Buried, Denoise, Footprint, Model, Seams, Shading};
use maps::Normalise;
use render::tables::{Lookup, NormalCode};
use render::{Model as Shown, PointForm};

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

macro_rules! words {
    ($($kind:ident { $($word:literal = $value:ident$(($bits:literal))? $($help:literal)?,)* })*) => {$(
        impl Words for $kind {
            const ALL: &'static [(&'static str, Self, &'static str)] =
                &[$(($word, Self::$value$(($bits))?, concat!($($help)?))),*];
        }
    )*};
}

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
    Lookup {
        "nearest" = Nearest "One texel",
        "bilinear" = Bilinear "Between four texels",
        "recursive" = Recursive "Halves the pixel until its corners show adjacent texels",
        "quad" = Quad "Integrates over the quad of the corners",
        "summed" = Summed "Rectangle of a pre-integrated table, constant cost",
    }
    Model {
        "phong" = Phong,
        "ggx" = Ggx,
    }
    NormalCode {
        "256" = Visible256 "256 normals of the visible hemisphere",
        "oct8+8" = Octahedral(8) "Octahedral, 16 bits",
        "oct10+10" = Octahedral(10) "Octahedral, 20 bits",
        "oct12+12" = Octahedral(12) "Octahedral, 24 bits",
        "oct16+16" = Octahedral(16) "Octahedral, 32 bits",
    }
    Normalise {
        "radiance" = Radiance "A constant map of 1 gives 1",
        "seed" = Seed "1/4π",
    }
    PointForm {
        "radiance" = Radiance "E over distance² over the texel's solid angle: what it lights does not depend on the size of the map",
        "raw" = Raw "E over distance², as the 1984 text says",
    }
    Seams {
        "off" = Off,
        "object" = Object,
        "scene" = Scene,
    }
    Shading {
        "production" = Production "What its mirror image in the facet's plane sees: convex bodies do not darken themselves",
        "exact" = Exact "Nothing: the facet hides it",
    }
    Shown {
        "traditional" = Traditional "Constant times the open share of the hemisphere",
        "traditional.closed" = TraditionalClosed "The same constant times what an open surface reflects, in closed form",
        "lambert" = Lambert "The Lambertian ambient term",
        "phong" = Phong "Lambertian and specular terms",
        "ggx" = Ggx "Lambertian and microfacet terms",
        "lommel-seeliger" = LommelSeeliger "Loose dust, as on the Moon, in place of the Lambertian term",
        "facing-ratio" = FacingRatio "Albedo times the cosine to the eye, without any light",
    }
    Uv {
        "auto" = Auto,
        "keep" = Keep,
        "unwrap" = Unwrap,
    }
}
