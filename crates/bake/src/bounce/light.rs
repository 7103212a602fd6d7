//! The light that gathers add up to: of a texel, of a page, and over all pages.

use super::REPLICATES;
use super::gather::Received;
use super::mean;
use super::radiosity::PageLight;
use crate::options::Bounces;
use crate::page::{
    BakedPage, BakedTile, Baker, Column, Columns, LayerPlanes, PageStats, finish_light,
};
use crate::survey::Texel;
use atlas::TILE;
use glam::DVec3;
use layers::Layer;
use serde::{Deserialize, Serialize};

/// Neighbours pool their variances where their normals are within acos of this, some 37 degrees.
const NORMAL_AGREEMENT: f64 = 0.8;

/// The rest of the series of gathers is known no better than this share of itself: ratios have noise.
const KNOWN: f64 = 0.02;

/// What one gather brought to a texel.
#[derive(Debug, Clone)]
pub(super) struct TexelLight {
    pub index: u32,
    pub irradiance: Received,
    pub reflection: Received,
    /// Variances of the means of both, of the mean of the channels.
    variances: [f64; 2],
    pub rays: u64,
    coverage: f32,
    position: DVec3,
    normal: DVec3,
    object: u32,
    validity: f32,
}

impl TexelLight {
    /// Nothing.
    pub fn dark(texel: &Texel, index: u32) -> Self {
        Self {
            index,
            irradiance: Received::default(),
            reflection: Received::default(),
            variances: [0.0; 2],
            rays: 0,
            coverage: texel.coverage,
            position: texel.position,
            normal: texel.normal,
            object: texel.object,
            validity: texel.seen.share,
        }
    }

    /// What it has of a layer of a page of light; what has one channel has it first.
    fn value(&self, layer: Layer) -> DVec3 {
        let one = |value: f64| DVec3::new(value, 0.0, 0.0);
        match layer {
            Layer::Coverage => one(self.coverage.into()),
            Layer::Rays => one(self.rays as f64),
            Layer::Irradiance => total(&self.irradiance),
            Layer::Reflection => total(&self.reflection),
            Layer::HalfIrradiance => half(self.irradiance),
            Layer::HalfReflection => half(self.reflection),
            Layer::StdErrIrradiance => one(self.variances[0].sqrt()),
            Layer::StdErrReflection => one(self.variances[1].sqrt()),
            Layer::Position => self.position,
            Layer::Normal => self.normal,
            Layer::Object => one(self.object.into()),
            Layer::Validity => one(self.validity.into()),
            other => unreachable!("layer {} is no fact of gathers", other.name()),
        }
    }
}

/// What a gather brought to the texels of a tile, in the layers of a page of light.
pub(super) fn tile(index: u32, texels: &[TexelLight], columns: &Columns) -> BakedTile {
    let value = |texel: &TexelLight, column: &Column| texel.value(column.layer)[column.channel];
    let columns = &columns.0;
    let values = columns.iter().flat_map(|column| {
        let values = texels.iter().map(move |texel| value(texel, column));
        values.map(|value| value as f32)
    });
    BakedTile {
        index,
        texels: texels.iter().map(|texel| texel.index).collect(),
        values: values.collect(),
        stats: PageStats {
            texels: texels.len() as u64,
            rays: texels.iter().map(|texel| texel.rays).sum(),
            ..PageStats::default()
        },
    }
}

fn total(received: &Received) -> DVec3 {
    received.iter().sum::<DVec3>() / f64::from(REPLICATES)
}

/// Half of what two independent halves differ by.
fn half([a, b, c, d]: Received) -> DVec3 {
    ((a + c) - (b + d)) / 4.0
}

/// The variance of the mean of independent replicates.
fn variance(received: &Received) -> f64 {
    let (count, middle) = (f64::from(REPLICATES), mean(total(received)));
    let squares = received.iter().map(|r| (mean(*r) - middle).powi(2));
    squares.sum::<f64>() / (count * (count - 1.0))
}

