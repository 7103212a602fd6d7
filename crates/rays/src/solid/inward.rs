//! Surfaces whose faces look inward though they are no rooms: which, and which of them are to be turned over. Closed
//! bodies are told by the sign of their volume, others face by face (`wound.rs`).

use super::placed::{Placed, PlacedTree};
use super::topology::{Surface, corners};
use super::weld::Face;
use super::{Body, Inside, Solids};
use glam::DVec3;
use std::collections::{BTreeMap, HashMap, HashSet};

/// A surface of a placement, or of a shape: their numbers.
type Key = (u32, u32);

/// How a triangle's normals stand to its winding.
pub(super) struct Lean {
    /// Its area, below 0 where they lean to the other side, all in all.
    pub area: f64,
    /// All three do.
    is_whole: bool,
}

impl Solids {
    /// An instance and a triangle of each surface whose faces look inward though it is no room.
    pub fn inside_out(&self) -> Vec<(u32, u32)> {
        let turned = self.turned_surfaces();
        let first = |key: Key| {
            let shape = &self.shapes[self.shape_of(key) as usize];
            let mut faces = shape.surfaces[key.1 as usize].faces.iter();
            let is_turned = turned.contains(&key);
            let wound = self.wound_but_for_holes(self.shape_of(key), key.1);
            let wound = wound.faces.first().filter(|_| is_turned);
            let face = wound.or_else(|| faces.find(|face| face.turned != is_turned))?;
            let start = self.firsts[key.0 as usize];
            let mut instances = (start..).zip(&self.instances[start as usize..]);
            instances.find_map(|(instance, of)| {
                let is_it = of.2 == key.0 && shape.meshes[of.1 as usize] == face.mesh;
                is_it.then_some((instance, face.triangle))
            })
        };
        let uneven = (self.placed_keys())
            .filter(|key| !turned.contains(key) && self.surface_of(*key).is_uneven());
        let found = turned.iter().copied().chain(uneven);
        let mut found: Vec<(u32, u32)> = found.filter_map(first).collect();
        found.sort_unstable();
        found
    }

    /// Triangles of each mesh whose back is what one sees, ascending: those of surfaces that are drawn from both
    /// sides and look inward wherever they are placed, though nothing is in them, none of these places and no lamp of
    /// their own, or whose front is blind there (`blind.rs`); and those that look the other way than most of their
    /// surface does, if that is right. From within nobody looks at them, and nothing would be seen there. Of those
    /// that look inward none where a scene has no other surfaces, but for those whose faces look both ways: then they
    /// are all that there is to be seen, and empty rooms.
    pub fn backs(&self, places: &[DVec3]) -> Vec<(u32, Vec<u32>)> {
        let mut turned = self.turned_surfaces();
        let whole = |key: &&Key| {
            let wound = &self.wound_but_for_holes(self.shape_of(**key), key.1).faces;
            wound.is_empty() || wound.len() == self.surface_of(**key).faces.len()
        };
        let is_uneven = |key: Key| self.surface_of(key).is_uneven();
        if self.count_surfaces() == turned.iter().filter(whole).count() {
            turned.retain(|&key| is_uneven(key));
        }
        let blind = self.blind_sheets(places);
        if turned.is_empty() && blind.is_empty() && !self.placed_keys().any(is_uneven) {
            return Vec::new();
        }
        let mut is_back: HashMap<Key, bool> = HashMap::new();
        let casts = |key: &Key| self.scene.instances[self.firsts[key.0 as usize] as usize].casts;
        for key in self.placed_keys().filter(casts) {
            let is_lit = || places.iter().any(|&at| self.is_in_turned(key, at));
            let is_turned = blind.contains(&key) || turned.contains(&key) && !is_lit();
            *is_back.entry((self.shape_of(key), key.1)).or_insert(true) &= is_turned;
        }
        is_back.retain(|&(shape, surface), is_back| {
            let surface = &self.shapes[shape as usize].surfaces[surface as usize];
            (*is_back || surface.is_uneven()) && self.is_drawn_from_both_sides(surface)
        });
        let mut turned: HashSet<(u32, u32, u32)> = HashSet::new();
        for (&(shape, surface), &is_back) in &is_back {
            let of = &self.shapes[shape as usize].surfaces[surface as usize];
            let wound: HashSet<&Face> = match is_back && of.is_mixed() {
                true => self
                    .wound_but_for_holes(shape, surface)
                    .faces
                    .iter()
                    .collect(),
                false => HashSet::new(),
            };
            let is_inward = |face: &Face| is_back && (!of.is_mixed() || wound.contains(face));
            let found = of
                .faces
                .iter()
                .filter(|face| is_inward(face) != face.turned);
            turned.extend(found.map(|face| (shape, face.mesh, face.triangle)));
        }
        let instances = self.scene.instances.iter().zip(&self.instances);
        by_mesh(instances.map(|(instance, &(shape, number, _))| {
            let mesh = self.shapes[shape as usize].meshes[number as usize];
            let count = self.scene.meshes[mesh as usize].triangles.len() as u32;
            let is_turned = |triangle| turned.contains(&(shape, mesh, triangle));
            (instance.mesh, (0..count).map(is_turned).collect())
        }))
    }

