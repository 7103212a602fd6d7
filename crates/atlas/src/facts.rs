//! What an artist asks of a layout first: where the texels went.

use crate::Atlas;
use crate::mask::Mask;
use crate::measure::{sum, triangle_area};
use crate::objects::{extent, object_names};
use crate::uv::{corners, page, twice_area};
use glam::DVec3;
use scene::Scene;

/// Where the texels of a layout went.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Share of the pages' texels that a chart touches or that are its gutter, 0..=1.
    pub page_use: f64,
    /// Share of the pages' area inside charts, 0..=1.
    pub covered: f64,
    /// Triangles with an area of less than one texel, over all objects that take texels, without what nobody sees.
    pub small_triangles: u64,
    /// Every object, in the order of the scene.
    pub objects: Vec<ObjectFacts>,
}

/// Where the texels of an object went.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectFacts {
    /// Its name, with `#2` and so on for repeats.
    pub name: String,
    /// Area on the pages in texels; 0 for an object that takes none.
    pub texels: f64,
    /// Texels per scene unit: the square root of its texels by its surface, without what of it nobody sees and what
    /// therefore has next to none. 0 where nobody sees any of it.
    pub density: f64,
    /// Its part of all objects' texels, 0..=1.
    pub share: f64,
    /// Texels across its longest extent.
    pub across: f64,
}

/// Measures a layout.
pub fn facts(scene: &Scene, atlas: &Atlas) -> Facts {
    let size = f64::from(atlas.page_size);
    let mut small_triangles = 0;
    let mut objects = Vec::new();
    for object in object_names(scene) {
        let somewhere = |i: &u32| atlas.placements[*i as usize].is_somewhere();
        let instances: Vec<u32> = object.instances.iter().copied().filter(somewhere).collect();
        // Texels and surface, and how many triangles have less than one; of all or of those that somebody sees.
        let over = |all: bool| -> DVec3 {
            let of = |i: u32| {
                let (instance, placement) =
                    (&scene.instances[i as usize], &atlas.placements[i as usize]);
                let layout = &atlas.meshes[instance.mesh as usize];
                sum(layout.triangles.len(), |triangle| {
                    if !all && layout.hidden.get(triangle) == Some(&true) {
                        return DVec3::ZERO;
                    }
                    let texels = 0.5 * twice_area(corners(layout, placement, triangle, size)).abs();
                    let surface = triangle_area(scene, i as usize, triangle);
                    DVec3::new(texels, surface, f64::from(u8::from(texels < 1.0)))
                })
            };
            instances.iter().map(|&i| of(i)).sum()
        };
        let (texels, seen) = (over(true).x, over(false));
        small_triangles += seen.z as u64;
        let density = match seen.y > 0.0 {
            true => (seen.x / seen.y).sqrt(),
            false => 0.0,
        };
        objects.push(ObjectFacts {
            across: density * extent(scene, &object.instances),
            name: object.name,
            texels,
            density,
            share: 0.0,
        });
    }
    let all: f64 = objects.iter().map(|o| o.texels).sum();
    for object in &mut objects {
        object.share = if all > 0.0 { object.texels / all } else { 0.0 };
    }
    let pages = size * size * f64::from(atlas.page_count);
    let used: u64 = (0..atlas.page_count)
        .map(|number| used(scene, atlas, number))
        .sum();
    Facts {
        page_use: used as f64 / pages,
        covered: all / pages,
        small_triangles,
        objects,
    }
}

/// Texels of a page that a chart touches or that are its gutter.
fn used(scene: &Scene, atlas: &Atlas, number: u32) -> u64 {
    let size = atlas.page_size;
    let objects = scene.instances.iter().zip(&atlas.placements);
    let triangles = objects
        .filter(|(_, placement)| placement.page <= number)
        .flat_map(|(instance, placement)| {
            let layout = &atlas.meshes[instance.mesh as usize];
            (0..layout.triangles.len())
                .filter(move |&t| page(layout, placement, t) == number)
                .map(move |t| corners(layout, placement, t, f64::from(size)))
        });
    let mask = Mask::of(triangles, size, size);
    let mut row = Vec::new();
    let gutter = atlas.gutter;
    (gutter..size + gutter)
        .map(|y| {
            mask.grown_row(y, gutter, &mut row);
            let inside = |x: u32| x.clamp(gutter, size + gutter);
            row.iter()
                .map(|&[a, b]| u64::from(inside(b) - inside(a)))
                .sum::<u64>()
        })
        .sum()
}
