//! The picture: error against seconds.

use super::curve::{Curve, Point, clock, curves};
use super::spread::rounded;
use crate::speed::Row;
use plotters::prelude::*;
use std::ops::Range;

/// Error against CPU seconds, both logarithmic, with lines of slope -1/2 and -3/4, as SVG. Points are medians of the
/// repeats, joined by rising effort.
///
/// * `quantity`: what the error is of, as [`crate::speed::quantity`] says.
///
/// # Errors
/// The drawing library's message.
pub fn svg(title: &str, quantity: &str, rows: &[Row]) -> Result<String, String> {
    let curves = curves(rows);
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let range = |of: fn(&Point) -> f64| {
        let low = all()
            .map(of)
            .filter(|v| *v > 0.0)
            .fold(f64::INFINITY, f64::min);
        let high = all().map(of).fold(0.0, f64::max);
        (low / 1.5)..(high * 1.5)
    };
    let (x, y) = (range(|p| p.seconds.median), range(|p| p.rmse));
    if !(x.start.is_finite() && y.start.is_finite() && y.end > 0.0) {
        return Err("every error is 0: there is nothing to draw".into());
    }
    let mut text = String::new();
    let names = Names {
        title,
        x: format!("{} seconds of the bake", clock(rows)),
        y: format!("RMSE of the {quantity}"),
    };
    draw(&mut text, &names, &curves, x, y).map_err(|e| e.to_string())?;
    Ok(text)
}

/// What stands above the picture and along its axes.
struct Names<'a> {
    title: &'a str,
    x: String,
    y: String,
}

fn draw(
    text: &mut String,
    names: &Names,
    curves: &[Curve],
    x: Range<f64>,
    y: Range<f64>,
) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    let area = SVGBackend::with_string(text, (960, 640)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(names.title, ("sans-serif", 22))
        .margin(16)
        .x_label_area_size(48)
        .y_label_area_size(72)
        .build_cartesian_2d(x.clone().log_scale(), y.clone().log_scale())?;
    chart
        .configure_mesh()
        .x_desc(&names.x)
        .y_desc(&names.y)
        .label_style(("sans-serif", 15))
        .axis_desc_style(("sans-serif", 17))
        .bold_line_style(RGBColor(205, 205, 205))
        .light_line_style(RGBColor(240, 240, 240))
        .x_labels(6)
        .y_labels(8)
        .x_label_formatter(&|v| rounded(*v, 3))
        .y_label_formatter(&|v| rounded(*v, 3))
        .draw()?;
    // Where the first technique would go at each rate.
    if let Some(start) = curves.first().and_then(|curve| curve.points.first()) {
        for (slope, name, shade) in [(-0.5, "slope -1/2", 190), (-0.75, "slope -3/4", 120)] {
            let from = start.seconds.median;
            let at = |seconds: f64| (seconds, start.rmse * (seconds / from).powf(slope));
            let end = (from * (y.start / start.rmse).powf(1.0 / slope)).min(x.end);
            let style = RGBColor(shade, shade, shade).stroke_width(1);
            chart
                .draw_series(LineSeries::new([at(from), at(end)], style))?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], style));
        }
    }
    for (index, curve) in curves.iter().enumerate() {
        let color = Palette99::pick(index).to_rgba();
        let line = curve.points.iter().map(|p| (p.seconds.median, p.rmse));
        chart
            .draw_series(LineSeries::new(line.clone(), color.stroke_width(2)))?
            .label(curve.name)
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
