//! What the rows of a benchmark say: medians, times to an error, a table and a picture.

use crate::speed::{Row, TECHNIQUES};
use plotters::prelude::*;
use std::fmt::Write;
use std::ops::Range;

/// Medians over the repeats of one technique at one effort.
#[derive(Debug, Clone)]
pub struct Point {
    /// `rays 64` or `target 0.01`.
    pub effort: String,
    /// Median root mean square error.
    pub rmse: f64,
    /// Median of what the `error` layer says.
    pub estimated_rmse: f64,
    /// Median CPU seconds.
    pub cpu: f64,
    /// Largest over smallest CPU seconds of the repeats.
    pub spread: f64,
    /// Median millions of rays per second of CPU.
    pub rate: f64,
    /// Median rays per texel.
    pub rays_per_texel: f64,
}

/// The points of every technique that has rows, by rising CPU time.
pub fn curves(rows: &[Row]) -> Vec<(&'static str, Vec<Point>)> {
    TECHNIQUES
        .iter()
        .map(|technique| {
            let own: Vec<&Row> = rows
                .iter()
                .filter(|row| row.technique == technique.name)
                .collect();
            let mut efforts: Vec<&String> = Vec::new();
            for row in &own {
                if !efforts.contains(&&row.effort) {
                    efforts.push(&row.effort);
                }
            }
            let mut points: Vec<Point> = efforts
                .into_iter()
                .map(|effort| point(effort, own.iter().copied().filter(|r| r.effort == *effort)))
                .collect();
            points.sort_by(|a, b| a.cpu.total_cmp(&b.cpu));
            (technique.name, points)
        })
        .filter(|(_, points)| !points.is_empty())
        .collect()
}

fn point<'a>(effort: &str, rows: impl Iterator<Item = &'a Row> + Clone) -> Point {
    let median = |of: fn(&Row) -> f64| median(rows.clone().map(of).collect());
    let cpu =
        |pick: fn(f64, f64) -> f64, from| rows.clone().map(|r| r.cpu_seconds).fold(from, pick);
    Point {
        effort: effort.into(),
        rmse: median(|r| r.rmse),
        estimated_rmse: median(|r| r.estimated_rmse),
        cpu: median(|r| r.cpu_seconds),
        spread: cpu(f64::max, 0.0) / cpu(f64::min, f64::INFINITY),
        rate: median(|r| r.rays as f64 / r.cpu_seconds / 1e6),
        rays_per_texel: median(|r| r.rays as f64 / r.texels.max(1) as f64),
    }
}

/// The median; 0 of nothing.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// CPU seconds to an error, along the straight line (in logarithms) through the two points nearest to it.
pub fn time_to(points: &[Point], rmse: f64) -> Option<f64> {
    let mut known: Vec<(f64, f64)> = points
        .iter()
        .filter(|p| p.rmse > 0.0 && p.cpu > 0.0)
        .map(|p| (p.rmse.ln(), p.cpu.ln()))
        .collect();
    let wanted = rmse.ln();
    known.sort_by(|a, b| (a.0 - wanted).abs().total_cmp(&(b.0 - wanted).abs()));
    let (a, b) = (known.first()?, known.get(1)?);
    let slope = (b.1 - a.1) / (b.0 - a.0);
    Some((a.1 + slope * (wanted - a.0)).exp()).filter(|t| t.is_finite())
}

/// The table in Markdown. `title` is its heading, `ceiling` the median ratio of the bake to the bare loop.
pub fn markdown(title: &str, rows: &[Row], ceiling: Option<f64>) -> String {
    let curves = curves(rows);
    let mut text = format!("# {title}\n\n");
    let seconds = |t: Option<f64>| t.map_or("-".into(), |t| format!("{t:.3}"));
    let _ = writeln!(
        text,
        "CPU seconds are of the bake over all threads; times to an error are read off the curve (log-log). Efficiency is \
         1 / (RMSE² × CPU s) at the last effort. RMSE is of the diffuse term over covered texels.\n\n\
         | technique | CPU s to RMSE 0.01 | to 0.003 | Mrays / CPU s | efficiency | spread |\n|---|---|---|---|---|---|"
    );
    for (name, points) in &curves {
        let Some(last) = points.last() else { continue };
        let _ = writeln!(
            text,
            "| {name} | {} | {} | {:.1} | {:.0} | {:.2} |",
            seconds(time_to(points, 0.01)),
            seconds(time_to(points, 0.003)),
            last.rate,
            1.0 / (last.rmse * last.rmse * last.cpu),
            points.iter().map(|p| p.spread).fold(1.0, f64::max),
        );
    }
    if let Some(ratio) = ceiling {
        let _ = writeln!(
            text,
            "\nThe bake takes {ratio:.2} times as long as the bare rtcOccluded16 loop over its packets (one thread)."
        );
    }
    text += "\n| technique | effort | rays/texel | RMSE | estimated | CPU s |\n|---|---|---|---|---|---|\n";
    for (name, points) in &curves {
        for p in points {
            let _ = writeln!(
                text,
                "| {name} | {} | {:.1} | {:.5} | {:.5} | {:.3} |",
                p.effort, p.rays_per_texel, p.rmse, p.estimated_rmse, p.cpu
            );
        }
    }
    text
}

