//! Numbers of how layers differ: within the pages of one bake by object and in all, or between any two pages.

use crate::{Error, Page};
use serde::{Deserialize, Serialize};
use std::borrow::Borrow;

/// How two layers differ: `a - b`, channels averaged.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// Texels that count.
    pub texels: u64,
    /// Sum of their weights.
    pub weight: f64,
    /// Root of the mean square.
    pub rmse: f64,
    /// Mean of `a - b`.
    pub mean_signed: f64,
    /// Largest absolute difference of one channel.
    pub maximum: f64,
    /// Where the largest difference lies; `None` where nothing differs.
    pub worst: Option<Worst>,
    /// Texels left out because a value is NaN or infinite.
    pub non_finite: u64,
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
    /// By object index; empty unless every page has an `object` layer.
    pub objects: Vec<Difference>,
}

/// The comparison of two pages.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PageComparison {
    /// The channels that both pages have, in the order of their names.
    pub channels: Vec<(String, Difference)>,
    /// Names that only the first has.
    pub only_a: Vec<String>,
    /// Names that only the second has.
    pub only_b: Vec<String>,
}

/// Compares the two layers of each pair, such as `("traditional", "lambert")`, over all pages, weighted by coverage.
///
/// * `pages`: number and layers of each page; they are taken one by one, so an iterator that reads files holds one.
/// * `objects`: how many objects the bake has.
///
/// # Errors
/// An error of `pages`; [`Error::MissingLayer`] without `coverage` or one of the layers; [`Error::Mismatch`] where
/// their channels differ or an object index is not below `objects`.
pub fn compare_layers<P: Borrow<Page>>(
    pages: impl IntoIterator<Item = Result<(u32, P), Error>>,
    objects: usize,
    pairs: &[(&str, &str)],
) -> Result<Vec<Comparison>, Error> {
    let empty = Comparison {
        all: Difference::default(),
        objects: vec![Difference::default(); objects],
    };
    let mut results = vec![empty; pairs.len()];
    let mut by_object = true;
    for page in pages {
        let (number, page) = page?;
        let page = page.borrow();
        by_object &= page.values("object").is_some();
        for (result, pair) in results.iter_mut().zip(pairs) {
            result.add(number, page, *pair)?;
        }
    }
    for result in &mut results {
        result.all.finish();
        result.objects.iter_mut().for_each(Difference::finish);
        if !by_object {
            result.objects.clear();
        }
    }
    Ok(results)
}

/// Compares every channel that two pages share. Texels count alike; those of no chart in either page are left out
/// where both have `coverage`.
///
/// # Errors
/// [`Error::Mismatch`] where the pages differ in size or share no channel.
pub fn compare_pages(a: &Page, b: &Page) -> Result<PageComparison, Error> {
    let mismatch = |reason: String| Err(Error::Mismatch { reason });
    if a.size != b.size {
        let (a, b) = (a.size, b.size);
        return mismatch(format!(
            "the first is {a} x {a} texels, the second {b} x {b}"
        ));
    }
    let coverage = a.values("coverage").zip(b.values("coverage"));
    let counts = |i: usize| coverage.is_none_or(|(a, b)| a[i] > 0.0 || b[i] > 0.0);
    let (first, mut second) = (a.named_channels(), b.named_channels());
    let mut result = PageComparison::default();
    for (name, a_values) in first {
        let Some(at) = second.iter().position(|(other, _)| *other == name) else {
            result.only_a.push(name);
            continue;
        };
        let (_, b_values) = second.swap_remove(at);
        let mut difference = Difference::default();
        for i in (0..a_values.len()).filter(|&i| counts(i)) {
            let value = f64::from(a_values[i]) - f64::from(b_values[i]);
            difference.add(1.0, &[value], || Worst::at(0, a, i));
        }
        difference.finish();
        result.channels.push((name, difference));
    }
    result.only_b = second.into_iter().map(|(name, _)| name).collect();
    if result.channels.is_empty() {
        return mismatch("they have no channel in common".into());
    }
    result.channels.sort_by(|a, b| a.0.cmp(&b.0));
    result.only_a.sort();
    result.only_b.sort();
    Ok(result)
}

/// `a - b` of a page's two layers at a texel, by channel.
pub(crate) fn differences<'a>(
    page: &'a Page,
    (a, b): (&str, &str),
) -> Result<impl Fn(usize) -> Vec<f64> + use<'a>, Error> {
    let layer = |name: &str| {
        let missing = || Error::MissingLayer { layer: name.into() };
        page.layer(name).ok_or_else(missing)
    };
    let (first, second) = (&layer(a)?.channels, &layer(b)?.channels);
    if first.len() != second.len() {
        let reason = format!("{a} has {} channels, {b} has {}", first.len(), second.len());
        return Err(Error::Mismatch { reason });
    }
    Ok(move |i: usize| {
        let pairs = first.iter().zip(second);
        pairs
            .map(|(a, b)| f64::from(a.values[i]) - f64::from(b.values[i]))
            .collect()
    })
}

impl Comparison {
    fn add(&mut self, number: u32, page: &Page, pair: (&str, &str)) -> Result<(), Error> {
        let coverage = page.values("coverage").ok_or_else(|| Error::MissingLayer {
            layer: "coverage".into(),
        })?;
        let differences = differences(page, pair)?;
        for (i, &weight) in coverage.iter().enumerate().filter(|(_, c)| **c > 0.0) {
            let values = differences(i);
            let worst = || Worst::at(number, page, i);
            self.all.add(f64::from(weight), &values, worst);
            let Some(object) = object(page, i) else {
                continue;
            };
            let known = self.objects.len();
            let Some(slot) = self.objects.get_mut(object as usize) else {
                let (x, y) = (i as u32 % page.size, i as u32 / page.size);
                let reason = format!(
                    "texel ({x}, {y}) of page {number} names object {object}, the bake has {known}"
                );
                return Err(Error::Mismatch { reason });
            };
            slot.add(f64::from(weight), &values, worst);
        }
        Ok(())
    }
}

