//! A tree of boxes around the objects of a scene, each with a sum over what stands in it.
//!
//! The sum of hashes says which objects are there, whatever their order. A box that is in reach as a whole gives its
//! sum at once, and one that is out of reach nothing, so few boxes are looked at.

use super::ground::Ground;
use glam::DVec3;

/// An object's box and the number that stands for its content.
#[derive(Debug, Clone, Copy)]
pub(super) struct Item {
    pub low: DVec3,
    pub high: DVec3,
    pub sum: u128,
}

/// A tree of boxes; without nodes where there are no objects.
#[derive(Debug, Default)]
pub(super) struct BoxTree(Vec<Node>);

#[derive(Debug)]
struct Node {
    item: Item,
    /// `None` for an object's own box.
    children: Option<[usize; 2]>,
}

impl BoxTree {
    pub fn build(mut items: Vec<Item>) -> Self {
        let mut tree = Self::default();
        if !items.is_empty() {
            tree.add(&mut items);
        }
        tree
    }

    /// Adds the subtree of some items and returns its place.
    fn add(&mut self, items: &mut [Item]) -> usize {
        let item = items.iter().copied().reduce(|a, b| Item {
            low: a.low.min(b.low),
            high: a.high.max(b.high),
            sum: a.sum.wrapping_add(b.sum),
        });
        let Some(item) = item else {
            unreachable!("a node stands for an item at least");
        };
        let place = self.0.len();
        self.0.push(Node {
            item,
            children: None,
        });
        if items.len() > 1 {
            let size = item.high - item.low;
            let axis = size.max_position();
            let middle = items.len() / 2;
            let centre = |item: &Item| item.low[axis] + item.high[axis];
            items.select_nth_unstable_by(middle, |a, b| centre(a).total_cmp(&centre(b)));
            let (left, right) = items.split_at_mut(middle);
            let children = [self.add(left), self.add(right)];
            self.0[place].children = Some(children);
        }
        place
    }

    /// The sum over all objects that one of the grounds may see.
    pub fn sum(&self, grounds: &[Ground]) -> u128 {
        match self.0.is_empty() {
            true => 0,
            false => self.sum_of(0, grounds),
        }
    }

    fn sum_of(&self, place: usize, grounds: &[Ground]) -> u128 {
        let Node { item, children } = &self.0[place];
        if !grounds
            .iter()
            .any(|ground| ground.may_see(item.low, item.high))
        {
            return 0;
        }
        match children {
            Some([a, b]) if !grounds.iter().any(|g| g.sees_all(item.low, item.high)) => {
                let left = self.sum_of(*a, grounds);
                left.wrapping_add(self.sum_of(*b, grounds))
            }
            _ => item.sum,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_sums_what_a_look_at_every_object_sums() {
        let mut state = 1u64;
        let mut random = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        let items: Vec<Item> = (0..200)
            .map(|k| {
                let low = DVec3::new(random(), random(), random()) * 10.0;
                Item {
                    low,
                    high: low + DVec3::new(random(), random(), random()),
                    sum: 1 << (k % 128),
                }
            })
            .collect();
        let tree = BoxTree::build(items.clone());
        for k in 0..200 {
            let point = DVec3::new(random(), random(), random()) * 10.0;
            let normal = DVec3::new(random() - 0.5, random() - 0.5, random() - 0.5).normalize();
            let ground = Ground {
                low: point,
                high: point + 0.1,
                plane: (k % 2 == 0).then(|| (normal, normal.dot(point))),
                distance: if k % 3 == 0 {
                    f64::INFINITY
                } else {
                    3.0 * random()
                },
            };
            let seen = items
                .iter()
                .filter(|item| ground.may_see(item.low, item.high));
            let plain = seen.fold(0u128, |sum, item| sum.wrapping_add(item.sum));
            assert_eq!(tree.sum(&[ground]), plain, "{k}");
        }
        assert_eq!(BoxTree::build(Vec::new()).sum(&[]), 0);
    }
}
