//! What the plan says of each term is what runs.

use crate::support::{bake, report, run_well, scene};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The methods of diffuse, visibility and specular in a list of decisions.
fn methods(plan: &Value) -> [String; 3] {
    ["diffuse", "visibility", "specular"].map(|term| {
        let decisions = plan.as_array().expect("a list");
        let found = decisions.iter().find(|d| d["decision"] == term);
        let method = &found.expect("a decision for each term")["method"];
        method.as_str().expect("a method").to_owned()
    })
}

/// The methods that `plan` and `bake` state, which must be the same.
fn stated(file: &Path, arguments: &[&str]) -> [String; 3] {
    let name = file.to_str().expect("a UTF-8 path");
    let json = run_well([&["plan", name, "--json"], arguments].concat());
    let plan: Value = serde_json::from_str(&json).expect("JSON");
    let (folder, _) = bake(file, arguments);
    let planned = methods(&plan["plan"]);
    assert_eq!(planned, methods(&report(folder.path())["plan"]), "{name}");
    planned
}

/// A convex body with smooth normals, written into `folder`: an octahedron with each face cut into 64 triangles whose
/// corners lie on the unit sphere.
fn smooth_body(folder: &Path) -> PathBuf {
    const STEPS: usize = 8;
    let mut text = String::new();
    let mut count = 0;
    for octant in 0..8 {
        let sign = [0, 1, 2].map(|axis| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 });
        let turned = sign[0] * sign[1] * sign[2] < 0.0;
        let mut corner = |i: usize, j: usize| {
            let at = [i, j, STEPS - i - j].map(|k| k as f64);
            let length = at.iter().map(|x| x * x).sum::<f64>().sqrt();
            let [x, y, z] = [0, 1, 2].map(|axis| sign[axis] * at[axis] / length);
            text += &format!("v {x} {y} {z}\nvn {x} {y} {z}\n");
            count += 1;
            count
        };
        let mut faces = Vec::new();
        for i in 0..STEPS {
            for j in 0..STEPS - i {
                faces.push([corner(i, j), corner(i + 1, j), corner(i, j + 1)]);
                if i + j + 2 <= STEPS {
                    faces.push([corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]);
                }
            }
        }
        for [a, b, c] in faces {
            let [b, c] = if turned { [c, b] } else { [b, c] };
            text += &format!("f {a}//{a} {b}//{b} {c}//{c}\n");
        }
    }
    let path = folder.join("body.obj");
    std::fs::write(&path, text).expect("a file");
    path
}

