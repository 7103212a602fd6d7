//! The highlight of a material that ambake wrote.
//!
//! The GLB of a bake has the coat of its materials off, so that engines show the baked light. What highlight the
//! scene's material has stands in `extras.ambake`: `Ks` and `Ns` as in an OBJ file.

use crate::material::MAX_EXPONENT;
use glam::Vec3;
use serde::Deserialize;
use serde_json::Value;

/// Specular reflectance, 0..=1 a channel, and lobe exponent of Phong's model.
pub(super) struct Phong {
    pub specular: Vec3,
    pub exponent: f64,
}

#[derive(Deserialize)]
struct Extras {
    ambake: Written,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Written {
    ks: [f32; 3],
    ns: f64,
}

/// The highlight that `extras.ambake` names; `None` where it names none. Extras may hold anything, so what does not fit
/// is not an error.
pub(super) fn phong(material: &Value) -> Option<Phong> {
    let extras = material.get("extras")?.clone();
    let Written { ks, ns } = serde_json::from_value::<Extras>(extras).ok()?.ambake;
    Some(Phong {
        specular: Vec3::from_array(ks).clamp(Vec3::ZERO, Vec3::ONE),
        exponent: ns.clamp(0.0, MAX_EXPONENT),
    })
}
