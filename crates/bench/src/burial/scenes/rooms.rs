//! Caves, rooms, roofs and what else is made of sheets.

use super::*;

/// A tube along x, seen from within, open at x = 0 and, as a tunnel, at its end, with rocks that reach out of it: their
/// places and radii.
pub(super) fn cave(radius: f64, rocks: &[[f64; 3]], s: f64, tunnel: bool) -> Made {
    let end = 10.0;
    let ring = |x: f64, k: usize| {
        // The seam is no slit: the last corner is the first, to the last bit.
        let angle = std::f64::consts::TAU * (k % 16) as f64 / 16.0;
        DVec3::new(x, 0.5 * radius * angle.cos(), 0.5 * radius * angle.sin())
    };
    let mut faces = Vec::new();
    for k in 0..16 {
        for j in 0..10 {
            let [x, next] = [j, j + 1].map(f64::from);
            faces.push(vec![
                ring(x, k),
                ring(next, k),
                ring(next, k + 1),
                ring(x, k + 1),
            ]);
        }
    }
    let sides = planes(&inverted(polygons(&faces)));
    if !tunnel {
        faces.push((0..16).rev().map(|k| ring(end, k)).collect());
    }
    let mut made = Made::default();
    made.open(polygons(&faces));
    made.hide(Some(0), move |p| -beyond(&sides, p));
    for &[x, y, size] in rocks {
        made.convex(lump([x, y, s - 0.48 * radius], size, 1.6 * size));
    }
    made
}

/// A closed room of 6 x 6 x 3, seen from within.
pub(super) fn room(things: &[([f64; 3], [f64; 3])]) -> Made {
    let walls = block([-3.0, -3.0, 0.0], [3.0, 3.0, 3.0]);
    let within = planes(&walls);
    let mut made = Made::default();
    made.open(inverted(walls));
    made.hide(None, move |p| -beyond(&within, p));
    for &(low, high) in things {
        made.convex(block(low, high));
    }
    made
}

/// A room of six sheets, each of which reaches so far through the others.
pub(super) fn sheets_room(through: f64) -> Made {
    let (a, h) = (2.0, 2.5);
    let (b, low, high) = (a + through, -through, h + through);
    let (w, t) = (2.0 * b, high - low);
    let mut made = Made::default();
    for mesh in [
        sheet([-b, -b, 0.0], [w, 0.0, 0.0], [0.0, w, 0.0]),
        sheet([-b, b, h], [w, 0.0, 0.0], [0.0, -w, 0.0]),
        sheet([-b, a, low], [w, 0.0, 0.0], [0.0, 0.0, t]),
        sheet([b, -a, low], [-w, 0.0, 0.0], [0.0, 0.0, t]),
        sheet([a, b, low], [0.0, -w, 0.0], [0.0, 0.0, t]),
        sheet([-a, -b, low], [0.0, w, 0.0], [0.0, 0.0, t]),
    ] {
        made.open(mesh);
    }
    let within = planes(&block([-a, -a, 0.0], [a, a, h]));
    made.hide(None, move |p| -beyond(&within, p));
    made.convex(block([-0.5, -0.5, 0.0], [0.5, 0.5, 0.9]));
    made
}

/// A room with an open window in its wall at y = -3, a sill in it and a table through its floor.
pub(super) fn window(s: f64) -> Made {
    let mut walls = inverted(block([-3.0, -3.0, 0.0], [3.0, 3.0, 3.0]));
    walls.triangles.drain(4..6);
    let at = |x: f64, z: f64| DVec3::new(x, -3.0, z);
    let ring = [[-1.0, 1.0], [1.0, 1.0], [1.0, 2.0], [-1.0, 2.0]].map(|[x, z]| at(x, z));
    let outer = [[-3.0, 0.0], [3.0, 0.0], [3.0, 3.0], [-3.0, 3.0]].map(|[x, z]| at(x, z));
    let frame = (0..4).map(|k| {
        let next = (k + 1) % 4;
        vec![outer[k], ring[k], ring[next], outer[next]]
    });
    let frame = polygons(&frame.collect::<Vec<_>>());
    // One surface: corners that are equal are joined.
    let numbers: Vec<u32> = (frame.positions.iter())
        .map(|p| {
            let known = walls.positions.iter().position(|q| q == p);
            known.unwrap_or_else(|| {
                walls.positions.push(*p);
                walls.positions.len() - 1
            }) as u32
        })
        .collect();
    let faces = frame
        .triangles
        .iter()
        .map(|t| t.map(|k| numbers[k as usize]));
    walls.triangles.extend(faces);
    let mut made = Made::default();
    made.open(walls);
    // Under the floor nobody looks; beyond the wall with the window some may, and either will do.
    made.hide(None, |p| if p.y < -3.0 { 0.0005 } else { p.z });
    made.convex(block([-1.2, -3.2, 0.9 + s], [1.2, -2.8, 1.0 + s]));
    made.convex(block([-0.1, -0.1, -0.3], [0.1, 0.1, 0.8]));
    made
}

