//! The picture of Fig. 1.

use super::fig1::{EXPONENTS, Fig1Point};
use ambient::closed_form::phong_open_angle;
use ambient::convention::lobe_scale;
use plotters::prelude::*;

/// Colours of the curves by rank: eight hues of middling lightness.
const COLORS: [RGBColor; 8] = [
    RGBColor(0xb6, 0x20, 0x20),
    RGBColor(0xa8, 0x6a, 0x12),
    RGBColor(0x76, 0x8a, 0x10),
    RGBColor(0x1f, 0x8f, 0x3a),
    RGBColor(0x15, 0x8a, 0x8a),
    RGBColor(0x20, 0x60, 0xb6),
    RGBColor(0x5a, 0x36, 0xb6),
    RGBColor(0xa8, 0x2a, 0x86),
];

/// Curves of the closed form with the points and bars of three standard errors, as SVG.
///
/// # Errors
/// The drawing library's message.
pub fn fig1_svg(points: &[Fig1Point]) -> Result<String, String> {
    let mut text = String::new();
    draw(&mut text, points).map_err(|e| e.to_string())?;
    Ok(text)
}

fn draw(
    text: &mut String,
    points: &[Fig1Point],
) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    let area = SVGBackend::with_string(text, (760, 480)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(
            "Specular ambient term of an open Phong surface: curves exact, points by rays ± 3 standard errors",
            ("sans-serif", 14),
        )
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(56)
        .build_cartesian_2d(0.0..90.0, 0.0..3.25)?;
    chart
        .configure_mesh()
        .x_desc("view angle, degrees")
        .y_desc("J / (i k), sr")
        .x_labels(7)
        .y_labels(7)
        .label_style(("sans-serif", 13))
        .axis_desc_style(("sans-serif", 14))
        .bold_line_style(RGBColor(221, 221, 221))
        .light_line_style(WHITE)
        .draw()?;
    for (exponent, color) in EXPONENTS.into_iter().zip(COLORS) {
        let n = f64::from(exponent);
        let value = |degrees: f64| phong_open_angle(n, degrees.to_radians()) / lobe_scale(n);
        let curve = (0..=90)
            .map(f64::from)
            .map(|degrees| (degrees, value(degrees)));
        chart
            .draw_series(LineSeries::new(curve, color))?
            .label(format!("n = {exponent}"))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], color));
        let own = || points.iter().filter(|p| p.exponent == exponent);
        chart.draw_series(own().map(|p| {
            let [low, high] = [-3.0, 3.0].map(|errors| p.rays + errors * p.std_err);
            PathElement::new([(p.angle_deg, low), (p.angle_deg, high)], color)
        }))?;
        chart.draw_series(own().map(|p| Circle::new((p.angle_deg, p.rays), 2, color.filled())))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .label_font(("sans-serif", 13))
        .background_style(WHITE.mix(0.85))
        .draw()?;
    area.present()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_names_every_exponent_and_draws_every_point() {
        let point = |exponent| Fig1Point {
            exponent,
            angle_deg: 30.0,
            exact: 1.0,
            rays: 1.0,
            std_err: 0.01,
        };
        let svg = fig1_svg(&EXPONENTS.map(point)).unwrap();
        for exponent in EXPONENTS {
            assert!(svg.contains(&format!("n = {exponent}")), "n = {exponent}");
        }
        assert_eq!(svg.matches("<circle").count(), EXPONENTS.len());
    }
}
