//! What is known of a scene once it was judged: rows, and the tables of them.

use super::score::Score;
use serde::Serialize;

/// One criterion of one scene on one backend.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// `T1` to `T10`.
    pub test: &'static str,
    /// Which of its scenes, and what of it is scored.
    pub variant: String,
    /// Name of the ray backend.
    pub backend: &'static str,
    /// Errors over the visible points.
    #[serde(flatten)]
    pub score: Score,
    /// What is measured, in a few words.
    pub criterion: &'static str,
    /// The measured number.
    pub measured: f64,
    /// The largest that holds; `None` where the row only reports.
    pub bound: Option<f64>,
}

impl Row {
    /// True where the measured number is at most the bound, or there is none. A NaN does not hold.
    pub fn holds(&self) -> bool {
        self.bound.is_none_or(|bound| self.measured <= bound)
    }

    fn verdict(&self) -> &'static str {
        match (self.bound, self.holds()) {
            (None, _) => "reported",
            (_, true) => "yes",
            (_, false) => "NO",
        }
    }

    /// The bound as text.
    fn limit(&self) -> String {
        self.bound.map_or_else(String::new, |b| format!("{b:.5}"))
    }
}

/// The rows as a Markdown table.
pub fn markdown(rows: &[Row]) -> String {
    let mut text = String::from(
        "| test | variant | backend | points | max error | RMSE | p99.9 | bias | criterion | measured | bound \
         | holds |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let score = &row.score;
        text += &format!(
            "| {} | {} | {} | {} | {:.5} | {:.5} | {:.5} | {:+.5} | {} | {:.5} | {} | {} |\n",
            row.test,
            row.variant,
            row.backend,
            score.points,
            score.max,
            score.rmse,
            score.p999,
            score.bias,
            row.criterion,
            row.measured,
            row.limit(),
            row.verdict()
        );
    }
    text
}

/// The rows as CSV with a header.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "test,variant,backend,points,max_error,rmse,p999,bias,criterion,measured,bound,holds\n",
    );
    for row in rows {
        let score = &row.score;
        text += &format!(
            "{},\"{}\",{},{},{},{},{},{},\"{}\",{},{},{}\n",
            row.test,
            row.variant,
            row.backend,
            score.points,
            score.max,
            score.rmse,
            score.p999,
            score.bias,
            row.criterion,
            row.measured,
            row.bound.map_or_else(String::new, |b| b.to_string()),
            row.verdict()
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_holds_up_to_its_bound_and_nan_never() {
        let row = |measured, bound| Row {
            test: "T0",
            variant: "none".into(),
            backend: "obvhs",
            score: Score::of(&[]),
            criterion: "nothing",
            measured,
            bound,
        };
        assert!(row(0.25, Some(0.25)).holds() && !row(0.26, Some(0.25)).holds());
        assert!(!row(f64::NAN, Some(1.0)).holds() && row(9.0, None).holds());
        let text = markdown(&[row(0.26, Some(0.25)), row(9.0, None)]);
        assert!(text.contains("| NO |") && text.contains("| reported |"));
    }
}
