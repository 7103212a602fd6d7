//! What `ambake bake` says at its end.

use report::{BakeReport, REPORT_NAME, WarningReport};
use std::path::Path;

/// The summary of a finished bake; with `verbose` also the plan and the time of each phase.
pub fn summary(report: &BakeReport, verbose: bool, dir: &Path) -> String {
    let mut text = String::new();
    let rays: u64 = report.pages.iter().map(|page| page.rays).sum();
    let seconds: f64 = report.pages.iter().map(|page| page.seconds).sum();
    let worst = report
        .pages
        .iter()
        .map(|page| page.max_error)
        .fold(0.0, f64::max);
    let texels: u64 = report.pages.iter().map(|page| page.texels).sum();
    let mean_square = |of: fn(&report::PageReport) -> f64| {
        let sum: f64 = report
            .pages
            .iter()
            .map(|page| of(page).powi(2) * page.texels as f64)
            .sum();
        (sum / texels.max(1) as f64).sqrt()
    };
    let (rmse, bound) = (mean_square(|p| p.rmse), mean_square(|p| p.rmse_bound));
    text += &format!(
        "{}: {} triangles, {} objects, {} charts on {} page(s) of {}², UVs {}\n",
        report.scene.path,
        report.scene.triangles,
        report.scene.instances,
        report.atlas.charts,
        report.atlas.pages,
        report.atlas.page_size,
        report.atlas.source,
    );
    text += &report.layout.text();
    for decision in report.plan.iter().filter(|_| verbose) {
        text += &format!("  {}: {}\n", decision.decision, decision.reason);
    }
    text += &format!(
        "{texels} texels, {rays} rays in {seconds:.2} s ({:.1} million rays/s, {})\n",
        rays as f64 / seconds.max(1e-9) / 1e6,
        report.versions.backend_version,
    );
    if report
        .plan
        .iter()
        .any(|d| d.decision == "diffuse" && d.modelled)
    {
        text += &format!(
            "error of diffuse: RMSE {rmse:.5} (below {bound:.5} with 99.9 % confidence), worst texel {worst:.5}\n"
        );
    }
    if report
        .pages
        .iter()
        .any(|page| page.irradiance_rmse.is_some())
    {
        let rmse = mean_square(|p| p.irradiance_rmse.unwrap_or(0.0));
        text += &format!("error of irradiance: RMSE {rmse:.5}, as a radiance\n");
    }
    if let Some(seams) = &report.seams {
        text += &format!(
            "seams: steps of RMS {:.5}, at most {:.5}; before {:.5} and {:.5}\n",
            seams.rms_after, seams.max_after, seams.rms_before, seams.max_before
        );
    }
    if let Some(update) = &report.update {
        text += &format!(
            "update: {:.1} % of the texels baked, the others kept; {} object(s) changed\n",
            100.0 * update.share,
            update.changed.len()
        );
    }
    for phase in report.timings.iter().filter(|_| verbose) {
        text += &format!("  {:>8.3} s {}\n", phase.seconds, phase.phase);
    }
    for warning in &report.warnings {
        text += &line(warning);
    }
    text += &format!("{} files in {}\n", report.files.len(), dir.display());
    // Last, what can be looked at.
    let ends = |end: &str| report.files.iter().find(|name| name.ends_with(end));
    for name in [ends(".lit.png"), ends(REPORT_NAME)].into_iter().flatten() {
        text += &format!("look at {}\n", dir.join(name).display());
    }
    text
}

/// A warning as it is printed: how often it holds, and where first.
pub fn line(warning: &WarningReport) -> String {
    let often = match warning.count {
        1 => String::new(),
        count => format!("{count} times, "),
    };
    format!("warning: {} ({often}{})\n", warning.message, warning.place)
}
