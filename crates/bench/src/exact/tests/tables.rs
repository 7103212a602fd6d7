//! Smooth scenes: `scenes.csv` and `lobes.csv`.

use super::super::{
    Open, polygon_form_factor, polygon_solid_angle, polygon_specular, round, shapes,
};
use super::{endless, flat, sideways, table, upright, v};
use ambient::closed_form::phong_open;
use glam::DVec3;
use std::f64::consts::TAU;

/// The closed form of a scene of the table.
fn closed_form(id: &str) -> Option<Open> {
    let number = |prefix: &str| -> Option<f64> { id.strip_prefix(prefix)?.parse().ok() };
    if let Some(h) = number("wall_h") {
        return Some(shapes::wall(1.0, h));
    }
    if let Some(rho) = number("restsphere_r") {
        return Some(round::resting_sphere(1.0, rho));
    }
    if let Some(degrees) = number("bowl_psi") {
        return Some(round::bowl(degrees.to_radians()));
    }
    if let Some(offset) = number("disc_a") {
        return Some(round::disc_above(1.0, 1.0, offset));
    }
    if let Some(depth) = number("canyonwall_w1_t") {
        return Some(shapes::slit_wall(1.0, depth));
    }
    if let Some(rest) = id.strip_prefix("trench_w1_h") {
        let (depth, x) = rest.split_once("_x")?;
        return Some(shapes::trench(1.0, depth.parse().ok()?, x.parse().ok()?));
    }
    let ball = |x: f64, z: f64, r: f64| round::sphere(r, x.hypot(z), x.atan2(z));
    Some(match id {
        "plane" => Open::FULL,
        "corner3_inf" => shapes::corner(),
        "fwall_y-1_1_h1" => shapes::finite_wall(1.0, [-1.0, 1.0], 1.0),
        "fwall_y0_2_h1" => shapes::finite_wall(1.0, [0.0, 2.0], 1.0),
        "fwall_y-10_10_h1" => shapes::finite_wall(1.0, [-10.0, 10.0], 1.0),
        "fwall_y-1000_1000_h1" => shapes::finite_wall(1.0, [-1e3, 1e3], 1.0),
        "fwall_y-1_1_h0.000976562" => shapes::finite_wall(1.0, [-1.0, 1.0], 0.5_f64.powi(10)),
        "fwall_y-1_1_h1024" => shapes::finite_wall(1.0, [-1.0, 1.0], 1024.0),
        "rect_unit" => shapes::rectangle_above([-1.0, 1.0], [-1.0, 1.0], 1.0),
        "rect_off" => shapes::rectangle_above([0.5, 2.0], [0.0, 1.0], 0.5),
        "rect_near" => shapes::rectangle_above([-100.0, 100.0], [-100.0, 100.0], 0.5_f64.powi(7)),
        "rect_strip" => shapes::rectangle_above([-1e3, 1e3], [1.0, 1.0 + 0.5_f64.powi(20)], 1.0),
        "disc_tilt" => {
            let axes = [v(0.5, 0.0, -0.5) * 2.0_f64.sqrt(), DVec3::Y];
            round::ellipse(v(0.5, 0.0, 1.0), axes, DVec3::Z)
        }
        "sphere_above" => ball(0.0, 2.0, 1.0),
        "sphere_side" => ball(1.5, 1.0, 0.5),
        "sphere_half" => ball(2.0, 0.0, 1.0),
        "sphere_low" => ball(2.0, -0.5, 1.0),
        "sphere_high" => ball(2.0, 0.5, 1.0),
        "sphere_close" => ball(1.2, 0.3, 1.0),
        _ => return None,
    })
}