/// Gives each texel of a tile the mean variance of its neighbourhood of 3 x 3 on the same surface: four replicates
/// alone are uncertain by 80 %. And, to smooth what is only sent on, the mean irradiance too.
pub(super) fn pool(texels: &mut [TexelLight], size: u32, smooths: bool) {
    let place = |texel: &TexelLight| (texel.index % size % TILE, texel.index / size % TILE);
    let mut at = [usize::MAX; (TILE * TILE) as usize];
    for (i, texel) in texels.iter().enumerate().filter(|(_, t)| t.rays > 0) {
        let (x, y) = place(texel);
        at[(y * TILE + x) as usize] = i;
    }
    let own: Vec<[f64; 2]> = texels
        .iter()
        .map(|texel| [&texel.irradiance, &texel.reflection].map(variance))
        .collect();
    let received: Vec<Received> = texels.iter().map(|texel| texel.irradiance).collect();
    for i in 0..texels.len() {
        if texels[i].rays == 0 {
            continue;
        }
        let (x, y) = place(&texels[i]);
        let (mut sums, mut count) = ([0.0; 2], 0.0);
        let mut light = Received::default();
        for row in y.saturating_sub(1)..(y + 2).min(TILE) {
            for column in x.saturating_sub(1)..(x + 2).min(TILE) {
                let other = at[(row * TILE + column) as usize];
                if other != usize::MAX
                    && texels[other].normal.dot(texels[i].normal) >= NORMAL_AGREEMENT
                {
                    sums[0] += own[other][0];
                    sums[1] += own[other][1];
                    light
                        .iter_mut()
                        .zip(&received[other])
                        .for_each(|(sum, own)| *sum += *own);
                    count += 1.0;
                }
            }
        }
        let count = f64::max(count, 1.0);
        texels[i].variances = sums.map(|sum| sum / count);
        if smooths {
            texels[i].irradiance = light.map(|sum| sum / count);
        }
    }
}

/// The light that gathers add to one page, as facts of its own.
pub(super) struct LightPage {
    page: BakedPage,
    pub rays: u64,
}

impl LightPage {
    /// A dark one of these layers.
    pub fn new(page: &BakedPage, layers: &[Layer]) -> Self {
        let texels = page.texels();
        let void = |&layer: &Layer| LayerPlanes::void(layer, texels);
        Self {
            page: BakedPage {
                page: page.page,
                size: page.size,
                tiles: Vec::new(),
                planes: layers.iter().map(void).collect(),
                finished: false,
                stats: Default::default(),
            },
            rays: 0,
        }
    }

    /// What no gather has reached yet.
    pub fn dark(&self) -> PageLight {
        PageLight {
            irradiance: vec![[0.0; 3]; self.page.texels()],
            holds: vec![false; self.page.texels()],
        }
    }

    /// Begins another gather, of which no tile is here yet.
    pub fn begin(&mut self) {
        self.page.tiles.clear();
    }

    /// True where a tile of the gather has been added.
    pub fn has(&self, index: u32) -> bool {
        self.page.has(index)
    }

    /// Every channel of its layers.
    pub fn columns(&self) -> Columns {
        self.page.columns()
    }

    /// Adds a tile of a gather, here and to what the next one is sent; false, and nothing is done, where it does not
    /// fit.
    pub fn add(&mut self, tile: &BakedTile, next: &mut PageLight) -> bool {
        let columns = self.columns();
        if !self.page.fits(tile, &columns) {
            return false;
        }
        let plane = self.page.texels();
        for &texel in &tile.texels {
            next.holds[texel as usize] = true;
        }
        for (column, values) in columns.0.iter().zip(tile.channels()) {
            let Column { layer, channel, .. } = *column;
            for (&texel, &value) in tile.texels.iter().zip(values) {
                let texel = texel as usize;
                let sum = &mut self.page.planes[column.planes].values[channel * plane + texel];
                let (before, new) = (f64::from(*sum), f64::from(value));
                *sum = match layer {
                    Layer::Rays
                    | Layer::Irradiance
                    | Layer::Reflection
                    | Layer::HalfIrradiance
                    | Layer::HalfReflection => (before + new) as f32,
                    Layer::StdErrIrradiance | Layer::StdErrReflection => {
                        (before * before + new * new).sqrt() as f32
                    }
                    _ => value,
                };
                match layer {
                    Layer::Irradiance => next.irradiance[texel][channel] = value,
                    Layer::Validity => next.holds[texel] = value > 0.0,
                    _ => (),
                }
            }
        }
        self.rays += tile.stats.rays;
        self.page.count(tile);
        true
    }

