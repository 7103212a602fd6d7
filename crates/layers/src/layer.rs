//! The layers that a bake can write: their names in files, their channels, and how gutters treat them.

use serde::Serialize;

/// One term or quantity over the atlas. Names and meanings are fixed by the file contract.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(into = "&'static str")]
pub enum Layer {
    /// Fraction of the texel's square inside its charts, 0..=1.
    Coverage,
    /// Open solid angle / 2 pi, 0..=1.
    Visibility,
    /// (1/pi) times the integral of V cos, 0..=1.
    Diffuse,
    /// ((n+1)/2pi) times the integral of V (R.V)^n, 0..=1; 0 where the material does not reflect specularly.
    Specular,
    /// Mean sky x albedo x visibility: the baseline.
    Traditional,
    /// Albedo x irradiance; under a uniform sky x albedo x diffuse.
    Lambert,
    /// Lambert plus specular reflectance x reflection; under a uniform sky x specular reflectance x specular.
    Phong,
    /// Standard error of the diffuse term.
    Error,
    /// Rays spent.
    Rays,
    /// Mean world position over the footprint.
    Position,
    /// Mean shading normal, unit.
    Normal,
    /// Mean geometric normal, unit.
    Geometric,
    /// Mean open direction, cosine-weighted, unit; zero where nothing is open.
    Bent,
    /// Lobe exponent.
    Exponent,
    /// Index of the object with the largest share of the footprint; -1 where there is none.
    Object,
    /// Share of the footprint whose upper hemisphere does not see back faces first, 0..=1.
    Validity,
    /// Traditional minus Lambert.
    DifferenceLambert,
    /// Traditional minus Phong.
    DifferencePhong,
    /// Standard error of the visibility.
    ErrorVisibility,
    /// Standard error of the specular term.
    ErrorSpecular,
    /// Diffuse reflectance, linear.
    Albedo,
    /// Specular reflectance, linear.
    Reflectance,
    /// (1/pi) times the integral of L V cos, L the sky's radiance.
    Irradiance,
    /// ((n+1)/2pi) times the integral of L V (R.V)^n; 0 where the material does not reflect specularly.
    Reflection,
    /// Standard error of the irradiance, of the mean of its channels.
    ErrorIrradiance,
    /// Standard error of the reflection, of the mean of its channels.
    ErrorReflection,
}

use Layer::*;

const RGB: &[&str] = &["R", "G", "B"];
const XYZ: &[&str] = &["X", "Y", "Z"];
const ONE: &[&str] = &[""];

/// Every layer in the order of the enum, with its name and its channel suffixes.
const TABLE: [(Layer, &str, &[&str]); 26] = [
    (Coverage, "coverage", ONE),
    (Visibility, "visibility", ONE),
    (Diffuse, "diffuse", ONE),
    (Specular, "specular", ONE),
    (Traditional, "traditional", RGB),
    (Lambert, "lambert", RGB),
    (Phong, "phong", RGB),
    (Error, "error", ONE),
    (Rays, "rays", ONE),
    (Position, "position", XYZ),
    (Normal, "normal", XYZ),
    (Geometric, "geometric", XYZ),
    (Bent, "bent", XYZ),
    (Exponent, "exponent", ONE),
    (Object, "object", ONE),
    (Validity, "validity", ONE),
    (DifferenceLambert, "difference.lambert", RGB),
    (DifferencePhong, "difference.phong", RGB),
    (ErrorVisibility, "error.visibility", ONE),
    (ErrorSpecular, "error.specular", ONE),
    (Albedo, "albedo", RGB),
    (Reflectance, "reflectance", RGB),
    (Irradiance, "irradiance", RGB),
    (Reflection, "reflection", RGB),
    (ErrorIrradiance, "error.irradiance", ONE),
    (ErrorReflection, "error.reflection", ONE),
];

impl Layer {
    /// The layers of a plain bake.
    pub const STANDARD: [Self; 9] = [
        Coverage,
        Visibility,
        Diffuse,
        Specular,
        Traditional,
        Lambert,
        Phong,
        Error,
        Rays,
    ];

    /// Every layer.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.into_iter().map(|(layer, _, _)| layer)
    }

    /// The name in files and on the command line.
    pub const fn name(self) -> &'static str {
        TABLE[self as usize].1
    }

    /// The layer of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|layer| layer.name() == name)
    }

    /// Channel suffixes in order: none, `R G B` or `X Y Z`.
    pub const fn channels(self) -> &'static [&'static str] {
        TABLE[self as usize].2
    }

    /// True where gutter texels take the mean of their neighbours; counts and indices keep their void value.
    pub const fn dilates(self) -> bool {
        !matches!(self, Coverage | Rays | Object)
    }

    /// The value of a texel that no chart touches.
    pub const fn void(self) -> f32 {
        match self {
            Object => -1.0,
            _ => 0.0,
        }
    }
}

impl From<Layer> for &'static str {
    fn from(layer: Layer) -> Self {
        layer.name()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_stands_in_the_order_of_the_enum() {
        for (index, (layer, name, _)) in TABLE.into_iter().enumerate() {
            assert_eq!(layer as usize, index, "{name}");
            assert_eq!(Layer::from_name(name), Some(layer));
        }
    }
}
