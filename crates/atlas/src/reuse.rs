//! The layout of an earlier version of a scene, for what is the same in both: charts stay where they are.

use crate::audit::audit;
use crate::free::{Newcomers, insert};
use crate::keep::{Square, own_layout, squares};
use crate::measure::{AS_IT_STANDS, chart_count, density, sum, uv_area};
use crate::objects::{Object, object_names, objects};
use crate::share::{FLOOR, GIVEN};
use crate::{Atlas, Error, MeshLayout, Options, Placement, Seen, UvMode, UvSource};
use glam::DVec3;
use scene::{Mesh, Scene};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Areas and edges that differ by less than this share are the same: an object may be moved, and rounding move its
/// corners.
const SAME: f64 = 1e-3;

/// What decides how an instance is laid out, apart from where it stands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Name of its object.
    object: String,
    /// Its mesh: index into the scene's.
    mesh: u32,
    /// Hash of the mesh's triangles and coordinates.
    charts: String,
    /// Surface in square scene units, the sum of the squares of its triangles' areas, and the length of all edges: what
    /// no movement changes.
    shape: [f64; 3],
    /// Texels per scene unit that were asked for it by name.
    asked: Option<f64>,
    /// It takes texels.
    included: bool,
}

/// What each instance of a scene claims, in their order.
///
/// # Errors
///
/// As [`crate::layout`], for names and densities that do not fit the scene.
pub fn claims(scene: &Scene, options: &Options) -> Result<Vec<Claim>, Error> {
    let charts: Vec<String> = scene.meshes.iter().map(charts_hash).collect();
    let mut claims = vec![None; scene.instances.len()];
    let named = object_names(scene).into_iter();
    for (object, name) in objects(scene, options)?.into_iter().zip(named) {
        for &instance in &object.instances {
            let mesh = scene.instances[instance as usize].mesh;
            claims[instance as usize] = Some(Claim {
                object: name.name.clone(),
                mesh,
                charts: charts[mesh as usize].clone(),
                shape: shape(scene, instance as usize),
                asked: object.asked,
                included: object.included,
            });
        }
    }
    Ok(claims.into_iter().flatten().collect())
}

