//! Every engine with its row of the table: the files that it gets, what it multiplies by, and how it takes them.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A lightmap in `bake.json`: which engine it is for, and how that engine shows it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LightmapReport {
    /// The engine, as `--for` calls it.
    pub engine: String,
    /// The file, beside `bake.json`.
    pub file: String,
    /// How it is compressed for the graphics processor, `BC6H`; `None` where it is not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compression: Option<String>,
    /// What the file's numbers are.
    pub unit: String,
    /// What the engine multiplies by, so that a white surface under an open sky of 1 shows as 1.
    pub scale: f64,
    /// How to use it, in two sentences.
    #[serde(rename = "use")]
    pub how: String,
}

/// A program that shows lightmaps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Engine {
    /// Any reader of glTF.
    Gltf,
    /// three.js.
    Three,
    /// Blender.
    Blender,
    /// Bevy.
    Bevy,
    /// Godot 3 and 4.
    Godot,
    /// Unity.
    Unity,
    /// Unreal Engine.
    Unreal,
}

/// A file that an engine gets of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// OpenEXR, half floats, channels R, G, B.
    Exr,
    /// Radiance RGBE.
    Hdr,
    /// KTX2, uncompressed half floats, with the mip levels that the layout allows.
    Ktx2,
    /// KTX2, the same in BC6H.
    Bc6h,
    /// DDS, the same in BC6H.
    Bc6hDds,
    /// Light by direction in Godot's packing: OpenEXR, half floats, four slices under one another.
    Sh,
    /// Light by direction as plain numbers: KTX2, an array of four pictures.
    ShKtx2,
    /// Occlusion, 16-bit grey PNG.
    Ao,
    /// Occlusion, 8-bit grey PNG, dithered.
    Ao8,
    /// Occlusion, KTX2 in BC7, with the levels of the lightmap.
    Bc7,
    /// How Godot is to import the OpenEXR file.
    GodotImport,
}

struct Row {
    engine: Engine,
    name: &'static str,
    kinds: &'static [Kind],
    /// What the engine multiplies by.
    scale: f64,
    how: &'static str,
}

/// Edge in texels of a block of BC6H and BC7.
pub(crate) const BLOCK: u32 = 4;

/// What Bevy's default camera (EV100 9.7) divides luminance by: 1.2 * 2^9.7.
pub(crate) const BEVY_WHITE: f64 = 998.095_744_642_541_7;

use Kind::*;

#[rustfmt::skip]
const TABLE: [Row; 7] = [
    Row { engine: Engine::Gltf, name: "gltf", kinds: &[Exr, Hdr, Ao], scale: 1.0,
        how: "STEM.glb carries the occlusion on TEXCOORD_1, for readers that heed texCoord; glTF itself has no \
              lightmaps. In your own shader add albedo x texel x scale, sampled with TEXCOORD_1, row 0 of the picture \
              at v = 0." },
    Row { engine: Engine::Three, name: "three", kinds: &[Exr, Hdr, Ktx2, Ao], scale: PI,
        how: "material.lightMap = texture with texture.channel = 1 and material.lightMapIntensity = scale; three.js \
              divides by pi. Set material.aoMap = null, which would darken the lightmap again; flipY = true after \
              EXRLoader, false after HDRLoader and DDSLoader; after KTX2Loader set linear filters." },
    Row { engine: Engine::Blender, name: "blender", kinds: &[Exr, Ao], scale: 1.0,
        how: "Image Texture (Linear Rec.709) on the second UV map, multiplied by the base colour, into Emission of \
              strength scale. Import STEM.glb first: its second UV map is the layout. Or import STEM.lit.glb, which \
              is lit as it is." },
    Row { engine: Engine::Bevy, name: "bevy", kinds: &[Ktx2, Exr, Ao, Ao8], scale: BEVY_WHITE,
        how: "Lightmap { image, ..default() } on each mesh entity of STEM.glb, StandardMaterial::lightmap_exposure = \
              scale x (1 - 0.16 x reflectance^2), GlobalAmbientLight::affects_lightmapped_meshes = false. The scale \
              undoes the default camera Exposure (EV100 9.7); for another take 1.2 * 2^EV100." },
    Row { engine: Engine::Godot, name: "godot", kinds: &[Exr, Ao, Ao8, GodotImport], scale: 1.0,
        how: "STEM.godot.glb with the files of that name beside it shows it as it is. In your own spatial shader: \
              EMISSION = albedo * texture(lightmap, UV2).rgb * scale with ambient light off. Or occlusion alone: \
              STEM.P.ao8.png as AO texture with AO on UV2." },
    Row { engine: Engine::Unity, name: "unity", kinds: &[Exr, Hdr, Ao], scale: 1.0,
        how: "Import as a lightmap without mipmaps, sRGB off; it lies on uv2 of the imported STEM.glb, scale and \
              offset 1,1,0,0. Set it in LightmapSettings, Non-Directional; the lit shader multiplies by albedo." },
    Row { engine: Engine::Unreal, name: "unreal", kinds: &[Exr, Ao], scale: 1.0,
        how: "A 2-D texture with sRGB off and without mipmaps, sampled at TexCoord[1]: base colour x texel x scale \
              into Emissive Color of the material. STEM.P.ao.png goes into Ambient Occlusion, as a mask." },
];

