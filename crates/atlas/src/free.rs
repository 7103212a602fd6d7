//! Room for what is new in a layout that otherwise stays: charts go where earlier ones left pages free, and on further
//! pages.

use crate::arrange::{cut, settle};
use crate::charts::sheets;
use crate::hidden::hide;
use crate::keep::Square;
use crate::mask::Mask;
use crate::measure::AS_IT_STANDS;
use crate::pack::{Frame, Page, Shape, Spot, add};
use crate::search::{Cut, MOST_PAGES};
use crate::share::Limits;
use crate::uv::{corners, page};
use crate::{Atlas, Options, Pages, Placement, Seen};
use glam::{DVec2, Vec2};
use layers::Progress;
use rayon::prelude::*;
use scene::Scene;
use std::cmp::Reverse;

/// What needs room.
pub(crate) struct Newcomers<'a> {
    /// Instances whose meshes are laid out anew, all users of a mesh together.
    pub anew: &'a [bool],
    /// Instances that take the coordinates which their mesh has, each with a known instance of that mesh and how much
    /// longer its edges are than that one's.
    pub copies: &'a [(u32, u32, f64)],
    /// Instances that lie together as their file's set says, whose meshes have its coordinates already.
    pub squares: &'a [(Vec<u32>, Square)],
    /// Texels per scene unit of each instance, if it is laid out anew, and whether it may have less.
    pub densities: &'a [(f64, bool)],
}

/// Where what is new does not fit, it is made smaller by this factor and tried again, down to [`LEAST`].
const STEP: f64 = 0.8;
const LEAST: f64 = 0.5;

impl Newcomers<'_> {
    fn density(&self, instance: u32, shrink: f64) -> f64 {
        let (density, flexible) = self.densities[instance as usize];
        if flexible { density * shrink } else { density }
    }
}

/// Adds what is new to an atlas that has no place for it yet; `None` where it does not fit, or was cancelled.
pub(crate) fn insert(
    atlas: &mut Atlas,
    scene: &Scene,
    new: &Newcomers<'_>,
    options: &Options,
    seen: Option<&Seen<'_>>,
    progress: &dyn Progress,
) -> Option<()> {
    let mut sheets = sheets(scene, new.anew, progress).ok()?;
    if let Some(seen) = seen {
        hide(&mut sheets, seen, options.cut_hidden);
        for sheet in &mut sheets {
            sheet.fit_seen(scene);
        }
    }
    let size = f64::from(atlas.page_size);
    let rectangle = |&(_, sibling, ratio): &(u32, u32, f64)| {
        Vec2::from(atlas.placements[sibling as usize].scale).as_dvec2() * ratio
    };
    let rectangles: Vec<DVec2> = new.copies.iter().map(rectangle).collect();
    let pages = taken(scene, atlas, options.gutter);
    let most = match options.pages {
        Pages::Auto => MOST_PAGES,
        Pages::Most(pages) => pages,
    };
    let mut shrink = 1.0;
    let (tiles, charts, spots, count) = loop {
        let density = |instance: u32| new.density(instance, shrink);
        let Cut {
            mut shapes,
            mut groups,
            kept: tiles,
        } = cut(&sheets, options.gutter, |i| Limits::law(density(i)), false);
        let charts = shapes.len();
        for rectangle in &rectangles {
            let texels = (*rectangle * size - 1e-6).ceil().max(DVec2::ONE);
            shapes.push(vec![Mask::full(texels.x as u32, texels.y as u32)]);
            groups.push(groups.last().map_or(0, |last| last + 1));
        }
        for (instances, square) in new.squares {
            let density = density(instances[0]);
            let mask = square.mask(scene, &atlas.meshes, instances, density, atlas.page_size);
            shapes.push(vec![mask]);
            groups.push(groups.last().map_or(0, |last| last + 1));
        }
        if let Some((spots, count)) = fit(&shapes, &groups, pages.clone(), most, progress) {
            break (tiles, charts, spots, count);
        }
        shrink *= STEP;
        if shrink < LEAST || progress.cancelled() {
            return None;
        }
    };
    atlas.page_count = atlas.page_count.max(count);
    for (instance, _) in new.anew.iter().enumerate().filter(|(_, anew)| **anew) {
        atlas.placements[instance] = AS_IT_STANDS;
    }
    let density = |instance: u32| new.density(instance, shrink);
    atlas.audit.specks += settle(atlas, &sheets, &tiles, &spots[..charts], density);
    for ((&(instance, ..), scale), spot) in new.copies.iter().zip(rectangles).zip(&spots[charts..])
    {
        atlas.placements[instance as usize] = Placement {
            page: spot.page,
            scale: scale.as_vec2().to_array(),
            offset: [spot.x, spot.y].map(|t| (f64::from(t) / size) as f32),
        };
    }
    let spots = &spots[charts + new.copies.len()..];
    for ((instances, square), spot) in new.squares.iter().zip(spots) {
        let placed = square.placed(spot, density(instances[0]), atlas.page_size);
        for &instance in instances {
            atlas.placements[instance as usize] = placed;
        }
    }
    Some(())
}

