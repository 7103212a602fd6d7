//! How much of the borders of charts lies inside flat faces of one material, where a look-up shows a step for no
//! reason.

use crate::models::skip;
use ambake_atlas::{Atlas, Options, UvMode, facts, layout};
use glam::DVec3;
use scene::Scene;
use std::collections::HashMap;

/// Cosine of a quarter of a degree: planes that turn by less are one.
const FLAT: f64 = 1.0 - 1e-5;
/// Edges are one line where ends lie off it by less than this share of the object.
const OFF: f64 = 1e-5;

/// An edge of a triangle that no other triangle of its chart shares, in the world.
struct Border {
    from: DVec3,
    to: DVec3,
    normal: DVec3,
    at: [[u32; 2]; 2],
}

/// Length of cuts inside flat faces in scene units, and of all borders.
///
/// Found from edges alone, pair by pair: two borders of one object that run along one another in opposite directions,
/// whose triangles lie in one plane, and whose ends are not at one place on the page.
pub fn cuts(scene: &Scene, atlas: &Atlas) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (instance, placement) in scene.instances.iter().zip(&atlas.placements) {
        if !placement.is_somewhere() {
            continue;
        }
        let mesh = &scene.meshes[instance.mesh as usize];
        let made = &atlas.meshes[instance.mesh as usize];
        let world = |v: u32| {
            instance
                .transform
                .transform_point3(mesh.positions[v as usize].as_dvec3())
        };
        let place = |v: u32| (made.uvs[v as usize] + 0.0).to_array().map(f32::to_bits);
        let mut uses: HashMap<[[u32; 2]; 2], u32> = HashMap::new();
        let edges = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
        for [a, b] in made.triangles.iter().flat_map(edges) {
            *uses.entry([place(a), place(b)]).or_default() += 1;
        }
        let mut borders = Vec::new();
        for (t, corners) in mesh.triangles.iter().zip(&made.triangles) {
            let [a, b, c] = t.map(world);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            for ([v, w], [p, q]) in edges(t).into_iter().zip(edges(corners)) {
                if uses.contains_key(&[place(q), place(p)]) {
                    continue;
                }
                borders.push(Border {
                    from: world(v),
                    to: world(w),
                    normal,
                    at: [place(p), place(q)],
                });
            }
        }
        sums[1] += borders.iter().map(|b| b.from.distance(b.to)).sum::<f64>();
        sums[0] += inside(&mut borders);
    }
    sums
}

/// Length of borders that lie inside flat faces.
fn inside(borders: &mut [Border]) -> f64 {
    let low = |b: &Border| b.from.min(b.to);
    let high = |b: &Border| b.from.max(b.to);
    let all = borders
        .iter()
        .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[l, h], b| {
            [l.min(low(b)), h.max(high(b))]
        });
    let off = OFF * (all[1] - all[0]).max_element();
    borders.sort_by(|a, b| low(a).x.total_cmp(&low(b).x));
    let mut open: Vec<&Border> = Vec::new();
    let mut sum = 0.0;
    for border in borders.iter() {
        open.retain(|o| high(o).x + off >= low(border).x);
        for other in &open {
            let apart = low(border).cmpgt(high(other) + off) | low(other).cmpgt(high(border) + off);
            if apart.any() || border.normal.dot(other.normal) < FLAT {
                continue;
            }
            sum += common([border, other], off);
        }
        open.push(border);
    }
    sum
}

/// Length along which two borders of one plane are one line, each in its own direction, and lie apart on the page.
fn common([a, b]: [&Border; 2], off: f64) -> f64 {
    let [a, b] = match a.from.distance(a.to) < b.from.distance(b.to) {
        true => [b, a],
        false => [a, b],
    };
    let along = a.to - a.from;
    let length = along.length();
    let along = along / length;
    let [from, to] = [b.from, b.to].map(|p| (p - a.from).dot(along));
    let beside = |p: DVec3| (p - a.from).reject_from(along).length() > off;
    if from <= to || beside(b.from) || beside(b.to) {
        return 0.0;
    }
    // One corner at one place on the page: both are one chart there.
    let near = |p: DVec3, q: DVec3| p.distance(q) <= off;
    let ends = [(a.from, a.at[0]), (a.to, a.at[1])];
    let others = [(b.from, b.at[0]), (b.to, b.at[1])];
    let hang =
        |(p, at): &(DVec3, [u32; 2])| others.iter().any(|(q, there)| near(*p, *q) && at == there);
    let common = (from.min(length) - to.max(0.0)).max(0.0);
    if ends.iter().any(hang) { 0.0 } else { common }
}

/// Prints a table of layouts of the scenes that `AMBAKE_LAYOUTS` names, parted by colons.
#[test]
fn cuts_of_named_scenes() {
    let Some(paths) = std::env::var_os("AMBAKE_LAYOUTS") else {
        return;
    };
    println!(
        "| scene | triangles | charts | cuts inside flat faces | all borders | page use | covered | stretch | s |"
    );
    for path in std::env::split_paths(&paths) {
        let scene = scene::load(&path).unwrap();
        let options = Options {
            uv: UvMode::Unwrap,
            page_size: 1024,
            gutter: 2,
            ..Options::default()
        };
        let start = std::time::Instant::now();
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let atlas = match layout(&scene, &options, &|| false) {
            Ok(atlas) => atlas,
            Err(why) => {
                println!("| {name} | {why} |");
                continue;
            }
        };
        let seconds = start.elapsed().as_secs_f64();
        let [cut, all] = cuts(&scene, &atlas);
        let facts = facts(&scene, &atlas);
        println!(
            "| {name} | {} | {} | {cut:.3} | {all:.1} | {:.1} % | {:.1} % | {:.4} | {seconds:.1} |",
            scene
                .meshes
                .iter()
                .map(|m| m.triangles.len())
                .sum::<usize>(),
            atlas.chart_count,
            100.0 * facts.page_use,
            100.0 * facts.covered,
            stretch(&scene, &atlas),
        );
    }
}

