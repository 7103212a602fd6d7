//! The summaries of recorded runs are what their rows say.
//!
//! `AMBAKE_REBUILD_RUNS=1 cargo test -p ambake-bench --test runs` writes tables and pictures anew from the rows, which
//! stay as they were recorded.

use ambake_bench::speed::{Row, TECHNIQUES};
use ambake_bench::summary::{markdown, svg};
use ambake_bench::{maps, tables};
use std::path::{Path, PathBuf};

const DIFFUSE: &str = "diffuse term";
const IRRADIANCE: &str = "irradiance (mean of its channels)";

/// Rows of each run without their ending, and what their errors are of.
const RUNS: [(&str, &str); 7] = [
    ("colonnade-2026-11/bench", DIFFUSE),
    ("room-2026-11/bench", DIFFUSE),
    ("sphere-2026-11/bench", DIFFUSE),
    ("terrain-2026-11/bench", DIFFUSE),
    ("zdm2-2026-11/bench", DIFFUSE),
    ("sky-2026-11/spiaggia_di_mondello", IRRADIANCE),
    ("sky-2026-11/venice_sunset", IRRADIANCE),
];

#[test]
fn tables_of_recorded_techniques_are_what_their_rows_say() {
    for (run, quantity) in RUNS {
        let rows: Vec<Row> = lines(&format!("{run}.csv"))
            .filter_map(|line| row(&line))
            .collect();
        let recorded = read(&format!("{run}.md"));
        let title = recorded
            .lines()
            .next()
            .and_then(|line| line.strip_prefix("# "));
        let title = title.expect("a table has a title");
        if rebuild() {
            let picture = svg(title, quantity, &rows).expect("the rows have errors");
            std::fs::write(file(&format!("{run}.svg")), picture).expect("the picture is written");
        }
        check(
            &format!("{run}.md"),
            &markdown(title, quantity, &rows, None),
        );
    }
}

#[test]
fn the_table_of_the_recorded_convolution_is_what_its_rows_say() {
    let rows = lines("maps-2026-11/maps.csv").map(|line| {
        let fields: Vec<&str> = line.split(',').collect();
        maps::Row {
            case: fields[0].into(),
            kernel: fields[1].into(),
            seconds: number(fields[2]),
            double_sum_seconds: number(fields[3]),
            sampled: number(fields[4]) as usize,
            ratio: number(fields[5]),
            from_double_sum: number(fields[6]),
            from_fine_sum: number(fields[7]),
        }
    });
    check(
        "maps-2026-11/maps.md",
        &maps::markdown(&rows.collect::<Vec<_>>()),
    );
}

#[test]
fn the_table_of_the_recorded_look_ups_is_what_its_rows_say() {
    let rows = lines("tables-2026-11/tables.csv").map(|line| {
        let (case, fields) = quoted(&line);
        tables::Row {
            case: case.into(),
            lookup: fields[0].into(),
            pixels: number(fields[1]) as usize,
            rms: number(fields[2]),
            flicker: number(fields[3]),
        }
    });
    let speed = lines("tables-2026-11/tables_speed.csv").map(|line| {
        let fields: Vec<&str> = line.split(',').collect();
        tables::Speed {
            lookup: fields[0].into(),
            pixels: number(fields[1]) as usize,
            milliseconds: number(fields[2]),
            spread: [number(fields[3]), number(fields[4])],
        }
    });
    let (rows, speed): (Vec<_>, Vec<_>) = (rows.collect(), speed.collect());
    check("tables-2026-11/tables.md", &tables::markdown(&rows, &speed));
}

/// Holds a recorded table against the one of its rows, or replaces it.
fn check(name: &str, table: &str) {
    let recorded = read(name);
    if rebuild() {
        // What no row holds: the ratio to the bare loop, version and options.
        let ours = |line: &&str| line.starts_with("The bake takes") || line.starts_with("ambake ");
        let rest: String = recorded
            .lines()
            .filter(ours)
            .map(|line| format!("\n{line}\n"))
            .collect();
        std::fs::write(file(name), format!("{table}{rest}")).expect("the table is written");
        return;
    }
    assert!(
        recorded.starts_with(table),
        "{name} is not what its rows say; see the head of this test to rebuild it:\n{table}"
    );
}

fn rebuild() -> bool {
    std::env::var_os("AMBAKE_REBUILD_RUNS").is_some()
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("runs")
        .join(name)
}

fn read(name: &str) -> String {
    std::fs::read_to_string(file(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The lines below the head.
fn lines(name: &str) -> impl Iterator<Item = String> {
    let lines: Vec<String> = read(name).lines().skip(1).map(String::from).collect();
    lines.into_iter()
}

fn number(text: &str) -> f64 {
    text.parse()
        .unwrap_or_else(|error| panic!("{text}: {error}"))
}

/// The quoted first field of a line, and the others.
fn quoted(line: &str) -> (&str, Vec<&str>) {
    let parts = line
        .strip_prefix('"')
        .and_then(|line| line.split_once("\","));
    let (first, rest) = parts.unwrap_or_else(|| panic!("{line} has no quoted field"));
    (first, rest.split(',').collect())
}

/// A bake; `None` where it is of a technique that is gone.
fn row(line: &str) -> Option<Row> {
    let (name, fields) = quoted(line);
    // The flag had another name when the rows were recorded.
    let name = name.replace("--filter", "--denoise");
    if name == "the same, --pattern tiled" {
        return None;
    }
    let technique = TECHNIQUES.iter().find(|technique| technique.name == name);
    Some(Row {
        technique: technique
            .unwrap_or_else(|| panic!("no technique {name}"))
            .name,
        effort: fields[0].into(),
        repeat: number(fields[1]) as u32,
        rmse: number(fields[2]),
        estimated_rmse: number(fields[3]),
        cpu_seconds: number(fields[4]),
        wall_seconds: number(fields[5]),
        rays: number(fields[6]) as u64,
        texels: number(fields[7]) as u64,
    })
}
