//! Made-up rows whose times to an error and ratios are known.

use super::curve::curves;
use super::{markdown, svg};
use crate::speed::{Row, TECHNIQUES};

/// Rays of the first technique and of the second.
const FIRST: &[u32] = &[16, 32, 64, 128, 256, 512, 1024];
const SECOND: &[u32] = &[16, 32, 64, 128, 256];

/// Between 256 and 128 rays of [`row`], which both techniques have.
const SHARED: f64 = 0.02;

fn row(technique: usize, rays: u32, repeat: u32, rmse: f64, seconds: f64) -> Row {
    Row {
        technique: TECHNIQUES[technique].name,
        effort: format!("rays {rays}"),
        repeat,
        rmse,
        estimated_rmse: rmse,
        cpu_seconds: seconds,
        wall_seconds: 0.5 * seconds,
        rays: u64::from(rays) * 10,
        texels: 10,
    }
}

/// rmse = n^-3/4 and seconds = factor · n ms: seconds = factor · rmse^-4/3 ms.
fn law(technique: usize, efforts: &[u32], factors: &[f64]) -> Vec<Row> {
    let mut rows = Vec::new();
    for (repeat, factor) in factors.iter().enumerate() {
        rows.extend(efforts.iter().map(|&n| {
            let rmse = f64::from(n).powf(-0.75);
            row(
                technique,
                n,
                repeat as u32,
                rmse,
                1e-3 * factor * f64::from(n),
            )
        }));
    }
    rows
}

fn both() -> Vec<Row> {
    let mut rows = law(0, FIRST, &[0.5, 1.0, 4.0]);
    rows.extend(law(1, SECOND, &[0.75, 3.0, 8.0]));
    rows
}

#[track_caller]
fn assert_near(found: f64, exact: f64) {
    // Logarithms and powers of f64.
    assert!(
        (found / exact - 1.0).abs() < 1e-12,
        "{found} is not {exact}"
    );
}

#[test]
fn times_to_a_measured_error_follow_the_power_law() {
    let rows = both();
    let first = &curves(&rows)[0];
    for rmse in [0.1_f64, 0.03, SHARED, 0.006] {
        let exact = 1e-3 * rmse.powf(-4.0 / 3.0);
        let found = first.seconds_to(rmse).expect("it was measured");
        assert_near(found.median, exact);
        assert_near(found.min, 0.5 * exact);
        assert_near(found.max, 4.0 * exact);
    }
    // At a measured point, also at the first and at the last, its own time.
    let [start, end] = [16, 1024].map(|n| f64::from(n).powf(-0.75));
    assert_near(first.seconds_to(start).expect("measured").median, 0.016);
    assert_near(first.seconds_to(end).expect("measured").median, 1.024);
}

#[test]
fn no_time_is_extrapolated() {
    let curves = curves(&both());
    let [first, second] = [&curves[0], &curves[1]];
    // Below the last effort of 1,024 and 256 rays, above the first of 16.
    for (curve, rmse) in [
        (first, 0.0055),
        (second, 0.0155),
        (first, 0.126),
        (second, 0.126),
    ] {
        let found = curve.seconds_to(rmse);
        assert_eq!(found, None, "{} to {rmse}", curve.name);
    }
    assert!(first.seconds_to(0.0155).is_some());
    assert_eq!(second.ratio_to(first, 0.0155), None);

    // One repeat of three that stays above the error.
    let mut rows = law(0, FIRST, &[1.0; 3]);
    rows.retain(|row| row.repeat != 1 || row.effort != "rays 1024");
    let curve = &super::curve::curves(&rows)[0];
    assert_eq!(curve.seconds_to(0.006), None);
    assert!(curve.seconds_to(0.01).is_some());
}

#[test]
fn an_error_that_the_least_effort_beats_has_no_time() {
    // Its error rises once above what is asked for; only the way down there is a price of the error.
    let points = [(16, 0.008), (32, 0.03), (64, 0.004)];
    let rows: Vec<Row> = points
        .map(|(n, rmse)| row(0, n, 0, rmse, f64::from(n)))
        .into();
    assert_eq!(curves(&rows)[0].seconds_to(0.01), None);
}

#[test]
fn ratios_are_of_one_error_and_one_repeat_with_their_spread() {
    let curves = curves(&both());
    let ratio = curves[1]
        .ratio_to(&curves[0], SHARED)
        .expect("both measured it");
    // By repeat: 0.75 / 0.5, 3 / 1, 8 / 4. The ratio of the medians would be 3.
    assert_near(ratio.median, 2.0);
    assert_near(ratio.min, 1.5);
    assert_near(ratio.max, 3.0);
    let own = curves[0].ratio_to(&curves[0], SHARED).expect("measured");
    assert_eq!((own.median, own.min, own.max), (1.0, 1.0, 1.0));
}