/// The pages of an atlas as they are taken.
fn taken(scene: &Scene, atlas: &Atlas, gutter: u32) -> Vec<Page> {
    let size = atlas.page_size;
    let mut triangles: Vec<Vec<(u32, u32)>> = vec![Vec::new(); atlas.page_count as usize];
    let placed = scene.instances.iter().zip(&atlas.placements).enumerate();
    for (i, (instance, placement)) in placed.filter(|(_, (_, at))| at.is_somewhere()) {
        let layout = &atlas.meshes[instance.mesh as usize];
        for t in 0..layout.triangles.len() {
            // A damaged file may name a page that is none; the audit refuses it.
            if let Some(on) = triangles.get_mut(page(layout, placement, t) as usize) {
                on.push((i as u32, t as u32));
            }
        }
    }
    let page = |on: &Vec<(u32, u32)>| {
        let corners = on.iter().map(|&(i, t)| {
            let (instance, placement) =
                (&scene.instances[i as usize], &atlas.placements[i as usize]);
            let layout = &atlas.meshes[instance.mesh as usize];
            corners(layout, placement, t as usize, f64::from(size))
        });
        let mut page = Page::new(Frame {
            width: size,
            height: size,
            gutter,
            border: gutter,
        });
        page.insert(&Mask::of(corners, size, size), [0, 0]);
        page
    };
    triangles.par_iter().map(page).collect()
}

/// A spot for every shape, and how many pages they take: each group on the first page that has room for all of it, the
/// largest group first.
fn fit(
    shapes: &[Shape],
    groups: &[u32],
    mut pages: Vec<Page>,
    most: u32,
    progress: &dyn Progress,
) -> Option<(Vec<Spot>, u32)> {
    let all: Vec<usize> = (0..shapes.len()).collect();
    let area =
        |members: &[usize]| -> u64 { members.iter().map(|&i| shapes[i][0].grown_area(0)).sum() };
    let mut waiting: Vec<(u64, &[usize])> = all
        .chunk_by(|&a, &b| groups[a] == groups[b])
        .map(|members| (area(members), members))
        .collect();
    waiting.sort_by_key(|(area, members)| (Reverse(*area), members[0]));
    let mut spots = vec![Spot::default(); shapes.len()];
    for (area, members) in waiting {
        let mut number = 0;
        let placed = loop {
            if progress.cancelled() {
                return None;
            }
            let Some(page) = pages.get(number) else {
                if number as u32 >= most {
                    return None;
                }
                let frame = pages[0].frame();
                let mut page = Page::new(frame);
                let placed = add(&mut page, shapes, members).ok()?;
                pages.push(page);
                break placed;
            };
            if page.free() >= area {
                let mut trial = page.clone();
                if let Ok(placed) = add(&mut trial, shapes, members) {
                    pages[number] = trial;
                    break placed;
                }
            }
            number += 1;
        };
        for (&i, spot) in members.iter().zip(placed) {
            spots[i] = Spot {
                page: number as u32,
                ..spot
            };
        }
    }
    Some((spots, pages.len() as u32))
}
