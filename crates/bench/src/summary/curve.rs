//! Error against seconds of a technique, in the order of its efforts, and what can be read off without a guess.
//!
//! A time to an error is known only where the error lies between those of two neighbouring efforts; between them the
//! curve is taken for a straight line in logarithms. Each repeat is read by itself, so a ratio has a spread. Techniques
//! are compared at one error, never at their last efforts, which may be 1,024 rays of one and 256 of another.

use super::spread::{Spread, median};
use crate::speed::{Row, TECHNIQUES, Technique, effort_name};

/// One effort of a technique over the repeats.
#[derive(Debug, Clone)]
pub(super) struct Point {
    /// `rays 64` or `target 0.01`.
    pub effort: String,
    /// Median root mean square error.
    pub rmse: f64,
    /// Median of what the `error` layer says.
    pub estimated_rmse: f64,
    /// CPU seconds.
    pub seconds: Spread,
    /// Median millions of rays per CPU second.
    pub rate: f64,
    /// Median rays per texel.
    pub rays_per_texel: f64,
}

/// What was measured of a technique.
#[derive(Debug, Clone)]
pub(super) struct Curve {
    /// The technique's name.
    pub name: &'static str,
    /// Its efforts, rising.
    pub points: Vec<Point>,
    /// Errors and CPU seconds of each repeat by rising effort, with the repeat's number.
    repeats: Vec<(u32, Vec<(f64, f64)>)>,
}

/// What the seconds of the rows are of: `CPU`, or `wall` where the system does not tell CPU time.
pub(super) fn clock(rows: &[Row]) -> &'static str {
    match rows.iter().all(|row| row.cpu_seconds == row.wall_seconds) {
        true => "wall",
        false => "CPU",
    }
}

/// The curve of every technique that has rows, in the order of the techniques.
pub(super) fn curves(rows: &[Row]) -> Vec<Curve> {
    let curve = |technique: &Technique| {
        let own = || rows.iter().filter(|row| row.technique == technique.name);
        let efforts = technique.efforts.iter().map(|&effort| effort_name(effort));
        let points: Vec<Point> = efforts.filter_map(|effort| point(effort, own())).collect();
        let mut numbers: Vec<u32> = own().map(|row| row.repeat).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let of_repeat = |number: u32| {
            let at = |point: &Point| {
                own().find(|row| row.repeat == number && row.effort == point.effort)
            };
            let found = points.iter().filter_map(at);
            (
                number,
                found.map(|row| (row.rmse, row.cpu_seconds)).collect(),
            )
        };
        Curve {
            name: technique.name,
            repeats: numbers.into_iter().map(of_repeat).collect(),
            points,
        }
    };
    let all = TECHNIQUES.iter().map(curve);
    all.filter(|curve| !curve.points.is_empty()).collect()
}

fn point<'a>(effort: String, rows: impl Iterator<Item = &'a Row>) -> Option<Point> {
    let rows: Vec<&Row> = rows.filter(|row| row.effort == effort).collect();
    let all = |of: fn(&Row) -> f64| -> Vec<f64> { rows.iter().copied().map(of).collect() };
    Some(Point {
        rmse: median(all(|r| r.rmse)),
        estimated_rmse: median(all(|r| r.estimated_rmse)),
        seconds: Spread::of(&all(|r| r.cpu_seconds))?,
        rate: median(all(|r| r.rays as f64 / r.cpu_seconds / 1e6)),
        rays_per_texel: median(all(|r| r.rays as f64 / r.texels.max(1) as f64)),
        effort,
    })
}

impl Curve {
    /// CPU seconds to an error; `None` unless every repeat has measured efforts on both sides of it.
    pub fn seconds_to(&self, rmse: f64) -> Option<Spread> {
        let known = self
            .repeats
            .iter()
            .map(|(_, points)| seconds_to(points, rmse));
        Spread::of(&known.collect::<Option<Vec<f64>>>()?)
    }

    /// CPU seconds to an error over those of another technique in the same repeat; `None` unless both know them in the
    /// same repeats.
    pub fn ratio_to(&self, other: &Curve, rmse: f64) -> Option<Spread> {
        if self.repeats.len() != other.repeats.len() {
            return None;
        }
        let pairs = self.repeats.iter().zip(&other.repeats);
        let ratio = |((a, own), (b, others)): (&(u32, Vec<_>), &(u32, Vec<_>))| {
            let own = seconds_to(own, rmse).filter(|_| a == b)?;
            Some(own / seconds_to(others, rmse)?)
        };
        Spread::of(&pairs.map(ratio).collect::<Option<Vec<f64>>>()?)
    }

    /// The errors of one digit (1, 2, 3, 5) that every repeat has measured efforts on both sides of, falling.
    pub fn round_errors(&self) -> Vec<f64> {
        let errors = || {
            let all = self.repeats.iter().flat_map(|(_, points)| points);
            all.map(|(rmse, _)| *rmse).filter(|rmse| rmse.is_normal())
        };
        let (Some(least), Some(most)) = (errors().reduce(f64::min), errors().reduce(f64::max))
        else {
            return Vec::new();
        };
        let decade = |value: f64| value.log10().floor() as i32;
        let decades = (decade(least)..=decade(most)).rev();
        // Read from text, so that 0.003 is the number that a reader would type.
        let round = decades.flat_map(|e| [5, 3, 2, 1].map(|digit| format!("{digit}e{e}").parse()));
        let measured = |rmse: &f64| self.seconds_to(*rmse).is_some();
        round.filter_map(Result::ok).filter(measured).collect()
    }
}

/// Seconds to an error in one repeat: between the first effort that is as good and the one before it.
fn seconds_to(points: &[(f64, f64)], wanted: f64) -> Option<f64> {
    let at = points.iter().position(|(rmse, _)| *rmse <= wanted)?;
    let (rmse, seconds) = points[at];
    if rmse == wanted {
        return Some(seconds);
    }
    // The least effort may be better than is asked for: what less would have taken is not known.
    let (worse, before) = points[at.checked_sub(1)?];
    if !(rmse > 0.0 && seconds > 0.0 && before > 0.0) {
        return None;
    }
    let share = (wanted / worse).ln() / (rmse / worse).ln();
    Some(before * (seconds / before).powf(share))
}