/// The scene as polygons that do not overlap, with the normal; endless strips have corners at infinity.
fn polygons(id: &str) -> Option<(Vec<Vec<DVec3>>, DVec3)> {
    let number = |prefix: &str| -> Option<f64> { id.strip_prefix(prefix)?.parse().ok() };
    let rim = |x: f64, z: f64| {
        if z.is_finite() {
            v(x, 0.0, z)
        } else {
            DVec3::Z
        }
    };
    if let Some(h) = number("wall_h") {
        return Some((endless(DVec3::X, rim(1.0, h)).to_vec(), DVec3::Z));
    }
    if let Some(depth) = number("canyonwall_w1_t") {
        // From the wall x = 0 the far wall is all but the sky above its rim; the horizon of N = x is the yz plane.
        let parts = [
            endless(DVec3::NEG_Z, DVec3::X),
            endless(DVec3::X, v(1.0, 0.0, depth)),
        ];
        return Some((parts.concat(), DVec3::X));
    }
    if let Some(rest) = id.strip_prefix("trench_w1_h") {
        let (depth, x) = rest.split_once("_x")?;
        let (depth, x): (f64, f64) = (depth.parse().ok()?, x.parse().ok()?);
        let walls = [
            endless(DVec3::NEG_X, v(-x, 0.0, depth)),
            endless(DVec3::X, v(1.0 - x, 0.0, depth)),
        ];
        return Some((walls.concat(), DVec3::Z));
    }
    let small = 0.5_f64.powi(13);
    let soup = match id {
        "plane" => vec![],
        "corner3_inf" => vec![
            vec![DVec3::X, DVec3::Y, DVec3::Z],
            vec![DVec3::NEG_Y, DVec3::X, DVec3::Z],
            vec![DVec3::Y, DVec3::NEG_X, DVec3::Z],
        ],
        "fwall_y-1_1_h1" => vec![upright(1.0, [-1.0, 1.0], [0.0, 1.0])],
        "fwall_y0_2_h1" => vec![upright(1.0, [0.0, 2.0], [0.0, 1.0])],
        "fwall_y-10_10_h1" => vec![upright(1.0, [-10.0, 10.0], [0.0, 1.0])],
        "fwall_y-1000_1000_h1" => vec![upright(1.0, [-1e3, 1e3], [0.0, 1.0])],
        "fwall_y-1_1_h0.000976562" => vec![upright(1.0, [-1.0, 1.0], [0.0, 0.5_f64.powi(10)])],
        "fwall_y-1_1_h1024" => vec![upright(1.0, [-1.0, 1.0], [0.0, 1024.0])],
        "corner_fin" => vec![
            upright(1.0, [-4.0, 2.0], [0.0, 1.0]),
            sideways(2.0, [-4.0, 1.0], [0.0, 1.0]),
        ],
        "rect_unit" => vec![flat([-1.0, 1.0], [-1.0, 1.0], 1.0)],
        "rect_off" => vec![flat([0.5, 2.0], [0.0, 1.0], 0.5)],
        "rect_near" => vec![flat([-100.0, 100.0], [-100.0, 100.0], 0.5_f64.powi(7))],
        "rect_strip" => vec![flat([-1e3, 1e3], [1.0, 1.0 + 0.5_f64.powi(20)], 1.0)],
        "closed_box" => {
            let side = [-1.0, 1.0];
            vec![
                upright(1.0, side, [0.0, 1.0]),
                upright(-1.0, side, [0.0, 1.0]),
                sideways(1.0, side, [0.0, 1.0]),
                sideways(-1.0, side, [0.0, 1.0]),
                flat(side, side, 1.0),
            ]
        }
        "tri_front" => vec![vec![
            v(1.0, 0.25, 0.5),
            v(0.25, 1.0, 1.0),
            v(1.0, 0.75, 2.0),
        ]],
        "tri_cut" => vec![vec![
            v(1.0, -0.5, -0.5),
            v(0.5, 1.0, -0.25),
            v(0.75, 0.25, 1.5),
        ]],
        "tri_below" => vec![vec![
            v(1.0, 0.0, -1.0),
            v(0.0, 1.0, -1.0),
            v(-1.0, -1.0, -2.0),
        ]],
        "tri_sliver" => vec![vec![
            v(1.0, 0.0, 0.5),
            v(1.0, 0.5_f64.powi(20), 0.5),
            v(1.0, 0.0, 1.5),
        ]],
        "tri_huge" => vec![vec![
            v(-1e3, -1e3, 1.0),
            v(1500.0, -500.0, 1.0),
            v(0.0, 2e3, 1.0),
        ]],
        "tri_tiny" => vec![vec![
            v(1.0, 1.0, 1.0),
            v(1.0 + small, 1.0, 1.0),
            v(1.0, 1.0 + small, 1.0),
        ]],
        "tri_over" => vec![vec![
            v(-1.0, -1.0, 0.5),
            v(2.0, -0.5, 0.75),
            v(0.0, 2.0, 1.0),
        ]],
        // The front face; from the floor the box shows no other.
        "box" => vec![upright(1.0, [-0.5, 0.5], [0.0, 1.5])],
        _ => return None,
    };
    Some((soup, DVec3::Z))
}

