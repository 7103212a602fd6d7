//! Every layer with its row of the table. Help, planner, writer, previews and gutters all read it here.

use serde::Serialize;

/// One term or quantity over the atlas. Names and meanings are fixed by the file contract.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(into = "&'static str")]
#[non_exhaustive]
pub enum Layer {
    /// Fraction of the texel's square inside its charts.
    Coverage,
    /// Open solid angle / 2 pi.
    Visibility,
    /// (1/pi) times the integral of V cos.
    Diffuse,
    /// ((n+1)/2pi) times the integral of V (R.V)^n; 0 where the material does not reflect specularly.
    Specular,
    /// Mean sky x albedo x visibility: the baseline.
    Traditional,
    /// Albedo x irradiance; under a uniform sky x albedo x diffuse.
    Lambert,
    /// Base x irradiance plus specular reflectance x reflection, of the microfacet model.
    Ggx,
    /// Lambert plus specular reflectance x reflection; under a uniform sky x specular reflectance x specular.
    Phong,
    /// Standard error of the diffuse term.
    StdErrDiffuse,
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
    /// Share of the footprint that can be seen: 0 where it lies inside of another closed body.
    Validity,
    /// Traditional minus Lambert.
    DifferenceLambert,
    /// Traditional minus Phong.
    DifferencePhong,
    /// Standard error of the visibility.
    StdErrVisibility,
    /// Standard error of the specular term.
    StdErrSpecular,
    /// Diffuse reflectance, linear.
    Albedo,
    /// Specular reflectance, linear; under the microfacet model that of an open texel for its view.
    Reflectance,
    /// Diffuse reflectance under the coat of the microfacet model, linear.
    Base,
    /// (1/pi) times the integral of L V cos, L the sky's radiance.
    Irradiance,
    /// ((n+1)/2pi) times the integral of L V (R.V)^n; 0 where the material does not reflect specularly.
    Reflection,
    /// Standard error of the irradiance, of the mean of its channels.
    StdErrIrradiance,
    /// Standard error of the reflection, of the mean of its channels.
    StdErrReflection,
    /// Share of the texel that something seals: what stands so close above it that it takes all light from it.
    Sealed,
    /// Half of the difference between the diffuse terms of two independent halves of the rays.
    HalfDiffuse,
    /// The same of the visibility.
    HalfVisibility,
    /// The same of the specular term.
    HalfSpecular,
    /// The same of the irradiance.
    HalfIrradiance,
    /// The same of the reflection.
    HalfReflection,
    /// Harmonics of the open directions up to order 4, from which the specular term follows for any view.
    AnyView,
    /// The same up to order 8.
    AnyView8,
    /// Root mean square error over all views of the specular term that they give.
    StdErrAnyView,
    /// What the specular term of an open texel is for its view, in closed form.
    OpenSpecular,
    /// Sky x visibility x what an open texel reflects: the second baseline.
    TraditionalClosed,
    /// Spherical harmonics of the light that arrives, up to order 1: (1/4pi) times the integral of L V, and the same
    /// times each axis of the direction. E/pi of a normal n is about the first plus twice the dot product of n and the
    /// others.
    Sh,
    /// The same of [`Layer::Bent`], of the diffuse term plus each axis of the cosine-weighted sum.
    HalfBent,
    /// The same of [`Layer::Sh`], of the first plus each of the others.
    HalfSh,
    /// [`Layer::Bent`] in the tangent frame of the surface, as normal maps of OpenGL hold it.
    BentTangent,
    /// [`Layer::AnyView`], whatever the lobes of the materials are.
    AnyView4,
    /// The part of [`Layer::Irradiance`] that comes straight from lights without extent.
    Direct,
    /// k_a, by which the traditional model reflects.
    Ambient,
    /// [`Layer::Specular`] of the part of the microfacet model's lobe that Fresnel's term makes white.
    White,
    /// Share of [`Layer::Reflectance`] that has the colour of the material, not Fresnel's white.
    Tint,
}

/// An integral over the directions of a texel. A bake models those that its layers need.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Term {
    /// (1/pi) times the integral of V cos: the Lambertian ambient term.
    Diffuse,
    /// Open solid angle / 2 pi: the traditional occlusion factor.
    Visibility,
    /// ((n+1)/2pi) times the integral of V (R.V)^n: the Phong ambient term.
    Specular,
}

