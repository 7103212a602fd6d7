//! Bakes a scene as the product does by default, but for its denoiser: criteria hold texels to their own rays.

use super::error::Error;
use super::lit::Lit;
use super::points::{Point, points};
use super::row::Row;
use super::score::Score;
use atlas::{Atlas, UvMode};
use bake::{BakedPage, Baker, Effort, Options, Plan};
use glam::DVec2;
use layers::Layer;
use rayon::prelude::*;
use rays::{BackendKind, World};
use scene::Scene;
use std::sync::Arc;

/// Points of a texel's edge: 16 in a texel.
pub(super) const PER_EDGE: u32 = 4;
/// What 8 bits can show.
pub(super) const STEP: f64 = 1.0 / 255.0;
/// Rays a texel that the criteria are stated for.
const STATED_RAYS: f64 = 4096.0;

/// Where and with how many rays scenes are baked.
#[derive(Clone, Copy)]
pub(super) struct Lab {
    /// Ray library.
    pub kind: BackendKind,
    /// Its name in the rows.
    pub backend: &'static str,
    /// Rays a texel.
    pub rays: u32,
}

/// How texels are laid out.
#[derive(Debug, Clone, Copy)]
pub(super) enum Texels {
    /// The scene's own lightmap coordinates on one page of this edge.
    Authored(u32),
    /// ambake's charts on pages of this edge, at so many texels per unit.
    Unwrapped(u32, f64),
}

/// A baked scene.
pub(super) struct Baked {
    pub world: World,
    pub atlas: Atlas,
    pub pages: Vec<BakedPage>,
    /// Bytes that the ray structure holds.
    pub structure_bytes: u64,
}

impl Lab {
    /// The scene, baked with the default options but for rays and `change`.
    pub fn bake_with(
        &self,
        name: &str,
        scene: Scene,
        texels: Texels,
        change: impl FnOnce(&mut Options),
    ) -> Result<Baked, Error> {
        let name = || name.to_owned();
        let (uv, page_size, density) = match texels {
            Texels::Authored(size) => (UvMode::Keep, size, None),
            Texels::Unwrapped(size, density) => (UvMode::Auto, size, Some(density)),
        };
        let layout = atlas::Options {
            uv,
            page_size,
            density,
            ..atlas::Options::default()
        };
        let mut options = Options {
            effort: Effort::Rays(self.rays),
            layers: vec![Layer::Coverage, Layer::Diffuse, Layer::StdErrDiffuse],
            ..Options::default()
        };
        change(&mut options);
        let scene = Arc::new(scene);
        let fail = |source| Error::Bake {
            name: name(),
            source,
        };
        let (plan, world) = Plan::of(&scene, &options).map_err(fail)?;
        let atlas = atlas::layout(&scene, &layout, &|| false).map_err(|source| Error::Layout {
            name: name(),
            source,
        })?;
        let backend = rays::build(self.kind, &world, 0).map_err(fail)?;
        let baker = Baker::new(&world, &plan, backend.as_ref(), &atlas, &options);
        let bake = |page| {
            let mut page = baker.start(page);
            baker.run(&mut page, &());
            page
        };
        let pages = (0..atlas.page_count).map(bake).collect();
        let structure_bytes = backend.memory_bytes();
        drop(backend);
        Ok(Baked {
            world,
            atlas,
            pages,
            structure_bytes,
        })
    }

    /// The scene, baked with the default options.
    pub fn bake(&self, name: &str, scene: Scene, texels: Texels) -> Result<Baked, Error> {
        self.bake_with(name, scene, texels, |_| ())
    }

    /// A bound on noise that is stated for 4,096 rays a texel, for the rays of this lab.
    pub fn noise(&self, stated: f64) -> f64 {
        stated * (STATED_RAYS / f64::from(self.rays)).powf(0.75).max(1.0)
    }

    /// A row of this lab.
    pub fn row(
        &self,
        test: &'static str,
        variant: impl Into<String>,
        score: Score,
        (criterion, measured, bound): (&'static str, f64, Option<f64>),
    ) -> Row {
        Row {
            test,
            variant: variant.into(),
            backend: self.backend,
            score,
            criterion,
            measured,
            bound,
        }
    }
}

/// A visible point with what was looked up there and what is true.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judged {
    pub point: Point,
    pub value: f64,
    pub truth: f64,
}

impl Judged {
    /// Value minus truth.
    pub fn error(&self) -> f64 {
        self.value - self.truth
    }
}

impl Baked {
    /// As a renderer sees it.
    pub fn lit(&self) -> Lit<'_> {
        Lit {
            world: &self.world,
            atlas: &self.atlas,
            pages: &self.pages,
        }
    }

    /// The points for which `truth` knows a value, `per_edge`² a texel. It answers `None` for what cannot be seen.
    pub fn judge(
        &self,
        per_edge: u32,
        truth: impl Fn(&Point) -> Option<f64> + Sync,
    ) -> Vec<Judged> {
        let lit = self.lit();
        points(&lit, per_edge)
            .into_par_iter()
            .filter_map(|point| {
                truth(&point).map(|truth| Judged {
                    point,
                    value: lit.diffuse(point.page, point.place),
                    truth,
                })
            })
            .collect()
    }

    /// A covered texel of page 0: its value and its standard error.
    pub fn texel(&self, at: [u32; 2]) -> (f64, f64) {
        let page = &self.pages[0];
        let index = (at[1] * page.size + at[0]) as usize;
        let plane = |layer| page.layer(layer).map_or(f64::NAN, |p| f64::from(p[index]));
        (plane(Layer::Diffuse), plane(Layer::StdErrDiffuse))
    }
}

/// The score of judged points.
pub(super) fn score(judged: &[Judged]) -> Score {
    Score::of(&judged.iter().map(Judged::error).collect::<Vec<_>>())
}

/// The largest error of the points that `pick` takes; NaN, which no bound holds, where it takes none.
pub(super) fn largest(judged: &[Judged], pick: impl Fn(&Judged) -> bool) -> f64 {
    let own = judged.iter().filter(|j| pick(j));
    own.map(|j| j.error().abs()).fold(f64::NAN, f64::max)
}

/// Places and truths of judged points of page 0.
pub(super) fn targets(judged: &[Judged]) -> Vec<(DVec2, f64)> {
    judged.iter().map(|j| (j.point.place, j.truth)).collect()
}