    /// Triangles of each mesh, ascending, whose normals point to the other side than the one that is lit, wherever
    /// they are placed. Where a surface looks one way all over by its winding, as a sheet, a body or a room does, and
    /// most of its normals agree, these are the triangles of which all three do not and that are no folds: the smooth
    /// normals of a coarse body lean behind its steepest faces. Where most point the other way, those of bodies that
    /// look outward, are no rooms and have none of these places in them.
    pub fn averse(&self, places: &[DVec3]) -> Vec<(u32, Vec<u32>)> {
        let leans = self.all_leans();
        if leans.is_empty() {
            return Vec::new();
        }
        let folds: HashMap<u32, Vec<u32>> = self.folds().into_iter().collect();
        let placed = self.placed_surfaces();
        let all = PlacedTree::of(placed.iter().collect());
        let is_body = |of: &Placed| {
            let body = self.placements.get(&of.key);
            let inside = body.map(|&body| &self.bodies[body as usize].inside);
            of.surface.content() > 0.0
                && matches!(inside, None | Some(Inside::Solid | Inside::Nothing))
                && !places.iter().any(|&at| self.winding_about(of, at) > 0)
                && !self.is_lived_in(of, 1, &all)
        };
        let mut is_known: HashMap<Key, bool> = HashMap::new();
        let of_keys: HashMap<Key, &Placed> = placed.iter().map(|of| (of.key, of)).collect();
        let instances = self.scene.instances.iter().zip(&self.instances);
        let averse = instances.filter_map(|(instance, &(shape, number, placement))| {
            // Copies of one shape have normals of their own.
            let leans = leans.get(&instance.mesh)?;
            let surfaces = &self.shapes[shape as usize].surface_of[number as usize];
            let mut sums: HashMap<u32, f64> = HashMap::new();
            for (surface, lean) in surfaces.iter().zip(leans) {
                *sums.entry(*surface).or_default() += lean.area;
            }
            let folds = folds.get(&instance.mesh).map_or(&[][..], |of| &of[..]);
            let is_averse = |(triangle, (surface, lean)): (u32, (&u32, &Lean))| {
                let key = (placement, *surface);
                let is_body = || of_keys.get(&key).is_some_and(|of| is_body(of));
                let of = &self.shapes[shape as usize].surfaces[*surface as usize];
                let looks_one_way = of.front.is_some() || of.content() != 0.0 && !of.tangled;
                // Most normals agree with a winding that is one and the same all over the surface, or none is right.
                lean.area < 0.0
                    && folds.binary_search(&triangle).is_err()
                    && match sums[surface] < 0.0 {
                        false => lean.is_whole && looks_one_way,
                        true => *is_known.entry(key).or_insert_with(is_body),
                    }
            };
            let marks = (0..)
                .zip(surfaces.iter().zip(leans))
                .map(is_averse)
                .collect();
            Some((instance.mesh, marks))
        });
        by_mesh(averse)
    }

    /// How the normals of the triangles of each placed mesh lean; of those alone of which some lean to the other side.
    pub(super) fn all_leans(&self) -> HashMap<u32, Vec<Lean>> {
        let mut leans: HashMap<u32, Vec<Lean>> = HashMap::new();
        for instance in &self.scene.instances {
            let mesh = instance.mesh;
            leans.entry(mesh).or_insert_with(|| self.leans(mesh));
        }
        leans.retain(|_, leans| leans.iter().any(|lean| lean.area < 0.0));
        leans
    }