pub(super) fn thin_wall(s: f64) -> Made {
    let mut made = Made::default();
    made.open(level([-3.0, 3.0], [-2.0, 2.0], 0.0));
    made.open(sheet([s, 2.0, 0.0], [0.0, -4.0, 0.0], [0.0, 0.0, 2.5]));
    made.convex(block([-2.0, -1.0, 0.0], [-1.0, 0.0, 0.7]));
    made.convex(block([1.0, -1.0, 0.0], [2.0, 0.0, 0.7]));
    made.hide(Some(0), below(3.0, 0.0));
    made
}

pub(super) fn carport(s: f64) -> Made {
    let mut made = on_ground(vec![block([-0.8, -0.8, 0.0], [0.8, 0.8, 1.2])]);
    made.open(level([-1.5, 1.5], [-1.5, 1.5], 2.0 + s));
    for [x, y] in [[-1.3, -1.3], [1.2, -1.3], [1.2, 1.2], [-1.3, 1.2]] {
        made.convex(block([x, y, 0.0], [x + 0.1, y + 0.1, 2.3]));
    }
    made
}

pub(super) fn storeys(s: f64) -> Made {
    let mut made = on_ground(vec![block([-0.2, -0.2, -0.3], [0.2, 0.2, 6.0])]);
    made.open(level([-3.0, 3.0], [-3.0, 3.0], 2.5 + s));
    made.convex(block([1.0, 1.0, 0.0], [1.5, 1.5, 1.0]));
    made
}

pub(super) fn table(s: f64) -> Made {
    let mut made = on_ground(vec![]);
    made.open(level([-1.0, 1.0], [-0.6, 0.6], 0.8 + s));
    for [x, y] in [[-0.9, -0.5], [0.9, -0.5], [0.9, 0.5], [-0.9, 0.5]] {
        made.open(sheet([x - 0.05, y, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, 0.8]));
    }
    made.convex(block([-0.3, -0.3, 0.0], [0.3, 0.3, 0.5]));
    made
}

pub(super) fn tent() -> Made {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let roof = polygons(&[
        vec![
            at(-1.2, -1.5, 0.0),
            at(0.0, -1.5, 1.6),
            at(0.0, 1.5, 1.6),
            at(-1.2, 1.5, 0.0),
        ],
        vec![
            at(0.0, -1.5, 1.6),
            at(1.2, -1.5, 0.0),
            at(1.2, 1.5, 0.0),
            at(0.0, 1.5, 1.6),
        ],
        vec![at(1.2, 1.5, 0.0), at(-1.2, 1.5, 0.0), at(0.0, 1.5, 1.6)],
    ]);
    let mut made = on_ground(vec![block([-0.4, 0.0, 0.0], [0.4, 0.8, 0.4])]);
    let up = planes(&roof)[0].0.z > 0.0;
    made.open(if up { roof } else { inverted(roof) });
    made
}

pub(super) fn cards(s: f64) -> Made {
    let mut made = on_ground(vec![]);
    for k in 0..6 {
        let angle = std::f64::consts::PI * f64::from(k) / 6.0;
        let along = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let corner = (-along + s * DVec3::X).to_array();
        made.open(sheet(corner, (2.0 * along).to_array(), [0.0, 0.0, 1.0]));
    }
    made
}

pub(super) fn rug(s: f64) -> Made {
    let mut made = on_ground(vec![]);
    let at = 0.3 + s;
    let rug = made.open(level([at - 1.5, at + 1.5], [-1.0, 1.0], 0.003));
    made.hide(Some(rug), move |p| {
        let beside = ((p.x - at).abs() - 1.5).max(p.y.abs() - 1.0);
        // Near its edge one sees under it.
        if beside > -0.02 && beside < 0.0 {
            0.0005
        } else {
            beside.max(p.z - 0.003)
        }
    });
    made
}

