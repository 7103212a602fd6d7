//! Six photographs to one map, by the built program.

use crate::support::{run, run_well, save_image};

#[test]
fn six_photographs_of_unlike_exposure_become_the_map_that_they_were_taken_of() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let text = |name: &str| at(name).display().to_string();
    let sky = |[x, y, z]: [f64; 3]| 1.0 + 0.4 * y + 0.2 * (3.0 * x + z).sin();
    // Faces of a cube as `map convert` has them, each exposed differently.
    let (n, gains) = (48, [0.8, 1.0, 1.25, 1.1, 0.9, 1.05]);
    let cube = environment::Projection::Cube;
    for (face, name) in environment::FACES.into_iter().enumerate() {
        let value = |at: usize| {
            let place = (at % n, face * n + at / n);
            let (x, y) = (place.0 as f64 + 0.5, place.1 as f64 + 0.5);
            let direction = cube.direction((n, 6 * n), x, y).expect("on the cube");
            (sky(direction) * gains[face]) as f32
        };
        let image = environment::Image {
            width: n,
            height: n,
            pixels: (0..n * n).map(|at| [value(at); 3]).collect(),
        };
        save_image(at(&format!("p_{name}.exr")), &image);
    }
    let (input, output) = (text("p.exr"), text("map.exr"));
    let told = run_well(["map", "mosaic", &input, "-o", &output, "--json"]);
    let told: serde_json::Value = serde_json::from_str(&told).expect("JSON");
    let mean = gains.iter().map(|g: &f64| g.ln()).sum::<f64>() / 6.0;
    for (face, gain) in gains.into_iter().enumerate() {
        let found = told["gains"][face][1].as_f64().expect("a factor");
        let off = (found * gain).ln() - mean;
        // Faces of 90 degrees share no pixel: their outermost ones lie 1.9 degrees apart, over which this sky changes
        // by 1 to 2 %.
        assert!(
            off.abs() < 0.01,
            "{face}: {found} undoes {gain} but for {off}"
        );
    }
    let map = maps::read_polar(&at("map.exr")).expect("a polar map").map;
    for direction in [
        [0.6, 0.0, 0.8],
        [0.0, 0.8, 0.6],
        [-0.48, -0.6, 0.64],
        [0.6, 0.0, -0.8],
    ] {
        let found = f64::from(map.bilinear(direction)[0]) / mean.exp();
        assert!(
            (found / sky(direction) - 1.0).abs() < 0.02,
            "{direction:?}: {found}"
        );
    }
    let narrow = run(["map", "mosaic", &input, "-o", &output, "--fov-deg", "60"]);
    let errors = String::from_utf8_lossy(&narrow.stderr);
    assert!(
        narrow.status.code() == Some(1) && errors.contains("90 degrees"),
        "{errors}"
    );
}