    /// How the normals of a mesh's triangles lean.
    fn leans(&self, mesh: u32) -> Vec<Lean> {
        let of = &self.scene.meshes[mesh as usize];
        let lean = |triangle: u32| {
            let [a, b, c] = corners(&self.scene, Face::of(mesh, triangle));
            let across = (b - a).cross(c - a);
            let vertices = of.triangles[triangle as usize];
            let sides = vertices.map(|vertex| {
                let normal = of.normals.get(vertex as usize);
                normal.map_or(0.0, |normal| normal.dot(across))
            });
            let area = f64::from(across.length());
            Lean {
                area: if sides.iter().sum::<f32>() < 0.0 {
                    -area
                } else {
                    area
                },
                is_whole: sides.iter().all(|side| *side < 0.0),
            }
        };
        (0..of.triangles.len() as u32).map(lean).collect()
    }

    /// Placed surfaces whose faces, or some of them, look inward though they are no rooms.
    fn turned_surfaces(&self) -> HashSet<Key> {
        let bodies = self.placements.iter();
        let bodies = bodies.filter(|(_, body)| self.is_inside_out(&self.bodies[**body as usize]));
        let mut found: HashSet<Key> = bodies.map(|(&key, _)| key).collect();
        found.retain(|&key| {
            let surface = self.surface_of(key);
            // The faces of those that are drawn from one side only are not told apart: they are not turned over.
            !surface.is_mixed() || !self.is_drawn_from_both_sides(surface)
        });
        if !self
            .shapes
            .iter()
            .any(|shape| shape.surfaces.iter().any(Surface::is_mixed))
        {
            return found;
        }
        let placed = self.placed_surfaces();
        let all = PlacedTree::of(placed.iter().collect());
        let is_wound = |of: &&Placed| {
            let body = self.placements.get(&of.key);
            let inside = body.map(|&body| &self.bodies[body as usize].inside);
            let may = matches!(inside, None | Some(Inside::Solid | Inside::Nothing));
            of.surface.is_mixed()
                && may
                && self.is_wound(of, &all)
                && !self.is_lived_in(of, -1, &all)
        };
        found.extend(placed.iter().filter(is_wound).map(|of| of.key));
        found
    }

    /// True where a point of the world lies in what a surface that looks inward encloses.
    fn is_in_turned(&self, key: Key, point: DVec3) -> bool {
        let instance = self.firsts[key.0 as usize] as usize;
        let transform = self.scene.instances[instance].transform;
        let surface = self.surface_of(key);
        let tree = self.tree_of(self.shape_of(key), key.1);
        let local = transform.inverse().transform_point3(point);
        tree.winding(&self.scene, surface.caps.iter().flatten(), local) < 0
    }

    fn shape_of(&self, key: Key) -> u32 {
        self.instances[self.firsts[key.0 as usize] as usize].0
    }

    fn surface_of(&self, key: Key) -> &Surface {
        &self.shapes[self.shape_of(key) as usize].surfaces[key.1 as usize]
    }

    /// All surfaces of all placements.
    fn placed_keys(&self) -> impl Iterator<Item = Key> + '_ {
        let placements = (0..).zip(&self.firsts);
        placements.flat_map(|(placement, &first)| {
            let shape = self.instances[first as usize].0;
            let count = self.shapes[shape as usize].surfaces.len() as u32;
            (0..count).map(move |surface| (placement, surface))
        })
    }

    fn count_surfaces(&self) -> usize {
        self.placed_keys().count()
    }

    fn is_inside_out(&self, body: &Body) -> bool {
        body.inside == Inside::Solid && self.surface(body).volume < 0.0
    }
}

/// By mesh the triangles that are marked wherever it stands, both ascending.
pub(super) fn by_mesh(marked: impl Iterator<Item = (u32, Vec<bool>)>) -> Vec<(u32, Vec<u32>)> {
    let mut found: BTreeMap<u32, Vec<bool>> = BTreeMap::new();
    for (mesh, marks) in marked {
        let known = found.entry(mesh).or_insert_with(|| vec![true; marks.len()]);
        known
            .iter_mut()
            .zip(marks)
            .for_each(|(all, own)| *all &= own);
    }
    let listed = |(mesh, marks): (u32, Vec<bool>)| {
        let marked = (0..).zip(marks).filter(|(_, is_marked)| *is_marked);
        (mesh, marked.map(|(triangle, _)| triangle).collect())
    };
    let listed = found.into_iter().map(listed);
    listed
        .filter(|(_, of): &(u32, Vec<u32>)| !of.is_empty())
        .collect()
}