impl Worst {
    /// The texel number `i` of a page.
    fn at(number: u32, page: &Page, i: usize) -> Worst {
        let position = page.layer("position").map(|layer| &layer.channels[..]);
        Worst {
            page: number,
            x: i as u32 % page.size,
            y: i as u32 / page.size,
            object: object(page, i),
            position: match position {
                Some([x, y, z]) => Some([x, y, z].map(|channel| channel.values[i])),
                _ => None,
            },
        }
    }
}

/// The object that a texel names.
fn object(page: &Page, i: usize) -> Option<u32> {
    let value = page.values("object")?[i];
    (value >= 0.0 && value.is_finite()).then_some(value as u32)
}

impl Difference {
    /// Adds a texel; `rmse` and `mean_signed` hold sums until [`Difference::finish`].
    fn add(&mut self, weight: f64, differences: &[f64], worst: impl Fn() -> Worst) {
        if differences.iter().any(|d| !d.is_finite()) || !weight.is_finite() {
            self.non_finite += 1;
            return;
        }
        let count = differences.len() as f64;
        self.texels += 1;
        self.weight += weight;
        self.rmse += weight * differences.iter().map(|d| d * d).sum::<f64>() / count;
        self.mean_signed += weight * differences.iter().sum::<f64>() / count;
        let most = largest(differences).abs();
        if most > self.maximum {
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

/// The first of the values that are farthest from 0.
pub(crate) fn largest(values: &[f64]) -> f64 {
    let farther = |most: f64, &v: &f64| if v.abs() > most.abs() { v } else { most };
    values.iter().fold(0.0, farther)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PageLayer;

    fn page() -> Page {
        Page {
            size: 2,
            layers: vec![
                PageLayer::scalar("coverage", vec![1.0, 0.5, 0.0, 0.5]),
                PageLayer::scalar("visibility", vec![1.0, 0.5, 9.0, 0.25]),
                PageLayer::scalar("diffuse", vec![0.5, 0.5, 0.0, 0.75]),
                PageLayer::scalar("object", vec![0.0, 1.0, -1.0, 1.0]),
            ],
        }
    }

    #[test]
    fn differences_are_weighted_by_coverage_and_kept_apart_by_object() {
        let pairs = [("visibility", "diffuse"), ("diffuse", "diffuse")];
        let results = compare_layers([Ok((3, page()))], 3, &pairs).unwrap();
        let result = &results[0];
        assert_eq!((result.all.texels, result.all.weight), (3, 2.0));
        assert_eq!(result.all.mean_signed, (0.5 - 0.25) / 2.0);
        assert_eq!(result.all.rmse, ((0.25 + 0.125) / 2.0f64).sqrt());
        assert_eq!(result.objects[1].mean_signed, -0.25);
        let worst = result.objects[1].worst.as_ref().unwrap();
        assert_eq!(
            (worst.page, worst.x, worst.y, worst.object),
            (3, 1, 1, Some(1))
        );
        assert_eq!(result.objects[2], Difference::default());
        assert_eq!(
            (results[1].all.maximum, &results[1].all.worst),
            (0.0, &None)
        );
    }

    #[test]
    fn an_object_that_the_bake_does_not_have_is_refused() {
        let pair = [("visibility", "diffuse")];
        let error = compare_layers([Ok((3, page()))], 1, &pair).unwrap_err();
        let error = error.to_string();
        assert!(error.contains("names object 1, the bake has 1"), "{error}");
        let mut plain = page();
        plain.layers.truncate(3);
        let result = compare_layers([Ok((0, page())), Ok((1, plain))], 2, &pair).unwrap();
        assert_eq!((result[0].all.texels, result[0].objects.len()), (6, 0));
    }

    #[test]
    fn pages_are_compared_by_common_channel_over_the_charts_of_either() {
        let (a, mut b) = (page(), page());
        b.layers.remove(2);
        b.layers.push(PageLayer::scalar("rays", vec![1.0; 4]));
        b.layers[1].channels[0].values = vec![0.5, f32::NAN, 7.0, 0.5];
        let result = compare_pages(&a, &b).unwrap();
        let names: Vec<_> = result.channels.iter().map(|c| c.0.as_str()).collect();
        assert_eq!(names, ["coverage", "object", "visibility"]);
        assert_eq!(
            (&result.only_a[0][..], &result.only_b[0][..]),
            ("diffuse", "rays")
        );
        let visibility = &result.channels[2].1;
        assert_eq!((visibility.texels, visibility.non_finite), (2, 1));
        assert_eq!((visibility.mean_signed, visibility.maximum), (0.125, 0.5));
        let worst = visibility.worst.as_ref().unwrap();
        assert_eq!((worst.x, worst.y), (0, 0));

        let small = Page {
            size: 1,
            layers: vec![PageLayer::scalar("rays", vec![1.0])],
        };
        let error = compare_pages(&a, &small).unwrap_err().to_string();
        assert!(
            error.contains("2 x 2") && error.contains("1 x 1"),
            "{error}"
        );
        let foreign = Page {
            size: 2,
            layers: vec![PageLayer::scalar("Z", vec![1.0; 4])],
        };
        let error = compare_pages(&a, &foreign).unwrap_err().to_string();
        assert!(error.contains("no channel in common"), "{error}");
    }
}
