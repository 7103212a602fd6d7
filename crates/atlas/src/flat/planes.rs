//! The planes of a mesh, and the junctions where they meet in other ways than by edges of two triangles.

use crate::flatten::{NONE, Welded};
use glam::DVec3;
use rayon::prelude::*;
use scene::around;

/// Cosine of the largest angle between normals of one plane: a quarter of a degree.
const ONE_PLANE: f64 = 1.0 - 1e-5;
/// Corners lie in a plane or on a line that is nearer than this share of the mesh. Files round by less.
const NEAR: f64 = 1e-6;
/// Cells of normals and of planes' places in which borders are looked for together.
const NORMALS: f64 = 1e3;
const PLACES: f64 = 1e4;

/// For each triangle the largest of those that lie in its plane and hang together with it by edges of two triangles.
pub(super) fn planes(surface: &Welded) -> Vec<u32> {
    let mut seeds: Vec<u32> = (0..surface.triangles.len() as u32).collect();
    seeds.par_sort_unstable_by(|&a, &b| {
        let areas = surface.areas[b as usize].total_cmp(&surface.areas[a as usize]);
        areas.then(a.cmp(&b))
    });
    let mut of = vec![NONE; surface.triangles.len()];
    let mut waiting = Vec::new();
    for seed in seeds {
        if of[seed as usize] != NONE {
            continue;
        }
        let normal = surface.normals[seed as usize];
        let corner = |c: u32| surface.corners[c as usize];
        let origin = corner(surface.triangles[seed as usize][0]);
        let is_flat = |t: u32| {
            let turned = surface.normals[t as usize].dot(normal);
            let corners = surface.triangles[t as usize].map(corner);
            let lies = || {
                corners
                    .iter()
                    .all(|&p| (p - origin).dot(normal).abs() <= NEAR)
            };
            // The normal of a thin triangle says little.
            turned >= ONE_PLANE || (turned > 0.0 && lies())
        };
        of[seed as usize] = seed;
        waiting.push(seed);
        while let Some(t) = waiting.pop() {
            for beside in surface.neighbours[t as usize] {
                if beside != NONE && of[beside as usize] == NONE && is_flat(beside) {
                    of[beside as usize] = seed;
                    waiting.push(beside);
                }
            }
        }
    }
    of
}

/// Two borders of one plane that run along one another.
#[derive(Clone, Copy)]
pub(super) struct Junction {
    pub triangles: [u32; 2],
    /// What they have in common.
    pub length: f64,
    /// Corners of one that lie on the edge of the other, and the ends of that edge.
    pub on: [Option<(u32, [u32; 2])>; 2],
}

/// An edge of a triangle, in its direction, beyond which its plane does not go on by a neighbour.
#[derive(Clone, Copy)]
struct Border {
    triangle: u32,
    ends: [u32; 2],
    low: DVec3,
    high: DVec3,
    normal: DVec3,
}

