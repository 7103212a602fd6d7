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
    /// True root mean square error.
    pub rmse: f64,
    /// That over the root mean square of the stated errors; 1 is right.
    pub over_stated: f64,
    /// Share of texels within 1.96 stated errors; 0.95 is right.
    pub within: f64,
}

impl Row {
    /// What values with their stated errors say, beside the truth.
    ///
    /// * `texels`: value, stated standard error and truth of every texel that is judged.
    pub fn of(scene: &str, rays: u32, term: &str, texels: &[[f64; 3]]) -> Row {
        let count = texels.len() as f64;
        let root_mean = |square: &dyn Fn(&[f64; 3]) -> f64| {
            (texels.iter().map(square).sum::<f64>() / count).sqrt()
        };
        let rmse = root_mean(&|[value, _, truth]| (value - truth).powi(2));
        let stated = root_mean(&|[_, error, _]| error * error);
        // Values are 32-bit numbers.
        let holds =
            |[value, error, truth]: &&[f64; 3]| (value - truth).abs() <= 1.96 * error + 1e-7;
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
