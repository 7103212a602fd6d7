//! Values at vertices by least squares.

use super::{System, texels};
use crate::{Bake, Baked, Denoise, Layer, Mesh, Scene};
use atlas::PageRaster;
use glam::{DVec3, Vec3};

/// A square from -1 to 1 of `cells` by `cells` quads, bent by `height`, with unit normals up.
fn grid(cells: u32, height: impl Fn(f32, f32) -> f32) -> Mesh {
    let mut mesh = Mesh::default();
    let side = cells + 1;
    let at = |k: u32| 2.0 * k as f32 / cells as f32 - 1.0;
    for row in 0..side {
        for column in 0..side {
            let (x, z) = (at(column), at(row));
            mesh.positions.push([x, height(x, z), z]);
            mesh.normals.push([0.0, 1.0, 0.0]);
        }
    }
    for row in 0..cells {
        for column in 0..cells {
            let v = row * side + column;
            let triangles = [[v, v + side, v + side + 1], [v, v + side + 1, v + 1]];
            mesh.triangles.extend(triangles);
        }
    }
    mesh
}

fn baked(meshes: Vec<Mesh>, size: u32) -> Baked {
    let scene = Scene::from_meshes(meshes, vec![]).expect("a scene");
    let bake = Bake::new(&scene).size(size).rays(4).denoise(Denoise::Off);
    let bake = bake.only([Layer::Position]);
    bake.run(&()).expect("it bakes")
}

/// The values at the vertices of the only object, where each texel has that of `field` at the mean position of its
/// footprint; texels of triangles that are not `wanted` are none.
fn fitted(
    baked: &Baked,
    wanted: impl Fn(u32) -> bool,
    field: impl Fn([f64; 3]) -> f64,
) -> Vec<f32> {
    let (job, page) = (baked.job(), baked.page(0));
    let raster = PageRaster::new(job.scene(), job.atlas(), 0);
    let mut plane = vec![f32::NAN; page.layer(Layer::Coverage).len()];
    let mut system = System::new(baked.job(), 0, 1);
    for tile in 0..raster.tiles().len() {
        for texel in texels(&raster.tile(tile), page.size()) {
            let area: f64 = texel.parts.iter().map(|part| part.1).sum();
            let middle = |&(triangle, own, [u, v, w]): &(u32, f64, [f64; 3])| {
                let [a, b, c] = job.world().corners(0, triangle);
                (a * u + b * v + c * w) * (own / area)
            };
            let parts = texel
                .parts
                .iter()
                .map(|part| (part.0, part.1, part.2.to_array()));
            let mean: DVec3 = parts.map(|part| middle(&part)).sum();
            plane[texel.index] = field(mean.to_array()) as f32;
            if texel.parts.iter().all(|part| wanted(part.0)) {
                system.add(&texel, &[&plane]);
            }
        }
    }
    system.solved().remove(0)
}

#[test]
fn a_linear_field_comes_out_as_it_is() {
    // By a dozen texels a triangle, and by many more; of a plane that lies askew.
    for (cells, size) in [(1, 32), (5, 64), (20, 128)] {
        let mesh = grid(cells, |x, z| 0.25 * x - 0.5 * z);
        let positions = mesh.positions.clone();
        let baked = baked(vec![mesh], size);
        let field = |[x, y, z]: [f64; 3]| 0.3 + 0.1 * x - 0.2 * y + 0.05 * z;
        let found = fitted(&baked, |_| true, field);
        for (position, found) in positions.iter().zip(&found) {
            let exact = field(position.map(f64::from)) as f32;
            assert!(
                (found - exact).abs() < 1e-6,
                "{cells} {size}: {found} for {exact} at {position:?}"
            );
        }
        // The mean position of a texel is such a field, three times; a bake takes it from footprints whose corners are
        // rounded to a thousandth of a texel or so.
        let objects = baked.vertex_values(Layer::Position).expect("asked for");
        for (vertex, position) in positions.iter().enumerate() {
            let place = [0, 1, 2].map(|c: usize| objects[0].channels[c][vertex]);
            let far = (Vec3::from(place) - Vec3::from(*position)).length();
            assert!(far < 1e-4, "{cells} {size}: {place:?} for {position:?}");
        }
    }
}

#[test]
fn hard_edges_keep_two_values_and_smooth_ones_have_one() {
    // A floor, and a wall on its edge or more of the floor, which has vertices of its own there.
    let both = |other: [f32; 3]| {
        let mut mesh = Mesh::default();
        let [x, y, _] = other;
        mesh.positions = vec![
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 1.0],
            [1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            [x, y, 1.0],
            [x, y, 0.0],
        ];
        let normal = [y, -x, 0.0];
        mesh.normals = [[[0.0, 1.0, 0.0]; 4], [normal; 4]].concat();
        mesh.triangles = vec![[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]];
        mesh
    };
    let wall = |[_, y, _]: [f64; 3]| if y > 0.0 { 0.25 } else { 0.75 };
    let found = fitted(&baked(vec![both([0.0, 1.0, 0.0])], 64), |_| true, wall);
    assert!((0..4).all(|v| (found[v] - 0.75).abs() < 2e-6), "{found:?}");
    assert!((4..8).all(|v| (found[v] - 0.25).abs() < 2e-6), "{found:?}");
    let side = |[x, ..]: [f64; 3]| if x < 0.0 { 0.25 } else { 0.75 };
    let found = fitted(&baked(vec![both([-1.0, 0.0, 0.0])], 64), |_| true, side);
    assert_eq!((found[0], found[1]), (found[4], found[5]));
    assert!((found[0] - 0.5).abs() < 0.02, "{found:?}");
}

