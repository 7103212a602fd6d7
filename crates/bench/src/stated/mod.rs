//! Whether the errors that a bake states are those that it has, on scenes that nobody has seen.

mod scenes;

pub use scenes::{Made, scenes};

use serde::Serialize;
use std::fmt::Write;

/// A term of one scene with one number of rays.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Which scene.
    pub scene: String,
    /// Rays a texel.
    pub rays: u32,
    /// The layer's name.
    pub term: String,
    /// Texels that were judged.
    pub texels: usize,
    /// True root mean square error, without what the truth adds by its own.
    pub rmse: f64,
    /// That over the root mean square of the stated errors; 1 is right.
    pub over_stated: f64,
    /// Share of texels within 1.96 stated errors of texel and truth; 0.95 is right, and more where texels are exact.
    pub within: f64,
}

/// What is judged of a texel.
#[derive(Debug, Clone, Copy)]
pub struct Judged {
    /// What was baked.
    pub value: f64,
    /// The standard error that is stated of it.
    pub std_err: f64,
    /// What a bake of far more rays says.
    pub truth: f64,
    /// The standard error of that.
    pub truth_err: f64,
}

impl Row {
    /// What values with their stated errors say, beside the truth.
    pub fn of(scene: &str, rays: u32, term: &str, texels: &[Judged]) -> Row {
        let count = texels.len() as f64;
        let mean = |square: &dyn Fn(&Judged) -> f64| texels.iter().map(square).sum::<f64>() / count;
        let off = mean(&|texel| (texel.value - texel.truth).powi(2));
        let rmse = (off - mean(&|texel| texel.truth_err.powi(2)))
            .max(0.0)
            .sqrt();
        let stated = mean(&|texel| texel.std_err.powi(2)).sqrt();
        // Values are 32-bit numbers.
        let holds = |texel: &&Judged| {
            let error = texel.std_err.hypot(texel.truth_err);
            (texel.value - texel.truth).abs() <= 1.96 * error + 1e-7
        };
        Row {
            scene: scene.into(),
            rays,
            term: term.into(),
            texels: texels.len(),
            rmse,
            over_stated: rmse / stated.max(f64::MIN_POSITIVE),
            within: texels.iter().filter(holds).count() as f64 / count,
        }
    }
}

/// The rows as a table in Markdown: a line for each scene and number of rays, a column for each term.
pub fn markdown(rows: &[Row]) -> String {
    let mut terms: Vec<&str> = Vec::new();
    for row in rows {
        if !terms.contains(&&row.term[..]) {
            terms.push(&row.term);
        }
    }
    let columns = terms
        .iter()
        .map(|term| format!(" {term}: RMSE, over stated, within |"));
    let mut text = format!(
        "| scene | rays |{}\n|---|---|{}\n",
        columns.collect::<String>(),
        "---|".repeat(terms.len())
    );
    for line in rows.chunk_by(|a, b| (&a.scene, a.rays) == (&b.scene, b.rays)) {
        let _ = write!(text, "| {} | {} |", line[0].scene, line[0].rays);
        for row in line {
            let Row {
                rmse,
                over_stated,
                within,
                ..
            } = row;
            let _ = write!(text, " {rmse:.5}, {over_stated:.2}, {within:.3} |");
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_truth_is_off_by_counts_for_no_error() {
        // Off by 5, of which the truth has 3; and within 1.96 errors of 3 and 4 together up to 9.8.
        let judged = |value: f64| Judged {
            value,
            std_err: 4.0,
            truth: 1.0,
            truth_err: 3.0,
        };
        let row = Row::of("scene", 64, "diffuse", &[6.0, -4.0].map(judged));
        assert_eq!([row.rmse, row.over_stated, row.within], [4.0, 1.0, 1.0]);
        let row = Row::of("scene", 64, "diffuse", &[10.9, 10.7].map(judged));
        assert_eq!(row.within, 0.5);
    }
}
