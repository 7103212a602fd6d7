//! Charts that the unwrapper's solver spoils are laid flat in another way.

use crate::scenes::{mesh, scene};
use ambake_atlas::{Options, UvMode, layout};
use glam::{DAffine3, Vec3};

/// A wall and, far from it, seven faces of a ball with eight, a two-thousandth as large. At some places the unwrapper
/// makes a line of the ball that is thousands of times as long.
fn wall_and_ball(middle: Vec3) -> scene::Scene {
    let at = |x: f32, y: f32, z: f32| middle + 0.075 * Vec3::new(x, y, z);
    let mut positions = vec![
        at(1.0, 0.0, -0.125),
        at(0.0, 1.0, 0.0),
        at(0.0, 0.0, 1.0),
        at(-1.0, 0.0, 0.0),
        at(0.0, -1.0, 0.0),
        at(-0.125, 0.0, -1.125),
    ];
    positions.extend([[0.0; 3], [0.0, 150.0, 0.0], [0.0, 0.0, 100.0]].map(Vec3::from));
    let ball = [
        [3, 1, 5],
        [5, 1, 0],
        [1, 3, 2],
        [2, 3, 4],
        [3, 5, 4],
        [5, 0, 4],
        [2, 4, 0],
    ];
    let triangles = [&ball[..], &[[6, 7, 8]]].concat();
    let mesh = mesh("finial", positions, triangles);
    scene(vec![mesh], &[(0, 0, DAffine3::IDENTITY)])
}

#[test]
fn a_small_ball_beside_a_large_wall_takes_no_texels_from_it() {
    let options = Options {
        uv: UvMode::Unwrap,
        page_size: 256,
        ..Options::default()
    };
    let texels = |k: u16| {
        let along = |steps: u16| f32::from(k * steps % 400) / 400.0;
        let middle = Vec3::new(35.0 * along(1), 102.0 * along(7), along(13));
        let atlas = layout(&wall_and_ball(middle), &options, &|| false).expect("a layout");
        atlas.audit.texels
    };
    // The wall lies on its longest edge, or on another and then takes more.
    let fewest = (0..400).map(texels).min();
    assert!(fewest > Some(14_000), "{fewest:?}");
}
