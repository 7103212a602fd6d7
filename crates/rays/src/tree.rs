//! Box trees of obvhs, made conservative: a ray that meets a box's content always reaches that content.
//!
//! obvhs is exact neither about boxes nor about scale: it compares rounded slab distances without a margin, drops what
//! lies nearer than 1e-4, raises small direction components to 1.2e-7 and quantises wide nodes. So a tree lives in its
//! own units. Its content is centred and scaled to a sphere of radius [`RADIUS`]; a ray starts where it enters that
//! sphere, with a direction of length 1; every box is padded by at least [`PAD`]. With u = 2^-24 all roundings together
//! (the ray's origin and direction, the slab's differences, products and inverses, the node grid) move a plane by less
//! than 32 u times the radius, which is 2 units: less than the pad. A box is left at least 2 units after its content
//! is met, so the near cut never shows. Triangles are tested outside of the tree, in the world's units, by the caller.

use crate::mix::Mix;
use crate::triangle::ShearedRay;
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::bvh2::{Bvh2, DEFAULT_MAX_STACK_DEPTH};
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::ray::{Ray, RayHit};

/// Radius of the sphere around the content, in tree units.
const RADIUS: f64 = 1_048_576.0;
/// The least distance from a box's content to its planes, in tree units.
const PAD: f64 = 4.0;
/// Directions are kept this far from 0 on each axis: over the whole tree that is 2^-38 units.
const SMALLEST: f64 = 1.0 / (1u64 << 60) as f64;
/// obvhs stacks 32 groups, overwrites the last when full, and pushes at most one a level.
const WIDE_LEVELS: usize = 31;

/// Boxes with a tree above them.
pub(crate) struct Tree {
    nodes: Nodes,
    center: DVec3,
    /// Radius in the content's units.
    radius: f64,
    /// Tree units per unit of the content.
    scale: f64,
}

enum Nodes {
    Wide(CwBvh),
    Binary(Bvh2),
}

/// A ray in tree units.
struct Entry {
    ray: Ray,
    /// Distance from the origin to the tree's ray, in the content's units.
    start: f64,
    /// Content units per unit of t.
    length: f64,
}

impl Tree {
    /// A tree over `count` boxes (lowest and highest corner), and the order in which [`Tree::any`] and
    /// [`Tree::nearest`] number them.
    ///
    /// `wide` asks for eight children a node; a tree too deep for obvhs's fixed stack stays binary.
    pub fn build(
        count: usize,
        box_of: impl Fn(usize) -> [DVec3; 2],
        wide: bool,
    ) -> (Self, Vec<u32>) {
        Self::build_limited(count, box_of, wide.then_some(WIDE_LEVELS))
    }

    fn build_limited(
        count: usize,
        box_of: impl Fn(usize) -> [DVec3; 2],
        wide_levels: Option<usize>,
    ) -> (Self, Vec<u32>) {
        let whole = (0..count)
            .map(&box_of)
            .reduce(|[low, high], [min, max]| [low.min(min), high.max(max)]);
        let [low, high] = whole.unwrap_or_default();
        let center = (low + high) * 0.5;
        let reach = (high - low).length() * 0.5;
        let radius = if reach > 0.0 {
            reach * (1.0 + 1e-6)
        } else {
            1.0
        };
        let scale = RADIUS / radius;
        let padded: Vec<Aabb> = (0..count)
            .map(|index| {
                let [min, max] = box_of(index);
                let [below, above] = pads(index as u64);
                let min = (min - center) * scale - below;
                let max = (max - center) * scale + above;
                Aabb::new(min.as_vec3a(), max.as_vec3a())
            })
            .collect();
        let (nodes, order) = grow(&padded, wide_levels);
        (
            Self {
                nodes,
                center,
                radius,
                scale,
            },
            order,
        )
    }

