//! What was repaired or ignored on the way to a scene, and how often.

use crate::Scene;
use serde::{Serialize, Serializer};
use std::fmt;

/// Something that was repaired or ignored on load.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Warning {
    /// What happened; serialised as its stable word.
    pub kind: WarningKind,
    /// Mesh, primitive or material it is about.
    pub place: String,
    /// How many times.
    pub count: u64,
    /// One sentence.
    pub message: String,
}

/// What can be repaired or ignored. This is the whole list: no other word stands in a report's `warnings`.
///
/// What stops a load instead is listed at the head of `validate.rs`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum WarningKind {
    /// OBJ: `Ka` of a material is neither black, white nor its `Kd`, and the traditional term takes `Kd`.
    AmbientCoefficients,
    /// OBJ: `Kd` of a material is black. Beside `map_Kd` it counts as white, else Lambert's and the traditional model
    /// are black on it.
    BlackDiffuse,
    /// glTF: a material that is all metal, by `metallicFactor` 1 or without one, and no texture says otherwise. A metal
    /// has no albedo, so that Lambert's and the traditional model are black on it. Nor has one whose coat reflects all,
    /// as that of a specular-glossiness material without a `specularFactor` does.
    BlackMetals,
    /// A normal that is zero or not finite becomes the area-weighted mean of the geometric normals around the vertex.
    /// Where every normal of a mesh is bad, the mesh has none and is shaded with its geometric normals.
    BadNormals,
    /// Tangents of a mesh that are zero or not finite: all of the mesh's are made from its UVs.
    BadTangents,
    /// A UV that is not finite becomes (0, 0).
    BadUvs,
    /// glTF: what a bake can do without (an attribute, a property of a material, a sampler, a name) cannot be meant as
    /// it stands in the file: it is as if it were not there.
    BrokenParts,
    /// A factor of a material outside its range is clamped into it.
    ClampedFactors,
    /// Diffuse and specular reflectance add up to more than 1: both are scaled down, by one factor for all channels.
    ReflectanceScaled,
    /// A mesh without a triangle is left out, with its instances.
    EmptyMeshes,
    /// An object that lies so far from most of the scene that the 32-bit numbers of rays do not tell its details apart.
    FarApart,
    /// A file that the scene names is not there; one of the same name, but for its folders or the case of letters, is
    /// read.
    FilesFoundElsewhere,
    /// A glTF extension that could change light and is not read, or not known.
    IgnoredExtensions,
    /// OBJ: lines, points and faces of fewer than three corners are left out.
    IgnoredLinesAndPoints,
    /// MTL: lines without the number or name they need.
    IgnoredMtlLines,
    /// A normal or bump map (glTF `normalTexture`; MTL `map_Bump`, `bump`, `norm`), for a bake that does not ask for
    /// them: normals are the mesh's.
    IgnoredNormalMaps,
    /// OBJ: corners name `vn` 0, or a `vn` where none stands before them.
    IgnoredNormalReferences,
    /// OBJ: corners name `vt` 0, or a `vt` where none stands before them.
    IgnoredUvReferences,
    /// A material in use that lets all light through (MTL `Tr 1` or `d 0`; glTF BLEND with an alpha of 0): what has it
    /// blocks nothing.
    InvisibleMaterials,
    /// glTF: indices that make no whole triangle are left out.
    LeftoverIndices,
    /// A mesh whose 32-bit coordinates lie so far from its origin that the file has lost its details.
    LostDigits,
    /// OBJ: a material library that is absent.
    MissingMaterialLibraries,
    /// A normal map whose picture cannot be had, for a bake that asks for them: the mesh's normals stand alone.
    MissingNormalMaps,
    /// A texture whose picture cannot be had, for it is absent, broken or not on this machine: the factor stands alone.
    MissingTextures,
    /// OBJ: corners without a `vt` in a mesh that has some get the UV (0, 0).
    MissingUvs,
    /// glTF: morph targets are left out, the base shape is baked.
    MorphTargets,
    /// glTF: scenes beside the baked one that have nodes of their own are left out.
    OtherScenes,
    /// glTF: a primitive of points or lines is left out.
    PointsAndLines,
    /// An instance whose transform has no inverse, such as a scale of 0, is left out.
    SingularTransforms,
    /// glTF: a skin is left out, the mesh is baked where its node stands.
    Skins,
    /// A texture on a mesh without the UV set it reads: the mesh gets the material without it.
    TexturesWithoutUvs,
    /// An instance of which no side is as long as 1e-12 units is left out: products of three such lengths vanish in the
    /// f32 of rays.
    TinyInstances,
    /// glTF: a surface with a tint lets light pass by `KHR_materials_transmission`, and that of the sky gets none of it
    /// in a bake.
    GreyTransmission,
    /// glTF: `extras.ambake` of a node or a mesh has a name that means nothing, such as a misspelt one.
    UnknownExtras,
    /// OBJ: a material that is in no library that was read; its parts stay untinted.
    UnknownMaterials,
    /// A texture of a kind or in a format that is not read (KTX2, AVIF): the factor stands alone.
    UnreadTextures,
    /// A vertex that is not finite or out of reach, and that no triangle uses, is moved onto a used one.
    UnusedBadVertices,
    /// glTF: UV sets after a missing number are left out.
    UvSetsAfterAGap,
    /// Faces of zero area (exactly, in f64) are dropped: triangles, and polygons of which every triangle is such a one.
    ZeroAreaTriangles,
}