/// What the values of a layer are measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// A share, 0..=1.
    Share,
    /// Radiance in the unit of the sky, linear RGB; also the error of one.
    Radiance,
    /// Reflectance, 0..=1 a channel, linear RGB.
    Reflectance,
    /// A length in scene units.
    SceneUnits,
    /// A direction of unit length in world space.
    Direction,
    /// A dimensionless number of any size.
    Number,
    /// A count or an index.
    Count,
}

/// How a value becomes a byte of an 8-bit preview.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preview {
    /// `round(255 v)`, clamped.
    Linear,
    /// `round(255 v / m)`, m the largest value of the page.
    OfLargest,
    /// `round(255 (v + 1) / 2)`, clamped.
    Signed,
    /// The sRGB curve, clamped.
    Srgb,
    /// No preview: 8 bits show nothing useful.
    None,
}

/// A row of the table.
#[derive(Debug, Clone, Copy)]
struct Row {
    layer: Layer,
    name: &'static str,
    channels: &'static [&'static str],
    unit: Unit,
    preview: Preview,
    dilates: bool,
    needs: &'static [Term],
    help: &'static str,
}

use Layer::*;

const RGB: &[&str] = &["R", "G", "B"];
const XYZ: &[&str] = &["X", "Y", "Z"];
const ONE: &[&str] = &[""];
#[rustfmt::skip]
const SH: &[&str] = &["0.R", "0.G", "0.B", "x.R", "x.G", "x.B", "y.R", "y.G", "y.B", "z.R", "z.G", "z.B"];
#[rustfmt::skip]
const NUMBERS: &[&str] = &[
    "00", "01", "02", "03", "04", "05", "06", "07", "08", "09", "10", "11", "12", "13", "14",
    "15", "16", "17", "18", "19", "20", "21", "22", "23", "24", "25", "26", "27", "28", "29",
    "30", "31", "32", "33", "34", "35", "36", "37", "38", "39", "40", "41", "42", "43", "44",
];

/// A row whose gutters are dilated.
const fn row(
    layer: Layer,
    name: &'static str,
    channels: &'static [&'static str],
    (unit, preview): (Unit, Preview),
    needs: &'static [Term],
    help: &'static str,
) -> Row {
    Row {
        layer,
        name,
        channels,
        unit,
        preview,
        dilates: true,
        needs,
        help,
    }
}

/// The row of counts and indices: gutters keep their void value.
const fn counted(row: Row) -> Row {
    Row {
        dilates: false,
        ..row
    }
}

const SHARE: (Unit, Preview) = (Unit::Share, Preview::Linear);
const LIGHT: (Unit, Preview) = (Unit::Radiance, Preview::Srgb);
const TINT: (Unit, Preview) = (Unit::Reflectance, Preview::Srgb);
const HALF: (Unit, Preview) = (Unit::Radiance, Preview::Signed);
const UNIT_VECTOR: (Unit, Preview) = (Unit::Direction, Preview::Signed);

