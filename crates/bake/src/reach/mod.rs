//! What the values of a tile depend on, as a fingerprint: tiles of two bakes with the same fingerprint hold the same
//! values, bit for bit.
//!
//! **What goes in.** What the plan decided for the whole bake; the page and the tile's place on it, which number its
//! sample points; of each triangle that meets the tile its coordinates, the content of its object and whether anything
//! stands above it; the closed surfaces whose boxes meet the tile's piece of surface, which may bury it; and the sum
//! over all objects that its rays can reach, by [`ground`].
//!
//! How many rays the tile takes goes in too: with a target, all tiles of a page have a say in that.
//!
//! **Why that is all.** A texel's values are sums over its sample points, which its place numbers, its pieces of
//! surface place and its rays judge. A ray that is not in reach of an object cannot meet it, so leaving it out or
//! moving it there changes no answer; the ray libraries find every triangle that a ray meets whatever tree they hold
//! (their box tests are conservative), and whether a ray meets a triangle is a function of these two alone, but for
//! rays that pass it within rounding (docs/bounces.md, "What an update may keep"). What a texel shares with its
//! neighbours it shares within its tile. What is done to whole pages (mending, denoising, seams, gutters, bounces) is
//! done anew in any case.

mod content;
mod ground;
mod tree;

pub use content::Fingerprint;

use crate::choice::Choice;
use crate::page::Baker;
use atlas::{PageRaster, TilePart};
use blake3::Hasher;
use content::{Content, Feed, contents, numbers};
use glam::DVec3;
use ground::Ground;
use layers::Layer;
use rayon::prelude::*;
use rays::{Patch, Solids, around};
use std::collections::HashMap;
use tree::{BoxTree, Item};

/// Slack of all tests of reach, per unit of the scene's coordinates: far above the rounding of 32-bit rays.
const SLACK: f64 = 1e-5;
/// Above this change of corner weights, samples that keep away from edges may leave the hull of their piece: it counts
/// whole.
const MOVED: f64 = 0.01;

/// The contents of a scene, ready to be asked by tiles.
pub struct Reach<'a> {
    baker: &'a Baker<'a>,
    contents: Vec<Content>,
    tree: BoxTree,
    bodies: Vec<Fingerprint>,
    /// What buries or lays open.
    burying: BoxTree,
    /// By body, the grounds and rooms that bury it, in order.
    roots: HashMap<u32, Vec<u32>>,
    /// What every tile depends on.
    common: Hasher,
    /// The `object` layer holds the numbers of objects.
    numbered: bool,
    slack: f64,
}

impl<'a> Reach<'a> {
    /// Hashes the scene of a bake.
    pub fn of(baker: &'a Baker<'a>) -> Self {
        let world = baker.world;
        let contents = contents(world);
        let items = contents.iter().zip(0..).filter_map(|(content, instance)| {
            let (low, high) = world.box_of(instance)?;
            Some(Item {
                low,
                high,
                sum: u128::from_le_bytes(content.seen),
            })
        });
        let layers = baker.layers();
        let decided = [
            Choice::Sky,
            Choice::Diffuse,
            Choice::Visibility,
            Choice::Specular,
        ]
        .map(|choice| baker.plan.models(choice));
        let mut common = Hasher::new();
        common.update(&numbers(&world.origin().to_array()));
        let words = (&layers, decided, baker.plan.mixture, baker.solids.is_some());
        common.update(format!("{words:?}").as_bytes());
        let bodies = baker.solids.map_or_else(Vec::new, bodies);
        Self {
            baker,
            tree: BoxTree::build(items.collect()),
            contents,
            burying: baker
                .solids
                .map_or_else(BoxTree::default, |solids| burying(solids, &bodies)),
            roots: baker.solids.map_or_else(HashMap::new, roots),
            bodies,
            common,
            numbered: layers.contains(&Layer::Object),
            slack: SLACK * (world.scale_bound() + world.bounds().diagonal()),
        }
    }

