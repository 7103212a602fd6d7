//! Cases that break bakers, baked on every backend and held against their exact values.

use crate::support::table;
use bench::hard::{Status, cases, markdown, run};
use std::f64::consts::TAU;

#[test]
fn hard_cases_are_within_their_bounds() {
    let rows = run().expect("every scene is baked");
    println!("{}", markdown(&rows));
    let failed: Vec<_> = rows
        .into_iter()
        .filter(|row| row.status == Status::Fails)
        .collect();
    assert!(failed.is_empty(), "\n{}", markdown(&failed));
}

/// A line of the table starts with two quoted fields and the value.
fn line(text: &str) -> Option<(&str, &str, f64)> {
    let mut fields = text.strip_prefix('"')?.splitn(3, "\",");
    let (case, quantity) = (fields.next()?, fields.next()?.strip_prefix('"')?);
    Some((
        case,
        quantity,
        fields.next()?.split(',').next()?.parse().ok()?,
    ))
}

#[test]
fn formulas_of_the_hard_cases_give_the_digits_of_the_table() {
    let rows = table("hard_cases.csv");
    let lines: Vec<_> = rows.iter().filter_map(|row| line(row)).collect();
    assert_eq!(lines.len(), rows.len(), "every row can be read");
    let mut compared = 0;
    for case in cases() {
        for expected in &case.expected {
            let Some(entry) = expected.table else {
                continue;
            };
            let &(.., value) = lines
                .iter()
                .find(|(case, quantity, _)| {
                    *case == entry.case && quantity.starts_with(entry.quantity)
                })
                .unwrap_or_else(|| panic!("{}: {entry:?} is not in the table", case.name));
            let value = if entry.complement { 1.0 - value } else { value };
            // The formulas run in f64: a few of its ulps of 1, and the ulp of an angle times the slope √(n/2π) of a
            // lobe.
            let slope = (case.setup.exponent.unwrap_or(0.0) / TAU).sqrt();
            assert!(
                (expected.value - value).abs() < 4e-15 + slope * f64::EPSILON,
                "{}: {} is not {value}",
                case.name,
                expected.value
            );
            compared += 1;
        }
    }
    assert!(compared > 40, "only {compared} values compared");
}
