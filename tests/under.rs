//! Sheets that lie just above a surface take no light from it.

use crate::bounces::obj;
use crate::support::{Page, backends, bake, run};

/// A floor of 4 by 4 over y = 0 and a mark of its middle square a thousandth above it, which looks up too.
const MARKED: &str = "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\n\
    v -1 .001 -1\nv 1 .001 -1\nv 1 .001 1\nv -1 .001 1\n\
    o floor\nf 4 3 2 1\no mark\nusemtl mark\nf 8 7 6 5\n";

/// Of the floor's texels: the least value, and the mean of those that lie within 0.9 of the middle.
fn floor(page: &Page, channel: &str) -> [f64; 2] {
    let (mut least, mut sum, mut count) = (f64::INFINITY, 0.0, 0);
    for texel in 0..page.plane("object").len() {
        if page.plane("coverage")[texel] == 0.0 || page.plane("object")[texel] != 0.0 {
            continue;
        }
        let value = f64::from(page.plane(channel)[texel]);
        least = value.min(least);
        let [x, z] = ["position.X", "position.Z"].map(|axis| page.plane(axis)[texel].abs());
        if x.max(z) < 0.9 {
            sum += value;
            count += 1;
        }
    }
    assert!(count > 100, "{count} texels under the mark");
    [least, sum / f64::from(count)]
}

#[test]
fn what_lies_under_a_mark_has_the_light_of_the_floor_without_it() {
    let folder = tempfile::tempdir().expect("a folder");
    // See-through by half, and opaque.
    for (materials, dark) in [
        ("newmtl mark\nd .5\n", 0.5),
        ("newmtl mark\nKd 1 1 1\n", 0.0),
    ] {
        let path = obj(folder.path(), materials, MARKED);
        for backend in backends() {
            let with = |more: &[&str]| {
                let layers = "diffuse,object,validity,position";
                let small = ["--size", "128", "--rays", "256", "--only", layers];
                let all = [&small[..], &["--backend", backend], more].concat();
                bake(&path, &all).1
            };
            // Without the mark all of the floor is 1. Beside it a texel of a thirtieth sees an edge a thousandth high.
            for more in [&[][..], &["--under", "0.001"], &["--under", "0.05"]] {
                let page = with(more);
                let [least, mean] = floor(&page, "diffuse");
                assert!((mean - 1.0).abs() < 1e-6, "{more:?}: {mean} under the mark");
                assert!(least > 0.97, "{more:?}: {least} beside it");
                assert_eq!(floor(&page, "validity")[0], 1.0);
            }
            // With half as much it takes all light, and in between a share that falls evenly.
            for (under, share) in [
                ("0", 0.0),
                ("0.0005", 0.0),
                ("0.000625", 0.4),
                ("0.0008", 0.75),
            ] {
                let [_, mean] = floor(&with(&["--under", under]), "diffuse");
                let expected = share + (1.0 - share) * dark;
                assert!(
                    (mean - expected).abs() < 0.01,
                    "--under {under}: {mean}, not {expected}"
                );
            }
        }
    }
}

#[test]
fn a_mark_far_above_for_its_size_takes_no_light_where_that_is_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    // A tenth of the mark's length above the floor.
    let text = MARKED.replace(".001", ".2");
    let path = obj(folder.path(), "newmtl mark\n", &text);
    let mean = |under: &str| {
        let layers = "diffuse,object,validity,position";
        let small = ["--size", "64", "--rays", "64", "--only", layers];
        let page = bake(&path, &[&small[..], &["--under", under]].concat()).1;
        floor(&page, "diffuse")[1]
    };
    assert!(mean("0.1") < 0.5, "{}", mean("0.1"));
    for under in ["0.21", "1"] {
        assert!((mean(under) - 1.0).abs() < 1e-6, "{under}: {}", mean(under));
    }
}

#[test]
fn a_distance_below_zero_is_refused() {
    let refused = run(["bake", "scenes/plane.obj", "--under=-1"]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(
        said.contains("--under") && said.contains("at least 0"),
        "{said}"
    );
}
