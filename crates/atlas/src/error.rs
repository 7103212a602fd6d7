//! What can go wrong while laying out an atlas.

use thiserror::Error;

/// Why there is no atlas.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Error {
    /// The page edge is out of range.
    #[error("page size {0} is out of range: choose 1 to 16384 texels")]
    PageSize(u32),
    /// The density is not a positive number.
    #[error("density {0} is out of range: give texels per scene unit above 0")]
    Density(f64),
    /// No page at all.
    #[error("0 pages hold nothing: give at least 1, or auto")]
    Pages,
    /// A name that was asked for fits no object.
    #[error("{flag} {pattern}: no object has such a name; there are {}", some(.names, *.count))]
    NoSuchObject {
        /// The flag.
        flag: &'static str,
        /// The name with its wildcards.
        pattern: String,
        /// The first few names that there are, and how many there are.
        names: Vec<String>,
        /// See `names`.
        count: usize,
    },
    /// The scene places no triangles.
    #[error(
        "the scene places no triangles that take texels: there is nothing to lay out; `--exclude`, or `bake = false` \
         in extras.ambake, leaves objects out"
    )]
    Empty,
    /// `--uv keep` on a set that is no lightmap set.
    #[error("mesh `{mesh}`: TEXCOORD_{set} {why}: use `--uv auto` or `--uv unwrap`")]
    Unusable {
        /// First mesh concerned.
        mesh: String,
        /// TEXCOORD number.
        set: u32,
        /// What is wrong with it.
        why: Why,
    },
    /// Some charts, or those of a mesh that is placed several times, do not fit on a page at any density.
    #[error(
        "the charts ({charts}) with their gutters do not fit on pages of {size}x{size} texels: {}",
        larger(*size, "raise `--size`", "leave objects out with `--exclude`, or lower `--gutter` and `--mips`")
    )]
    PageFull {
        /// Number of charts, or of objects where their own charts are kept.
        charts: u32,
        /// Page edge in texels.
        size: u32,
    },
    /// The charts do not fit on the pages that were allowed.
    #[error(
        "the charts with their gutters do not fit on {pages} page(s) of {size}x{size} texels: {}",
        larger(*size, "raise `--size` or `--pages`, or lower the density", "raise `--pages` or lower the density")
    )]
    PagesFull {
        /// Pages that were allowed.
        pages: u32,
        /// Page edge in texels.
        size: u32,
    },
    /// At the density asked for, one chart is larger than a page.
    #[error(
        "a chart takes {width}x{height} texels with its gutter and the page has {size}x{size}: \
         {}",
        if width.max(height) > &LARGEST { "lower `--density`".into() }
        else { format!("raise `--size` to {} or lower `--density`", width.max(height)) }
    )]
    ChartTooLarge {
        /// Chart width in texels with gutter.
        width: u32,
        /// Chart height in texels with gutter.
        height: u32,
        /// Page edge in texels.
        size: u32,
    },
    /// The density asks for more texels than can be laid out.
    #[error("the density asks for {0} texels or more: lower `--density`")]
    TooManyTexels(u64),
    /// An object's transform or size cannot be measured in 32-bit numbers.
    #[error("object `{0}` is too large or too small to unwrap: scale the scene")]
    Extent(String),
    /// The unwrapper refused its input.
    #[error("unwrapping failed: {0}: please report this scene")]
    Unwrap(String),
    /// The audit of the unwrapper's result failed.
    #[error(
        "the unwrapped layout of `{mesh}` failed its audit ({overlaps} overlapping sample points, {missing} triangles \
         missing, {outside} vertices outside): please report this scene"
    )]
    Audit {
        /// First mesh concerned.
        mesh: String,
        /// Sample points inside more than one triangle.
        overlaps: u64,
        /// Triangles without area.
        missing: u64,
        /// Vertices outside the page.
        outside: u64,
    },
    /// The caller asked to stop.
    #[error("cancelled")]
    Cancelled,
}

/// Why a UV set is no lightmap set. Counts are over all objects that were checked together.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum Why {
    /// The mesh does not have the set.
    #[error("is absent")]
    Absent,
    /// Coordinates that are not finite or not within 0..1.
    #[error("has {0} coordinates outside 0..1")]
    Outside(u64),
    /// Objects that share the set's square were given different densities.
    #[error("is shared by objects of different densities")]
    Shared,
    /// Triangles that have no area in the set.
    #[error("gives {0} triangles no area")]
    NoArea(u64),
    /// The area of all triangles in pages: more than one, so they lie over each other.
    #[error("covers its page {0:.2} times")]
    Crowded(f64),
    /// Sample points, 16 a texel, strictly inside more than one triangle.
    #[error("overlaps at {points} sample points (16 a texel, {size}x{size} texels)")]
    Overlap {
        /// How many points.
        points: u64,
        /// Page edge in texels.
        size: u32,
    },
}

/// Some of so many names.
fn some(names: &[String], count: usize) -> String {
    let quoted: Vec<String> = names.iter().map(|n| format!("`{n}`")).collect();
    match count - names.len() {
        0 => quoted.join(", "),
        more => format!("{}, and {more} more", quoted.join(", ")),
    }
}

/// Largest page edge in texels.
const LARGEST: u32 = 16_384;

/// Advice that holds for pages that can be larger, or for the largest.
fn larger(size: u32, raise: &'static str, otherwise: &'static str) -> &'static str {
    if size < LARGEST { raise } else { otherwise }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_page_is_advised_to_be_larger_than_the_largest() {
        let advice = |size| larger(size, "raise", "leave out");
        assert_eq!(advice(LARGEST / 2), "raise");
        assert_eq!(advice(LARGEST), "leave out");
    }
}