    /// The content of each instance of the scene: geometry, coordinates, placement and material.
    pub fn instances(&self) -> impl Iterator<Item = Fingerprint> + '_ {
        self.contents.iter().map(|content| content.own)
    }

    /// The row-major number of every tile of a page, in the order of their indices, and what its values depend on.
    pub fn tiles(&self, page: u32) -> Vec<(u32, Fingerprint)> {
        let raster = self.baker.raster(page);
        let rays = self.baker.rays(page);
        let tile = |index: usize| {
            let fingerprint = self.tile(&raster, page, index, rays[index]);
            (raster.tiles()[index], fingerprint)
        };
        (0..raster.tiles().len())
            .into_par_iter()
            .with_max_len(1)
            .map(tile)
            .collect()
    }

    fn tile(&self, raster: &PageRaster<'_>, page: u32, index: usize, rays: u32) -> Fingerprint {
        let mut hasher = Feed::after(&self.common);
        hasher.update(&rays.to_le_bytes());
        hasher.update(&page.to_le_bytes());
        hasher.update(&raster.tiles()[index].to_le_bytes());
        let mut grounds = Vec::new();
        let mut owns = Vec::new();
        for part in raster.parts(index) {
            let TilePart {
                instance, triangle, ..
            } = part;
            if self.numbered {
                hasher.update(&instance.to_le_bytes());
            }
            hasher.update(&self.contents[instance as usize].own);
            hasher.update(&triangle.to_le_bytes());
            hasher.numbers(part.corners.map(|p| p.to_array()).as_flattened());
            hasher.update(&[self.baker.plan.open.contains(instance, triangle).into()]);
            hasher.update(&[self.baker.world.is_turned_over(instance, triangle).into()]);
            let own = self.baker.solids.and_then(|of| of.own(instance, triangle));
            hasher.update(&own.map_or([0; 16], |body| self.bodies[body as usize]));
            if !owns.contains(&own) {
                owns.push(own);
            }
            let rims = self.baker.solids.map(|of| of.rims(instance, triangle));
            for rim in rims.into_iter().flatten() {
                hasher.numbers(&rim.inward.to_array());
                hasher.numbers(&[rim.at, rim.depth, rim.most]);
            }
            let baker = self.baker;
            let covers = baker.solids.and_then(|of| {
                let covering = baker.covering.as_deref();
                of.covers(covering, (instance, triangle), || f64::INFINITY)
            });
            // Rays may begin above what covers it.
            let lift = covers.map_or(0.0, |covers| covers.above());
            let ground = self.ground(&part, lift);
            let about = covers
                .iter()
                .flat_map(|covers| covers.about(ground.low, ground.high));
            for cover in about {
                hasher.numbers(cover.map(|p| p.to_array()).as_flattened());
            }
            grounds.push(ground);
        }
        let (low, high) = around(grounds.iter().flat_map(|ground| [ground.low, ground.high]));
        if let Some(solids) = self.baker.solids {
            let about = Ground::meeting(low, high);
            hasher.update(&self.burying.sum(&[about]).to_le_bytes());
            // What buries some of the tile's surfaces and not others.
            for own in owns {
                let roots = own.and_then(|own| self.roots.get(&own));
                let meets = |body: &&u32| {
                    let box_of = solids.box_of(**body);
                    box_of.is_some_and(|(low, high)| about.may_see(low, high))
                };
                let roots = roots.into_iter().flatten().filter(meets);
                let mut roots: Vec<Fingerprint> =
                    roots.map(|&body| self.bodies[body as usize]).collect();
                roots.sort_unstable();
                hasher.update(&(roots.len() as u64).to_le_bytes());
                hasher.update(roots.as_flattened());
            }
        }
        hasher.update(&self.tree.sum(&grounds).to_le_bytes());
        hasher.short()
    }

    /// Where rays leave a part of a triangle, or begin at most `lift` above it.
    fn ground(&self, part: &TilePart, lift: f64) -> Ground {
        let baker = self.baker;
        let patch = Patch::of(baker.world, &baker.errors, part.instance, part.triangle);
        let moved = |w: DVec3| (patch.kept(w) - w).abs().max_element();
        let moved = [DVec3::X, DVec3::Y, DVec3::Z]
            .map(moved)
            .into_iter()
            .fold(0.0, f64::max);
        let corners = patch.corners;
        let at = |w: &DVec3| corners[0] * w.x + corners[1] * w.y + corners[2] * w.z;
        let whole = around(corners);
        let (low, high) = match moved > MOVED {
            true => whole,
            false => around(part.hull.iter().map(at)),
        };
        let slack = self.slack + patch.rounding() + 4.0 * moved * (whole.1 - whole.0).length();
        let up = patch.geometric;
        let heights = corners.map(|corner| corner.dot(up));
        let least = heights.into_iter().fold(f64::INFINITY, f64::min) - slack;
        let distance = baker.options.max_distance.map_or(f64::INFINITY, f64::from);
        Ground {
            low: low - slack,
            high: high + slack,
            plane: Some((up, least)),
            distance: distance * (1.0 + SLACK) + slack + lift,
        }
    }
}

/// What decides what each body counts at a point, but for what is rooted in it.
fn bodies(solids: &Solids) -> Vec<Fingerprint> {
    let content = |body| {
        let mut hasher = Feed::default();
        solids.content(body, &mut |bytes| hasher.update(bytes));
        hasher.short()
    };
    let all = 0..solids.bodies();
    let contents: Vec<Fingerprint> = all.into_par_iter().map(content).collect();
    let rooms = solids.rooms().iter();
    let rooms = rooms.map(|&room| u128::from_le_bytes(contents[room as usize]));
    let rooms = rooms.fold(0, u128::wrapping_add);
    let body = |(body, content): (u32, &Fingerprint)| {
        let mut hasher = Feed::default();
        hasher.update(content);
        hasher.update(&[solids.kind(body)]);
        if solids.asks_rooms(body) {
            hasher.update(&rooms.to_le_bytes());
        }
        hasher.short()
    };
    (0..).zip(&contents).map(body).collect()
}

/// A tree of what buries or lays open.
fn burying(solids: &Solids, bodies: &[Fingerprint]) -> BoxTree {
    let item = |(body, content): (u32, &Fingerprint)| {
        let (low, high) = solids.box_of(body)?;
        let sum = u128::from_le_bytes(*content);
        Some(Item { low, high, sum })
    };
    BoxTree::build((0..).zip(bodies).filter_map(item).collect())
}

/// By body, the grounds and rooms that it is rooted in, and the grounds that cut it.
fn roots(solids: &Solids) -> HashMap<u32, Vec<u32>> {
    let mut roots: HashMap<u32, Vec<u32>> = HashMap::new();
    for body in 0..solids.bodies() {
        for &rooted in solids.rooted(body).iter().chain(solids.cut(body)) {
            roots.entry(rooted).or_default().push(body);
        }
    }
    roots
}
