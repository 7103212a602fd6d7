//! From charts to an atlas: each chart at its object's density, packed by shape.

use crate::audit::{Findings, audit};
use crate::authored::authored_sheets;
use crate::charts::sheets;
use crate::copies::Tile;
use crate::hidden::hide;
use crate::mask::Mask;
use crate::measure::{AS_IT_STANDS, density};
use crate::objects::Object;
use crate::pack::Spot;
use crate::search::{Cut, Found, search};
use crate::share::{Limits, limits};
use crate::sheet::{Sheet, turn};
use crate::uv::twice_area;
use crate::{Atlas, Audit, Error, MeshLayout, Options, Placement, Seen, UvSource};
use glam::{DVec2, Vec2};
use layers::Progress;
use rayon::prelude::*;
use scene::Scene;

/// Edge of a speck: two units in the last place of a coordinate in 0.5..1.
const SPECK: f32 = 1.0 / (1 << 23) as f32;
/// The least number of pieces into which the meshes of a scene are parted for threads.
const PIECES: usize = 256;
/// How often triangles that lie over others of their charts are parted from them: a chart that is all but right has
/// few.
const ROUNDS: u32 = 8;

/// Unwraps every mesh that takes texels and packs all charts together.
///
/// A mesh placed once is unwrapped in its world shape, so its texels are square there, and its charts go wherever there
/// is room. A mesh placed several times is unwrapped once in its own shape; each object gets a rectangle, scaled by the
/// square root of its mean area scale.
///
/// * `authored`: layouts of the meshes by coordinates of the file, whose charts are packed in place of others.
pub(crate) fn unwrap(
    scene: &Scene,
    objects: &[Object],
    options: &Options,
    authored: Option<&[MeshLayout]>,
    seen: Option<&Seen<'_>>,
    progress: &dyn Progress,
) -> Result<Atlas, Error> {
    let mut object_of = vec![0; scene.instances.len()];
    for (o, object) in objects.iter().enumerate() {
        for &i in &object.instances {
            object_of[i as usize] = o;
        }
    }
    let included: Vec<bool> = object_of.iter().map(|&o| objects[o].included).collect();
    let mut sheets = match authored {
        Some(layouts) => authored_sheets(scene, &included, layouts),
        None => sheets(scene, &included, progress)?,
    };
    let mut objects = objects.to_vec();
    if let Some(seen) = seen {
        hide(&mut sheets, seen, options.cut_hidden);
        for object in objects.iter_mut().filter(|object| object.included) {
            object.area = 0.0;
        }
        for sheet in &mut sheets {
            let (seen, texels) = (sheet.fit_seen(scene), sheet.hidden_texels());
            for (&i, seen) in sheet.instances.iter().zip(seen) {
                let object = &mut objects[object_of[i as usize]];
                object.area += seen;
                object.hidden += texels;
            }
        }
    }
    let mut rounds = if authored.is_none() { ROUNDS } else { 0 };
    loop {
        let (atlas, findings) = arrange(scene, (&objects, &object_of), &sheets, options, progress)?;
        if findings.clean() {
            return Ok(atlas);
        }
        if rounds == 0 || !part_what_lies_over(scene, &mut sheets, &findings.over) {
            return Err(refused(scene, &findings));
        }
        rounds -= 1;
    }
}

/// Makes charts of their own of triangles, each with an instance, that lie over others of their charts; false where
/// there are none.
fn part_what_lies_over(scene: &Scene, sheets: &mut [Sheet], over: &[[u32; 2]]) -> bool {
    let mut parted = false;
    for &[instance, triangle] in over {
        let mesh = scene.instances[instance as usize].mesh as usize;
        let of_mesh = sheets.iter_mut().filter(|sheet| sheet.mesh == mesh);
        for sheet in of_mesh {
            parted |= sheet.part(triangle);
        }
    }
    parted
}

/// The error of a layout that is not clean.
fn refused(scene: &Scene, findings: &Findings) -> Error {
    let mesh = findings
        .mesh()
        .map(|mesh| &scene.meshes[mesh as usize].name);
    Error::Audit {
        mesh: mesh.cloned().unwrap_or_default(),
        overlaps: findings.audit.overlaps,
        missing: findings.audit.missing,
        outside: findings.audit.outside,
    }
}

