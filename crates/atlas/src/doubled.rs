//! Sheets of which every triangle is drawn twice, once for each side: the layers that they lie in.
//!
//! Four triangles meet at each edge inside of such a sheet, where an unwrapper sees no surface that goes on. Each layer
//! by itself is an ordinary one.

use scene::Sets;
use std::collections::HashMap;

/// The layers of some triangles, as their numbers, ascending: none has two triangles with the same corners, and what
/// goes on from one triangle to the next is in one layer. All are in the first where none is doubled.
///
/// * `triangles`: corners as numbers that are equal where their places are.
pub(crate) fn layers(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let all = || (0..triangles.len() as u32).collect();
    let mut copies: HashMap<[u32; 3], Vec<u32>> = HashMap::with_capacity(triangles.len());
    for (number, triangle) in (0..).zip(triangles) {
        copies.entry(sorted(*triangle)).or_default().push(number);
    }
    if copies.len() == triangles.len() {
        return vec![all()];
    }
    let sheets = sheets(triangles);
    let mut members: HashMap<u32, Vec<u32>> = HashMap::new();
    let mut order = Vec::new();
    for (number, &sheet) in (0..).zip(&sheets) {
        let of = members.entry(sheet).or_insert_with(|| {
            order.push(sheet);
            Vec::new()
        });
        of.push(number);
    }
    // Each sheet goes to the first layer that has none of its copies.
    let mut layer_of: Vec<Option<usize>> = vec![None; triangles.len()];
    let mut layers: Vec<Vec<u32>> = Vec::new();
    for sheet in order {
        let own = &members[&sheet];
        let mut taken: Vec<usize> = own
            .iter()
            .flat_map(|&number| &copies[&sorted(triangles[number as usize])])
            .filter_map(|&copy| layer_of[copy as usize])
            .collect();
        taken.sort_unstable();
        taken.dedup();
        let layer = (0..).zip(&taken).find(|(free, layer)| free != *layer);
        let layer = layer.map_or(taken.len(), |(free, _)| free);
        layers.resize_with(layers.len().max(layer + 1), Vec::new);
        layers[layer].extend(own);
        own.iter()
            .for_each(|&number| layer_of[number as usize] = Some(layer));
    }
    layers.iter_mut().for_each(|layer| layer.sort_unstable());
    layers
}

fn sorted(mut triangle: [u32; 3]) -> [u32; 3] {
    triangle.sort_unstable();
    triangle
}

/// For each triangle the first of those that it goes on to, over edges at which that can be told: of those that run
/// along the edge the other way, one alone is no copy of it. Copies are never of one sheet.
fn sheets(triangles: &[[u32; 3]]) -> Vec<u32> {
    let edges = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]];
    let mut along: HashMap<[u32; 2], Vec<u32>> = HashMap::with_capacity(3 * triangles.len());
    for (number, triangle) in (0..).zip(triangles) {
        for edge in edges(*triangle) {
            along.entry(edge).or_default().push(number);
        }
    }
    let next = |number: u32, [a, b]: [u32; 2]| {
        let own = sorted(triangles[number as usize]);
        let others = along.get(&[b, a])?.iter().copied();
        let mut others = others.filter(|&other| sorted(triangles[other as usize]) != own);
        others.next().filter(|_| others.next().is_none())
    };
    let mut sets = Sets::new(triangles.len());
    for (number, triangle) in (0..).zip(triangles) {
        for edge @ [a, b] in edges(*triangle) {
            let other = next(number, edge);
            if let Some(other) = other.filter(|&other| next(other, [b, a]) == Some(number)) {
                sets.join(number, other);
            }
        }
    }
    (0..triangles.len() as u32)
        .map(|at| sets.root(at))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of triangles, and the same turned over.
    fn strip(count: u32) -> [Vec<[u32; 3]>; 2] {
        let turn = |[a, b, c]: [u32; 3]| [a, c, b];
        let one = |k: u32| {
            if k.is_multiple_of(2) {
                [k, k + 1, k + 2]
            } else {
                [k + 1, k, k + 2]
            }
        };
        let front: Vec<[u32; 3]> = (0..count).map(one).collect();
        let back = front.iter().copied().map(turn).collect();
        [front, back]
    }

    #[test]
    fn each_side_of_a_doubled_sheet_is_a_layer_however_they_are_listed() {
        let [front, back] = strip(6);
        assert_eq!(layers(&front), [(0..6).collect::<Vec<u32>>()]);
        let apart = [front.clone(), back.clone()].concat();
        let sides: [Vec<u32>; 2] = [(0..6).collect(), (6..12).collect()];
        assert_eq!(layers(&apart), sides);
        // In turns, the first of each pair being of either side.
        let pairs = front.iter().zip(&back).enumerate();
        let mixed: Vec<[u32; 3]> = pairs
            .flat_map(|(k, (f, b))| {
                if k.is_multiple_of(3) {
                    [*f, *b]
                } else {
                    [*b, *f]
                }
            })
            .collect();
        let is_front = |number: &u32| front.contains(&mixed[*number as usize]);
        let found = layers(&mixed);
        assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), [6, 6]);
        for layer in &found {
            assert!(
                layer.iter().all(is_front) || !layer.iter().any(is_front),
                "{found:?}"
            );
        }
        // A third copy of one triangle is a layer of its own.
        let third = [apart, vec![front[2]]].concat();
        assert_eq!(layers(&third).len(), 3);
        assert_eq!(layers(&[]), [Vec::<u32>::new()]);
    }
}