#[test]
fn vertices_without_texels_follow_their_neighbours() {
    let mut mesh = grid(4, |_, _| 0.0);
    // What hangs on the square by an edge, and a vertex of no triangle.
    mesh.positions.extend([[2.0, 0.0, 1.0], [5.0, 5.0, 5.0]]);
    mesh.normals.extend([[0.0, 1.0, 0.0]; 2]);
    mesh.triangles.push([24, 25, 19]);
    let last = mesh.triangles.len() as u32 - 1;
    let field = |[x, _, z]: [f64; 3]| 0.5 + 0.125 * x - 0.25 * z;
    let found = fitted(&baked(vec![mesh], 128), |triangle| triangle != last, field);
    // The mean of its two neighbours, whose values are 0.375 and 0.5; a slope carried on would give 0.5.
    assert!((found[25] - 0.4375).abs() < 0.03, "{}", found[25]);
    for (vertex, [x, z]) in [(0, [-1.0, -1.0]), (12, [0.0, 0.0]), (20, [-1.0, 1.0])] {
        let exact = field([x, 0.0, z]) as f32;
        assert!(
            (found[vertex] - exact).abs() < 0.002,
            "{} for {exact}",
            found[vertex]
        );
    }
    // The mean of the square without the texels that it shares with the triangle.
    assert!((found[26] - 0.5).abs() < 0.01, "{}", found[26]);
}

#[test]
fn least_squares_come_nearer_than_samples_at_vertices() {
    // A narrow dark spot at a vertex, which a sample there takes for all around it.
    let bump = |[x, _, z]: [f64; 3]| 1.0 - 0.8 * (-(x * x + z * z) / 0.01).exp();
    let cells = 8;
    let mesh = grid(cells, |_, _| 0.0);
    let positions = mesh.positions.clone();
    let triangles = mesh.triangles.clone();
    let found = fitted(&baked(vec![mesh], 256), |_| true, bump);
    let at_vertices = positions.iter().map(|p| bump(p.map(f64::from)) as f32);
    let sampled: Vec<f32> = at_vertices.collect();
    // Root mean square over the surface, by points of every triangle.
    let error = |values: &[f32]| {
        let (mut sum, mut count) = (0.0, 0);
        for triangle in &triangles {
            for i in 0..16 {
                for j in 0..16 - i {
                    let (s, t) = ((i as f64 + 1.0 / 3.0) / 16.0, (j as f64 + 1.0 / 3.0) / 16.0);
                    let weights = [1.0 - s - t, s, t];
                    let of = |k: usize| {
                        let at = |v: u32| f64::from(positions[v as usize][k]);
                        (0..3).map(|c| weights[c] * at(triangle[c])).sum::<f64>()
                    };
                    let value = |c: usize| weights[c] * f64::from(values[triangle[c] as usize]);
                    let shown: f64 = (0..3).map(value).sum();
                    sum += (shown - bump([of(0), of(1), of(2)])).powi(2);
                    count += 1;
                }
            }
        }
        (sum / f64::from(count)).sqrt()
    };
    let (squares, samples) = (error(&found), error(&sampled));
    assert!(
        squares < 0.75 * samples,
        "{squares} for {samples} by samples"
    );
}

#[test]
fn instances_and_channels_have_values_of_their_own() {
    let mut lid = grid(2, |_, _| 0.0);
    lid.name = "lid".into();
    lid.transform[3] = [0.0, 0.5, 0.0, 1.0];
    let mut floor = grid(2, |_, _| 0.0);
    floor.name = "floor".into();
    let baked = baked(vec![floor, lid], 64);
    let objects = baked.vertex_values(Layer::Position).expect("asked for");
    let names: Vec<&str> = objects.iter().map(|of| of.name.as_str()).collect();
    assert_eq!(names, ["floor", "lid"]);
    let given = grid(2, |_, _| 0.0).positions;
    for (object, height) in objects.iter().zip([0.0, 0.5]) {
        assert_eq!(object.vertices, (0..9).collect::<Vec<u32>>());
        for (vertex, [x, _, z]) in given.iter().enumerate() {
            let found = [0, 1, 2].map(|c: usize| object.channels[c][vertex]);
            let far = (Vec3::from(found) - Vec3::new(*x, height, *z)).length();
            assert!(far < 1e-5, "{found:?} at {x} {height} {z}");
        }
    }
    assert!(baked.vertex_values(Layer::Bent).is_none(), "not asked for");
}
