//! Grounds of several meshes: tiles of a floor, and panels that go on where one ends.

use super::*;

#[test]
fn panels_of_a_floor_go_on_where_one_ends() {
    // A wall stands on two panels that overlap, and reaches below both. The second may look down instead.
    let corners = [(0.0, -0.02), (4.0, -0.02), (4.0, 2.0), (0.0, 2.0)];
    let wall = corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec();
    let wall = mesh(wall, vec![[0, 1, 2], [0, 2, 3]]);
    let turned = DQuat::from_rotation_x(0.6) * DQuat::from_rotation_z(0.5);
    let place = DAffine3::from_quat(turned);
    for (up, expected) in [(true, 1), (false, 0)] {
        let mut next = level(0.0, 2.01);
        next.positions.iter_mut().for_each(|p| p.x += 4.0);
        if !up {
            next.triangles.iter_mut().for_each(|t| t.reverse());
        }
        let meshes = vec![level(0.0, 2.01), wall.clone(), next];
        let scene = placed_scene(meshes, &[(0, place), (1, place), (2, place)]);
        let solids = Solids::of(world(scene).scene());
        for (x, y, expected) in [
            (1.0, -0.01, expected),
            (3.0, -0.01, expected),
            (1.0, 0.01, 0),
        ] {
            let found = buried(&solids, place.transform_point3(DVec3::new(x, y, 0.0)));
            assert_eq!(found, expected, "up {up}, at {x}, {y}");
        }
    }
}

/// A floor of 4 x 4 tiles, 2 wide and from -4 to 4, about a crate that is sunk in four of them, as the second mesh.
fn tiled(y: f32) -> Vec<Mesh> {
    let tile = |k: u32| {
        let mut tile = level(y, 1.0);
        let at = Vec3::new(2.0 * (k % 4) as f32 - 3.0, 0.0, 2.0 * (k / 4) as f32 - 3.0);
        tile.positions.iter_mut().for_each(|p| *p += at);
        tile
    };
    (0..16).map(tile).collect()
}

#[test]
fn tiles_of_a_floor_are_one_ground_with_and_without_walls() {
    let crate_ = block(
        Vec3::new(0.1, y_of(1.0), -0.2),
        Vec3::new(0.6, 1.0, 0.6),
        false,
    );
    // Panels as wide as the tiles along two sides, which look inward; their heights make the border of tiles and panels
    // no plane.
    let panel = |x: f32, high: f32| {
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, high), (0.0, high)];
        let positions = corners.map(|(dx, y)| Vec3::new(x + dx, y, -4.0)).to_vec();
        mesh(positions, vec![[0, 1, 2], [0, 2, 3]])
    };
    let panels = [(-4.0, 3.0), (-2.0, 2.0), (0.0, 3.0), (2.0, 1.0)].map(|(x, high)| panel(x, high));
    let opposite = panels.clone().map(|mut panel| {
        let turned = |p: &mut Vec3| (p.x, p.z) = (-p.x, -p.z);
        panel.positions.iter_mut().for_each(turned);
        panel
    });
    let walls = [panels, opposite].concat();
    for with in [&[][..], &walls[..]] {
        let mut meshes = tiled(0.0);
        meshes.insert(1, crate_.clone());
        meshes.extend(with.iter().cloned());
        // As one OBJ file, and each as a node of its own.
        let apart = |k: usize, mesh: &Mesh| {
            let mut mesh = mesh.clone();
            let far = Vec3::new(k as f32, 0.0, 0.0);
            mesh.positions.iter_mut().for_each(|p| *p -= far);
            (mesh, DAffine3::from_translation(far.as_dvec3()))
        };
        let (moved, places): (Vec<Mesh>, Vec<DAffine3>) =
            (0..).zip(&meshes).map(|(k, mesh)| apart(k, mesh)).unzip();
        let placed: Vec<(u32, DAffine3)> = (0..).zip(places).collect();
        for solids in [
            solids(meshes.clone()),
            Solids::of(world(placed_scene(moved, &placed)).scene()),
        ] {
            for (dx, dz) in [(-0.6, 0.5), (0.6, 0.5), (0.6, -0.5), (-0.6, -0.5)] {
                let at = |y: f64| DVec3::new(0.1 + dx, y, -0.2 + dz);
                let found = [buried(&solids, at(-0.01)), buried(&solids, at(0.01))];
                assert_eq!(found, [1, 0], "{dx} {dz}, {} walls", with.len());
            }
        }
    }
}

/// The middle of a crate that is `half` high to each side and reaches 0.02 below the floor.
fn y_of(half: f32) -> f32 {
    half - 0.02
}

#[test]
fn tiles_of_the_storey_below_lay_a_tiled_floor_bare() {
    let post = block(Vec3::new(0.1, y_of(1.0), -0.2), Vec3::splat(1.0), false);
    for (below, expected) in [(-3.0, 0), (3.0, 1)] {
        let mut meshes = tiled(0.0);
        meshes.insert(1, post.clone());
        meshes.extend(tiled(below));
        let solids = solids(meshes);
        let at = DVec3::new(1.1, -0.01, 0.3);
        assert_eq!(buried(&solids, at), expected, "other tiles at {below}");
    }
}

#[test]
fn a_wall_of_which_the_middle_stands_where_two_tiles_meet_crosses_both() {
    let wall = {
        let corners = [(-2.0, -0.01), (2.0, -0.01), (2.0, 2.0), (-2.0, 2.0)];
        let at = |(x, y)| Vec3::new(x, y, -1.99);
        mesh(corners.map(at).to_vec(), vec![[0, 1, 2], [0, 2, 3]])
    };
    let tile = |from: f32| {
        let mut tile = level(0.0, 1.0);
        let place = |p: &mut Vec3| (p.x, p.z) = (p.x + from, 2.0 * p.z);
        tile.positions.iter_mut().for_each(place);
        tile
    };
    let solids = solids(vec![wall, tile(-1.0), tile(1.0)]);
    let (below, own) = (DVec3::new(0.3, -0.005, -1.99), solids.own(0, 0));
    let near = solids.about(below, below);
    let depths = near.iter().map(|&body| solids.depth(body, below, own));
    assert_eq!(depths.sum::<i32>(), 1);
}