/// The layout of a scene that keeps the places which an earlier one gave to what is the same in both.
///
/// Instances that are gone leave their places free. What is new, has another shape or is asked for at another density
/// goes into free space, and on further pages where there is none. It gets the density that its object had, else the
/// median of the earlier objects', within what [`crate::layout`] gives every object at least and at most. A mesh that
/// stood once and now stands twice is laid out anew for both.
///
/// `None` where all of the scene must be laid out anew: the file's own coordinates were kept and something is new, or
/// it does not fit.
pub fn reuse(
    earlier: &Atlas,
    before: &[Claim],
    scene: &Scene,
    now: &[Claim],
    options: &Options,
    seen: Option<&Seen<'_>>,
) -> Option<Atlas> {
    if before.len() != earlier.placements.len() || now.len() != scene.instances.len() {
        return None;
    }
    let places = same(before, now);
    let mut meshes: Vec<MeshLayout> = Vec::with_capacity(scene.meshes.len());
    let mut placements = vec![Placement::NOWHERE; now.len()];
    let mut anew = vec![false; now.len()];
    let mut copies = Vec::new();
    let mut joining = Vec::new();
    let set = match earlier.source {
        UvSource::Kept { set } | UvSource::Repacked { set } => Some(set),
        UvSource::Apart { .. } | UvSource::Unwrapped => None,
    };
    let mut users = vec![Vec::new(); scene.meshes.len()];
    for (instance, claim) in now.iter().enumerate() {
        users[claim.mesh as usize].push(instance);
    }
    for (mesh, users) in scene.meshes.iter().zip(users) {
        let known = || users.iter().filter_map(|&i| Some((i, places[i]?)));
        let mut sources = known().map(|(_, place)| before[place].mesh);
        let source = sources.next().and_then(|source| {
            // All instances of a mesh share its coordinates.
            let layout = earlier.meshes.get(source as usize)?;
            let same = sources.all(|other| other == source);
            let fits = layout.triangles.len() == mesh.triangles.len()
                && layout
                    .source_vertices
                    .iter()
                    .all(|&v| (v as usize) < mesh.positions.len());
            (same && fits).then_some(layout)
        });
        // One that stood alone has its charts all over the page.
        let tile = known().find(|&(_, place)| {
            let at = earlier.placements[place];
            at.is_somewhere() && at != AS_IT_STANDS
        });
        let news = users
            .iter()
            .filter(|&&i| places[i].is_none() && now[i].included);
        let own = set.and_then(|set| own_layout(mesh, set).ok());
        match (source, tile) {
            (Some(layout), _) if news.clone().next().is_none() => meshes.push(layout.clone()),
            _ if own.is_some() => {
                meshes.extend(own);
                joining.extend(news.map(|&i| i as u32));
            }
            // What has no usable coordinates of its own is unwrapped where that is allowed.
            _ if set.is_some() && options.uv == UvMode::Keep => return None,
            (Some(layout), Some((sibling, _))) => {
                meshes.push(layout.clone());
                let edge = |i: usize| now[i].shape[0].sqrt();
                let least = known().map(|(i, _)| edge(i)).fold(f64::INFINITY, f64::min);
                for &i in news {
                    // No smaller than the smallest, whose gutters are just wide enough.
                    copies.push((i as u32, sibling as u32, edge(i).max(least) / edge(sibling)));
                }
            }
            _ => {
                meshes.push(MeshLayout::without_texels(mesh));
                users.iter().for_each(|&i| anew[i] = now[i].included);
                continue;
            }
        }
        for (i, place) in known() {
            placements[i] = earlier.placements[place];
        }
    }
    let mut atlas = Atlas {
        placements,
        meshes,
        ..earlier.clone()
    };
    let mut squares = Vec::new();
    if let Some(set) = set.filter(|_| !joining.is_empty())
        && !join(&mut atlas, scene, &joining)
    {
        squares = squares_of(&atlas, scene, now, &joining, options)?;
        atlas.source = UvSource::Repacked { set };
    }
    if anew.contains(&true) || !copies.is_empty() || !squares.is_empty() {
        let densities = densities(earlier, before, scene, now, options);
        let new = Newcomers {
            anew: &anew,
            copies: &copies,
            squares: &squares,
            densities: &densities,
        };
        insert(&mut atlas, scene, &new, options, seen, &())?;
    }
    let findings = audit(scene, &atlas);
    if !findings.clean() {
        return None;
    }
    atlas.chart_count = atlas.meshes.iter().map(chart_count).sum();
    atlas.audit.texels = findings.audit.texels;
    atlas.density = density(scene, &atlas.meshes, &atlas.placements, atlas.page_size);
    Some(atlas)
}

/// Lays instances out as the file's set stands, where the set was kept so and nothing overlaps; true where that is so.
fn join(atlas: &mut Atlas, scene: &Scene, joining: &[u32]) -> bool {
    if !matches!(atlas.source, UvSource::Kept { .. }) {
        return false;
    }
    let place = |atlas: &mut Atlas, at: Placement| {
        for &instance in joining {
            atlas.placements[instance as usize] = at;
        }
    };
    place(atlas, AS_IT_STANDS);
    let clean = audit(scene, atlas).clean();
    if !clean {
        place(atlas, Placement::NOWHERE);
    }
    clean
}

/// The parts of authored squares that these instances are, each to be placed by itself.
fn squares_of(
    atlas: &Atlas,
    scene: &Scene,
    now: &[Claim],
    joining: &[u32],
    options: &Options,
) -> Option<Vec<(Vec<u32>, Square)>> {
    let areas: Vec<f64> = atlas.meshes.iter().map(uv_area).collect();
    let mut found = Vec::new();
    for object in squares(scene, &objects(scene, options).ok()?) {
        let new = |instance: &u32| joining.contains(instance);
        let instances: Vec<u32> = object.instances.iter().copied().filter(new).collect();
        if instances.is_empty() {
            continue;
        }
        let area = instances.iter().map(|&i| now[i as usize].shape[0]).sum();
        let part = Object {
            instances,
            area,
            ..object
        };
        let square = Square::of(scene, &atlas.meshes, &part, &areas);
        found.push((part.instances, square));
    }
    Some(found)
}