#[test]
fn closed_forms_and_polygons_meet_the_table_of_scenes() {
    let (mut closed, mut polygonal) = (0, 0);
    for row in table("scenes.csv") {
        let columns: Vec<&str> = row.split(',').collect();
        let id = columns[0];
        let exact: [f64; 2] = [columns[1].parse().unwrap(), columns[2].parse().unwrap()];
        // Rounding of numbers of magnitude 1, a handful of operations each, or a quadrature.
        let bound = 4e-15;
        if let Some(open) = closed_form(id) {
            closed += 1;
            for (value, exact) in [(open.visibility, exact[0]), (open.diffuse, exact[1])] {
                assert!(
                    (value - exact).abs() < bound,
                    "{id} closed: {value} for {exact}"
                );
            }
        }
        if let Some((soup, normal)) = polygons(id) {
            polygonal += 1;
            let solid: f64 = soup.iter().map(|p| polygon_solid_angle(p, normal)).sum();
            let factor: f64 = soup.iter().map(|p| polygon_form_factor(p, normal)).sum();
            for (value, exact) in [(1.0 - solid / TAU, exact[0]), (1.0 - factor, exact[1])] {
                assert!(
                    (value - exact).abs() < bound,
                    "{id} polygons: {value} for {exact}"
                );
            }
        }
    }
    assert_eq!((closed, polygonal), (49, 34));
}

#[test]
fn lobes_over_polygons_meet_the_table_of_lobes() {
    let rows = table("lobes.csv");
    for row in &rows {
        let columns: Vec<&str> = row.split(',').collect();
        let (soup, normal) = polygons(columns[0]).unwrap_or_else(|| panic!("no scene for {row}"));
        let number = |i: usize| -> f64 { columns[i].parse().unwrap() };
        let (n, exact) = (number(3), number(4));
        // The azimuth runs from +x to +y; in the slits, whose normal is +x, from +z to -y.
        let tangent = if normal == DVec3::X {
            DVec3::Z
        } else {
            DVec3::X
        };
        let (s, c) = number(1).to_radians().sin_cos();
        let (y, x) = number(2).to_radians().sin_cos();
        let axis = s * (x * tangent + y * normal.cross(tangent)) + c * normal;
        let open = phong_open(n, normal.dot(axis), normal.cross(axis).length());
        let blocked: f64 = soup
            .iter()
            .map(|p| polygon_specular(p, normal, axis, n))
            .sum();
        // The axis is rounded, too: by an ulp or two, which the slope of a lobe, at most √(1000/2π) = 13, makes larger.
        assert!(
            (open - blocked - exact).abs() < 1e-14,
            "{row}: {}",
            open - blocked
        );
    }
    // 34 scenes from 10 views.
    assert_eq!(rows.len(), 340);
}
