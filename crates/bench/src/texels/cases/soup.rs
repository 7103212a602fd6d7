//! T7: thousands of triangles smaller than a texel, with needles and broken ones. Each must have its value.

use super::scene;
use crate::exact::shapes;
use crate::texels::Error;
use crate::texels::bake::{Lab, PER_EDGE, Texels, score};
use crate::texels::build::mesh;
use crate::texels::row::Row;
use glam::{DVec2, DVec3};
use scene::authored::Mesh;
use std::f64::consts::{PI, TAU};

/// Texels a unit: a triangle of edge 0.02 has 0.3 of a texel.
const DENSITY: f64 = 15.0;
const SIZE: u32 = 1024;
/// Triangles in a row of the square of 4 units.
const ROW: u32 = 100;
/// Of the square's triangles: so many with NaN or zero normals, so many whose corners share a texture coordinate.
const BROKEN: usize = 20;
const NEEDLES: u32 = 50;
const FLAT: u32 = 20;
/// The wall before the floor: height, and reach to both sides.
const WALL: (f64, f64) = (1.0, 16.0);

pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, Error> {
    let (height, reach) = WALL;
    let mut wall = mesh("wall");
    let corners = [
        [0.0, -reach, 0.0],
        [0.0, reach, 0.0],
        [0.0, reach, height],
        [0.0, -reach, height],
    ];
    wall.positions = corners.map(|p| p.map(|c| c as f32)).to_vec();
    wall.triangles = vec![[0, 1, 2], [0, 2, 3]];
    let made = scene("T7", vec![soup(), wall], vec![])?;
    let baked = lab.bake("T7", made, Texels::Unwrapped(SIZE, DENSITY))?;
    let judged = baked.judge(PER_EDGE, |point| {
        let [x, y, _] = point.position.to_array();
        (point.instance == 0)
            .then(|| shapes::finite_wall(x, [-reach - y, reach - y], height).diffuse)
    });
    let score = score(&judged);
    let criterion = (
        "every triangle's value: 0.005 at 4,096 rays",
        if score.points == 0 {
            f64::NAN
        } else {
            score.max
        },
        Some(lab.noise(0.005)),
    );
    Ok(vec![lab.row(
        "T7",
        "10,000 triangles of 0.3 texel, 50 needles",
        score,
        criterion,
    )])
}

/// The triangles, in the plane z = 0 and apart from each other.
fn soup() -> Mesh {
    let mut soup = mesh("soup");
    let mut add = |corners: [DVec2; 3], uvs: [DVec2; 3], normal: [f32; 3]| {
        let first = soup.positions.len() as u32;
        soup.positions
            .extend(corners.map(|p| p.extend(0.0).as_vec3().to_array()));
        soup.uvs.extend(uvs.map(|p| p.as_vec2().to_array()));
        soup.normals.extend([normal; 3]);
        soup.triangles.push([first, first + 1, first + 2]);
    };
    let up = DVec3::Z.as_vec3().to_array();
    let (step, radius) = (4.0 / f64::from(ROW), 0.02 / 3f64.sqrt());
    let golden = PI * (3.0 - 5f64.sqrt());
    for k in 0..ROW * ROW {
        let cell = DVec2::new(f64::from(k % ROW) + 0.5, f64::from(k / ROW) + 0.5);
        let turn = golden * f64::from(k);
        let corner = |i: u32| DVec2::from_angle(turn + TAU * f64::from(i) / 3.0);
        let middle = cell * step - DVec2::new(0.0, 2.0);
        let place = |i| (cell + 0.3 * corner(i)) / f64::from(ROW);
        let uvs = if (k as usize) < BROKEN {
            [place(0); 3]
        } else {
            [0, 1, 2].map(place)
        };
        let normal = match k as usize {
            n if n < BROKEN => up,
            n if n < 2 * BROKEN && n % 2 == 0 => [f32::NAN; 3],
            n if n < 2 * BROKEN => [0.0; 3],
            _ => up,
        };
        add([0, 1, 2].map(|i| middle + radius * corner(i)), uvs, normal);
    }
    for k in 0..NEEDLES {
        // 30 by 0.05 texels.
        let base = DVec2::new(0.05 + 0.03 * f64::from(k), 2.1 + 0.02 * f64::from(k));
        let size = DVec2::new(30.0, 0.05) / DENSITY;
        let corners = [
            base,
            base + size * DVec2::X,
            base + size * DVec2::new(0.5, 1.0),
        ];
        add(corners, [DVec2::ZERO, DVec2::X, DVec2::Y], up);
    }
    for k in 0..FLAT {
        let base = DVec2::new(1.0 + f64::from(k), -3.0);
        add([base, base, base + DVec2::X], [DVec2::ZERO; 3], up);
    }
    soup
}