    /// The page mended, denoised, without seams, its gutters filled.
    pub fn finished(mut self, baker: &Baker<'_>) -> BakedPage {
        self.page.tiles.clear();
        finish_light(&mut self.page, &baker.site());
        self.page
    }

    /// The light of its texels, by their covered area.
    fn power(&self) -> f64 {
        power(&self.page)
    }
}

/// The light that the seen texels of a page receive, by their covered area, in texels times radiance.
fn power(page: &BakedPage) -> f64 {
    let channel = |layer, channel| page.channel(layer, channel).unwrap_or_default();
    let planes = [0, 1, 2].map(|c| channel(Layer::Irradiance, c));
    let coverage = channel(Layer::Coverage, 0).iter().enumerate();
    let texel = |(i, share): (usize, &f32)| {
        f64::from(*share) * mean(DVec3::from(planes.map(|plane| f64::from(plane[i]))))
    };
    coverage.filter(|(_, share)| **share > 0.0).map(texel).sum()
}

/// What the gathers of a bake added.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct BounceStats {
    /// How many there were.
    pub gathers: u32,
    /// Share of all light that the last one added.
    pub change: f64,
    /// Estimated share of all light that is missing; 1 after the first of several.
    pub missing: f64,
    /// Rays of all gathers.
    pub rays: u64,
    /// Light from the sky, that of all gathers, and that of the last one, in texels times radiance.
    sky: f64,
    added: f64,
    last: f64,
    /// What the last gather brought for what the one before had, and the same of the one before.
    ratio: f64,
    before: f64,
}

impl BounceStats {
    pub(super) fn start(&mut self, pages: &[BakedPage]) {
        self.sky = pages.iter().map(power).sum();
    }

    /// True where another gather is due.
    pub(super) fn goes_on(&self, bounces: Bounces, enough: f64) -> bool {
        match bounces {
            Bounces::Off => false,
            Bounces::Most(most) => self.gathers < most,
            Bounces::Auto => {
                let short = self.change.max(self.missing) <= enough || self.left() <= enough;
                self.gathers == 0 || (self.gathers < super::MOST && !short)
            }
        }
    }

    /// What further gathers would bring for what the last one brought, if each brought as much of the one before: the
    /// rest of a geometric series. 0 where too few are known.
    pub(super) fn rest(&self) -> f64 {
        match self.gathers {
            0..3 => 0.0,
            _ => self.ratio / (1.0 - self.ratio),
        }
    }

    /// The share of all light that is missing beside [`BounceStats::rest`], as far as the ratio of one gather to the
    /// next still changes.
    fn left(&self) -> f64 {
        match self.gathers {
            0..3 => self.missing,
            _ => {
                let moved = (self.ratio - self.before).abs() / (1.0 - self.ratio);
                self.missing * moved.clamp(KNOWN, 1.0)
            }
        }
    }

    /// Counts a gather before the last.
    pub(super) fn end_gather(&mut self, light: &[LightPage]) {
        let gathered: f64 = light.iter().map(LightPage::power).sum();
        self.rays += light.iter().map(|page| page.rays).sum::<u64>();
        self.end(self.sky, self.added + gathered);
    }

    /// Counts the last gather. It brings the light of all others again, and what they send on.
    pub(super) fn end_last(&mut self, light: &[LightPage]) {
        self.rays += light.iter().map(|page| page.rays).sum::<u64>();
        self.end_with(light.iter().map(LightPage::power).sum());
    }

