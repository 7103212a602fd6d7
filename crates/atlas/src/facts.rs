//! What an artist asks of a layout first: where the texels went.

use crate::Atlas;
use crate::mask::Mask;
use crate::measure::{sum, world_area};
use crate::objects::{extent, object_names};
use crate::uv::{corners, page, twice_area};
use glam::DVec2;
use scene::Scene;

/// Where the texels of a layout went.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Share of the pages' texels that a chart touches or that are its gutter, 0..=1.
    pub page_use: f64,
    /// Share of the pages' area inside charts, 0..=1.
    pub covered: f64,
    /// Triangles with an area of less than one texel, over all objects that take texels.
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
    /// Texels per scene unit: the square root of its texels by its surface.
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
        let (mut texels, mut surface) = (0.0, 0.0);
        for &i in &object.instances {
            let (instance, placement) =
                (&scene.instances[i as usize], &atlas.placements[i as usize]);
            let layout = &atlas.meshes[instance.mesh as usize];
            if !placement.is_somewhere() {
                continue;
            }
            let [small, area] = sum(layout.triangles.len(), |triangle| {
                let area = 0.5 * twice_area(corners(layout, placement, triangle, size)).abs();
                DVec2::new(f64::from(u8::from(area < 1.0)), area)
            })
            .to_array();
            small_triangles += small as u64;
            texels += area;
            surface += world_area(scene, i as usize);
        }
        let density = if surface > 0.0 {
            (texels / surface).sqrt()
        } else {
            0.0
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