/// The earlier instance that each one is; `None` for what is new or differs.
fn same(before: &[Claim], now: &[Claim]) -> Vec<Option<usize>> {
    let mut known: HashMap<_, Vec<usize>> = HashMap::new();
    for (place, claim) in before.iter().enumerate().rev() {
        let key = (&claim.object, &claim.charts);
        known.entry(key).or_default().push(place);
    }
    let mut places = Vec::with_capacity(now.len());
    for claim in now {
        let own = known.get_mut(&(&claim.object, &claim.charts));
        let place = own.and_then(Vec::pop);
        places.push(place.filter(|&place| claim.stays(&before[place])));
    }
    places
}

/// Texels per scene unit of each instance, if it is laid out anew, and true where nobody asked for them.
fn densities(
    earlier: &Atlas,
    before: &[Claim],
    scene: &Scene,
    now: &[Claim],
    options: &Options,
) -> Vec<(f64, bool)> {
    let edge = f64::from(earlier.page_size);
    // Texels and surface of each object that had any.
    let mut had: HashMap<&str, [f64; 2]> = HashMap::new();
    for (claim, placement) in before.iter().zip(&earlier.placements) {
        let layout = earlier.meshes.get(claim.mesh as usize);
        if let Some(layout) = layout.filter(|_| placement.is_somewhere()) {
            let [u, v] = placement.scale.map(f64::from);
            let sums = had.entry(&claim.object).or_default();
            sums[0] += uv_area(layout) * u * v * edge * edge;
            sums[1] += claim.shape[0];
        }
    }
    let of = |[texels, surface]: [f64; 2]| (texels / surface).sqrt();
    let mut all: Vec<f64> = had
        .values()
        .copied()
        .map(of)
        .filter(|d| d.is_normal())
        .collect();
    all.sort_by(f64::total_cmp);
    let median = all.get(all.len() / 2).copied().unwrap_or(1.0);
    let mut densities = vec![(0.0, false); now.len()];
    for object in object_names(scene) {
        let surface: f64 = (object.instances.iter())
            .map(|&instance| now[instance as usize].shape[0])
            .sum();
        let floor = (FLOOR / surface).sqrt();
        let most = ((1.0 - GIVEN) / surface).sqrt() * edge;
        for &instance in &object.instances {
            let claim = &now[instance as usize];
            let own = had
                .get(&*claim.object)
                .copied()
                .map(of)
                .filter(|d| d.is_normal());
            let asked = claim.asked.or(options.density);
            // One density for all knows neither least nor most.
            let usual = if options.even {
                median
            } else {
                median.max(floor).min(most)
            };
            let density = asked.or(own).unwrap_or(usual);
            densities[instance as usize] = (density, asked.is_none());
        }
    }
    densities
}

impl Claim {
    /// True where the earlier place serves the claim.
    fn stays(&self, earlier: &Claim) -> bool {
        let near = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME * a.abs().max(b.abs());
        self.asked == earlier.asked
            && self.included == earlier.included
            && self.shape.iter().zip(&earlier.shape).all(near)
    }
}

fn charts_hash(mesh: &Mesh) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(mesh.positions.len() as u64).to_le_bytes());
    for triangle in &mesh.triangles {
        hasher.update(triangle.map(u32::to_le_bytes).as_flattened());
    }
    for set in &mesh.uv_sets {
        for uv in set {
            hasher.update(uv.to_array().map(f32::to_le_bytes).as_flattened());
        }
        hasher.update(b"set");
    }
    hasher.finalize().to_hex().to_string()
}

/// See [`Claim::shape`].
fn shape(scene: &Scene, instance: usize) -> [f64; 3] {
    let placed = &scene.instances[instance];
    let mesh = &scene.meshes[placed.mesh as usize];
    let shape = sum(mesh.triangles.len(), |t| {
        let at = |v: u32| mesh.positions[v as usize].as_dvec3();
        let [a, b, c] = mesh.triangles[t].map(|v| placed.transform.transform_vector3(at(v)));
        let area = 0.5 * (b - a).cross(c - a).length();
        let edges = (b - a).length() + (c - b).length() + (a - c).length();
        DVec3::new(area, area * area, edges)
    });
    shape.to_array()
}
