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
    let error = Rmse {
        all: mean_square(|p| p.rmse),
        rays: mean_square(|p| p.rmse_rays),
        bound: mean_square(|p| p.rmse_bound),
    };
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
        let grade = against_target(&report.options, &error).unwrap_or_else(|| error.grade());
        text += &format!(
            "error of diffuse: {}, worst texel {worst:.5}: {grade}\n",
            error.text()
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
            match seams.rms_moved > error.rays {
                true => ", more than the rays leave",
                false => "",
            },
            steps(seams.rms_after, seams.rms_moved, error.rays),
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

/// Root mean square errors of the diffuse term.
struct Rmse {
    /// That of the layer `error`.
    all: f64,
    /// What of it the rays leave.
    rays: f64,
    /// What that stays below with 99.9 % confidence.
    bound: f64,
}

impl Rmse {
    /// What seams add to what the rays leave.
    fn seams(&self) -> f64 {
        (self.all.powi(2) - self.rays.powi(2)).max(0.0).sqrt()
    }

    /// Its sizes in words. What is said of the rays holds for all of it only where seams move next to nothing.
    fn text(&self) -> String {
        let Self { all, rays, bound } = self;
        match self.seams() {
            seams if seams >= 0.1 * rays && seams >= 0.000_005 => format!(
                "RMSE {all:.5}, of rays {rays:.5} (below {bound:.5} with 99.9 % confidence) and of seams {seams:.5}"
            ),
            _ => format!("RMSE {all:.5} (below {bound:.5} with 99.9 % confidence)"),
        }
    }

    /// What lowers it: more rays, as long as what seams move is no larger part; if that is no small one, more texels.
    fn remedy(&self) -> &'static str {
        match self.seams() / self.rays.max(f64::MIN_POSITIVE) {
            ..0.34 => "four times the --rays halve it",
            ..1.0 => {
                "four times the --rays halve that of rays, a larger --size lowers that of seams"
            }
            _ => "a larger --size lowers it",
        }
    }

    /// What it looks like, and what helps.
    fn grade(&self) -> String {
        let steps = match self.all / STEP {
            ..0.5 => return "good, under half a step of 8 bits".into(),
            ..1.0 => "fair, under a step of 8 bits",
            ..2.0 => "fair, one to two steps of 8 bits",
            _ if self.seams() > self.rays => "coarse",
            _ => {
                let remedy = self.remedy();
                return format!("grainy; {remedy}, and --target-error 0.004 is a step of 8 bits");
            }
        };
        format!("{steps}; {}", self.remedy())
    }
}

/// What the error that the rays leave is beside the target that was set for it; `None` where none was.
fn against_target(
    options: &serde_json::Map<String, serde_json::Value>,
    error: &Rmse,
) -> Option<String> {
    let number = |key: &str| options.get(key)?.as_f64();
    let target = number("target_error")?;
    if number("target_relative").is_some_and(|share| share > 0.0) {
        return Some(format!("the target is {target}, or its share of the value"));
    }
    let seams = match error.all > target && error.seams() > 0.34 * error.rays {
        true => "; a larger --size lowers that of seams",
        false => "",
    };
    Some(match error.rays / target - 1.0 {
        ..=0.0 if seams.is_empty() => format!("the target is {target}"),
        ..=0.0 => format!("the target of {target} is that of rays{seams}"),
        above => {
            let (above, nearer) = ((100.0 * above).max(1.0), target * target / error.rays);
            let rays = if seams.is_empty() { "" } else { "rays " };
            format!(
                "{rays}{above:.0} % above the target of {target}; --target-error {nearer:.5} gets nearer, \
                 if --max-rays lets it{seams}"
            )
        }
    })
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

    fn rmse(rays: f64, seams: f64) -> Rmse {
        Rmse {
            all: rays.hypot(seams),
            rays,
            bound: 1.1 * rays,
        }
    }

    #[test]
    fn an_error_is_graded_by_steps_of_8_bits() {
        // Half a step is 0.00196, one 0.00392, two 0.00784.
        for (error, words) in [
            (0.0, "good, under half a step"),
            (0.0019, "good, under half a step"),
            (0.002, "fair, under a step"),
            (0.0039, "fair, under a step"),
            (0.004, "fair, one to two steps"),
            (0.0078, "fair, one to two steps"),
            (0.008, "grainy; four times the --rays halve it, and"),
            (1.0, "grainy; four times the --rays halve it, and"),
        ] {
            let said = rmse(error, 0.0).grade();
            assert!(said.starts_with(words), "{error}: {said}");
        }
    }

    #[test]
    fn an_error_of_seams_is_counted_and_no_rays_are_advised_against_it() {
        // 0.010_73 and 0.022_3 are 0.024_75 together.
        let small_charts = rmse(0.010_73, 0.022_3);
        assert_eq!(
            small_charts.text(),
            "RMSE 0.02475, of rays 0.01073 (below 0.01180 with 99.9 % confidence) and of seams 0.02230"
        );
        assert_eq!(small_charts.grade(), "coarse; a larger --size lowers it");
        assert_eq!(
            rmse(0.005, 0.003).grade(),
            "fair, one to two steps of 8 bits; four times the --rays halve that of rays, \
             a larger --size lowers that of seams"
        );
        assert_eq!(
            rmse(0.005, 0.0001).text(),
            "RMSE 0.00500 (below 0.00550 with 99.9 % confidence)"
        );
        let said = |error: Rmse| {
            let options = serde_json::json!({"target_error": 0.01});
            against_target(options.as_object().expect("options"), &error).expect("a target")
        };
        assert_eq!(said(rmse(0.0099, 0.0)), "the target is 0.01");
        assert_eq!(
            said(rmse(0.0099, 0.02)),
            "the target of 0.01 is that of rays; a larger --size lowers that of seams"
        );
        assert_eq!(
            said(rmse(0.0108, 0.04)),
            "rays 8 % above the target of 0.01; --target-error 0.00926 gets nearer, if --max-rays lets it; \
             a larger --size lowers that of seams"
        );
        assert_eq!(
            said(rmse(0.0108, 0.0)),
            "8 % above the target of 0.01; --target-error 0.00926 gets nearer, if --max-rays lets it"
        );
    }
}