impl WarningKind {
    /// The stable word that scripts look for in `bake.json`, such as `zero-area-triangles`.
    pub fn name(self) -> &'static str {
        match self {
            WarningKind::AmbientCoefficients => "ambient-coefficients",
            WarningKind::BlackDiffuse => "black-diffuse",
            WarningKind::BlackMetals => "black-metals",
            WarningKind::BadNormals => "bad-normals",
            WarningKind::BadTangents => "bad-tangents",
            WarningKind::BadUvs => "bad-uvs",
            WarningKind::BrokenParts => "broken-parts",
            WarningKind::ClampedFactors => "clamped-factors",
            WarningKind::ReflectanceScaled => "reflectance-scaled",
            WarningKind::EmptyMeshes => "empty-meshes",
            WarningKind::FarApart => "far-apart",
            WarningKind::FilesFoundElsewhere => "files-found-elsewhere",
            WarningKind::IgnoredExtensions => "ignored-extensions",
            WarningKind::IgnoredLinesAndPoints => "ignored-lines-and-points",
            WarningKind::IgnoredMtlLines => "ignored-mtl-lines",
            WarningKind::IgnoredNormalMaps => "ignored-normal-maps",
            WarningKind::IgnoredNormalReferences => "ignored-normal-references",
            WarningKind::IgnoredUvReferences => "ignored-uv-references",
            WarningKind::InvisibleMaterials => "invisible-materials",
            WarningKind::LeftoverIndices => "leftover-indices",
            WarningKind::LostDigits => "lost-digits",
            WarningKind::MissingMaterialLibraries => "missing-material-libraries",
            WarningKind::MissingNormalMaps | WarningKind::MissingTextures => "missing-textures",
            WarningKind::MissingUvs => "missing-uvs",
            WarningKind::MorphTargets => "morph-targets",
            WarningKind::OtherScenes => "other-scenes",
            WarningKind::PointsAndLines => "points-and-lines",
            WarningKind::SingularTransforms => "singular-transforms",
            WarningKind::Skins => "skins",
            WarningKind::TexturesWithoutUvs => "textures-without-uvs",
            WarningKind::TinyInstances => "tiny-instances",
            WarningKind::GreyTransmission => "grey-transmission",
            WarningKind::UnknownExtras => "unknown-extras",
            WarningKind::UnknownMaterials => "unknown-materials",
            WarningKind::UnreadTextures => "unread-textures",
            WarningKind::UnusedBadVertices => "unused-bad-vertices",
            WarningKind::UvSetsAfterAGap => "uv-sets-after-a-gap",
            WarningKind::ZeroAreaTriangles => "zero-area-triangles",
        }
    }
}

impl fmt::Display for WarningKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for WarningKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Scene {
    /// How often a kind of warning was counted, over all places.
    pub fn warned(&self, kind: WarningKind) -> u64 {
        let own = self.warnings.iter().filter(|w| w.kind == kind);
        own.map(|w| w.count).sum()
    }
}
