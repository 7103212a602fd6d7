//! What walls cut off from the ends of floors.

use crate::support::{backends, bake};
use std::fmt::Write;

/// Page edge, texels a scene unit of the floor, and half the edge of the room.
const SIZE: usize = 64;
const DENSITY: f64 = 8.0;
const ROOM: f64 = 2.0;

/// A closed room of sheets that share no corner, on a floor that goes on behind two of the walls by so much.
fn room(lip: f64) -> String {
    let mut text = String::from("o floor\n");
    let floor = [[-ROOM - lip, ROOM], [-ROOM, ROOM + lip]];
    for (x, z) in [(0, 0), (0, 1), (1, 1), (1, 0)].map(|(i, j)| (floor[0][i], floor[1][j])) {
        // No wall stands along texels' edges.
        let uv = |x: f64| (3.37 + (x + ROOM) * DENSITY) / SIZE as f64;
        writeln!(text, "v {x} 0 {z}\nvt {} {}", uv(x), 1.0 - uv(z)).expect("a string");
    }
    text += "f 1/1 2/2 3/3 4/4\n";
    let sheets = [
        [[-1, 0, -1], [-1, 1, -1], [-1, 1, 1], [-1, 0, 1]],
        [[1, 0, -1], [1, 0, 1], [1, 1, 1], [1, 1, -1]],
        [[-1, 0, -1], [1, 0, -1], [1, 1, -1], [-1, 1, -1]],
        [[-1, 0, 1], [-1, 1, 1], [1, 1, 1], [1, 0, 1]],
        [[-1, 1, -1], [1, 1, -1], [1, 1, 1], [-1, 1, 1]],
    ];
    for (number, sheet) in sheets.into_iter().enumerate() {
        writeln!(text, "o sheet{number}").expect("a string");
        for ([x, y, z], (u, v)) in sheet.into_iter().zip([(0, 0), (1, 0), (1, 1), (0, 1)]) {
            let [x, y, z] = [x, y, z].map(|place| f64::from(place) * ROOM);
            let [u, v] = [(u, 0.75), (v, 0.1 + 0.15 * number as f64)];
            let [u, v] = [u, v].map(|(step, from)| from + 0.1 * f64::from(step));
            writeln!(text, "v {x} {y} {z}\nvt {u} {v}").expect("a string");
        }
        let corner = |k: usize| format!("{0}/{0}", 5 + 4 * number + k);
        writeln!(text, "f {}", [0, 1, 2, 3].map(corner).join(" ")).expect("a string");
    }
    text
}

#[test]
fn what_a_floor_has_behind_a_wall_stays_out_of_the_room_where_it_is_a_texel_or_less() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("room.obj");
    for (texels, is_dark) in [(0.0, true), (0.3, true), (0.9, true), (3.0, false)] {
        std::fs::write(&file, room(texels / DENSITY)).expect("a file");
        for backend in backends() {
            let (_baked, page) = bake(&file, &["--size=64", "--rays=64", "--backend", backend]);
            let floor = (0..SIZE * SIZE).filter(|i| i % SIZE < 44);
            let lit = floor.filter(|&i| page.plane("coverage")[i] > 0.0);
            let lit = lit.map(|i| page.plane("diffuse")[i]).fold(0.0, f32::max);
            // In the open, half of the sky is seen from what the wall stands on.
            let expected = if is_dark { lit == 0.0 } else { lit > 0.4 };
            assert!(
                expected,
                "{texels} texels behind the wall, {backend}: {lit}"
            );
        }
    }
}
