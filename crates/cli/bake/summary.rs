//! What `ambake bake` says at its end.

use crate::progress::{count, ray_rate, square};
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
        "{}: {}, {}, {} on {} of {}, UVs {}\n",
        report.scene.path,
        count(report.scene.instanced_triangles, "triangle"),
        count(report.layout.objects.len() as u64, "object"),
        count(report.atlas.charts, "chart"),
        count(report.atlas.pages, "page"),
        square(report.atlas.page_size),
        report.atlas.source,
    );
    text += &report.layout.text();
    for decision in report.plan.iter().filter(|_| verbose) {
        text += &format!("  {}: {}\n", decision.decision, decision.reason);
    }
    text += &format!(
        "{texels} texels, {rays} rays in {seconds:.2} s ({}, {})\n",
        ray_rate(rays, seconds),
        report.versions.backend_version,
    );
    if report
        .plan
        .iter()
        .any(|d| d.decision == "diffuse" && d.modelled)
    {
        text += &format!(
            "error of diffuse: RMSE {rmse:.5} (below {bound:.5} with 99.9 % confidence), worst texel {worst:.5}: {}\n",
            against_target(report, rmse).unwrap_or_else(|| grade(rmse).into())
        );
    }
    if report
        .pages
        .iter()
        .any(|page| page.irradiance_rmse.is_some())
    {
        let rmse = mean_square(|p| p.irradiance_rmse.unwrap_or(0.0));
        let means = report.pages.iter().map(|page| page.irradiance_mean);
        let sum: Option<f64> = std::iter::zip(means, &report.pages)
            .map(|(mean, page)| Some(mean? * page.texels as f64))
            .sum();
        text += &irradiance(rmse, sum.map(|sum| sum / texels.max(1) as f64));
    }
    if let Some(seams) = &report.seams {
        text += &format!(
            "seams: steps of RMS {:.5}, at most {:.5}; before {:.5} and {:.5}; texels moved by RMS {:.5} for it{}{}\n",
            seams.rms_after,
            seams.max_after,
            seams.rms_before,
            seams.max_before,
            seams.rms_moved,
            match seams.rms_moved > rmse {
                true => ", more than the rays leave",
                false => "",
            },
            steps(seams.rms_after, seams.rms_moved, rmse),
        );
    }
    if let Some(update) = &report.update {
        text += &format!(
            "update: {:.1} % of the texels baked, the others kept; {}\n",
            100.0 * update.share,
            match update.changed.len() {
                0 => "no object changed".into(),
                changed => count(changed as u64, "object") + " changed",
            }
        );
    }
    for phase in report.timings.iter().filter(|_| verbose) {
        text += &format!("  {:>8.3} s {}\n", phase.seconds, phase.phase);
    }
    text += &lines(&report.warnings);
    text += &format!("{} files in {}\n", report.files.len(), dir.display());
    // Last, what can be looked at.
    let ends = |end: &str| report.files.iter().find(|name| name.ends_with(end));
    for name in [ends(".lit.png"), ends(REPORT_NAME)].into_iter().flatten() {
        text += &format!("look at {}\n", dir.join(name).display());
    }
    text
}

/// A step of 8 bits.
const STEP: f64 = 1.0 / 255.0;

/// Steps across seams are seen from here on, by their RMS in parts of the full light: an edge shows where both sides
/// differ by a fiftieth (E. H. Weber's fraction of brightness). Their largest says little: one point is no edge.
const EDGE: f64 = 0.02;

/// What steps across seams look like beside the error of the rays, and what helps; of steps that do not show, what
/// lowers what texels were moved by for them, where that is more than the rays leave.
fn steps(rms: f64, moved: f64, rmse: f64) -> &'static str {
    match rms >= EDGE {
        false if moved > rmse => ": a larger --size lowers it",
        false => "",
        // Both sides of a seam have that error.
        true if rms <= 2.0 * rmse => ": steps may show, four times the --rays halve them",
        true => ": steps may show, a larger --size lowers them where light is smooth",
    }
}

/// What an error of shares looks like, and what helps.
/// What an error is beside the target that was set for it; `None` where none was.
fn against_target(report: &BakeReport, rmse: f64) -> Option<String> {
    let number = |key: &str| report.options.get(key)?.as_f64();
    let target = number("target_error")?;
    Some(match rmse / target - 1.0 {
        _ if number("target_relative").is_some_and(|share| share > 0.0) => {
            format!("the target is {target}, or its share of the value")
        }
        ..=0.0 => format!("the target is {target}"),
        above => format!(
            "{:.0} % above the target of {target}; --target-error {:.5} gets nearer, if --max-rays lets it",
            (100.0 * above).max(1.0),
            target * target / rmse,
        ),
    })
}

fn grade(rmse: f64) -> &'static str {
    match rmse / STEP {
        ..0.5 => "good, under half a step of 8 bits",
        ..1.0 => "fair, under a step of 8 bits; four times the --rays halve it",
        ..2.0 => "fair, one to two steps of 8 bits; four times the --rays halve it",
        _ => "grainy; four times the --rays halve it, and --target-error 0.004 is a step of 8 bits",
    }
}

/// The line of the error of the irradiance, as a radiance, beside the mean of it where that is known.
fn irradiance(rmse: f64, mean: Option<f64>) -> String {
    let Some(mean) = mean.filter(|mean| *mean > 0.0) else {
        return format!("error of irradiance: RMSE {rmse:.5}, as a radiance\n");
    };
    let grade = match rmse / mean / EDGE {
        ..0.5 => "good, under half of what an eye tells apart",
        ..2.0 => "fair, about what an eye tells apart; four times the --rays halve it",
        _ => "grainy; four times the --rays halve it",
    };
    let percent = 100.0 * rmse / mean;
    format!("error of irradiance: RMSE {rmse:.5}, {percent:.1} % of its mean {mean:.5}: {grade}\n")
}