/// Mean over the surface of how much longer the longer half axis of a circle on the page is than the shorter.
fn stretch(scene: &Scene, atlas: &Atlas) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for (instance, placement) in scene.instances.iter().zip(&atlas.placements) {
        let mesh = &scene.meshes[instance.mesh as usize];
        let made = &atlas.meshes[instance.mesh as usize];
        let scale = glam::Vec2::from(placement.scale).as_dvec2();
        for (t, corners) in mesh.triangles.iter().zip(&made.triangles) {
            let [a, b, c] = t.map(|v| {
                let p = mesh.positions[v as usize].as_dvec3();
                instance.transform.transform_vector3(p)
            });
            let [p, q, r] = corners.map(|v| made.uvs[v as usize].as_dvec2() * scale);
            let (e, f) = (b - a, c - a);
            let own = e.cross(f).length();
            let x = e.length();
            let [fx, fy] = [f.dot(e) / x, own / x];
            let du = (q - p) / x;
            let dv = (r - p - du * fx) / fy;
            let (m, d) = (
                du.length_squared() + dv.length_squared(),
                du.perp_dot(dv).abs(),
            );
            let root = (m * m - 4.0 * d * d).max(0.0).sqrt();
            let ratio = ((m + root) / (m - root).max(1e-30)).sqrt();
            if ratio.is_finite() {
                sum += own * ratio.min(10.0);
                area += own;
            }
        }
    }
    sum / area
}

/// Share of the borders of charts that lies inside flat faces.
fn share(scene: &Scene) -> f64 {
    let [cut, all] = cuts(scene, &unwrapped(scene));
    cut / all
}

fn unwrapped(scene: &Scene) -> Atlas {
    let options = Options {
        uv: UvMode::Unwrap,
        ..Options::default()
    };
    layout(scene, &options, &|| false).unwrap()
}

/// Two walls at a right angle, each of the same quads, from their lowest to their highest corners.
fn walls(quads: &[[f32; 4]]) -> Scene {
    let mut mesh = scene::authored::Mesh::default();
    for &[x0, y0, x1, y1] in quads {
        for side in [false, true] {
            let first = mesh.positions.len() as u32;
            let at = |x: f32, y: f32| if side { [0.0, y, x] } else { [x, y, 0.0] };
            let corners = [at(x0, y0), at(x1, y0), at(x1, y1), at(x0, y1)];
            mesh.positions.extend(corners);
            let faces = if side {
                [[0, 2, 1], [0, 3, 2]]
            } else {
                [[0, 1, 2], [0, 2, 3]]
            };
            mesh.triangles.extend(faces.map(|t| t.map(|k| first + k)));
        }
    }
    Scene::from_meshes(vec![mesh], vec![]).unwrap()
}

#[test]
fn walls_with_t_junctions_are_one_chart_each() {
    let scene = walls(&[
        [0.0, 0.0, 6.0, 1.0],
        [0.0, 1.0, 2.3, 3.0],
        [2.3, 1.0, 6.0, 2.0],
        [2.3, 2.0, 3.1, 3.0],
        [3.1, 2.0, 6.0, 3.0],
    ]);
    let atlas = unwrapped(&scene);
    assert_eq!(atlas.chart_count, 2);
    assert_eq!(cuts(&scene, &atlas)[0], 0.0);
    let stretch = stretch(&scene, &atlas);
    assert!((stretch - 1.0).abs() < 1e-4, "{stretch}");
}

#[test]
fn cuts_are_measured_where_a_part_of_a_wall_lies_elsewhere() {
    let scene = walls(&[[0.0, 0.0, 6.0, 1.0], [0.0, 1.0, 2.5, 3.0]]);
    let mut atlas = unwrapped(&scene);
    // The upper part of the first wall.
    let made = &mut atlas.meshes[0];
    let mut moved: Vec<u32> = made.triangles[4..6].concat();
    moved.sort_unstable();
    moved.dedup();
    for v in moved {
        made.uvs[v as usize] += 1e-3;
    }
    let [cut, _] = cuts(&scene, &atlas);
    assert!((cut - 2.5).abs() < 1e-6, "{cut}");
}

#[test]
fn flat_faces_of_real_models_are_hardly_cut() {
    for (model, most) in [
        ("boeing_787/scene.gltf", 0.002),
        ("flight_helmet/FlightHelmet.gltf", 0.001),
        ("suzi.glb", 0.001),
        ("spot.obj", 0.001),
        // Many of its faces lie over one another.
        ("game_level_zdm2.glb", 0.01),
    ] {
        if let Some(path) = skip::model(model) {
            let share = share(&scene::load(&path).unwrap());
            assert!(share <= most, "{model}: {share}");
        }
    }
}