/// Every layer in the order of the enum.
#[rustfmt::skip]
const TABLE: [Row; 48] = [
    counted(row(Coverage, "coverage", ONE, SHARE, &[], "fraction of the texel inside its chart")),
    row(Visibility, "visibility", ONE, SHARE, &[Term::Visibility],
        "open solid angle / 2 pi, the traditional occlusion factor"),
    row(Diffuse, "diffuse", ONE, SHARE, &[Term::Diffuse], "the Lambertian ambient term"),
    row(Specular, "specular", ONE, SHARE, &[Term::Specular], "the Phong ambient term"),
    row(Traditional, "traditional", RGB, LIGHT, &[Term::Visibility], "mean sky x albedo x visibility"),
    row(Lambert, "lambert", RGB, LIGHT, &[Term::Diffuse], "albedo x light that arrives"),
    row(Ggx, "ggx", RGB, LIGHT, &[Term::Diffuse, Term::Specular],
        "light that a microfacet surface sends out (--model ggx)"),
    row(Phong, "phong", RGB, LIGHT, &[Term::Diffuse, Term::Specular],
        "lambert plus specular reflectance x reflected light"),
    row(StdErrDiffuse, "error", ONE, SHARE, &[Term::Diffuse], "standard error of diffuse"),
    counted(row(Rays, "rays", ONE, (Unit::Count, Preview::OfLargest), &[], "rays spent")),
    row(Position, "position", XYZ, (Unit::SceneUnits, Preview::None), &[], "mean position in the world"),
    row(Normal, "normal", XYZ, UNIT_VECTOR, &[], "mean shading normal"),
    row(Geometric, "geometric", XYZ, UNIT_VECTOR, &[], "mean geometric normal"),
    row(Bent, "bent", XYZ, UNIT_VECTOR, &[Term::Diffuse], "mean open direction, cosine-weighted"),
    row(Exponent, "exponent", ONE, (Unit::Number, Preview::OfLargest), &[], "lobe exponent of the material"),
    counted(row(Object, "object", ONE, (Unit::Count, Preview::None), &[], "index of the object, -1 for none")),
    row(Validity, "validity", ONE, SHARE, &[], "share of the texel that can be seen"),
    row(DifferenceLambert, "difference.lambert", RGB, (Unit::Radiance, Preview::Signed),
        &[Term::Visibility, Term::Diffuse], "traditional - lambert"),
    row(DifferencePhong, "difference.phong", RGB, (Unit::Radiance, Preview::Signed),
        &[Term::Visibility, Term::Diffuse, Term::Specular], "traditional - phong"),
    row(StdErrVisibility, "error.visibility", ONE, SHARE, &[Term::Visibility], "standard error of visibility"),
    row(StdErrSpecular, "error.specular", ONE, SHARE, &[Term::Specular], "standard error of specular"),
    row(Albedo, "albedo", RGB, TINT, &[], "diffuse reflectance"),
    row(Reflectance, "reflectance", RGB, TINT, &[], "specular reflectance"),
    row(Base, "base", RGB, TINT, &[], "diffuse reflectance under a coat (--model ggx)"),
    row(Irradiance, "irradiance", RGB, LIGHT, &[Term::Diffuse], "light that arrives, E / pi, without albedo"),
    row(Reflection, "reflection", RGB, LIGHT, &[Term::Specular], "light that the lobe reflects, without its colour"),
    row(StdErrIrradiance, "error.irradiance", ONE, (Unit::Radiance, Preview::Linear), &[Term::Diffuse],
        "standard error of irradiance"),
    row(StdErrReflection, "error.reflection", ONE, (Unit::Radiance, Preview::Linear), &[Term::Specular],
        "standard error of reflection"),
    row(Sealed, "sealed", ONE, SHARE, &[Term::Diffuse], "share of the texel that has something close above it"),
    row(HalfDiffuse, "half.diffuse", ONE, HALF, &[Term::Diffuse],
        "half the difference of diffuse between two halves of the rays"),
    row(HalfVisibility, "half.visibility", ONE, HALF, &[Term::Visibility], "the same of visibility"),
    row(HalfSpecular, "half.specular", ONE, HALF, &[Term::Specular], "the same of specular"),
    row(HalfIrradiance, "half.irradiance", RGB, HALF, &[Term::Diffuse], "the same of irradiance"),
    row(HalfReflection, "half.reflection", RGB, HALF, &[Term::Specular], "the same of reflection"),
    row(AnyView, "any-view", NUMBERS.first_chunk::<15>().unwrap(), (Unit::Number, Preview::None),
        &[Term::Visibility], "15 numbers that give specular for any view, or 45 where the lobes need them"),
    row(AnyView8, "any-view.8", NUMBERS, (Unit::Number, Preview::None), &[Term::Visibility],
        "45 numbers, for narrower lobes"),
    row(StdErrAnyView, "error.any-view", ONE, SHARE, &[Term::Visibility], "error over all views of what they give"),
    row(OpenSpecular, "specular.open", ONE, SHARE, &[Term::Specular], "specular of an open texel, in closed form"),
    row(TraditionalClosed, "traditional.closed", RGB, LIGHT, &[Term::Visibility, Term::Specular],
        "the closed form of an open texel x visibility"),
    row(Sh, "sh", SH, (Unit::Radiance, Preview::None), &[Term::Diffuse, Term::Visibility],
        "light by direction, spherical harmonics of order 1 in 4 x 3 numbers"),
    row(HalfBent, "half.bent", XYZ, HALF, &[Term::Diffuse], "the same of the sum that bent is the direction of"),
    row(HalfSh, "half.sh", SH, (Unit::Radiance, Preview::None), &[Term::Diffuse, Term::Visibility], "the same of sh"),
    row(BentTangent, "bent.tangent", XYZ, UNIT_VECTOR, &[Term::Diffuse],
        "bent in the tangent frame of the surface (MikkTSpace, green up)"),
    row(AnyView4, "any-view.4", NUMBERS.first_chunk::<15>().unwrap(), (Unit::Number, Preview::None),
        &[Term::Visibility], "15 such numbers, whatever the lobes; written as any-view"),
    row(Direct, "direct", RGB, LIGHT, &[], "light that arrives straight from suns, points and spots, E / pi"),
    row(Ambient, "ambient", RGB, TINT, &[], "coefficient of the traditional model (--ambient-coefficient)"),
    row(White, "specular.white", ONE, SHARE, &[Term::Specular],
        "specular of the part of the lobe that Fresnel's term makes white (--model ggx)"),
    row(Tint, "reflectance.tint", RGB, TINT, &[], "share of reflectance that is not of that part"),
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
        StdErrDiffuse,
        Rays,
    ];

    /// Every layer.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.into_iter().map(|row| row.layer)
    }

    /// The name in files and on the command line.
    pub const fn name(self) -> &'static str {
        TABLE[self as usize].name
    }

    /// The layer of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|layer| layer.name() == name)
    }

    /// Channel suffixes in order: none, `R G B` or `X Y Z`.
    pub const fn channels(self) -> &'static [&'static str] {
        TABLE[self as usize].channels
    }

    /// The name of one of its channels in a file, such as `diffuse` or `phong.R`.
    pub fn channel_name(self, channel: usize) -> String {
        match self.channels()[channel] {
            "" => self.name().into(),
            suffix => format!("{}.{suffix}", self.name()),
        }
    }

    /// What its values are measured in.
    pub const fn unit(self) -> Unit {
        TABLE[self as usize].unit
    }

    /// How its 8-bit preview stores a value.
    pub const fn preview(self) -> Preview {
        TABLE[self as usize].preview
    }

    /// True for harmonics of the open directions.
    pub const fn is_any_view(self) -> bool {
        matches!(self, AnyView | AnyView4 | AnyView8)
    }

    /// True for what two halves of the rays differ by.
    pub const fn is_of_halves(self) -> bool {
        matches!(
            self,
            HalfDiffuse
                | HalfVisibility
                | HalfSpecular
                | HalfIrradiance
                | HalfReflection
                | HalfBent
                | HalfSh
        )
    }

    /// True where a file holds its values as halves.
    pub const fn is_half(self) -> bool {
        self.is_any_view()
    }

    /// True where gutter texels take the mean of their neighbours; coverage, counts and indices keep their void value.
    pub const fn dilates(self) -> bool {
        TABLE[self as usize].dilates
    }

    /// The terms that must be modelled for it.
    pub const fn needs(self) -> &'static [Term] {
        TABLE[self as usize].needs
    }

    /// A few words about it, for help and tables.
    pub const fn help(self) -> &'static str {
        TABLE[self as usize].help
    }

    /// The value of a texel that no chart touches.
    pub const fn void(self) -> f32 {
        match self {
            Object => -1.0,
            _ => 0.0,
        }
    }
}

