//! Where land and sea meet: what lies behind one of two surfaces that cross, and what a texel on both sides of a shore
//! holds.

use crate::support::bake;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A beach that rises by 0.2 along x and 0.03 along z, 2 wide to each side, and a sea of height 0.03 that reaches
/// beyond it.
fn beach(folder: &Path) -> PathBuf {
    let path = folder.join("beach.obj");
    let mut text = String::from("o land\n");
    let square = |half: f64| [(-half, -half), (-half, half), (half, half), (half, -half)];
    for (x, z) in square(2.0) {
        writeln!(text, "v {x} {} {z}", 0.2 * x + 0.03 * z).expect("a string");
    }
    for (x, z) in square(5.0) {
        writeln!(text, "v {x} 0.03 {z}").expect("a string");
    }
    text += "f 1 2 3 4\no sea\nf 5 6 7 8\n";
    std::fs::write(&path, text).expect("a file");
    path
}

#[test]
fn a_sea_beyond_its_land_has_no_dark_rim_along_the_shore() {
    let folder = tempfile::tempdir().expect("a folder");
    let flags = "--size 256 --rays 64 --uv auto --layers position,object --seams off";
    let flags: Vec<&str> = flags.split(' ').collect();
    let (_folder, page) = bake(&beach(folder.path()), &flags);
    let [x, z, object] = ["position.X", "position.Z", "object"].map(|name| page.plane(name));
    let texel = {
        let covered = page.plane("coverage").iter().filter(|c| **c > 0.0).count();
        (116.3 / covered as f64).sqrt()
    };
    let shore = |i: usize| 0.15 - 0.15 * f64::from(z[i]);
    // Before the shore the beach hides less than a hundredth of the sky.
    let rim = |i: &usize| {
        let before = shore(*i) - f64::from(x[*i]);
        object[*i] == 1.0 && z[*i].abs() < 1.8 && before > 0.0 && before < 1.5 * texel
    };
    let light: Vec<f32> = (0..x.len())
        .filter(rim)
        .map(|i| page.plane("diffuse")[i])
        .collect();
    assert!(light.len() > 20, "{} texels", light.len());
    // Texels of which a tenth lies before the shore are filled from both sides; whole ones had 0.55 and 0.91.
    let least = light.iter().copied().fold(1.0, f32::min);
    let mean = light.iter().sum::<f32>() / light.len() as f32;
    assert!(least > 0.65 && mean > 0.94, "{least} {mean}");
    // One looks under the land from beyond its end: that is kept, and dark.
    let under = |i: &usize| {
        let behind = f64::from(x[*i]) - shore(*i);
        object[*i] == 1.0 && z[*i].abs() < 1.8 && behind > 2.0 * texel && x[*i] < 1.0
    };
    let dark: Vec<f32> = (0..x.len())
        .filter(under)
        .map(|i| page.plane("diffuse")[i])
        .collect();
    let mean = dark.iter().sum::<f32>() / dark.len() as f32;
    assert!(dark.len() > 100 && mean < 0.2, "{mean} of {}", dark.len());
}
