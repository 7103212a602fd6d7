//! Layouts from a UV set of the file: as it stands, or with a rectangle for each object.

use crate::audit::audit;
use crate::measure::{AS_IT_STANDS, charts, density, uv_area, uv_bounds, world_area};
use crate::rectangles::shelves;
use crate::{Atlas, Audit, Error, MeshLayout, Options, Placement, UvSource, Why};
use glam::{DVec2, Vec2};
use scene::{Mesh, Scene};

/// Coordinates this far outside 0..1 are taken for rounding and clamped: a sixtieth of a texel on the largest page.
const ROUNDING: f32 = 1.0 / (1 << 20) as f32;
/// More area than the page has, beyond rounding: triangles overlap.
const FULL: f64 = 1.0 + 1e-6;

/// The layout that the file's set `set` gives.
///
/// Without a density the set is kept as it stands where nothing overlaps over all objects together. Otherwise every
/// object (all parts of a node, or a whole OBJ) gets a rectangle of its own with its charts as they were authored.
pub(crate) fn keep(scene: &Scene, options: &Options, set: u32) -> Result<Atlas, Error> {
    let meshes = layouts(scene, set)?;
    let areas: Vec<f64> = meshes.iter().map(uv_area).collect();
    let chart_count = meshes.iter().map(charts).sum();
    let objects = objects(scene);
    let name = |mesh: u32| scene.meshes[mesh as usize].name.clone();
    let crowded = |instances: &[u32]| {
        let mesh_of = |&i: &u32| scene.instances[i as usize].mesh;
        let pages: f64 = instances.iter().map(|i| areas[mesh_of(i) as usize]).sum();
        (pages > FULL).then(|| Error::Unusable {
            mesh: name(mesh_of(&instances[0])),
            set,
            why: Why::Crowded(pages),
        })
    };
    for object in &objects {
        crowded(object).map_or(Ok(()), Err)?;
    }
    let all: Vec<u32> = (0..scene.instances.len() as u32).collect();
    let mut refusal = crowded(&all);
    let mut atlas = Atlas {
        page_size: options.page_size,
        page_count: 1,
        meshes,
        placements: vec![AS_IT_STANDS; scene.instances.len()],
        source: UvSource::Kept { set },
        audit: Audit::default(),
        density: 0.0,
        chart_count,
        notes: Vec::new(),
    };
    if refusal.is_none() && options.density.is_none() {
        match checked(scene, &mut atlas, set) {
            Ok(()) => return Ok(atlas),
            Err(why) => refusal = Some(why),
        }
    }
    // One object that overlaps with itself overlaps in any rectangle.
    if let Some(why) = refusal {
        if objects.len() == 1 {
            return Err(why);
        }
        atlas.notes.push(format!(
            "each object has a rectangle of its own, for over all objects together {}",
            note(&why)
        ));
    }
    atlas.source = UvSource::Repacked { set };
    repack(scene, &mut atlas, &objects, &areas, options)?;
    checked(scene, &mut atlas, set)?;
    Ok(atlas)
}

/// The refusal of a set without the advice.
pub(crate) fn note(error: &Error) -> String {
    match error {
        Error::Unusable { mesh, set, why } => format!("TEXCOORD_{set} of mesh `{mesh}` {why}"),
        other => other.to_string(),
    }
}

/// Audits the atlas and fills in what it measures.
fn checked(scene: &Scene, atlas: &mut Atlas, set: u32) -> Result<(), Error> {
    let findings = audit(scene, atlas);
    atlas.audit = findings.audit;
    if let Some(mesh) = findings.mesh() {
        let mesh = scene.meshes[mesh as usize].name.clone();
        let Audit {
            overlaps: points,
            missing,
            outside,
            ..
        } = findings.audit;
        let size = atlas.page_size;
        let why = match (points, missing) {
            (0, 0) => Why::Outside(outside),
            (0, missing) => Why::NoArea(missing),
            _ => Why::Overlap { points, size },
        };
        return Err(Error::Unusable { mesh, set, why });
    }
    atlas.density = density(scene, &atlas.meshes, &atlas.placements, atlas.page_size);
    Ok(())
}

/// The set of every mesh that is placed, checked to be finite and within 0..1.
fn layouts(scene: &Scene, set: u32) -> Result<Vec<MeshLayout>, Error> {
    let mut used = vec![false; scene.meshes.len()];
    for instance in &scene.instances {
        used[instance.mesh as usize] = true;
    }
    let layout = |(mesh, used): (&Mesh, bool)| {
        if used {
            own_layout(mesh, set)
        } else {
            Ok(MeshLayout::default())
        }
    };
    scene.meshes.iter().zip(used).map(layout).collect()
}

