//! Areas of objects in the world and on their pages.

use crate::uv::{corners, twice_area};
use crate::{Atlas, MeshLayout, Placement};
use glam::{DAffine3, DVec2, Vec2};
use rayon::prelude::*;
use scene::{Mesh, Scene, Sets};
use std::iter::Sum;

/// A placement that leaves coordinates as they are.
pub(crate) const AS_IT_STANDS: Placement = Placement {
    page: 0,
    scale: [1.0; 2],
    offset: [0.0; 2],
};

/// Numbers that one thread adds up at a time.
const ADDED: usize = 1 << 16;

/// The sum of `of` over `0..count`, which no number of threads changes.
pub(crate) fn sum<T: Sum + Send>(count: usize, of: impl Fn(usize) -> T + Sync) -> T {
    let parts = (0..count.div_ceil(ADDED)).into_par_iter();
    let part = |part: usize| {
        let own = part * ADDED..count.min((part + 1) * ADDED);
        own.map(&of).sum()
    };
    parts.map(part).collect::<Vec<T>>().into_iter().sum()
}

/// Surface area of an object in the world, in square scene units.
pub(crate) fn world_area(scene: &Scene, instance: usize) -> f64 {
    let instance = &scene.instances[instance];
    area(&scene.meshes[instance.mesh as usize], &instance.transform)
}

/// Surface area of a mesh in its own space.
pub(crate) fn mesh_area(scene: &Scene, mesh: usize) -> f64 {
    area(&scene.meshes[mesh], &DAffine3::IDENTITY)
}

fn area(mesh: &Mesh, transform: &DAffine3) -> f64 {
    sum(mesh.triangles.len(), |t| placed_area(mesh, transform, t))
}

/// Surface area of a triangle of an instance in the world.
pub(crate) fn triangle_area(scene: &Scene, instance: usize, triangle: usize) -> f64 {
    let instance = &scene.instances[instance];
    placed_area(
        &scene.meshes[instance.mesh as usize],
        &instance.transform,
        triangle,
    )
}

fn placed_area(mesh: &Mesh, transform: &DAffine3, triangle: usize) -> f64 {
    let corner = |v: u32| transform.transform_vector3(mesh.positions[v as usize].as_dvec3());
    let [a, b, c] = mesh.triangles[triangle].map(corner);
    0.5 * (b - a).cross(c - a).length()
}

/// Area that a layout takes of its own square.
pub(crate) fn uv_area(layout: &MeshLayout) -> f64 {
    sum(layout.triangles.len(), |t| {
        0.5 * twice_area(corners(layout, &AS_IT_STANDS, t, 1.0)).abs()
    })
}

/// Bounds of a layout in its own square; `None` without triangles.
pub(crate) fn uv_bounds(layout: &MeshLayout) -> Option<(DVec2, DVec2)> {
    layout
        .triangles
        .iter()
        .flatten()
        .map(|&v| layout.uvs[v as usize].as_dvec2())
        .map(|p| (p, p))
        .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// The chart of each triangle of a layout, numbered from 0 in the order of triangles: sets of triangles that hang
/// together by corners at one coordinate.
pub fn charts(layout: &MeshLayout) -> Vec<u32> {
    // Adding 0 makes -0 equal to it.
    let place = |v: u32| (layout.uvs[v as usize] + 0.0).to_array().map(f32::to_bits);
    let mut sets = Sets::new(layout.uvs.len());
    let mut order: Vec<u32> = (0..layout.uvs.len() as u32).collect();
    order.par_sort_unstable_by_key(|&v| (place(v), v));
    for pair in order.windows(2) {
        if place(pair[0]) == place(pair[1]) {
            sets.join(pair[0], pair[1]);
        }
    }
    for &[a, b, c] in &layout.triangles {
        sets.join(a, b);
        sets.join(b, c);
    }
    let mut numbers = vec![u32::MAX; layout.uvs.len()];
    let mut count = 0;
    let number = |&[a, _, _]: &[u32; 3]| {
        let number = &mut numbers[sets.root(a) as usize];
        if *number == u32::MAX {
            *number = count;
            count += 1;
        }
        *number
    };
    layout.triangles.iter().map(number).collect()
}

/// Texels of the rectangles about the charts that have the most, at most `count` of them, the largest first.
pub fn largest_charts(scene: &Scene, atlas: &Atlas, count: usize) -> Vec<u64> {
    let largest_first = |mut areas: Vec<DVec2>| {
        areas.par_sort_by(|a, b| b.element_product().total_cmp(&a.element_product()));
        areas.truncate(count);
        areas
    };
    // Placements scale all charts of a mesh alike, so that its largest are those of each of its objects.
    let of_layout = |layout: &MeshLayout| {
        let charts = charts(layout);
        let most = charts.iter().max().map_or(0, |&last| last as usize + 1);
        let none = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let mut bounds = vec![none; most];
        for (triangle, chart) in layout.triangles.iter().zip(charts) {
            let (low, high) = &mut bounds[chart as usize];
            for &v in triangle {
                let uv = layout.uvs[v as usize].as_dvec2();
                (*low, *high) = (low.min(uv), high.max(uv));
            }
        }
        let sizes = bounds.into_iter().map(|(low, high)| high - low);
        largest_first(sizes.collect())
    };
    let meshes: Vec<Vec<DVec2>> = atlas.meshes.par_iter().map(of_layout).collect();
    let objects = scene.instances.iter().zip(&atlas.placements);
    let placed = objects.filter(|(_, placement)| placement.is_somewhere());
    let sizes = placed.flat_map(|(object, placement)| {
        let scale = Vec2::from(placement.scale).as_dvec2() * f64::from(atlas.page_size);
        // What a border cuts is a texel too.
        let texels = move |size: &DVec2| (*size * scale).ceil() + 1.0;
        meshes[object.mesh as usize].iter().map(texels)
    });
    let sizes = largest_first(sizes.collect());
    sizes.iter().map(|s| s.element_product() as u64).collect()
}

/// Number of charts of a layout.
pub(crate) fn chart_count(layout: &MeshLayout) -> u32 {
    charts(layout).into_iter().max().map_or(0, |last| last + 1)
}

/// Texels per scene unit that a layout reaches: the mean over the surface of the square root of texel area by area.
pub(crate) fn density(
    scene: &Scene,
    meshes: &[MeshLayout],
    placements: &[Placement],
    size: u32,
) -> f64 {
    let objects = scene.instances.iter().zip(placements);
    let objects = objects.filter(|(_, placement)| placement.is_somewhere());
    let sums = objects.map(|(instance, placement)| {
        let layout = &meshes[instance.mesh as usize];
        let mesh = &scene.meshes[instance.mesh as usize];
        sum(layout.triangles.len(), |triangle| {
            let area = placed_area(mesh, &instance.transform, triangle);
            let texels = 0.5 * twice_area(corners(layout, placement, triangle, f64::from(size)));
            DVec2::new((texels.abs() * area).sqrt(), area)
        })
    });
    let [root, area] = sums.sum::<DVec2>().to_array();
    if area > 0.0 { root / area } else { 0.0 }
}