/// Where planes meet in other ways than by edges of two triangles.
pub(super) fn junctions(surface: &Welded, planes: &[u32]) -> Vec<Junction> {
    let mut sizes = vec![0u32; planes.len()];
    planes.iter().for_each(|&plane| sizes[plane as usize] += 1);
    let borders = |t: usize| {
        let beside = surface.neighbours[t];
        let plane = planes[t] as usize;
        // A facet of a curved surface has no junctions.
        let is_facet = sizes[plane] == 1 && !beside.contains(&NONE);
        let sides = if is_facet || surface.areas[t] == 0.0 {
            0
        } else {
            3
        };
        let border = move |k: usize| {
            let corners = surface.triangles[t];
            let ends = [corners[k], corners[(k + 1) % 3]];
            let goes_on = beside[k] != NONE && planes[beside[k] as usize] as usize == plane;
            let [a, b] = ends.map(|end| surface.corners[end as usize]);
            (!goes_on && ends[0] != ends[1]).then_some(Border {
                triangle: t as u32,
                ends,
                low: a.min(b),
                high: a.max(b),
                normal: surface.normals[plane],
            })
        };
        (0..sides).filter_map(border)
    };
    let all = (0..planes.len()).into_par_iter();
    let borders: Vec<Border> = all.flat_map_iter(borders).collect();
    let place = |corner: u32| surface.corners[corner as usize];
    // What lies on both sides of a cell's wall lies in one cell of a grid beside it.
    let found = [0.0, 0.5].map(|shift| {
        let cell = |k: u32| {
            let border = &borders[k as usize];
            let at = place(border.ends[0]).dot(border.normal) * PLACES;
            let [x, y, z] = (border.normal * NORMALS).to_array();
            ([x, y, z, at].map(|x| (x + shift).floor() as i32), k)
        };
        let mut cells: Vec<([i32; 4], u32)> = (0..borders.len() as u32)
            .into_par_iter()
            .map(cell)
            .collect();
        cells.par_sort_unstable();
        let cells: Vec<&[([i32; 4], u32)]> = cells.chunk_by(|a, b| a.0 == b.0).collect();
        let among = |cell: &[([i32; 4], u32)]| {
            let own = cell.iter().map(|&(_, k)| borders[k as usize]);
            meeting(surface, own.collect())
        };
        let found: Vec<Vec<Junction>> = cells.into_par_iter().map(among).collect();
        found.concat()
    });
    let mut found = found.concat();
    found.sort_unstable_by_key(|junction| (junction.triangles, junction.on));
    found.dedup_by_key(|junction| (junction.triangles, junction.on));
    found
}

/// The junctions of some borders.
fn meeting(surface: &Welded, mut borders: Vec<Border>) -> Vec<Junction> {
    let (low, high) = around(borders.iter().flat_map(|border| [border.low, border.high]));
    let axis = (high - low).max_position();
    borders.sort_unstable_by(|a, b| {
        let order = a.low[axis].total_cmp(&b.low[axis]);
        order.then((a.triangle, a.ends).cmp(&(b.triangle, b.ends)))
    });
    let mut found = Vec::new();
    for (k, a) in borders.iter().enumerate() {
        let beside = borders[k + 1..].iter();
        for b in beside.take_while(|b| b.low[axis] <= a.high[axis] + NEAR) {
            let meet = a.low.cmple(b.high + NEAR) & b.low.cmple(a.high + NEAR);
            if meet.all() && a.triangle != b.triangle {
                found.extend(junction(surface, [a, b]));
            }
        }
    }
    found
}

fn junction(surface: &Welded, pair: [&Border; 2]) -> Option<Junction> {
    let place = |corner: u32| surface.corners[corner as usize];
    let length = |border: &Border| place(border.ends[0]).distance(place(border.ends[1]));
    let [long, short] = match length(pair[0]) < length(pair[1]) {
        true => [pair[1], pair[0]],
        false => pair,
    };
    let start = place(long.ends[0]);
    let along = (place(long.ends[1]) - start).try_normalize()?;
    let reach = length(long);
    let [from, to] = short.ends.map(|end| (place(end) - start).dot(along));
    let lies = |end: u32| (place(end) - start).reject_from_normalized(along).length() <= NEAR;
    let common = from.min(reach) - to.max(0.0);
    // Triangles that lie on both sides run along an edge in opposite directions.
    let is_one = from > to && common > NEAR && short.ends.into_iter().all(lies);
    if !is_one || long.normal.dot(short.normal) < ONE_PLANE {
        return None;
    }
    let on = [(short.ends[0], from), (short.ends[1], to)].map(|(end, at)| {
        let is_within = (0.0..=reach).contains(&at) && !long.ends.contains(&end);
        is_within.then_some((end, long.ends))
    });
    Some(Junction {
        triangles: [long.triangle, short.triangle],
        length: common,
        on,
    })
}