impl Engine {
    /// Every engine.
    pub fn all() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|row| row.engine)
    }

    /// Its name on the command line and in `bake.json`.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// The engine of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|engine| engine.name() == name)
    }

    /// What the engine multiplies the light by, so that a white surface under an open sky of 1 shows as 1.
    pub fn scale(self) -> f64 {
        self.row().scale
    }

    /// What it gets of a page that has light by direction, and how it takes that.
    fn directional(self) -> Option<(Kind, &'static str)> {
        match self {
            Self::Godot => Some((
                Sh,
                "Import as Texture2DArray, one column and four rows, without mipmaps and compression; a spatial \
                 shader samples it with UV2. Slices s0..s3 hold Godot's own packing: E/pi = s0 * (1 + 8 * ((s1 - 0.5) \
                 * n.y + (s2 - 0.5) * n.z + (s3 - 0.5) * n.x)), n the normal in the world.",
            )),
            Self::Bevy => Some((
                ShKtx2,
                "A texture_2d_array<f32> in a material extension, sampled with the second coordinates; n is the \
                 normal in the world. Layers a0..a3: E/pi = a0 + 2 * (a1 * n.x + a2 * n.y + a3 * n.z); times base \
                 colour and scale it is what Lightmap adds.",
            )),
            _ => None,
        }
    }

    /// What it gets in blocks, in place of uncompressed KTX2; nothing where it reads no blocks.
    fn blocks(self) -> &'static [Kind] {
        match self {
            Self::Three => &[Bc6hDds, Bc7],
            Self::Bevy => &[Bc6h, Bc7],
            _ => &[],
        }
    }

    /// True where it reads pictures in blocks.
    pub(crate) fn reads_blocks(self) -> bool {
        !self.blocks().is_empty()
    }

    pub(crate) fn kinds(self) -> &'static [Kind] {
        self.row().kinds
    }

    pub(crate) fn entry(self, kind: Kind, file: String) -> LightmapReport {
        LightmapReport {
            engine: self.name().into(),
            file,
            compression: matches!(kind, Bc6h | Bc6hDds).then(|| "BC6H".into()),
            unit: kind.unit().into(),
            scale: self.scale(),
            how: match self.directional() {
                Some((directional, how)) if directional == kind => how.into(),
                _ => self.row().how.into(),
            },
        }
    }

    fn row(self) -> &'static Row {
        &TABLE[self as usize]
    }
}

impl Kind {
    /// The files of several engines, each once, in a fixed order; `directional`: of a page that has light by direction;
    /// `compress`: in blocks, where an engine reads those.
    pub fn of(engines: &[Engine], directional: bool, compress: bool) -> Vec<Kind> {
        let wanted = |kind: &Kind| {
            engines.iter().any(|engine| {
                let own = engine.directional().filter(|_| directional);
                let blocks = if compress { engine.blocks() } else { &[] };
                let replaced = *kind == Ktx2 && !blocks.is_empty();
                (engine.kinds().contains(kind) && !replaced)
                    || blocks.contains(kind)
                    || own.is_some_and(|(own, _)| own == *kind)
            })
        };
        let all = [
            Exr,
            Hdr,
            Ktx2,
            Bc6h,
            Bc6hDds,
            Sh,
            ShKtx2,
            Ao,
            Ao8,
            Bc7,
            GodotImport,
        ];
        all.into_iter().filter(wanted).collect()
    }