impl Term {
    /// Every term, in the order in which the planner reports them.
    pub const ALL: [Self; 3] = [Self::Diffuse, Self::Visibility, Self::Specular];

    /// The name of its layer, on the command line and in `bake.json`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "diffuse",
            Self::Visibility => "visibility",
            Self::Specular => "specular",
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
        for (index, row) in TABLE.into_iter().enumerate() {
            assert_eq!(row.layer as usize, index, "{}", row.name);
            assert_eq!(Layer::from_name(row.name), Some(row.layer));
        }
    }

    #[test]
    fn channels_have_the_names_of_the_contract() {
        assert_eq!(Diffuse.channel_name(0), "diffuse");
        assert_eq!(DifferencePhong.channel_name(2), "difference.phong.B");
        assert_eq!(Bent.channel_name(0), "bent.X");
    }

    #[test]
    fn a_preview_suits_what_a_layer_holds() {
        for layer in Layer::all() {
            let (unit, preview) = (layer.unit(), layer.preview());
            let suits = match preview {
                Preview::Srgb => matches!(unit, Unit::Radiance | Unit::Reflectance),
                Preview::Linear => matches!(unit, Unit::Share | Unit::Radiance),
                Preview::OfLargest => matches!(unit, Unit::Count | Unit::Number),
                Preview::Signed => matches!(unit, Unit::Direction | Unit::Radiance),
                Preview::None => {
                    matches!(unit, Unit::SceneUnits | Unit::Count | Unit::Number)
                        || layer.channels() == SH
                }
            };
            assert!(suits, "{}: {preview:?} of {unit:?}", layer.name());
        }
    }
}
