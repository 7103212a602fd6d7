//! A tree over boxes that stay where they are: which of them meet a box.

use glam::DVec3;
use scene::around;

/// Boxes in a leaf.
const LEAF: usize = 4;

/// Boxes by their number, from 0.
#[derive(Debug, Default)]
pub struct Boxes {
    nodes: Vec<Node>,
    /// Boxes with their numbers, leaf by leaf.
    items: Vec<Item>,
}

#[derive(Debug, Clone, Copy)]
struct Item {
    low: DVec3,
    high: DVec3,
    number: u32,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    low: DVec3,
    high: DVec3,
    /// First item of a leaf; the first of two children of another.
    first: u32,
    /// Items of a leaf; 0 of another.
    count: u32,
}

impl Boxes {
    /// A tree over numbered boxes, each by its lowest and its highest corner.
    pub fn of(boxes: impl Iterator<Item = (u32, DVec3, DVec3)>) -> Self {
        let item = |(number, low, high)| Item { low, high, number };
        let mut items: Vec<Item> = boxes.map(item).collect();
        if items.is_empty() {
            return Self::default();
        }
        let mut nodes = vec![Node::around(&items, 0)];
        let mut pending = vec![(0, 0, items.len())];
        while let Some((node, start, end)) = pending.pop() {
            let part = &mut items[start..end];
            if part.len() <= LEAF {
                continue;
            }
            let middle = |item: &Item| item.low + item.high;
            let (low, high) = around(part.iter().map(middle));
            let axis = (high - low).max_position();
            let half = part.len() / 2;
            part.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
            let children = nodes.len() as u32;
            nodes.push(Node::around(&part[..half], start));
            nodes.push(Node::around(&part[half..], start + half));
            (nodes[node].first, nodes[node].count) = (children, 0);
            pending.push((children as usize, start, start + half));
            pending.push((children as usize + 1, start + half, end));
        }
        Self { nodes, items }
    }

    /// The numbers of the boxes that meet a box, if only in a point, ascending.
    pub fn meeting(&self, low: DVec3, high: DVec3) -> Vec<u32> {
        let mut found = Vec::new();
        self.any(low, high, |number| {
            found.push(number);
            false
        });
        found.sort_unstable();
        found
    }

    /// Hands over the numbers of the boxes that meet a box, if only in a point, until one is taken; false where none
    /// is.
    pub fn any(&self, low: DVec3, high: DVec3, mut take: impl FnMut(u32) -> bool) -> bool {
        if self.nodes.is_empty() {
            return false;
        }
        // Halves of halves: 32 levels for as many boxes as numbers reach.
        let mut pending = [0u32; 64];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[pending[depth] as usize];
            if !meets((node.low, node.high), (low, high)) {
                continue;
            }
            if node.count == 0 {
                (pending[depth], pending[depth + 1]) = (node.first, node.first + 1);
                depth += 2;
                continue;
            }
            let items = &self.items[node.first as usize..(node.first + node.count) as usize];
            for item in items {
                if meets((item.low, item.high), (low, high)) && take(item.number) {
                    return true;
                }
            }
        }
        false
    }
}

fn meets(a: (DVec3, DVec3), b: (DVec3, DVec3)) -> bool {
    a.0.cmple(b.1).all() && a.1.cmpge(b.0).all()
}

impl Node {
    /// A leaf of items of which the first is number `first` of all.
    fn around(items: &[Item], first: usize) -> Self {
        let (low, high) = around(items.iter().flat_map(|item| [item.low, item.high]));
        Self {
            low,
            high,
            first: first as u32,
            count: items.len() as u32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mix::Mix;

    #[test]
    fn the_tree_finds_what_a_look_at_every_box_finds() {
        let mut mix = Mix(1);
        let mut point = |size: f64| DVec3::new(mix.unit(), mix.unit(), mix.unit()) * size;
        // Grids of whole numbers, so that many boxes only touch.
        let boxes: Vec<(DVec3, DVec3)> = (0..300)
            .map(|_| {
                let low = point(20.0).floor();
                (low, low + point(4.0).floor())
            })
            .collect();
        let numbered = (0..).zip(&boxes);
        let tree = Boxes::of(numbered.map(|(number, &(low, high))| (number, low, high)));
        for k in 0..200 {
            let low = point(20.0).floor();
            let high = low + point(f64::from(k % 7)).floor();
            let plain: Vec<u32> = (0..boxes.len() as u32)
                .filter(|&number| meets(boxes[number as usize], (low, high)))
                .collect();
            assert_eq!(tree.meeting(low, high), plain, "{low} to {high}");
            let last = plain.last().copied();
            let is_last = |number| Some(number) == last;
            assert_eq!(tree.any(low, high, is_last), last.is_some());
        }
        let (nothing, all) = (Boxes::of(std::iter::empty()), DVec3::INFINITY);
        assert!(nothing.meeting(-all, all).is_empty());
        assert_eq!(tree.meeting(-all, all).len(), boxes.len());
    }
}