    /// True as soon as `hits` is true for a box that the ray may meet before `t_max`.
    #[inline]
    pub fn any(&self, sight: ShearedRay, t_max: f64, mut hits: impl FnMut(usize) -> bool) -> bool {
        let Some(entry) = self.enter(&sight, t_max) else {
            return false;
        };
        let test = |_: &Ray, index: usize| {
            if hits(index) {
                f32::NEG_INFINITY
            } else {
                f32::INFINITY
            }
        };
        match &self.nodes {
            Nodes::Wide(nodes) => !nodes.ray_traverse_miss(entry.ray, test),
            Nodes::Binary(nodes) => !nodes.ray_traverse_miss(entry.ray, test),
        }
    }

    /// Calls `visit` for boxes that the ray may meet before `t_max`, or before the t that `visit` has returned.
    #[inline]
    pub fn nearest(
        &self,
        sight: ShearedRay,
        t_max: f64,
        mut visit: impl FnMut(usize) -> Option<f64>,
    ) {
        let Some(entry) = self.enter(&sight, t_max) else {
            return;
        };
        let (start, length) = (entry.start, entry.length);
        let test = |_: &Ray, index: usize| match visit(index) {
            Some(t) => self.limit(t, start, length),
            None => f32::INFINITY,
        };
        let mut hit = RayHit::none();
        match &self.nodes {
            Nodes::Wide(nodes) => nodes.ray_traverse(entry.ray, &mut hit, test),
            Nodes::Binary(nodes) => nodes.ray_traverse(entry.ray, &mut hit, test),
        };
    }

    /// Bytes of the nodes.
    pub fn memory_bytes(&self) -> u64 {
        let bytes = match &self.nodes {
            Nodes::Wide(nodes) => size_of_val(&*nodes.nodes),
            Nodes::Binary(nodes) => size_of_val(&*nodes.nodes) + size_of_val(&*nodes.parents),
        };
        bytes as u64
    }

    /// The ray in tree units; `None` where it passes the sphere by, ends before it, or has no direction.
    #[inline]
    fn enter(&self, sight: &ShearedRay, t_max: f64) -> Option<Entry> {
        let ShearedRay {
            origin, direction, ..
        } = *sight;
        let length = direction.length();
        let toward = direction / length;
        let inward = self.center - origin;
        let along = inward.dot(toward);
        let aside = (inward - toward * along).length_squared();
        let start = (along - self.radius).max(0.0);
        // Written so that a NaN, from a ray that is not finite or has no direction, is a miss.
        let meets =
            aside <= self.radius * self.radius && along >= -self.radius && start <= t_max * length;
        if !meets {
            return None;
        }
        let tmax = self.limit(t_max, start, length);
        let origin = ((origin - self.center + toward * start) * self.scale).as_vec3a();
        let direction = DVec3::from_array(toward.to_array().map(away_from_zero)).as_vec3a();
        let ray = Ray {
            origin,
            direction,
            inv_direction: Vec3A::ONE / direction,
            tmin: 0.0,
            tmax,
        };
        Some(Entry { ray, start, length })
    }

    /// A distance in tree units that is past everything within `t`, and past the near cut.
    #[inline]
    fn limit(&self, t: f64, start: f64, length: f64) -> f32 {
        ((t * length - start) * self.scale + PAD).clamp(PAD, 8.0 * RADIUS) as f32
    }
}

/// Without a component that obvhs would take for 0. A negative zero becomes positive: obvhs's wide nodes take its sign
/// from a comparison and its inverse from the sign bit, and then see every box inside out.
#[inline]
fn away_from_zero(x: f64) -> f64 {
    if x < 0.0 {
        x.min(-SMALLEST)
    } else {
        x.max(SMALLEST)
    }
}

/// Pads of one box, each in `PAD..2 PAD`. They differ from box to box, for obvhs pairs equal boxes one a pass, in
/// quadratic time and with linear depth.
fn pads(index: u64) -> [DVec3; 2] {
    let mut mix = Mix(index);
    let mut next = || PAD * (1.0 + mix.unit());
    [
        DVec3::new(next(), next(), next()),
        DVec3::new(next(), next(), next()),
    ]
}

