//! The words of flags of other verbs than `bake` and `probes`.

use crate::words::{Words, words};
use frames::{Lookup, NormalCode};
use maps::Normalise;
use render::{Model as Shown, PointForm};

words! {
    Lookup {
        "nearest" = Nearest "One texel",
        "bilinear" = Bilinear "Between four texels",
        "recursive" = Recursive "Halves the pixel until its corners show adjacent texels",
        "quad" = Quad "Integrates over the quad of the corners",
        "summed" = Summed "Rectangle of a pre-integrated table, constant cost",
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
        "radiance" = Radiance "E over distance² over the texel's solid angle: what it lights does not depend on the \
         size of the map",
        "raw" = Raw "E over distance², as the 1984 text says",
    }
    Shown {
        "traditional" = Traditional "Constant times the open share of the hemisphere",
        "traditional.closed" = TraditionalClosed "The same constant times what an open surface reflects, \
         in closed form",
        "lambert" = Lambert "The Lambertian ambient term",
        "phong" = Phong "Lambertian and specular terms",
        "ggx" = Ggx "Lambertian and microfacet terms",
        "lommel-seeliger" = LommelSeeliger "Loose dust, as on the Moon, in place of the Lambertian term",
        "facing-ratio" = FacingRatio "Albedo times the cosine to the eye, without any light",
    }
}