#[test]
fn plan_and_report_state_one_method_for_each_term() {
    let small = ["--size=64", "--rays=16"];
    let with = |more: &[&'static str]| [&small[..], more].concat();
    let closed = "closed_form";
    let cases: [(&str, Vec<&str>, [&str; 3]); 5] = [
        ("plane.obj", with(&[]), [closed, closed, "off"]),
        ("plane.obj", with(&["--exponent=9"]), [closed; 3]),
        (
            "plane.obj",
            with(&["--exponent=9", "--view=1,2,3"]),
            [closed; 3],
        ),
        (
            "wall_long.obj",
            with(&["--only=diffuse"]),
            ["rays", "off", "off"],
        ),
        (
            "plane.obj",
            with(&["--plan-off=open"]),
            ["rays", "rays", "off"],
        ),
    ];
    for (name, arguments, expected) in cases {
        let found = stated(&scene(name), &arguments);
        assert_eq!(found, expected, "{name} {arguments:?}");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let body = smooth_body(folder.path());
    for (shading, lobe) in [
        ("--shading=production", closed),
        ("--shading=exact", "rays"),
    ] {
        let found = stated(&body, &with(&["--exponent=9", "--view=0,0,9", shading]));
        assert_eq!(
            found,
            [closed, closed, lobe],
            "smooth convex body, {shading}"
        );
    }
}

#[test]
fn closed_forms_of_a_smooth_body_are_no_samples() {
    let folder = tempfile::tempdir().expect("a folder");
    let (baked, page) = bake(
        &smooth_body(folder.path()),
        &[
            "--size=128",
            "--rays=256",
            "--exponent=9",
            "--view=0,0,9",
            "--shading=exact",
        ],
    );
    let [coverage, visibility, diffuse, errors] =
        ["coverage", "visibility", "diffuse", "error"].map(|name| page.plane(name));
    let covered: Vec<usize> = (0..coverage.len())
        .filter(|&i| coverage[i] == 1.0)
        .collect();
    assert!(covered.len() > 1000, "{} texels", covered.len());
    // Both are functions of the lean of the shading normal alone: diffuse = (1 + cos(pi (1 - visibility))) / 2. A texel
    // is a mean over leans, and the curve's second derivative is at most 1/2: it misses by at most a quarter of their
    // variance.
    let lean = |i: usize| std::f64::consts::PI * (1.0 - f64::from(visibility[i]));
    let most = covered.iter().map(|&i| lean(i)).fold(0.0, f64::max);
    // No normal of this body leans by more than 0.16 rad, so the variance is at most 0.08².
    assert!(
        (0.01..0.16).contains(&most),
        "the normals lean by up to {most} rad"
    );
    let tolerance = 0.25 * 0.08 * 0.08;
    for &i in &covered {
        let expected = 0.5 * (1.0 + lean(i).cos());
        assert!(
            (f64::from(diffuse[i]) - expected).abs() <= tolerance,
            "texel {i}: {} for {expected}",
            diffuse[i]
        );
        assert!(errors[i] < 2e-3, "texel {i}: stated {}", errors[i]);
    }
    // Counts of 256 rays would be multiples of 1/256 in the sums; closed forms are not.
    let steps = covered
        .iter()
        .filter(|&&i| (diffuse[i] * 1024.0).fract() == 0.0);
    let (steps, all) = (steps.count(), covered.len());
    assert!(
        steps < all / 10,
        "{steps} of {all} values lie on steps of 1/1024"
    );
    assert_eq!(report(baked.path())["rays"], 0, "no ray is cast");
}

/// Equation (1) of the paper: J = I_a k_a, times visibility.
#[test]
fn the_traditional_term_reflects_by_the_coefficient_that_is_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    let materials = "newmtl own\nKa 0.9 0.1 0.2\nKd 0.3 0.3 0.3\nnewmtl none\nKd 0.5 0.25 0.75\n\
                     newmtl white\nKa 1 1 1\nKd 0.4 0.4 0.4\n";
    let quad = |x: i32, name: &str| {
        format!(
            "o {name}\nusemtl {name}\nv {x} 0 0\nv {x} 0 1\nv {y} 0 1\nv {y} 0 0\nf -4 -3 -2 -1\n",
            y = x + 1
        )
    };
    let text = ["own", "none", "white"].into_iter().zip([0, 2, 4]);
    let text: String = text.map(|(name, x)| quad(x, name)).collect();
    let path = crate::bounces::obj(folder.path(), materials, &text);
    let common = "--size 32 --rays 4 --sky 2,3,4 --layers ambient,object,visibility";
    let common: Vec<&str> = common.split(' ').collect();
    let kd = [[0.3; 3], [0.5, 0.25, 0.75], [0.4; 3]];
    let ka = [[0.9, 0.1, 0.2], [0.5, 0.25, 0.75], [1.0; 3]];
    let one = [[0.6, 0.7, 0.8]; 3];
    for (more, expected, warns) in [
        (&[][..], kd, true),
        (&["--ambient-coefficient", "file"], ka, false),
        (&["--ambient-coefficient", "0.6,0.7,0.8"], one, false),
    ] {
        let (out, page) = bake(&path, &[&common[..], more].concat());
        let counted = report(out.path())["warnings"].to_string();
        assert_eq!(counted.contains("ambient-coefficients"), warns, "{counted}");
        let objects = page.plane("object");
        let mut judged = [0; 3];
        for (c, channel) in ["R", "G", "B"].into_iter().enumerate() {
            let sky = [2.0, 3.0, 4.0][c];
            let [value, own] =
                ["traditional", "ambient"].map(|layer| page.plane(&format!("{layer}.{channel}")));
            for texel in (0..objects.len()).filter(|&texel| objects[texel] >= 0.0) {
                let object = objects[texel] as usize;
                let exact = expected[object][c];
                // Nothing stands over the quads.
                assert!(
                    (f64::from(value[texel]) - sky * exact).abs() < 1e-6,
                    "{more:?}"
                );
                assert!((f64::from(own[texel]) - exact).abs() < 1e-7, "{more:?}");
                judged[object] += 1;
            }
        }
        assert!(judged.iter().all(|&count| count > 100), "{judged:?}");
    }
}