/// Packs charts at the highest densities at which they fit, and audits that.
///
/// * `objects`: all, and the number of that of each instance.
fn arrange(
    scene: &Scene,
    (objects, object_of): (&[Object], &[usize]),
    sheets: &[Sheet],
    options: &Options,
    progress: &dyn Progress,
) -> Result<(Atlas, Findings), Error> {
    let cut = |densities: &[f64], draft: bool| {
        let limits = limits(objects, densities, options.even);
        let of = |instance: u32| limits[object_of[instance as usize]];
        Ok(cut(sheets, options.gutter, of, draft))
    };
    let Found {
        densities,
        packed,
        kept,
    } = search(objects, options, progress, cut)?;
    let mut atlas = Atlas {
        page_size: options.page_size,
        page_count: packed.pages.max(1),
        gutter: options.gutter,
        meshes: scene
            .meshes
            .iter()
            .map(MeshLayout::without_texels)
            .collect(),
        placements: object_of
            .iter()
            .map(|&o| match objects[o].included {
                true => AS_IT_STANDS,
                false => Placement::NOWHERE,
            })
            .collect(),
        source: UvSource::Unwrapped,
        audit: Audit::default(),
        density: 0.0,
        chart_count: sheets.iter().map(|s| s.charts.len() as u32).sum(),
        notes: Vec::new(),
    };
    let of = |instance: u32| densities[object_of[instance as usize]];
    let specks = settle(&mut atlas, sheets, &kept, &packed.spots, of);
    if progress.cancelled() {
        return Err(Error::Cancelled);
    }
    let findings = audit(scene, &atlas);
    atlas.audit = Audit {
        specks,
        ..findings.audit
    };
    atlas.density = density(scene, &atlas.meshes, &atlas.placements, options.page_size);
    Ok((atlas, findings))
}

/// Writes the places of all sheets into an atlas, and counts the specks.
///
/// * `tiles`, `spots`: of [`cut`], and where its shapes went.
pub(crate) fn settle(
    atlas: &mut Atlas,
    sheets: &[Sheet],
    tiles: &[Option<Tile>],
    mut spots: &[Spot],
    density: impl Fn(u32) -> f64,
) -> u64 {
    let size = f64::from(atlas.page_size);
    let mut specks = 0;
    for (sheet, tile) in sheets.iter().zip(tiles) {
        let mut layout = match tile {
            None => {
                let (own, rest) = spots.split_at(sheet.charts.len());
                spots = rest;
                let only = sheet.instances[0];
                atlas.placements[only as usize] = AS_IT_STANDS;
                sheet.layout(own, density(only), DVec2::splat(size))
            }
            Some(tile) => {
                let (own, rest) = spots.split_at(sheet.instances.len());
                spots = rest;
                for ((&i, spot), &scale) in sheet.instances.iter().zip(own).zip(&tile.scales) {
                    let extent = tile.extent * (scale / tile.scale) / size;
                    atlas.placements[i as usize] = Placement {
                        page: spot.page,
                        scale: extent.as_vec2().to_array(),
                        offset: [spot.x, spot.y].map(|t| (f64::from(t) / size) as f32),
                    };
                }
                sheet.layout(&tile.spots, tile.scale, tile.extent)
            }
        };
        specks += add_specks(&mut layout) * sheet.instances.len() as u64;
        atlas.meshes[sheet.mesh] = layout;
    }
    specks
}

/// The shapes of all sheets, and the tiles of those that stand in several places.
///
/// * `limits`: those of each instance.
pub(crate) fn cut(
    sheets: &[Sheet],
    gutter: u32,
    limits: impl Fn(u32) -> Limits + Sync,
    draft: bool,
) -> Cut<Vec<Option<Tile>>> {
    let cut = |sheet: &Sheet| match sheet.instances[..] {
        [only] => (sheet.shapes(limits(only).density, draft), None),
        _ => {
            let tile = Tile::of(sheet, gutter, &limits);
            let shape = |&scale: &f64| {
                let size = (tile.extent * (scale / tile.scale) - 1e-6)
                    .ceil()
                    .max(DVec2::ONE);
                vec![Mask::full(size.x as u32, size.y as u32)]
            };
            (tile.scales.iter().map(shape).collect(), Some(tile))
        }
    };
    let at_once = sheets.len().div_ceil(PIECES);
    let parts: Vec<_> = sheets
        .par_iter()
        .with_max_len(at_once.max(1))
        .map(cut)
        .collect();
    let (mut shapes, mut groups, mut kept) = (Vec::new(), Vec::new(), Vec::new());
    for (own, tile) in parts {
        let first = groups.last().map_or(0, |g| g + 1);
        // Every instance by itself; all charts of a mesh placed once together.
        let group = |k: usize| first + if tile.is_some() { k as u32 } else { 0 };
        groups.extend((0..own.len()).map(group));
        shapes.extend(own);
        kept.push(tile);
    }
    Cut {
        shapes,
        groups,
        kept,
    }
}