/// Error against CPU seconds, both logarithmic, with lines of slope -1/2 and -3/4, as SVG.
///
/// # Errors
/// The drawing library's message.
pub fn svg(title: &str, rows: &[Row]) -> Result<String, String> {
    let curves = curves(rows);
    let all = || curves.iter().flat_map(|(_, points)| points);
    let range = |of: fn(&Point) -> f64| {
        let low = all()
            .map(of)
            .filter(|v| *v > 0.0)
            .fold(f64::INFINITY, f64::min);
        let high = all().map(of).fold(0.0, f64::max);
        (low / 1.5)..(high * 1.5)
    };
    let (x, y) = (range(|p| p.cpu), range(|p| p.rmse));
    if !(x.start.is_finite() && y.start.is_finite() && y.end > 0.0) {
        return Err("every error is 0: there is nothing to draw".into());
    }
    let mut text = String::new();
    draw(&mut text, title, &curves, x, y).map_err(|e| e.to_string())?;
    Ok(text)
}

fn draw(
    text: &mut String,
    title: &str,
    curves: &[(&'static str, Vec<Point>)],
    x: Range<f64>,
    y: Range<f64>,
) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    let area = SVGBackend::with_string(text, (960, 640)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(title, ("sans-serif", 22))
        .margin(16)
        .x_label_area_size(48)
        .y_label_area_size(72)
        .build_cartesian_2d(x.clone().log_scale(), y.clone().log_scale())?;
    chart
        .configure_mesh()
        .x_desc("CPU seconds of the bake")
        .y_desc("RMSE of the diffuse term")
        .label_style(("sans-serif", 15))
        .axis_desc_style(("sans-serif", 17))
        .bold_line_style(RGBColor(205, 205, 205))
        .light_line_style(RGBColor(240, 240, 240))
        .x_labels(6)
        .y_labels(8)
        .x_label_formatter(&|v| label(*v))
        .y_label_formatter(&|v| label(*v))
        .draw()?;
    // Where the first technique would go at each rate.
    if let Some(start) = curves.first().and_then(|(_, points)| points.first()) {
        for (slope, name, shade) in [(-0.5, "slope -1/2", 190), (-0.75, "slope -3/4", 120)] {
            let at = |cpu: f64| (cpu, start.rmse * (cpu / start.cpu).powf(slope));
            let end = (start.cpu * (y.start / start.rmse).powf(1.0 / slope)).min(x.end);
            let style = RGBColor(shade, shade, shade).stroke_width(1);
            chart
                .draw_series(LineSeries::new([at(start.cpu), at(end)], style))?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], style));
        }
    }
    for (index, (name, points)) in curves.iter().enumerate() {
        let color = Palette99::pick(index).to_rgba();
        let line = points.iter().map(|p| (p.cpu, p.rmse));
        chart
            .draw_series(LineSeries::new(line.clone(), color.stroke_width(2)))?
            .label(*name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], color.stroke_width(2)));
        chart.draw_series(line.map(|at| Circle::new(at, 3, color.filled())))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .label_font(("sans-serif", 15))
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(160, 160, 160))
        .draw()?;
    area.present()
}

/// An axis label without the rounding of the axis.
fn label(value: f64) -> String {
    let digits = 10.0_f64.powf(2.0 - value.log10().floor());
    format!("{}", (value * digits).round() / digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows() -> Vec<Row> {
        // rmse = n^-3/4, cpu = n ms: time to an error is known.
        let row = |rays: u32, repeat: u32| Row {
            technique: TECHNIQUES[0].name,
            effort: format!("rays {rays}"),
            repeat,
            rmse: f64::from(rays).powf(-0.75),
            estimated_rmse: 0.0,
            cpu_seconds: f64::from(rays) * 1e-3 * [0.5, 1.0, 4.0][repeat as usize],
            wall_seconds: 0.0,
            rays: u64::from(rays) * 10,
            texels: 10,
        };
        (0..3)
            .flat_map(|r| [16, 64, 256].map(|n| row(n, r)))
            .collect()
    }

    #[test]
    fn times_to_an_error_follow_the_power_law_of_the_medians() {
        let curves = curves(&rows());
        assert_eq!(curves.len(), 1);
        for rmse in [0.5_f64, 0.03, 0.001] {
            let exact = 1e-3 * rmse.powf(-4.0 / 3.0);
            let found = time_to(&curves[0].1, rmse).expect("three points");
            assert!(
                (found / exact - 1.0).abs() < 1e-9,
                "{rmse}: {found} {exact}"
            );
        }
        assert_eq!(curves[0].1[0].spread, 8.0);
    }

    #[test]
    fn table_and_picture_name_every_technique() {
        let (table, picture) = (markdown("t", &rows(), Some(1.5)), svg("t", &rows()));
        let picture = picture.expect("the rows have errors");
        assert!(table.contains(TECHNIQUES[0].name) && table.contains("1.50 times"));
        assert!(picture.contains(TECHNIQUES[0].name) && picture.contains("slope -3/4"));
        assert!(svg("t", &[]).is_err());
    }
}