    /// The name of its file.
    pub fn file(self, stem: &str, page: u32) -> String {
        let ending = match self {
            Exr => "lightmap.exr",
            Hdr => "lightmap.hdr",
            Ktx2 => "lightmap.ktx2",
            Bc6h => "lightmap.bc6h.ktx2",
            Bc6hDds => "lightmap.bc6h.dds",
            Sh => "sh.exr",
            ShKtx2 => "sh.ktx2",
            Ao => "ao.png",
            Ao8 => "ao8.png",
            Bc7 => "ao.bc7.ktx2",
            GodotImport => "lightmap.exr.import",
        };
        format!("{stem}.{page}.{ending}")
    }

    /// True for lightmaps, false for occlusion.
    pub fn is_light(self) -> bool {
        !matches!(self, Ao | Ao8 | Bc7 | GodotImport)
    }

    fn unit(self) -> &'static str {
        match self {
            GodotImport => "text",
            Ao | Ao8 | Bc7 => "open share of the cosine-weighted hemisphere, 0..1, linear",
            Sh | ShKtx2 => {
                "spherical harmonics of order 1 of the light that arrives, from which E/pi follows for any normal"
            }
            _ => "E/pi, linear RGB without albedo, 1 under an open sky of 1",
        }
    }
}

/// The names of all files that `engines` get of one page; `directional`: of one that has the layer `sh`; `compress`:
/// in blocks, where an engine reads those.
pub fn engine_files(
    stem: &str,
    page: u32,
    engines: &[Engine],
    directional: bool,
    compress: bool,
) -> Vec<String> {
    let kinds = Kind::of(engines, directional, compress);
    kinds.iter().map(|kind| kind.file(stem, page)).collect()
}

/// Checks that files in blocks can be made for these engines, of pages of `size` texels along their edge.
///
/// # Errors
/// What is wrong, in words: none of `engines` reads such files, or a page is no whole number of blocks.
pub fn check_compressed(engines: &[Engine], size: u32) -> Result<(), String> {
    let problem = if !engines.iter().any(|engine| engine.reads_blocks()) {
        "compressed lightmaps are made for three and bevy; name one of them by --for".into()
    } else if !size.is_multiple_of(BLOCK) {
        format!(
            "blocks are 4 x 4 texels and pages {size} wide; bake with a --size that is a multiple of 4"
        )
    } else {
        return Ok(());
    };
    Err(problem)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_stands_in_the_order_of_the_enum_and_gives_each_engine_light_and_occlusion() {
        for (index, row) in TABLE.iter().enumerate() {
            assert_eq!(row.engine as usize, index, "{}", row.name);
            assert_eq!(Engine::from_name(row.name), Some(row.engine));
            assert!(
                row.kinds.contains(&Exr) && row.kinds.contains(&Ao),
                "{}",
                row.name
            );
        }
        assert_eq!(Engine::from_name("quake"), None);
        assert!((BEVY_WHITE - 1.2 * 2f64.powf(9.7)).abs() < 1e-9);
    }

    #[test]
    fn a_file_that_two_engines_share_is_made_once() {
        assert_eq!(
            Kind::of(&[Engine::Three, Engine::Bevy], false, false),
            [Exr, Hdr, Ktx2, Ao, Ao8]
        );
        let all: Vec<Engine> = Engine::all().collect();
        assert_eq!(
            Kind::of(&all, true, false),
            [Exr, Hdr, Ktx2, Sh, ShKtx2, Ao, Ao8, GodotImport]
        );
        assert_eq!(
            Kind::of(&[Engine::Three], true, false),
            [Exr, Hdr, Ktx2, Ao]
        );
        assert_eq!(Kind::of(&[], true, true), []);
    }

    #[test]
    fn blocks_take_the_place_of_uncompressed_ktx2_where_an_engine_reads_them() {
        assert_eq!(
            Kind::of(&[Engine::Three, Engine::Bevy, Engine::Unity], false, true),
            [Exr, Hdr, Bc6h, Bc6hDds, Ao, Ao8, Bc7]
        );
        assert_eq!(
            Kind::of(&[Engine::Unity], false, true),
            Kind::of(&[Engine::Unity], false, false)
        );
        let told = |engine: Engine, kind| engine.entry(kind, String::new()).compression;
        assert_eq!(told(Engine::Bevy, Bc6h).as_deref(), Some("BC6H"));
        assert_eq!(told(Engine::Bevy, Exr), None);
    }

    /// Its importer makes a cube map of every .hdr file.
    #[test]
    fn unreal_gets_no_radiance_picture() {
        assert_eq!(Kind::of(&[Engine::Unreal], false, false), [Exr, Ao]);
    }
}
