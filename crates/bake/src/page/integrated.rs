//! A tile of a page: its texels surveyed and integrated, and what the page keeps of it.

use super::baker::Baker;
use super::compose::BakedTexel;
use super::directional;
use super::stats::PageStats;
use super::surveys::Texels;
use super::terms::finds_seals;
use super::tile::{BakedTile, Column, Columns};
use crate::choice::Choice;
use crate::integrate::{Coat, Task, Terms, integrate, seals};
use crate::options::{AmbientCoefficient, Footprint, Model, View};
use crate::survey::{Surveyor, Texel};
use ambient::closed_form::phong_open;
use ambient::sampling::Stream;
use atlas::{PageRaster, Tile};
use glam::DVec3;
use layers::Layer;
use pulp::Arch;

/// What makes the points of pilots independent of the others.
const PILOTS: u64 = 0x9e37_79b9_7f4a_7c15;

/// The texels of a tile with what their rays found, one number of each list for each texel.
pub(super) struct Integrated {
    pub texels: Texels,
    pub terms: Vec<Terms>,
    coats: Vec<Coat>,
    sealed: Vec<f32>,
    /// The specular term of an open texel with this material and view; 0 where it does not reflect specularly.
    open_specular: Vec<f64>,
}

impl Baker<'_> {
    /// The footprints of a tile.
    fn cut(&self, raster: &PageRaster<'_>, index: usize) -> Tile {
        let surveyor = self.surveyor();
        match self.options.footprint {
            Footprint::Texel => raster.whole_tile(index, |of| surveyor.keeps_whole(of)),
            Footprint::Centre => raster.centres(index),
        }
    }

    /// What so many rays over the hemisphere find at each texel of a tile of a page.
    pub(super) fn tile(&self, texels: Texels, page: u32, rays: u32) -> Integrated {
        let options = self.options;
        let task = Task {
            backend: self.backend,
            arch: Arch::new(),
            seed: match self.is_pilot {
                true => options.seed ^ PILOTS,
                false => options.seed,
            },
            page,
            size: self.atlas.page_size,
            rays,
            points: options.points,
            view: match options.view {
                View::Eye(eye) => View::Eye(eye - self.world.origin()),
                View::Normal => View::Normal,
            },
            model: options.model,
            shading: options.shading,
            t_max: options.max_distance.unwrap_or(f32::INFINITY),
            mixture: self.plan.mixture,
            full_lobes: options.full_highlights,
            hemisphere: self.plan.models(Choice::Diffuse),
            directional: options.is_directional(),
            any_view: options.any_view(),
            sky: &options.sky,
            draw_sky: options.draw_sky,
        };
        let lobes = self.plan.models(Choice::Specular);
        let specular: Vec<bool> = texels.iter().map(|t| lobes && self.reflects(t)).collect();
        let coats = Coat::of_all(&task, &texels);
        let terms = integrate(&task, &texels, &coats, &specular);
        let sealed = match finds_seals(options, self.plan) {
            true => seals(&task, &texels, &terms),
            false => vec![0.0; texels.len()],
        };
        let open_specular = |texel: &Texel| match options.model {
            Model::Ggx => 1.0,
            Model::Phong => {
                let view = task.view_from(texel.position, texel.normal);
                phong_open(
                    texel.material.exponent,
                    texel.normal.dot(view),
                    texel.normal.cross(view).length(),
                )
            }
        };
        let open_specular =
            texels.iter().zip(specular).map(
                |(texel, reflects)| {
                    if reflects { open_specular(texel) } else { 0.0 }
                },
            );
        Integrated {
            open_specular: open_specular.collect(),
            terms,
            coats,
            sealed,
            texels,
        }
    }

    /// k_a of a texel.
    fn ambient(&self, texel: &Texel) -> DVec3 {
        let own = || {
            let scene = self.world.scene();
            let mesh = scene.instances[texel.object as usize].mesh;
            let material = scene.meshes[mesh as usize].material;
            scene.materials[material as usize].ambient
        };
        match self.options.ambient {
            AmbientCoefficient::Albedo => texel.material.albedo,
            AmbientCoefficient::Rgb(rgb) => DVec3::from(rgb.map(f64::from)),
            AmbientCoefficient::Material => own().map_or(texel.material.albedo, |ka| ka.as_dvec3()),
        }
    }

    /// The texels of a tile, ready to be integrated.
    pub(crate) fn texels(&self, raster: &PageRaster<'_>, page: u32, index: usize) -> Texels {
        let gathers = [Choice::Bounces, Choice::Lights];
        let gathers = gathers.iter().any(|&choice| self.plan.models(choice));
        let is_last = !(gathers || self.is_pilot);
        let make = || self.survey(raster, page, index);
        self.surveys.of((page, index as u32), is_last, make)
    }

    /// The same, made anew.
    pub(crate) fn survey(&self, raster: &PageRaster<'_>, page: u32, index: usize) -> Vec<Texel> {
        let tile = self.cut(raster, index);
        let (seed, size) = (self.options.seed, self.atlas.page_size);
        let stream = |x, y, term| Stream::new(seed, page, y * size + x, term, 0);
        self.surveyor().texels(&tile, stream)
    }

    fn surveyor(&self) -> Surveyor<'_> {
        Surveyor {
            world: self.world,
            atlas: self.atlas,
            errors: &self.errors,
            overrides: &self.options.overrides,
            plan: self.plan,
            solids: self.solids,
            under: self.options.under,
            covering: self.covering.as_deref(),
        }
    }

    /// True where the texel's specular term is worth its rays: its material reflects, or the term itself was asked for.
    pub(crate) fn reflects(&self, texel: &Texel) -> bool {
        texel.material.specular.max_element() > 0.0
            || self.options.overrides.exponent.is_some()
            || !self.options.allows(Choice::Specular)
    }

    /// What the page keeps of a tile.
    pub(super) fn result(&self, index: u32, columns: &Columns, tile: &Integrated) -> BakedTile {
        let size = self.atlas.page_size;
        let value = |texel: &BakedTexel, column: &Column| match column.layer {
            Layer::AnyView | Layer::AnyView4 | Layer::AnyView8 => {
                let any = texel.terms.any_view.as_ref();
                any.map_or(0.0, |any| any.coefficients.0[column.channel] as f32)
            }
            layer if directional::holds(layer) => {
                directional::packed(texel.terms, layer, column.channel) as f32
            }
            layer => texel.values(layer)[column.channel],
        };
        let baked = tile.texels.iter().enumerate();
        let baked = baked.map(|(i, texel)| BakedTexel {
            texel,
            terms: &tile.terms[i],
            coat: &tile.coats[i],
            ambient: self.ambient(texel),
            sealed: tile.sealed[i],
            open_specular: tile.open_specular[i],
        });
        let baked: Vec<BakedTexel> = baked.collect();
        let mut values = Vec::with_capacity(baked.len() * columns.0.len());
        for column in &columns.0 {
            values.extend(baked.iter().map(|texel| value(texel, column)));
        }
        let mut stats = PageStats::default();
        for (texel, terms) in tile.texels.iter().zip(&tile.terms) {
            let [coverage, seen] = [texel.coverage, texel.seen.share].map(f64::from);
            stats.texels += 1;
            stats.coverage += coverage;
            stats.buried += u64::from(seen == 0.0);
            stats.buried_area += coverage * (1.0 - seen);
            if seen > 0.0 {
                stats.errors.add(terms.diffuse, [texel.x, texel.y]);
                stats.irradiance_squares += terms.irradiance.std_err.powi(2);
            }
            stats.rays += terms.rays;
        }
        let texels = tile.texels.iter();
        BakedTile {
            index,
            texels: texels.map(|texel| texel.y * size + texel.x).collect(),
            values,
            stats,
        }
    }
}
