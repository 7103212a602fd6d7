//! Surfaces for tests: a triangle, and texels on it.

use super::cell::Cell;
use super::cells::{Cells, Ground};
use atlas::Piece;
use glam::{DVec2, DVec3};
use rays::{Patch, PlaneErrors, World, WorldOptions};
use std::sync::Arc;

/// A triangle of a unit square over z = 0, with these normals.
pub(crate) fn patch(normals: [[f32; 3]; 3]) -> Patch {
    patch_at([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], normals)
}

/// A triangle over z = 0, with these normals.
pub(crate) fn patch_at(corners: [[f32; 2]; 3], normals: [[f32; 3]; 3]) -> Patch {
    let mut mesh = scene::authored::Mesh::default();
    mesh.positions = corners.map(|[x, y]| [x, y, 0.0]).to_vec();
    mesh.normals = normals.to_vec();
    mesh.triangles = vec![[0, 1, 2]];
    let scene = scene::Scene::from_meshes(vec![mesh], vec![]).expect("a scene");
    let world = World::new(Arc::new(scene), WorldOptions::default()).expect("a world");
    Patch::of(&world, &PlaneErrors::of(&world), 0, 0)
}

/// The corner weights of a place of that triangle's plane.
pub(crate) fn weights(x: f64, y: f64) -> DVec3 {
    DVec3::new(1.0 - x - y, x, y)
}

/// A piece with corners at places of the plane.
pub(crate) fn piece(square: bool, corners: [[f64; 2]; 3]) -> Piece {
    Piece {
        instance: 0,
        triangle: 0,
        number: 0,
        square,
        corners: corners.map(|[x, y]| weights(x, y)),
        cumulative: 0.0,
    }
}

/// Cells of a texel of these pieces, each with its area in texels.
pub(crate) fn cells(patch: &Patch, pieces: &[(Piece, f64)]) -> Cells {
    let mut ground = Ground::default();
    for (piece, area) in pieces {
        Cell::push(&mut ground.cells, (patch, None), piece, *area);
    }
    Cell::share(&mut ground.cells);
    let count = ground.cells.len() as u32;
    Cells::new(Arc::new(ground), 0..count, None)
}

/// A texel of so many equal slices side by side.
pub(crate) fn slices(count: u32) -> Cells {
    let slice = |k: u32| {
        let [from, to] = [k, k + 1].map(|k| 0.1 + 0.3 * f64::from(k) / f64::from(count));
        let corners = [[from, 0.1], [to, 0.1], [from, 0.4]];
        (piece(true, corners), 1.0 / f64::from(count))
    };
    let slices: Vec<_> = (0..count).map(slice).collect();
    cells(&patch([[0.0, 0.0, 1.0]; 3]), &slices)
}

/// A triangle and where its texels lie on it: its corner weights but for the first by the place on a page.
pub(crate) type Placed<'a> = (Patch, &'a dyn Fn(f64, f64) -> [f64; 2]);

/// A texel that triangles cover wholly: the first of its tile, by its corner and its edge in units of the page.
pub(crate) fn whole(triangles: &[Placed], (corner, edge): ([f64; 2], f64)) -> Cells {
    let mut ground = Ground::default();
    for (cell, (patch, place)) in (0..).zip(triangles) {
        let at = |u: DVec2| {
            let [s, t] = place(corner[0] + edge * u.x, corner[1] + edge * u.y);
            DVec3::new(1.0 - s - t, s, t)
        };
        ground.cells.push(Cell::whole((patch, None), at));
        ground.wholes.push(cell);
    }
    Cells::new(Arc::new(ground), 0..triangles.len() as u32, Some([0.0; 2]))
}
