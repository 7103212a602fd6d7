//! The tables in Markdown.

use super::curve::{Curve, clock, curves};
use super::spread::{Spread, rounded};
use crate::speed::{REFERENCE_RAYS, Row};

/// Times to an error, ratios at equal error and every effort.
///
/// * `title`: its heading.
/// * `quantity`: what the error is of, as [`crate::speed::quantity`] says.
/// * `ceiling`: seconds of a bake over those of the bare loop, one thread each.
pub fn markdown(title: &str, quantity: &str, rows: &[Row], ceiling: Option<Spread>) -> String {
    let curves = curves(rows);
    let clock = clock(rows);
    let mut text = format!("# {title}\n");
    if let Some(first) = curves.first() {
        let repeats = first.points.iter().map(|p| p.seconds.repeats).max();
        text += &notes(quantity, clock, repeats.unwrap_or(0));
        text += &at_equal_error(clock, &curves);
        text += &efforts(clock, &curves);
    }
    if let Some(ratio) = ceiling {
        text += &format!(
            "\nThe bake takes {ratio} times as long as the bare rtcOccluded16 loop over its packets (one thread).\n"
        );
    }
    text
}

/// What the numbers are, above the tables.
fn notes(quantity: &str, clock: &str, repeats: usize) -> String {
    let mut text = format!(
        "\nRMSE is of the {quantity} over covered texels, against {REFERENCE_RAYS} rays of another seed. {clock} \
         seconds are of the bake over all threads, without building the ray scene and without writing.\n"
    );
    text += &match repeats {
        1 => "There is one repeat: the spread is not known.\n".into(),
        _ => format!(
            "A number is the median of {repeats} repeats; in brackets are the least and the most of them.\n"
        ),
    };
    if clock == "wall" {
        text += "This system does not tell the time on the CPU.\n";
    }
    text
}

/// Seconds to each error that the first technique measured, then the ratios to it.
fn at_equal_error(clock: &str, curves: &[Curve]) -> String {
    let [first, others @ ..] = curves else {
        return String::new();
    };
    let errors = first.round_errors();
    if errors.is_empty() {
        return format!(
            "\nTechniques are not compared: no error of 1, 2, 3 or 5 times a power of ten lies between those of \
             `{}`.\n",
            first.name
        );
    }
    let mut text = format!(
        "\n{clock} seconds to an RMSE, on a straight line in logarithms between the two neighbouring efforts on \
         either side of it, each repeat by itself. The errors are those that `{}` measured; `-` where the efforts of \
         a technique do not lie on both sides of the error in every repeat. Nothing is extrapolated.\n\n",
        first.name
    );
    text += &table(curves, &errors, |curve, error| curve.seconds_to(error));
    if !others.is_empty() {
        text += &format!(
            "\n{clock} seconds over those of `{}` to the same RMSE in the same repeat; below 1 is faster.\n\n",
            first.name
        );
        text += &table(others, &errors, |curve, error| curve.ratio_to(first, error));
    }
    text
}

fn table(curves: &[Curve], errors: &[f64], cell: impl Fn(&Curve, f64) -> Option<Spread>) -> String {
    let heads = errors
        .iter()
        .map(|error| format!(" RMSE {} |", rounded(*error, 1)));
    let mut text = format!("| technique |{}\n", heads.collect::<String>());
    text += &format!("|---|{}\n", "---|".repeat(errors.len()));
    for curve in curves {
        let cells = errors.iter().map(|error| match cell(curve, *error) {
            Some(spread) => format!(" {spread} |"),
            None => " - |".into(),
        });
        text += &format!("| {} |{}\n", curve.name, cells.collect::<String>());
    }
    text
}

/// Every effort of every technique.
fn efforts(clock: &str, curves: &[Curve]) -> String {
    let mut text = format!(
        "\nEvery effort. `stated` is the RMSE that the bake itself states.\n\n\
         | technique | effort | rays / texel | RMSE | stated | {clock} s | Mrays / {clock} s |\n\
         |---|---|---|---|---|---|---|\n"
    );
    for curve in curves {
        for p in &curve.points {
            text += &format!(
                "| {} | {} | {:.1} | {:.5} | {:.5} | {} | {} |\n",
                curve.name,
                p.effort,
                p.rays_per_texel,
                p.rmse,
                p.estimated_rmse,
                p.seconds,
                rounded(p.rate, 3)
            );
        }
    }
    text
}