#[test]
fn ratios_need_the_same_repeats_of_both() {
    let mut rows = both();
    rows.retain(|row| row.technique == TECHNIQUES[0].name || row.repeat != 2);
    let curves = curves(&rows);
    assert!(curves[1].seconds_to(SHARED).is_some());
    assert_eq!(curves[1].ratio_to(&curves[0], SHARED), None);
}

/// A technique whose least effort takes longest, its rows in any order.
fn slow_start() -> Vec<Row> {
    let seconds = [(64, 1.5), (16, 4.0), (128, 1.25), (32, 2.0), (256, 6.0)];
    seconds
        .map(|(n, s)| row(0, n, 0, f64::from(n).powf(-0.75), s))
        .into()
}

#[test]
fn points_stand_by_effort_where_time_does_not_rise() {
    let curve = &curves(&slow_start())[0];
    let efforts: Vec<&str> = curve.points.iter().map(|p| p.effort.as_str()).collect();
    let rising = ["rays 16", "rays 32", "rays 64", "rays 128", "rays 256"];
    assert_eq!(efforts, rising);
    // Between 64 and 128 rays, in the middle of the logarithms.
    let middle = (64.0f64 * 128.0).sqrt().powf(-0.75);
    let found = curve.seconds_to(middle).expect("measured");
    assert_near(found.median, (1.5f64 * 1.25).sqrt());
}

#[test]
fn the_line_of_a_picture_joins_points_by_effort() {
    let picture = svg("t", "diffuse term", &slow_start()).expect("the rows have errors");
    let lines = picture.lines().filter(|line| line.contains("<polyline"));
    let heights = lines.map(|line| -> Vec<f64> {
        let points = line
            .split("points=\"")
            .nth(1)
            .and_then(|rest| rest.split('"').next());
        let pairs = points.expect("a line has points").split_whitespace();
        let height = |pair: &str| pair.split(',').nth(1).and_then(|y| y.parse().ok());
        pairs.filter_map(height).collect()
    });
    let five: Vec<Vec<f64>> = heights.filter(|line| line.len() == 5).collect();
    assert_eq!(five.len(), 1, "{picture}");
    // Downward: every effort has less error than the one before.
    let falls = five[0].windows(2).all(|pair| pair[1] > pair[0]);
    assert!(falls, "{:?}", five[0]);
}

#[test]
fn the_table_says_what_was_not_measured_and_at_which_errors() {
    let text = markdown("t", "diffuse term", &both(), None);
    assert!(!text.contains("fficiency"), "{text}");
    // 16 to 1,024 rays of the first technique: 0.125 to 0.0055.
    let head = "| technique | RMSE 0.1 | RMSE 0.05 | RMSE 0.03 | RMSE 0.02 | RMSE 0.01 |\n";
    assert_eq!(text.matches(head).count(), 2, "{text}");
    let second = format!("| {} |", TECHNIQUES[1].name);
    let lines: Vec<&str> = text
        .lines()
        .filter(|line| line.starts_with(&second))
        .collect();
    assert!(lines[0].ends_with("| - |"), "{}", lines[0]);
    let ratios = "2.00 (1.50 to 3.00) | 2.00 (1.50 to 3.00) | - |";
    assert!(lines[1].ends_with(ratios), "{}", lines[1]);
}

#[test]
fn table_and_picture_name_technique_quantity_and_clock() {
    let mut rows = both();
    let ceiling = super::Spread::of(&[1.5, 1.25, 2.0]);
    let table = markdown("t", "irradiance", &rows, ceiling);
    assert!(table.contains("1.50 (1.25 to 2.00) times"), "{table}");
    let picture = svg("t", "irradiance", &rows).expect("the rows have errors");
    assert!(picture.contains("slope -3/4"), "{picture}");
    for text in [&table, &picture] {
        let words = [
            TECHNIQUES[0].name,
            "RMSE",
            "of the irradiance",
            "CPU seconds",
        ];
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
    }
    for row in &mut rows {
        row.wall_seconds = row.cpu_seconds;
    }
    let table = markdown("t", "irradiance", &rows, None);
    assert!(
        table.contains("wall seconds") && !table.contains("CPU s"),
        "{table}"
    );
    assert!(svg("t", "irradiance", &[]).is_err());
}