    /// Counts the last gather, of which the light of all of them is told. From the third on the ratio of those before
    /// tells better what it added than the difference of two large numbers.
    fn end_with(&mut self, added: f64) {
        match self.gathers {
            0 | 1 => self.end(self.sky, added),
            _ => {
                self.gathers += 1;
                self.change *= self.ratio;
                self.missing *= self.ratio;
            }
        }
    }

    /// Notes that the rest of the series was added.
    pub(super) fn end_series(&mut self) {
        self.missing = self.left();
    }

    /// Counts a gather after which all of them have added so much to the light of the sky.
    pub(super) fn end(&mut self, sky: f64, added: f64) {
        let last = (added - self.added).max(0.0);
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let (first, ratio) = (self.gathers == 0, share(last, self.last).min(0.999));
        (self.before, self.ratio) = (self.ratio, ratio);
        self.change = share(last, sky + added);
        self.missing = match first {
            true if last > 0.0 => 1.0,
            _ => self.change * ratio / (1.0 - ratio),
        };
        (self.added, self.last) = (added, last);
        self.gathers += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_of_gathers_tells_what_is_missing_of_a_geometric_series() {
        // The sky brings 8, the gathers 4, 2, 1 and so on: 16 in all.
        let after = |gathers: u32| {
            let mut stats = BounceStats {
                sky: 8.0,
                ..BounceStats::default()
            };
            let added = |count: u32| 8.0 - 8.0 * 0.5f64.powi(count as i32);
            (1..gathers).for_each(|count| stats.end(8.0, added(count)));
            stats.end_with(added(gathers));
            assert_eq!(stats.gathers, gathers);
            [stats.change, stats.missing]
        };
        assert_eq!(after(1), [4.0 / 12.0, 1.0], "one tells nothing of the rest");
        assert_eq!(after(2), [2.0 / 14.0; 2]);
        // Of the third nothing but the ratio of the two before is used: half of 2 / 14.
        assert_eq!(after(3), [1.0 / 14.0; 2]);
    }

    #[test]
    fn halves_are_every_second_replicate_and_what_they_share_cancels() {
        let of = |shared: f64| half([1.0, 2.0, 3.0, 4.0].map(|v| DVec3::splat(v + shared)));
        // Halves of 2 and 3.
        assert_eq!([of(0.0), of(8.0)], [DVec3::splat(-0.5); 2]);
    }

    #[test]
    fn variances_are_pooled_over_three_by_three_on_the_same_surface() {
        const SIZE: u32 = 64;
        // A tile's corner of 4 x 4 texels; the last column leans away.
        let texel = |i: u32| {
            let spread = f64::from(1 + i);
            TexelLight {
                index: i / 4 * SIZE + i % 4,
                irradiance: [0.0, 0.0, 0.0, spread].map(DVec3::splat),
                reflection: [DVec3::ZERO; 4],
                variances: [0.0; 2],
                rays: if i == 5 { 0 } else { 16 },
                coverage: 1.0,
                position: DVec3::ZERO,
                normal: if i % 4 == 3 { DVec3::X } else { DVec3::Z },
                object: 0,
                validity: 1.0,
            }
        };
        let mut texels: Vec<TexelLight> = (0..16).map(texel).collect();
        let own: Vec<f64> = texels.iter().map(|t| variance(&t.irradiance)).collect();
        assert!((own[0] - 1.0 / 16.0).abs() < 1e-12, "{}", own[0]);
        pool(&mut texels, SIZE, false);
        for (i, about) in [
            (0, vec![0, 1, 4]),
            (4, vec![0, 1, 4, 8, 9]),
            (6, vec![1, 2, 6, 9, 10]),
            (3, vec![3, 7]),
            (15, vec![11, 15]),
            (9, vec![4, 6, 8, 9, 10, 12, 13, 14]),
            (5, vec![]),
        ] {
            let sum: f64 = about.iter().map(|&k| own[k]).sum();
            let expected = sum / about.len().max(1) as f64;
            let found = texels[i].variances;
            assert!(
                (found[0] - expected).abs() < 1e-12,
                "{i}: {found:?} {expected}"
            );
            assert_eq!(found[1], 0.0);
        }
    }
}