/// Places of one warning that are named; the others are counted.
const NAMED: usize = 3;

/// Warnings as they are printed: a line for each thing to say, with how often it holds and where.
pub fn lines(warnings: &[WarningReport]) -> String {
    let mut said: Vec<(&str, Vec<&WarningReport>)> = Vec::new();
    for warning in warnings {
        match said
            .iter_mut()
            .find(|(message, _)| *message == warning.message)
        {
            Some((_, same)) => same.push(warning),
            None => said.push((&warning.message, vec![warning])),
        }
    }
    let line = |(message, same): &(&str, Vec<&WarningReport>)| {
        let times: u64 = same.iter().map(|warning| warning.count).sum();
        let places: Vec<&str> = same.iter().map(|warning| warning.place.as_str()).collect();
        let often = match times {
            1 => String::new(),
            _ if times == places.len() as u64 => String::new(),
            _ => format!("{times} times, "),
        };
        format!("warning: {message} ({often}{})\n", named(&places))
    };
    said.iter().map(line).collect()
}

/// Places in words: one as it is, several counted and the first ones named.
fn named(places: &[&str]) -> String {
    if let [place] = places {
        return (*place).into();
    }
    // All are of one sort as a rule: material `a`, material `b`.
    let sort = |place: &str| place.split_once(' ').map(|(sort, _)| sort.to_owned());
    let first = sort(places[0]).filter(|_| places.iter().all(|place| place.contains(" `")));
    let common = first.filter(|first| {
        places
            .iter()
            .all(|place| sort(place).as_ref() == Some(first))
    });
    let plural = common
        .as_ref()
        .map_or("places".into(), |sort| match sort.as_str() {
            "mesh" => "meshes".into(),
            sort => format!("{sort}s"),
        });
    let skip = common.map_or(0, |sort| sort.len() + 1);
    let some: Vec<&str> = places
        .iter()
        .take(NAMED)
        .map(|place| &place[skip..])
        .collect();
    let more = if places.len() > NAMED { ", ..." } else { "" };
    format!("{} {plural}: {}{more}", places.len(), some.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn warning(message: &str, place: &str, count: u64) -> WarningReport {
        WarningReport {
            kind: "kind".into(),
            place: place.into(),
            count,
            message: message.into(),
        }
    }

    #[test]
    fn steps_are_told_of_where_they_show_with_the_flag_that_lowers_them() {
        // The largest of a thousand points may be 0.5 at an RMS of 0.016.
        for (rms, rmse) in [(0.0, 0.0), (0.0199, 0.0), (0.0199, 0.05)] {
            assert_eq!(steps(rms, 0.0, rmse), "", "{rms} {rmse}");
        }
        assert!(steps(0.02, 0.001, 0.005).contains("--size"));
        assert!(steps(0.02, 0.001, 0.01).contains("--rays"));
        assert!(steps(0.01, 0.006, 0.005).contains("--size"));
    }

    #[test]
    fn an_error_of_irradiance_is_held_against_its_mean() {
        assert_eq!(
            irradiance(12.6, Some(840.0)),
            "error of irradiance: RMSE 12.60000, 1.5 % of its mean 840.00000: fair, about what an eye tells apart; \
             four times the --rays halve it\n"
        );
        assert!(irradiance(0.0099, Some(1.0)).contains("1.0 % of its mean 1.00000: good"));
        assert!(irradiance(0.0401, Some(1.0)).contains("grainy"));
        for mean in [None, Some(0.0)] {
            assert_eq!(
                irradiance(0.5, mean),
                "error of irradiance: RMSE 0.50000, as a radiance\n"
            );
        }
    }

    #[test]
    fn equal_warnings_are_one_line_that_names_the_first_places() {
        let mut warnings: Vec<_> = ["Glass", "two words", "100%", "d"]
            .map(|name| warning("left out", &format!("material `{name}`"), 1))
            .into();
        warnings.insert(1, warning("dropped", "mesh `m` primitive 0", 7));
        warnings.push(warning("left out", "material `e`", 2));
        assert_eq!(
            lines(&warnings),
            "warning: left out (6 times, 5 materials: `Glass`, `two words`, `100%`, ...)\n\
             warning: dropped (7 times, mesh `m` primitive 0)\n"
        );
        warnings.truncate(3);
        assert!(
            lines(&warnings).starts_with("warning: left out (2 materials: `Glass`, `two words`)\n")
        );
        let mixed = [warning("x", "scene", 1), warning("x", "node 3", 1)];
        assert_eq!(lines(&mixed), "warning: x (2 places: scene, node 3)\n");
        assert_eq!(lines(&mixed[..1]), "warning: x (scene)\n");
    }
    #[test]
    fn an_error_is_graded_by_steps_of_8_bits() {
        // Half a step is 0.00196, one 0.00392, two 0.00784.
        for (rmse, words) in [
            (0.0, "good, under half a step"),
            (0.0019, "good, under half a step"),
            (0.002, "fair, under a step"),
            (0.0039, "fair, under a step"),
            (0.004, "fair, one to two steps"),
            (0.0078, "fair, one to two steps"),
            (0.008, "grainy;"),
            (1.0, "grainy;"),
        ] {
            assert!(grade(rmse).starts_with(words), "{rmse}: {}", grade(rmse));
        }
    }
}
