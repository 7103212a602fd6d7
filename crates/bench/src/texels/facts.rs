//! What an artist asks of any lightmap first, counted on its finished pages.

use super::lit::Lit;
use super::seams::{Seams, seams};
use layers::Layer;
use serde::Serialize;
use std::collections::BTreeMap;

/// Points of each seam edge.
const PER_SEAM: u32 = 8;
/// Below this share of a footprint that can be seen, a texel counts as buried.
const BURIED: f32 = 0.5;

/// Figures of a finished bake.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Facts {
    /// Pages.
    pub pages: usize,
    /// Texels that a chart touches.
    pub texels: usize,
    /// Share of the page area inside charts.
    pub page_use: f64,
    /// Charts.
    pub charts: u32,
    /// The object with the most texels.
    pub largest: ObjectShare,
    /// Objects that have no texel of their own.
    pub objects_without_texel: usize,
    /// Share of the touched texels of which less than half can be seen.
    pub buried: f64,
    /// Median diffuse term of the touched texels.
    pub median_diffuse: f64,
    /// Stated root mean square error of the diffuse term: the grain.
    pub rmse: f64,
    /// Stated error by value: the mean of error / value over texels of value above 1/255.
    pub relative_error: f64,
    /// Steps over the borders of charts.
    pub seams: Seams,
}

/// An object's part of the touched texels.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ObjectShare {
    /// Its name.
    pub name: String,
    /// Share of the touched texels, by the object that holds most of each.
    pub share: f64,
}

impl Facts {
    /// The figures of pages that hold coverage, diffuse, its error, object and validity.
    pub fn of(lit: &Lit<'_>) -> Facts {
        let (mut inside, mut buried, mut relative, mut lit_texels) = (0.0, 0usize, 0.0, 0usize);
        let mut values = Vec::new();
        let mut objects: BTreeMap<u32, usize> = BTreeMap::new();
        let mut squares = 0.0;
        for page in lit.pages {
            let plane = |layer| page.layer(layer).unwrap_or(&[]);
            let (coverage, object) = (plane(Layer::Coverage), plane(Layer::Object));
            let (diffuse, error) = (plane(Layer::Diffuse), plane(Layer::StdErrDiffuse));
            let validity = plane(Layer::Validity);
            for texel in (0..page.texels()).filter(|&t| coverage[t] > 0.0) {
                inside += f64::from(coverage[texel]);
                values.push(diffuse[texel]);
                buried += usize::from(validity[texel] < BURIED);
                *objects.entry(object[texel] as u32).or_default() += 1;
                squares += f64::from(error[texel]).powi(2);
                if diffuse[texel] > 1.0 / 255.0 {
                    relative += f64::from(error[texel] / diffuse[texel]);
                    lit_texels += 1;
                }
            }
        }
        values.sort_by(f32::total_cmp);
        let texels = values.len();
        let share = |count: f64| count / texels.max(1) as f64;
        let area: usize = lit.pages.iter().map(|page| page.texels()).sum();
        let scene = lit.world.scene();
        let largest = objects.iter().max_by_key(|(_, count)| **count);
        Facts {
            pages: lit.pages.len(),
            texels,
            page_use: inside / area.max(1) as f64,
            charts: lit.atlas.chart_count,
            largest: largest.map_or_else(ObjectShare::default, |(&index, &count)| ObjectShare {
                name: scene.instances[index as usize].name.clone(),
                share: share(count as f64),
            }),
            objects_without_texel: scene.instances.len() - objects.len(),
            buried: share(buried as f64),
            median_diffuse: values.get(texels / 2).map_or(f64::NAN, |v| f64::from(*v)),
            rmse: share(squares).sqrt(),
            relative_error: relative / lit_texels.max(1) as f64,
            seams: seams(lit, PER_SEAM),
        }
    }
}

impl Facts {
    /// The figures as lines of text.
    pub fn text(&self) -> String {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let seams = &self.seams;
        let lines = [
            (
                "page use",
                format!(
                    "{} of {} page(s), {} texels in {} charts",
                    percent(self.page_use),
                    self.pages,
                    self.texels,
                    self.charts
                ),
            ),
            (
                "largest object",
                format!(
                    "{} of the texels: {}",
                    percent(self.largest.share),
                    self.largest.name
                ),
            ),
            (
                "without a texel",
                format!("{} objects", self.objects_without_texel),
            ),
            ("buried texels", percent(self.buried)),
            ("median diffuse", format!("{:.4}", self.median_diffuse)),
            (
                "stated error",
                format!(
                    "RMSE {:.5}, {} of the value",
                    self.rmse,
                    percent(self.relative_error)
                ),
            ),
            (
                "seams",
                format!(
                    "RMS step {:.4}, largest {:.4}, {} of their length above 25/255 ({} edges)",
                    seams.rms,
                    seams.max,
                    percent(seams.share_visible),
                    seams.edges
                ),
            ),
        ];
        lines
            .map(|(name, value)| format!("{name:16} {value}\n"))
            .concat()
    }
}
