//! The scenes: half to tune rules on, half that only judge. Lengths are metres, z is up. `shift` moves one body by so
//! much, along which labels may change only where it is.

mod rooms;

use super::made::*;
use glam::DVec3;
use rooms::*;

/// A scene's name, whether it only judges, and how it is made.
pub(super) type Scene = (&'static str, bool, fn(f64) -> Made);

const TUNES: bool = false;
const JUDGES: bool = true;

/// All of them.
#[rustfmt::skip]
pub(super) const ALL: &[Scene] = &[
    ("box in a box", TUNES,
        |s| boxes(&[([-1.0, -1.0, 0.0], [1.0, 1.0, 2.0]), ([-0.5, -0.5, 0.5 + s], [0.5, 0.5, 1.0 + s])])),
    ("spheres that cross", JUDGES, |s| solids([lump([0.0, 0.0, 1.0], 1.0, 1.0), lump([0.8 + s, 0.3, 1.2], 0.7, 0.7)])),
    ("box sunk in a slab", TUNES,
        |s| boxes(&[([-3.0, -3.0, -1.0], [3.0, 3.0, 0.0]), ([-1.0, -1.0, s - 0.5], [1.0, 1.0, s + 1.0])])),
    ("box exactly on a slab", JUDGES,
        |_| boxes(&[([-3.0, -3.0, -1.0], [3.0, 3.0, 0.0]), ([-1.0, -1.0, 0.0], [1.0, 1.0, 1.5])])),
    ("box wound inward, sunk in a slab", TUNES, |s| wound_inward(s)),
    ("body of two boxes that cross", JUDGES, |s| crossing_body(s)),
    ("stairs of boxes side by side", TUNES, |_| stairs(0.0)),
    ("stairs of boxes that overlap", JUDGES, |s| stairs(0.1 + s)),
    ("books between boards", JUDGES, |s| books(s)),
    ("pipe through a thick wall", TUNES,
        |s| boxes(&[([-0.1, -2.0, 0.0], [0.1, 2.0, 3.0]), ([-1.0, -0.1 + s, 1.0], [1.0, 0.1 + s, 1.2])])),
    ("hull with a hole, things in it", JUDGES, |s| hull(s)),
    ("box exactly on an open ground", TUNES, |_| on_ground(vec![block([-1.0, -1.0, 0.0], [1.0, 1.0, 1.5])])),
    ("box 0.1 mm above an open ground", JUDGES, |_| on_ground(vec![block([-1.0, -1.0, 1e-4], [1.0, 1.0, 1.5])])),
    ("boxes sunk in an open ground", TUNES,
        |s| on_ground(vec![block([-1.0, -1.0, s - 0.5], [1.0, 1.0, 1.0]),
            turned_block([1.5, 1.5, -0.03], [2.5, 2.5, 0.4], 30.0)])),
    ("stone sunk by nine tenths", JUDGES, |s| on_ground(vec![lump([0.0, 0.0, s - 0.8], 1.0, 1.0)])),
    ("four walls sunk in an open ground", TUNES, |s| four_walls(s - 0.4)),
    ("two rows of posts in an open ground", JUDGES, |s| posts(s)),
    ("prop without a bottom on an open ground", TUNES, |_| bottomless(0.0)),
    ("prop without a bottom, sunk", JUDGES, |s| bottomless(s - 0.3)),
    ("box over a joint of ground tiles", TUNES, |s| tiles(s)),
    ("rocks in a hilly terrain", JUDGES, |s| rocks(s)),
    ("boxes let into a cliff", TUNES, |s| cliff(s)),
    ("trunk and leaves over a ground", JUDGES, |s| tree(s)),
    ("beach, low sea", TUNES, |s| beach(s - 1.0)),
    ("beach, middle sea", JUDGES, |s| beach(s)),
    ("beach, sea 3 cm higher", TUNES, |s| beach(s + 0.03)),
    ("beach, high sea", JUDGES, |s| beach(s + 1.0)),
    ("islands", TUNES, |s| islands(s)),
    ("lake in a bowl", JUDGES, |s| lake(s)),
    ("two tilted terrains that cross", TUNES, |s| tilted(s)),
    ("two wavy terrains that cross", JUDGES, |s| wavy(s)),
    ("rocks through a cave's tube", TUNES,
        |s| cave(3.0, &[[3.0, 0.0, 0.4], [5.0, 0.7, 0.5], [7.0, -0.8, 0.5]], s, false)),
    ("rocks through a tunnel", JUDGES,
        |s| cave(3.0, &[[2.0, 0.5, 0.7], [4.0, -0.4, 0.2], [6.5, 0.0, 0.9], [8.0, 0.9, 0.3]], s, true)),
    ("room with furniture", TUNES,
        |s| room(&[([-1.0, -1.0, 0.0], [1.0, 0.5, 0.8]), ([1.5, -2.9, 0.0], [2.5, -2.0, 2.0 + s])])),
    ("room, legs and shelves through its walls", JUDGES,
        |s| room(&[([-1.0, -1.0, s - 0.2], [-0.7, -0.7, 0.8]), ([2.5, -1.0, 1.0], [3.3, 1.0, 1.2])])),
    ("room of sheets that reach through each other", TUNES, |s| sheets_room(0.2 + s)),
    ("room of sheets that meet exactly", JUDGES, |_| sheets_room(0.0)),
    ("room with a window and its sill", JUDGES, |s| window(s)),
    ("floor on both sides of a thin wall", TUNES, |s| thin_wall(s)),
    ("carport: a sheet on posts", TUNES, |s| carport(s)),
    ("sheet on posts over a slab", JUDGES, |s| terrace(s)),
    ("parasol on a foot", TUNES, |s| parasol(s)),
    ("pillar from a street into a cellar", JUDGES, |s| pillar(s)),
    ("column through two storeys of sheets", JUDGES, |s| storeys(s)),
    ("table of sheets on a floor", JUDGES, |s| table(s)),
    ("tent", TUNES, |_| tent()),
    ("crossed cards and loose leaves", JUDGES, |s| cards(s)),
    ("rug 3 mm above an open ground", TUNES, |s| rug(s)),
    ("picture frame on a thick wall", JUDGES,
        |_| boxes(&[([-2.0, 0.0, 0.0], [2.0, 0.2, 3.0]), ([-0.5, -0.05, 1.0], [0.5, 0.0, 2.0])])),
    ("roof of doubled faces", JUDGES, |s| doubled(s)),
    ("boxes under a sky dome", TUNES, |s| dome(s)),
    ("fence cut out by alpha, sunk", JUDGES, |s| fence(s)),
    ("open bucket with things in it", TUNES, |s| bucket(s)),
    ("outer walls without a roof, furnished", JUDGES, |s| shell(s)),
    ("outer walls sunk in the ground, without a roof", JUDGES, |s| sunk_shell(s)),
    ("four outer walls apart, sunk in the ground", TUNES, |s| walls_apart(s)),
    ("cave behind a cliff", JUDGES, |s| cave_in_cliff(s)),
    ("furnished cellar under an open ground", TUNES, |s| cellar(s)),
    ("box through the corner of two grounds", JUDGES, |s| corner(s)),
    ("bridge of a sheet over a valley", JUDGES, bridge),
    ("boulders on a shore", JUDGES, shore),
    ("jar without a bottom on a slab", JUDGES, |_| jar()),
    ("pipe through the walls of two rooms", JUDGES, two_rooms),
    ("small room on a large floor", JUDGES, room_on_floor),
    ("plinth and statue in a hilly terrain", JUDGES, plinth),
];

fn solids(meshes: impl IntoIterator<Item = scene::authored::Mesh>) -> Made {
    let mut made = Made::default();
    meshes.into_iter().for_each(|mesh| {
        made.convex(mesh);
    });
    made
}

fn boxes(ends: &[([f64; 3], [f64; 3])]) -> Made {
    solids(ends.iter().map(|&(low, high)| block(low, high)))
}

fn wound_inward(s: f64) -> Made {
    let mut made = boxes(&[([-3.0, -3.0, -1.0], [3.0, 3.0, 0.0])]);
    let wound = block([-1.0, -1.0, s - 0.5], [1.0, 1.0, s + 1.0]);
    let within = planes(&wound);
    let body = made.open(inverted(wound));
    made.hide(Some(body), move |p| beyond(&within, p));
    // Its fronts look inward, where nobody stands.
    made.spare(body);
    made
}

fn crossing_body(s: f64) -> Made {
    let [a, b] = [
        block([-1.0, -0.3, 0.0], [1.0, 0.3, 0.6]),
        block([-0.3 + s, -1.0, 0.2], [0.3 + s, 1.0, 0.8]),
    ];
    let mut both = a.clone();
    let first = both.positions.len() as u32;
    both.positions.extend(&b.positions);
    let moved = b.triangles.iter().map(|t| t.map(|k| k + first));
    both.triangles.extend(moved);
    let mut made = Made::default();
    made.open(both);
    for part in [a, b] {
        let within = planes(&part);
        made.hide(None, move |p| beyond(&within, p));
    }
    made
}

fn stairs(overlap: f64) -> Made {
    let step = |k: usize| {
        let x = k as f64;
        block([x - overlap, -1.0, 0.0], [x + 1.0, 1.0, 0.3 * (x + 1.0)])
    };
    solids((0..4).map(step))
}

fn books(s: f64) -> Made {
    let mut made = boxes(&[
        ([-1.0, -0.3, -0.05], [1.0, 0.3, 0.0]),
        ([-1.0, -0.3, 0.5], [1.0, 0.3, 0.55]),
    ]);
    for k in 0..8 {
        let x = -0.9 + 0.2 * f64::from(k);
        let high = 0.3 + 0.02 * f64::from(k % 3) + 0.1 * s;
        made.convex(block([x, -0.2, 0.0], [x + 0.2, 0.1, high]));
    }
    made
}

fn hull(s: f64) -> Made {
    let mut made = Made::default();
    let mut outer = block([-1.0, -1.0, 0.0], [1.0, 1.0, 2.0]);
    // Without its front, at y = -1.
    outer.triangles.drain(4..6);
    made.open(outer);
    made.convex(block([-0.4, -0.4 + s, 0.3], [0.4, 0.4, 1.0]));
    made
}

/// An open ground of 8 x 8 with these bodies in it.
fn on_ground(bodies: Vec<scene::authored::Mesh>) -> Made {
    let mut made = Made::default();
    ground(&mut made, 4.0, 0.0);
    bodies.into_iter().for_each(|mesh| {
        made.convex(mesh);
    });
    made
}

fn ground(made: &mut Made, half: f64, z: f64) -> usize {
    let body = made.open(level([-half, half], [-half, half], z));
    made.hide(Some(body), below(half, z));
    body
}

fn below(half: f64, z: f64) -> impl Fn(DVec3) -> f64 {
    move |p| {
        let beside = p.truncate().abs().max_element() > half;
        if beside { f64::INFINITY } else { p.z - z }
    }
}

fn upright(at: [f64; 2], edges: &[[f64; 2]], [low, high]: [f64; 2]) -> scene::authored::Mesh {
    let faces: Vec<Vec<DVec3>> = edges
        .windows(2)
        .map(|pair| {
            let [a, b] = [pair[0], pair[1]].map(|p| [p[0] + at[0], p[1] + at[1]]);
            let corner = |p: [f64; 2], z| DVec3::new(p[0], p[1], z);
            vec![
                corner(a, low),
                corner(b, low),
                corner(b, high),
                corner(a, high),
            ]
        })
        .collect();
    polygons(&faces)
}

/// The corners of a square about the origin, the first one again at the end.
fn ring(half: f64) -> [[f64; 2]; 5] {
    let (a, b) = (-half, half);
    [[a, a], [b, a], [b, b], [a, b], [a, a]]
}

fn four_walls(low: f64) -> Made {
    let mut made = on_ground(vec![]);
    made.open(upright([0.3, 0.2], &ring(1.0), [low, 1.1]));
    // The ground within may be looked at from above, or not.
    made.spare(0);
    made
}

fn posts(s: f64) -> Made {
    let post = |k: usize| {
        let x = -2.0 + 0.5 * (k / 2) as f64;
        let y = 0.3 * (k % 2) as f64;
        block([x, y, s - 0.6], [x + 0.1, y + 0.1, 1.0])
    };
    on_ground((0..16).map(post).collect())
}

fn bottomless(low: f64) -> Made {
    let mut made = on_ground(vec![]);
    let whole = planes(&drum([0.2, 0.1], 1.0, [low, 1.5], true, true));
    let body = made.open(drum([0.2, 0.1], 1.0, [low, 1.5], false, true));
    made.hide(Some(body), move |p| {
        let inside = beyond(&whole, p);
        // The bottom is where the ground is, and no surface.
        if p.z < low + 1e-9 {
            f64::INFINITY
        } else {
            inside
        }
    });
    made
}

fn tiles(s: f64) -> Made {
    let mut made = Made::default();
    for k in 0..16 {
        let [x, y] = [k % 4, k / 4].map(|k: usize| -4.0 + 2.0 * k as f64);
        made.open(level([x, x + 2.0], [y, y + 2.0], 0.0));
    }
    for body in 0..16 {
        made.hide(Some(body), below(4.0, 0.0));
    }
    made.convex(turned_block([-0.7, -0.8, s - 0.4], [0.9, 0.6, 1.0], 20.0));
    made.convex(block([1.0, 1.0, -0.2], [1.6, 1.6, 0.5]));
    made
}

fn terrain(made: &mut Made, terrain: &Terrain) -> usize {
    let body = made.open(terrain.mesh());
    let terrain = terrain.clone();
    made.hide(Some(body), move |p| terrain.above(p));
    body
}

fn rocks(s: f64) -> Made {
    let hills = |x: f64, y: f64| 0.5 * (0.9 * x).sin() * (0.7 * y + 0.5).cos();
    let mut made = Made::default();
    terrain(&mut made, &Terrain::new(4.0, 24, hills));
    for [x, y] in [[-2.0, -1.0], [0.5, 1.5], [2.2, -2.0], [0.0, -0.5]] {
        made.convex(lump([x, y, hills(x, y) + s - 0.2], 0.7, 0.5));
    }
    made
}

fn cliff(s: f64) -> Made {
    let step = |x: f64, y: f64| 3.0 / (1.0 + (-6.0 * (x + 0.3 * y.sin())).exp());
    let mut made = Made::default();
    terrain(&mut made, &Terrain::new(4.0, 32, step));
    made.convex(block([-1.0 + s, -1.0, 1.0], [0.6, 0.0, 1.6]));
    made.convex(block([-0.6, 1.0, -0.3], [1.0, 2.0, 0.9]));
    made
}

fn tree(s: f64) -> Made {
    let mut made = on_ground(vec![]);
    let low = s - 0.3;
    made.open(drum([0.0, 0.0], 0.3, [low, 2.0], false, false));
    let mut faces = Vec::new();
    for k in 0..90 {
        let [u, v, w] =
            [0.819_2, 0.671_0, 0.549_7].map(|a: f64| (a * f64::from(k + 1)).fract() - 0.5);
        let middle = DVec3::new(3.0 * u, 3.0 * v, 2.4 + w);
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 5.0 * v, 4.0 * w, 6.0 * u);
        let at = |x: f64, y: f64| middle + turn * DVec3::new(0.25 * x, 0.15 * y, 0.0);
        faces.push(vec![
            at(-1.0, -1.0),
            at(1.0, -1.0),
            at(1.0, 1.0),
            at(-1.0, 1.0),
        ]);
    }
    made.open(polygons(&faces));
    // Through the open top of the trunk one may see what is in it.
    let within = planes(&drum([0.0, 0.0], 0.3, [low, 2.0], true, true));
    made.hide(None, move |p| {
        if beyond(&within, p) < 0.0 {
            0.0005
        } else {
            1.0
        }
    });
    made
}

