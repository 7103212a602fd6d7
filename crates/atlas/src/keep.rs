//! Layouts from a UV set of the file: as it stands, or with a rectangle for each object.

use crate::audit::audit;
use crate::mask::Mask;
use crate::measure::{AS_IT_STANDS, chart_count, density, uv_area, uv_bounds};
use crate::objects::{Object, extent};
use crate::pack::Spot;
use crate::search::{Cut, Found, search};
use crate::uv::corners;
use crate::{Atlas, Audit, Error, MeshLayout, Options, Placement, UvSource, Why};
use glam::{DVec2, Vec2};
use layers::Progress;
use scene::{Mesh, Scene};

/// Coordinates this far outside 0..1 are taken for rounding and clamped: a sixtieth of a texel on the largest page.
const ROUNDING: f32 = 1.0 / (1 << 20) as f32;
/// More area than the page has, beyond rounding: triangles overlap.
const FULL: f64 = 1.0 + 1e-6;

/// The layout that the file's set `set` gives.
///
/// Without a density the set is kept as it stands where nothing overlaps over all objects together. Otherwise every
/// object (all parts of a node, or a whole OBJ) gets a rectangle of its own with its charts as they were authored.
pub(crate) fn keep(
    scene: &Scene,
    objects: &[Object],
    options: &Options,
    set: u32,
    progress: &dyn Progress,
) -> Result<Atlas, Error> {
    let mut included = vec![true; scene.instances.len()];
    for object in objects.iter().filter(|o| !o.included) {
        for &i in &object.instances {
            included[i as usize] = false;
        }
    }
    let meshes = layouts(scene, &included, set)?;
    let areas: Vec<f64> = meshes.iter().map(uv_area).collect();
    let chart_count = meshes.iter().map(chart_count).sum();
    let squares = squares(scene, objects);
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
    for square in &squares {
        crowded(&square.instances).map_or(Ok(()), Err)?;
    }
    let all: Vec<u32> = squares.iter().flat_map(|s| &s.instances).copied().collect();
    let mut refusal = crowded(&all);
    let mut atlas = Atlas {
        page_size: options.page_size,
        page_count: 1,
        gutter: options.gutter,
        meshes,
        placements: included
            .iter()
            .map(|&i| if i { AS_IT_STANDS } else { Placement::NOWHERE })
            .collect(),
        source: UvSource::Kept { set },
        audit: Audit::default(),
        density: 0.0,
        chart_count,
        notes: Vec::new(),
    };
    let asked = objects.iter().any(|o| o.asked.is_some());
    if refusal.is_none() && !asked {
        match checked(scene, &mut atlas, set) {
            Ok(()) => return Ok(atlas),
            Err(why) => refusal = Some(why),
        }
    }
    // One object that overlaps with itself overlaps in any rectangle.
    if let Some(why) = refusal {
        if squares.len() == 1 {
            return Err(why);
        }
        atlas.notes.push(format!(
            "each object has a rectangle of its own, for over all objects together {}",
            note(&why)
        ));
    }
    atlas.source = UvSource::Repacked { set };
    for square in &squares {
        let mixed = |&i: &u32| objects[object_of(objects, i)].asked != square.asked;
        if square.instances.iter().any(mixed) {
            let mesh = name(scene.instances[square.instances[0] as usize].mesh);
            return Err(Error::Unusable {
                mesh,
                set,
                why: Why::Shared,
            });
        }
    }
    repack(scene, &mut atlas, &squares, &areas, options, progress)?;
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
fn layouts(scene: &Scene, included: &[bool], set: u32) -> Result<Vec<MeshLayout>, Error> {
    let mut used = vec![false; scene.meshes.len()];
    for (instance, &included) in scene.instances.iter().zip(included) {
        used[instance.mesh as usize] |= included;
    }
    let layout = |(mesh, used): (&Mesh, bool)| match used {
        true => own_layout(mesh, set),
        false => Ok(MeshLayout::without_texels(mesh)),
    };
    scene.meshes.iter().zip(used).map(layout).collect()
}

/// The set of a mesh, checked alike.
pub(crate) fn own_layout(mesh: &Mesh, set: u32) -> Result<MeshLayout, Error> {
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
        hidden: Vec::new(),
    })
}

/// The object of an instance.
fn object_of(objects: &[Object], instance: u32) -> usize {
    let holds = |o: &Object| o.instances.binary_search(&instance).is_ok();
    objects
        .iter()
        .position(holds)
        .expect("every instance has an object")
}

