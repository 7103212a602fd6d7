//! Faces of folds, whose normals point behind them, and faces that are wound the wrong way.

use super::*;
use crate::world::World;

/// Two terraces and the face between them, which the upper one overhangs by `undercut` at a height of 0.6: a sheet of
/// six triangles, whose normals all point up. Triangles 2 and 3 are the face.
fn ledge(undercut: f32) -> Mesh {
    let profile = [(-2.0, 0.0), (0.0, 0.0), (-undercut, -0.6), (2.5, -0.6)];
    let at = |(x, y): (f32, f32)| [-2.0, 2.0].map(|z| Vec3::new(x, y, z));
    let step = |k: u32| [[2 * k, 2 * k + 1, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 2]];
    let mut ledge = mesh(
        profile.into_iter().flat_map(at).collect(),
        (0..3).flat_map(step).collect(),
    );
    ledge.normals = vec![Vec3::Y; 8];
    ledge
}

/// The ledge whose corners are no others' than its triangles'.
fn apart(ledge: &Mesh) -> Mesh {
    let corners = ledge.triangles.iter().flatten();
    let positions = corners.map(|k| ledge.positions[*k as usize]).collect();
    let triangles = (0..ledge.triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]);
    let mut ledge = mesh(positions, triangles.collect());
    ledge.normals = vec![Vec3::Y; ledge.positions.len()];
    ledge
}

fn folds(mesh: &Mesh) -> Vec<(u32, Vec<u32>)> {
    Solids::of(world(scene(vec![mesh.clone()])).scene()).folds()
}

#[test]
fn a_face_that_its_ledge_overhangs_is_a_fold_and_one_that_is_wound_wrongly_is_not() {
    let whole = ledge(0.6);
    let fold = [(0, vec![2, 3])];
    assert_eq!(folds(&whole), fold);
    assert_eq!(folds(&ledge(0.1)), fold);
    assert_eq!(folds(&ledge(-0.1)), []);
    // Corners are one where their places are.
    assert_eq!(folds(&apart(&whole)), fold);
    // The upper terrace as a mesh of its own.
    let (mut upper, mut lower) = (whole.clone(), whole.clone());
    upper.triangles.truncate(2);
    lower.triangles.drain(..2);
    let parts = Solids::of(world(scene(vec![upper, lower])).scene());
    assert_eq!(parts.folds(), [(1, vec![0, 1])]);
    // The face of a slope of which the file has the corners the other way round.
    let mut wrong = ledge(-0.1);
    wrong.triangles[2..4]
        .iter_mut()
        .for_each(|of| of.swap(1, 2));
    assert_eq!(folds(&wrong), []);
    // Nothing is beside it, so nothing says how it is meant.
    let mut alone = whole.clone();
    alone.triangles = whole.triangles[2..4].to_vec();
    assert_eq!(folds(&alone), []);
    // The lower terrace goes on to a tile whose normals are turned round.
    let mut turned = whole.clone();
    turned
        .positions
        .extend([-2.0, 2.0].map(|z| Vec3::new(5.0, -0.6, z)));
    turned.triangles.extend([[6, 7, 9], [6, 9, 8]]);
    let mut turned = apart(&turned);
    turned.normals[18..].fill(Vec3::NEG_Y);
    assert_eq!(folds(&turned), fold);
    // Normals that contradict the winding as a whole, but for those of the overhang.
    let mut down = whole.clone();
    down.normals.fill(Vec3::NEG_Y);
    assert_eq!(folds(&down), []);
    let mut around = whole.clone();
    around.triangles.iter_mut().for_each(|of| of.swap(1, 2));
    assert_eq!(folds(&around), []);
}

#[test]
fn a_fold_keeps_its_winding_and_its_normals_are_mirrored_in_it() {
    let lit = |mesh: Mesh, is_double_sided: bool| {
        let mut scene = scene(vec![mesh]);
        scene.materials[0].double_sided = is_double_sided;
        let mut world = world(scene);
        world.turn_over(std::iter::empty());
        let of = |world: &World, triangle| {
            let [normal, ..] = world.normals(0, triangle).expect("normals");
            let along = world.on_lit_side(DVec3::X, 0, triangle);
            (world.face(0, triangle).normalize(), normal, along)
        };
        [of(&world, 2), of(&world, 3)]
    };
    let half = 0.5f64.sqrt();
    // Up, mirrored in a face that looks to the right and down by 45 degrees, is to the right.
    let front = (DVec3::new(half, -half, 0.0), DVec3::X, DVec3::X);
    let is = |found: [(DVec3, DVec3, DVec3); 2], right: (DVec3, DVec3, DVec3)| {
        for (face, normal, along) in found {
            let off = (face - right.0).length() + (normal - right.1).length();
            assert!(
                off + (along - right.2).length() < 1e-6,
                "{face} {normal} {along}"
            );
        }
    };
    is(lit(ledge(0.6), true), front);
    is(lit(ledge(0.6), false), front);
    // Alone it is lit where its normals point, if a viewer draws that side.
    let mut alone = ledge(0.6);
    alone.triangles = [&[[0, 0, 0]; 2][..], &alone.triangles[2..4]].concat();
    is(
        lit(alone.clone(), true),
        (DVec3::new(-half, half, 0.0), DVec3::Y, DVec3::X),
    );
    is(lit(alone, false), front);
}