fn own_layout(mesh: &Mesh, set: u32) -> Result<MeshLayout, Error> {
    let unusable = |why| Error::Unusable {
        mesh: mesh.name.clone(),
        set,
        why,
    };
    let Some(uvs) = mesh.uv_sets.get(set as usize) else {
        return Err(unusable(Why::Absent));
    };
    let usable = |v: Vec2| v.min_element() >= -ROUNDING && v.max_element() <= 1.0 + ROUNDING;
    let mut outside = vec![false; uvs.len()];
    for &v in mesh.triangles.iter().flatten() {
        outside[v as usize] = !usable(uvs[v as usize]);
    }
    let count = outside.iter().filter(|&&o| o).count() as u64;
    if count > 0 {
        return Err(unusable(Why::Outside(count)));
    }
    // Vertices that no triangle uses may hold anything.
    let clamped = |&v: &Vec2| {
        if usable(v) {
            v.clamp(Vec2::ZERO, Vec2::ONE)
        } else {
            Vec2::ZERO
        }
    };
    Ok(MeshLayout {
        source_vertices: (0..uvs.len() as u32).collect(),
        uvs: uvs.iter().map(clamped).collect(),
        triangles: mesh.triangles.clone(),
        triangle_pages: Vec::new(),
    })
}

/// Instances that share one authored square: the parts of one copy of a node. All of an OBJ is one.
fn objects(scene: &Scene) -> Vec<Vec<u32>> {
    let mut objects: Vec<Vec<u32>> = Vec::new();
    let mut known = std::collections::HashMap::new();
    for (i, instance) in scene.instances.iter().enumerate() {
        let object = *known
            .entry((instance.node, instance.copy))
            .or_insert_with(|| {
                objects.push(Vec::new());
                objects.len() - 1
            });
        objects[object].push(i as u32);
    }
    objects
}

/// Gives each object a rectangle with a gutter, all at one density: the one asked for, or the highest that fits one page.
fn repack(
    scene: &Scene,
    atlas: &mut Atlas,
    objects: &[Vec<u32>],
    areas: &[f64],
    options: &Options,
) -> Result<(), Error> {
    let (asked, gutter) = (options.density, options.gutter);
    let shapes: Vec<Shape> = objects
        .iter()
        .map(|object| Shape::of(scene, atlas, object, areas))
        .collect();
    let size = atlas.page_size;
    let attempt = |density: f64| {
        let sizes: Vec<[u32; 2]> = shapes
            .iter()
            .map(|s| s.texels(density, size, gutter))
            .collect();
        let packed = shelves(&sizes, size);
        (sizes, packed)
    };
    let density = match asked {
        Some(density) => density,
        None => {
            let whole: f64 = shapes.iter().map(Shape::area).sum();
            let (mut low, mut high) = (0.0, f64::from(size) / whole.sqrt());
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                match attempt(middle).1 {
                    Some((_, 1)) => low = middle,
                    _ => high = middle,
                }
            }
            low
        }
    };
    let (sizes, packed) = attempt(density);
    let Some((spots, pages)) = packed else {
        let [width, height] = sizes
            .into_iter()
            .max_by_key(|s| s[0].max(s[1]))
            .unwrap_or_default();
        return Err(Error::ChartTooLarge {
            width,
            height,
            size,
        });
    };
    if asked.is_none() && (pages > 1 || density <= 0.0) {
        let charts = objects.len() as u32;
        let holds = |s: &u32| matches!(shelves(&sizes, *s), Some((_, 1)));
        let fits = (1..=14).map(|k| 1 << k).filter(|&s| s > size).find(holds);
        return Err(Error::PageFull { charts, size, fits });
    }
    atlas.page_count = pages;
    for ((object, shape), spot) in objects.iter().zip(&shapes).zip(&spots) {
        let scale = shape.scale * density;
        let corner =
            DVec2::new(f64::from(spot.x + gutter), f64::from(spot.y + gutter)) + margin(size);
        let offset = (corner - shape.low * scale) / f64::from(size);
        for &i in object {
            atlas.placements[i as usize] = Placement {
                page: spot.page,
                scale: [(scale / f64::from(size)) as f32; 2],
                offset: offset.as_vec2().to_array(),
            };
        }
    }
    Ok(())
}

/// The part of its square that an object uses.
struct Shape {
    low: DVec2,
    high: DVec2,
    /// Scene units per unit of the square: times the density, texels.
    scale: f64,
}

impl Shape {
    fn of(scene: &Scene, atlas: &Atlas, object: &[u32], areas: &[f64]) -> Shape {
        let mesh = |i: u32| scene.instances[i as usize].mesh as usize;
        let bounds = object
            .iter()
            .filter_map(|&i| uv_bounds(&atlas.meshes[mesh(i)]));
        let (low, high) = bounds
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
            .unwrap_or_default();
        let world: f64 = object.iter().map(|&i| world_area(scene, i as usize)).sum();
        let square: f64 = object.iter().map(|&i| areas[mesh(i)]).sum();
        let scale = if square > 0.0 {
            (world / square).sqrt()
        } else {
            0.0
        };
        Shape { low, high, scale }
    }

    /// Bounding area in square scene units.
    fn area(&self) -> f64 {
        (self.high - self.low).element_product() * self.scale * self.scale
    }

    /// Size of the rectangle with its gutter.
    fn texels(&self, density: f64, size: u32, gutter: u32) -> [u32; 2] {
        let inner = ((self.high - self.low) * self.scale * density + 2.0 * margin(size)).ceil();
        inner
            .to_array()
            .map(|t| (t.max(1.0) as u32).saturating_add(2 * gutter))
    }
}

/// Room in texels, around the charts of an object, for what 32-bit coordinates round: they stay out of the gutter.
fn margin(size: u32) -> f64 {
    f64::from(size) * 0.5f64.powi(22)
}