impl Sheet {
    /// The layout with charts at these spots, in a square or page of `extent` texels. Vertices without a chart go to
    /// the first corner, which the gutter keeps free.
    fn layout(&self, spots: &[Spot], scale: f64, extent: DVec2) -> MeshLayout {
        let mut uvs = vec![Vec2::ZERO; self.points.len()];
        let mut pages = vec![0u16; self.triangles.len()];
        let mut hidden = vec![false; self.triangles.len()];
        for (chart, spot) in spots.iter().enumerate() {
            let size = DVec2::from(self.size(chart, scale).map(f64::from));
            let corner = DVec2::new(f64::from(spot.x), f64::from(spot.y));
            let scale = self.scale(chart, scale);
            for &t in &self.charts[chart] {
                pages[t as usize] = spot.page as u16;
                hidden[t as usize] = self.hidden[chart];
                for v in self.triangles[t as usize] {
                    let at = turn(self.points[v as usize] * scale, spot.turn, size) + corner;
                    uvs[v as usize] = (at / extent).clamp(DVec2::ZERO, DVec2::ONE).as_vec2();
                }
            }
        }
        MeshLayout {
            source_vertices: self.sources.clone(),
            uvs,
            triangles: self.triangles.clone(),
            triangle_pages: if pages.iter().all(|&p| p == 0) {
                Vec::new()
            } else {
                pages
            },
            hidden: if self.hidden.contains(&true) {
                hidden
            } else {
                Vec::new()
            },
        }
    }
}

/// Gives every triangle without area a speck at its first corner, with vertices of its own, and counts them.
///
/// These are triangles that the unwrapper found too thin (under a millionth of the mesh's diagonal) and collapsed onto
/// a neighbour's corner, and those that rounding to 32 bits flattened. A speck is smaller than what 32-bit coordinates
/// can tell apart on a page, so it takes nothing from its neighbour.
fn add_specks(layout: &mut MeshLayout) -> u64 {
    let mut specks = 0;
    for t in 0..layout.triangles.len() {
        let corners = layout.triangles[t];
        let uvs = corners.map(|v| layout.uvs[v as usize]);
        if twice_area(uvs.map(Vec2::as_dvec2)) != 0.0 {
            continue;
        }
        specks += 1;
        // Toward the middle of the square, so that the speck stays inside.
        let inward = |x: f32| if x < 0.5 { SPECK } else { -SPECK };
        let at = uvs[0];
        let (u, v) = (Vec2::new(inward(at.x), 0.0), Vec2::new(0.0, inward(at.y)));
        let (first, second) = if u.x * v.y > 0.0 { (u, v) } else { (v, u) };
        let next = layout.uvs.len() as u32;
        layout.uvs.extend([at, at + first, at + second]);
        let sources = corners.map(|c| layout.source_vertices[c as usize]);
        layout.source_vertices.extend(sources);
        layout.triangles[t] = [next, next + 1, next + 2];
    }
    specks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speck_turns_as_charts_do_and_stays_on_the_page() {
        let places = [0.0, 0.25, 0.5, 0.75, 1.0];
        for (x, y) in places.iter().flat_map(|&x| places.map(|y| (x, y))) {
            let mut layout = MeshLayout {
                source_vertices: vec![7, 8, 9, 4],
                uvs: vec![Vec2::new(x, y), Vec2::ONE, Vec2::new(x, y), Vec2::ZERO],
                triangles: vec![[0, 1, 2], [3, 0, 1]],
                ..MeshLayout::default()
            };
            let flat = 1 + u64::from(x == y);
            assert_eq!(add_specks(&mut layout), flat);
            assert_eq!(layout.triangles[0], [4, 5, 6]);
            assert_eq!(layout.source_vertices[4..7], [7, 8, 9]);
            let uvs = layout.triangles[0].map(|v| layout.uvs[v as usize]);
            assert_eq!(uvs[0], Vec2::new(x, y));
            assert!(twice_area(uvs.map(Vec2::as_dvec2)) > 0.0, "{x} {y}");
            for uv in uvs {
                assert!(uv.min_element() >= 0.0 && uv.max_element() <= 1.0, "{uv}");
                assert!(uv.distance(uvs[0]) <= SPECK, "{uv}");
            }
        }
    }
}