/// The steps of obvhs's medium build, without its debug validation, whose absolute tolerances do not suit our units.
fn grow(boxes: &[Aabb], wide_levels: Option<usize>) -> (Nodes, Vec<u32>) {
    let indices = (0..boxes.len() as u32).collect();
    let mut binary = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        boxes,
        indices,
        SortPrecision::U64,
        3,
    );
    // The optimiser's stack and the conversion's recursion are sized for trees of ordinary depth.
    let ordinary = binary.max_depth <= DEFAULT_MAX_STACK_DEPTH;
    let mut optimizer = ReinsertionOptimizer::default();
    if ordinary {
        optimizer.run(&mut binary, 0.05, None);
    }
    if let Some(levels) = wide_levels.filter(|_| ordinary) {
        let mut wide = bvh2_to_cwbvh(&binary, 3, true, false);
        if wide_depth(&wide) <= levels {
            wide.nodes.shrink_to_fit();
            let order = std::mem::take(&mut wide.primitive_indices);
            return (Nodes::Wide(wide), order);
        }
    }
    if ordinary {
        collapse(&mut binary, 8, 3.0);
        optimizer.run(&mut binary, 0.1, None);
    }
    binary.parents = Vec::new();
    // Reinsertion moves nodes down after obvhs has noted the depth by which it sizes the stack.
    binary.max_depth = binary_depth(&binary) + 1;
    let order = std::mem::take(&mut binary.primitive_indices);
    (Nodes::Binary(binary), order)
}

/// Levels of nodes.
fn binary_depth(tree: &Bvh2) -> usize {
    levels(tree.nodes.len(), |index, children| {
        let node = &tree.nodes[index as usize];
        if !node.is_leaf() {
            children.extend([node.first_index, node.first_index + 1]);
        }
    })
}

/// Levels of wide nodes.
fn wide_depth(tree: &CwBvh) -> usize {
    levels(tree.nodes.len(), |index, children| {
        let node = &tree.nodes[index as usize];
        let inner = (0..8).filter(|&child| !node.is_leaf(child));
        children.extend(inner.map(|child| node.child_node_index(child)));
    })
}

/// Levels of a tree of `count` nodes whose root is node 0; `children` appends the inner children of a node.
fn levels(count: usize, children: impl Fn(u32, &mut Vec<u32>)) -> usize {
    let mut level = if count == 0 { Vec::new() } else { vec![0] };
    let mut levels = 0;
    while !level.is_empty() {
        levels += 1;
        let mut next = Vec::new();
        for index in level {
            children(index, &mut next);
        }
        level = next;
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit_box(index: usize) -> [DVec3; 2] {
        let low = DVec3::new(index as f64 * 2.0, 0.0, 0.0);
        [low, low + DVec3::ONE]
    }

    #[test]
    fn a_tree_too_deep_for_the_fixed_stack_stays_binary() {
        let (tree, _) = Tree::build_limited(200, unit_box, Some(1));
        assert!(matches!(tree.nodes, Nodes::Binary(_)));
        let (tree, _) = Tree::build(200, unit_box, true);
        assert!(matches!(tree.nodes, Nodes::Wide(_)));
    }

    #[test]
    fn equal_boxes_make_a_shallow_tree() {
        for wide in [true, false] {
            let (tree, order) = Tree::build(5000, |_| [DVec3::ZERO, DVec3::ONE], wide);
            assert_eq!(order.len(), 5000);
            let depth = match &tree.nodes {
                Nodes::Wide(nodes) => wide_depth(nodes),
                Nodes::Binary(nodes) => binary_depth(nodes),
            };
            assert!(depth < 60, "{depth} levels");
        }
    }

    #[test]
    fn a_single_point_is_a_tree() {
        let (tree, order) = Tree::build(1, |_| [DVec3::ONE; 2], true);
        assert_eq!(order, [0]);
        assert!(tree.any(ShearedRay::new(DVec3::ZERO, DVec3::ONE), 1.0, |_| true));
        assert!(!tree.any(
            ShearedRay::new(DVec3::ZERO, DVec3::NEG_ONE),
            f64::INFINITY,
            |_| true
        ));
    }
}