pub(super) fn doubled(s: f64) -> Made {
    let mut made = carport(s);
    made.open(inverted(level([-1.5, 1.5], [-1.5, 1.5], 2.0 + s)));
    made
}

pub(super) fn dome(s: f64) -> Made {
    let mut made = on_ground(vec![block([-1.0, -1.0, s - 0.5], [1.0, 1.0, 1.0])]);
    made.open(inverted(lump([0.0, 0.0, 0.0], 30.0, 30.0)));
    made
}

pub(super) fn fence(s: f64) -> Made {
    let mut made = on_ground(vec![]);
    for y in [-1.0, 0.5] {
        let mut fence = sheet([-2.0, y, s - 0.3], [4.0, 0.0, 0.0], [0.0, 0.0, 1.3]);
        fence.material = 1;
        made.open(fence);
    }
    made
}

pub(super) fn bucket(s: f64) -> Made {
    let mut made = on_ground(vec![]);
    made.open(turned(
        [0.0, 0.0],
        &[[0.0, 0.001], [0.8, 0.001], [1.0, 1.2]],
        14,
    ));
    made.convex(block([-0.3, -0.3, 0.4 + s], [0.3, 0.3, 0.9 + s]));
    // Under the bucket the ground is covered; either will do.
    made.hide(Some(1), |p| {
        if p.truncate().length() < 0.82 && p.z < 1e-3 {
            0.0005
        } else {
            1.0
        }
    });
    made
}

pub(super) fn shell(s: f64) -> Made {
    let mut made = on_ground(vec![]);
    made.open(upright([0.0, 0.0], &ring(2.0), [0.0, 2.5]));
    made.convex(block([-1.0, -1.0, 0.0], [0.5 + s, 0.5, 0.8]));
    made.convex(block([1.2, 1.2, 0.0], [1.9, 1.9, 1.8]));
    made
}

pub(super) fn sunk_shell(s: f64) -> Made {
    let mut made = on_ground(vec![]);
    made.open(upright([0.0, 0.0], &ring(2.0), [s - 0.3, 2.5]));
    made.convex(block([-1.0, -1.0, 0.0], [0.5, 0.5, 0.8]));
    made
}

pub(super) fn walls_apart(s: f64) -> Made {
    let mut made = on_ground(vec![]);
    for pair in ring(2.0).windows(2) {
        made.open(upright([0.0, 0.0], pair, [s - 0.3, 2.5]));
    }
    made
}

/// A tube into a cliff, out of whose face it reaches a little, with a rock through it.
pub(super) fn cave_in_cliff(s: f64) -> Made {
    let mut made = cave(3.0, &[[4.0, 0.2, 0.6]], 0.0, false);
    let face = |z: f64, y: f64| DVec3::new(0.5 + s + 0.1 * z, y, z);
    let at = [
        face(-4.0, -4.0),
        face(-4.0, 4.0),
        face(4.0, 4.0),
        face(4.0, -4.0),
    ];
    let cliff = made.open(inverted(polygons(&[at.to_vec()])));
    made.show(cliff);
    made
}

pub(super) fn cellar(s: f64) -> Made {
    let mut made = Made::default();
    made.open(level([-4.0, 4.0], [-4.0, 4.0], 0.0));
    made.open(inverted(block([-2.0, -2.0, -2.8], [2.0, 2.0, -0.2])));
    let within = planes(&block([-2.0, -2.0, -2.8], [2.0, 2.0, -0.2]));
    made.hide(Some(0), move |p| {
        let under = below(4.0, 0.0)(p);
        under.max(-beyond(&within, p))
    });
    made.convex(block([-1.0, -1.0, -2.8], [0.0, 0.0, -2.0 + s]));
    made.convex(block([1.0, 1.0, -0.1], [1.5, 1.5, 0.5]));
    made
}

pub(super) fn corner(s: f64) -> Made {
    let mut made = Made::default();
    made.open(level([-3.0, 0.0], [-3.0, 3.0], 0.0));
    made.open(sheet([0.0, 3.0, 0.0], [0.0, -6.0, 0.0], [0.0, 0.0, 3.0]));
    for body in 0..2 {
        made.hide(Some(body), |p| {
            let beside = p.y.abs() > 3.0 || p.z > 3.0 || p.x < -3.0;
            if beside { f64::INFINITY } else { p.z.min(-p.x) }
        });
    }
    made.convex(block([-0.5, -0.5, s - 0.3], [0.4, 0.5, 0.8]));
    made
}

