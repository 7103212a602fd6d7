//! Numbers of how two layers differ, weighted by coverage, for each object and in all.

use crate::{Error, Page};
use serde::{Deserialize, Serialize};

/// How two layers differ: `a - b`, channels averaged, weighted by coverage.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// Texels with coverage above 0.
    pub texels: u64,
    /// Sum of their coverage.
    pub weight: f64,
    /// Root of the mean square.
    pub rmse: f64,
    /// Mean of `a - b`.
    pub mean_signed: f64,
    /// Largest absolute difference of one channel.
    pub maximum: f64,
    /// Where the largest difference lies.
    pub worst: Option<Worst>,
}

/// The texel of the largest difference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Worst {
    /// Page number.
    pub page: u32,
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Object index, where the page has an `object` layer.
    pub object: Option<u32>,
    /// World position, where the page has a `position` layer.
    pub position: Option<[f32; 3]>,
}

/// The comparison of two layers over all pages.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Over everything.
    pub all: Difference,
    /// By object index; empty without an `object` layer.
    pub objects: Vec<Difference>,
}

/// Compares the layers `a` and `b` of each page (with its number), such as `traditional` and `lambert`.
///
/// # Errors
/// [`Error::MissingLayer`] without `coverage` or one of the layers; [`Error::Mismatch`] where their channels differ.
pub fn compare_layers<'a>(
    pages: impl IntoIterator<Item = (u32, &'a Page)>,
    a: &str,
    b: &str,
) -> Result<Comparison, Error> {
    let mut result = Comparison::default();
    for (number, page) in pages {
        let missing = |layer: &str| Error::MissingLayer {
            layer: layer.into(),
        };
        let coverage = page.values("coverage").ok_or_else(|| missing("coverage"))?;
        let first = &page.layer(a).ok_or_else(|| missing(a))?.channels;
        let second = &page.layer(b).ok_or_else(|| missing(b))?.channels;
        if first.len() != second.len() {
            let reason = format!("{a} has {} channels, {b} has {}", first.len(), second.len());
            return Err(Error::Mismatch { reason });
        }
        let objects = page.values("object");
        let position = page
            .layer("position")
            .filter(|layer| layer.channels.len() == 3);
        for (i, &weight) in coverage.iter().enumerate().filter(|(_, c)| **c > 0.0) {
            let pairs = first.iter().zip(second);
            let difference = |(a, b): (&crate::Channel, &crate::Channel)| {
                f64::from(a.values[i]) - f64::from(b.values[i])
            };
            let differences: Vec<f64> = pairs.map(difference).collect();
            let object = objects
                .map(|o| o[i])
                .filter(|o| (0.0..16_777_216.0).contains(o))
                .map(|o| o as u32);
            let worst = || Worst {
                page: number,
                x: i as u32 % page.size,
                y: i as u32 / page.size,
                object,
                position: position.map(|p| [0, 1, 2].map(|c| p.channels[c].values[i])),
            };
            result.all.add(f64::from(weight), &differences, worst);
            if let Some(object) = object.map(|o| o as usize) {
                if result.objects.len() <= object {
                    result.objects.resize(object + 1, Difference::default());
                }
                result.objects[object].add(f64::from(weight), &differences, worst);
            }
        }
    }
    result.all.finish();
    result.objects.iter_mut().for_each(Difference::finish);
    Ok(result)
}

impl Difference {
    /// Adds a texel; `rmse` and `mean_signed` hold sums until [`Difference::finish`].
    fn add(&mut self, weight: f64, differences: &[f64], worst: impl Fn() -> Worst) {
        let count = differences.len() as f64;
        self.texels += 1;
        self.weight += weight;
        self.rmse += weight * differences.iter().map(|d| d * d).sum::<f64>() / count;
        self.mean_signed += weight * differences.iter().sum::<f64>() / count;
        let most = differences
            .iter()
            .fold(0.0, |most: f64, d| most.max(d.abs()));
        if self.worst.is_none() || most > self.maximum {
            self.maximum = most;
            self.worst = Some(worst());
        }
    }

    fn finish(&mut self) {
        if self.weight > 0.0 {
            self.rmse = (self.rmse / self.weight).sqrt();
            self.mean_signed /= self.weight;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Layer;

    #[test]
    fn differences_are_weighted_by_coverage_and_kept_apart_by_object() {
        let page = Page {
            size: 2,
            layers: vec![
                Layer::scalar("coverage", vec![1.0, 0.5, 0.0, 0.5]),
                Layer::scalar("visibility", vec![1.0, 0.5, 9.0, 0.25]),
                Layer::scalar("diffuse", vec![0.5, 0.5, 0.0, 0.75]),
                Layer::scalar("object", vec![0.0, 1.0, -1.0, 1.0]),
            ],
        };
        let result = compare_layers([(3, &page)], "visibility", "diffuse").unwrap();
        assert_eq!((result.all.texels, result.all.weight), (3, 2.0));
        assert_eq!(result.all.mean_signed, (0.5 - 0.25) / 2.0);
        assert_eq!(result.all.rmse, ((0.25 + 0.125) / 2.0f64).sqrt());
        assert_eq!(result.objects[1].mean_signed, -0.25);
        let worst = result.objects[1].worst.as_ref().unwrap();
        assert_eq!(
            (worst.page, worst.x, worst.y, worst.object),
            (3, 1, 1, Some(1))
        );
    }
}