/// A slope from -2 to 2 with ripples, and a sea over all of it.
fn beach(sea: f64) -> Made {
    let slope = |x: f64, y: f64| 0.5 * x + 0.12 * (1.7 * y + x).sin();
    flooded(&Terrain::new(4.0, 32, slope), sea)
}

fn flooded(land: &Terrain, sea: f64) -> Made {
    let mut made = Made::default();
    terrain(&mut made, land);
    ground(&mut made, 4.0, sea);
    made
}

fn islands(s: f64) -> Made {
    let hills = |x: f64, y: f64| (1.1 * x).sin() * (1.3 * y).cos() - 0.3;
    flooded(&Terrain::new(4.0, 32, hills), s + 0.2)
}

fn lake(s: f64) -> Made {
    let bowl = |x: f64, y: f64| 0.15 * (x * x + y * y) - 1.0;
    flooded(&Terrain::new(4.0, 32, bowl), s + 0.1)
}

fn tilted(s: f64) -> Made {
    let mut made = Made::default();
    terrain(&mut made, &Terrain::new(4.0, 8, |x, y| 0.3 * x + 0.1 * y));
    terrain(
        &mut made,
        &Terrain::new(4.0, 8, |x, y| s - 0.25 * x - 0.05 * y + 0.1),
    );
    made
}

fn wavy(s: f64) -> Made {
    let mut made = Made::default();
    let first = |x: f64, y: f64| 0.3 * (1.3 * x).sin() + 0.2 * (0.8 * y).cos();
    let second = |x: f64, y: f64| 0.25 * (0.9 * x + 1.4 * y).sin() + 0.1;
    terrain(&mut made, &Terrain::new(4.0, 32, first));
    terrain(
        &mut made,
        &Terrain::new(4.0, 29, move |x, y| second(x, y) + s),
    );
    made
}