pub(super) fn terrace(s: f64) -> Made {
    let mut made = boxes(&[([-3.0, -3.0, -0.5], [3.0, 3.0, 0.0])]);
    made.open(level([-1.5, 1.5], [-1.5, 1.5], 2.0 + s));
    for [x, y] in [[-1.3, -1.3], [1.2, -1.3], [1.2, 1.2], [-1.3, 1.2]] {
        made.convex(block([x, y, -0.1], [x + 0.1, y + 0.1, 2.3]));
    }
    made
}

pub(super) fn parasol(s: f64) -> Made {
    let mut made = on_ground(vec![block([-0.3, -0.3, 0.0], [0.3, 0.3, 0.2])]);
    made.open(turned([0.0, 0.0], &[[1.5, 1.8 + s], [0.0, 2.2 + s]], 12));
    made.convex(block([-0.04, -0.04, 0.1], [0.04, 0.04, 2.4]));
    made
}

pub(super) fn pillar(s: f64) -> Made {
    let mut made = cellar(0.0);
    made.convex(block([-1.6 + s, 1.0, -3.0], [-1.2 + s, 1.4, 2.0]));
    let within = planes(&block([-2.0, -2.0, -2.8], [2.0, 2.0, -0.2]));
    made.hide(
        None,
        move |p| if p.z > -2.5 { 1.0 } else { -beyond(&within, p) },
    );
    made
}

pub(super) fn bridge(s: f64) -> Made {
    let valley = |x: f64, y: f64| 0.25 * x * x - 1.0 + 0.1 * y.sin();
    let mut made = Made::default();
    terrain(&mut made, &Terrain::new(4.0, 32, valley));
    made.open(level([-3.2, 3.2], [-0.8, 0.8], 0.6 + s));
    made
}

pub(super) fn shore(s: f64) -> Made {
    let mut made = beach(0.2 + s);
    for [x, y] in [[0.5, -1.0], [-0.4, 1.2], [1.6, 2.0], [-1.5, -2.0]] {
        made.convex(lump([x, y, 0.45 * x], 0.6, 0.5));
    }
    made
}

pub(super) fn jar() -> Made {
    let mut made = boxes(&[([-2.0, -2.0, -0.4], [2.0, 2.0, 0.0])]);
    let jar = |bottom| drum([0.3, 0.1], 0.8, [0.0, 1.2], bottom, true);
    let whole = planes(&jar(true));
    let body = made.open(jar(false));
    made.hide(Some(body), move |p| beyond(&whole, p));
    made
}

pub(super) fn two_rooms(s: f64) -> Made {
    let ends = [-4.2, 0.2].map(|x| ([x, -2.0, 0.0], [x + 4.0, 2.0, 2.5]));
    let mut made = Made::default();
    let mut within = Vec::new();
    for (low, high) in ends {
        within.push(planes(&block(low, high)));
        made.open(inverted(block(low, high)));
    }
    made.hide(None, move |p| {
        let out = within.iter().map(|planes| beyond(planes, p));
        -out.fold(f64::INFINITY, f64::min)
    });
    made.convex(block([-2.0, -0.1 + s, 1.0], [2.0, 0.1 + s, 1.2]));
    for x in [-3.0, 2.0] {
        made.convex(block([x, -1.5, 0.0], [x + 0.8, -0.6, 0.9]));
    }
    made
}

pub(super) fn plinth(s: f64) -> Made {
    let hills = |x: f64, y: f64| 0.4 * (0.8 * x + 0.3).sin() + 0.2 * (1.1 * y).sin();
    let mut made = Made::default();
    terrain(&mut made, &Terrain::new(4.0, 28, hills));
    made.convex(turned_block([-0.9, -0.8, -0.9], [0.9, 0.8, 0.7], 25.0));
    made.convex(drum([0.1, 0.0], 0.4, [0.65 + s, 2.2], true, true));
    made
}

pub(super) fn room_on_floor(s: f64) -> Made {
    let mut made = Made::default();
    made.open(level([-3.0, 3.0], [-3.0, 3.0], 0.0));
    let room = made.open(inverted(block([-1.0, -1.0, s - 0.2], [1.0, 1.0, 1.8])));
    // Its walls below the floor are kept or not.
    made.spare(room);
    made.hide(Some(0), below(3.0, 0.0));
    made.convex(block([-0.4, -0.4, 0.0], [0.4, 0.4, 0.5]));
    made
}