/// Objects that share one authored square, taken together: the parts of one copy of a node. All of an OBJ is one.
pub(crate) fn squares(scene: &Scene, objects: &[Object]) -> Vec<Object> {
    let mut squares: Vec<Object> = Vec::new();
    let mut known = std::collections::HashMap::new();
    for object in objects.iter().filter(|o| o.included) {
        let first = &scene.instances[object.instances[0] as usize];
        let square = *known.entry((first.node, first.copy)).or_insert_with(|| {
            squares.push(Object {
                instances: Vec::new(),
                area: 0.0,
                ..object.clone()
            });
            squares.len() - 1
        });
        squares[square].instances.extend(&object.instances);
        squares[square].area += object.area;
    }
    for square in &mut squares {
        square.instances.sort_unstable();
        square.extent = extent(scene, &square.instances);
    }
    squares
}

/// Gives each square a place of its own at its density.
fn repack(
    scene: &Scene,
    atlas: &mut Atlas,
    squares: &[Object],
    areas: &[f64],
    options: &Options,
    progress: &dyn Progress,
) -> Result<(), Error> {
    let shapes: Vec<Square> = squares
        .iter()
        .map(|square| Square::of(scene, &atlas.meshes, square, areas))
        .collect();
    let size = options.page_size;
    let cut = |densities: &[f64], _: bool| {
        let cut = |((square, shape), &density): ((&Object, &Square), &f64)| {
            vec![shape.mask(scene, &atlas.meshes, &square.instances, density, size)]
        };
        let shapes = squares
            .iter()
            .zip(&shapes)
            .zip(densities)
            .map(cut)
            .collect();
        Ok(Cut {
            shapes,
            groups: (0..squares.len() as u32).collect(),
            kept: (),
        })
    };
    let Found {
        densities, packed, ..
    } = search(squares, options, progress, cut)?;
    atlas.page_count = packed.pages.max(1);
    for (((square, shape), spot), density) in squares
        .iter()
        .zip(&shapes)
        .zip(&packed.spots)
        .zip(densities)
    {
        for &i in &square.instances {
            atlas.placements[i as usize] = shape.placed(spot, density, size);
        }
    }
    Ok(())
}

/// The part of its square that an object uses.
pub(crate) struct Square {
    low: DVec2,
    high: DVec2,
    /// Scene units per unit of the square: times the density, texels.
    scale: f64,
}

impl Square {
    /// Of an object whose meshes have these coordinates, of these areas in the square.
    pub fn of(scene: &Scene, meshes: &[MeshLayout], object: &Object, areas: &[f64]) -> Self {
        let mesh = |i: &u32| scene.instances[*i as usize].mesh as usize;
        let instances = &object.instances;
        let bounds = instances.iter().filter_map(|i| uv_bounds(&meshes[mesh(i)]));
        let (low, high) = bounds
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
            .unwrap_or_default();
        let square: f64 = instances.iter().map(|i| areas[mesh(i)]).sum();
        let scale = match square > 0.0 {
            true => (object.area / square).sqrt(),
            false => 0.0,
        };
        Self { low, high, scale }
    }

    /// The texels that its charts touch at a density.
    pub fn mask(
        &self,
        scene: &Scene,
        meshes: &[MeshLayout],
        instances: &[u32],
        density: f64,
        size: u32,
    ) -> Mask {
        let scale = self.scale * density;
        let room = ((self.high - self.low) * scale + 2.0 * margin(size))
            .ceil()
            .max(DVec2::ONE);
        let triangles = instances.iter().flat_map(|&i| {
            let layout = &meshes[scene.instances[i as usize].mesh as usize];
            (0..layout.triangles.len()).map(move |t| {
                corners(layout, &AS_IT_STANDS, t, 1.0)
                    .map(|p| (p - self.low) * scale + margin(size))
            })
        });
        Mask::of(triangles, room.x as u32, room.y as u32)
    }

    /// Where its instances lie on a page once its mask has its spot.
    pub fn placed(&self, spot: &Spot, density: f64, size: u32) -> Placement {
        let scale = self.scale * density;
        let corner = DVec2::new(f64::from(spot.x), f64::from(spot.y)) + margin(size);
        let offset = (corner - self.low * scale) / f64::from(size);
        Placement {
            page: spot.page,
            scale: [(scale / f64::from(size)) as f32; 2],
            offset: offset.as_vec2().to_array(),
        }
    }
}

/// Room in texels, around the charts of an object, for what 32-bit coordinates round: they stay out of the gutter.
fn margin(size: u32) -> f64 {
    f64::from(size) * 0.5f64.powi(22)
}
