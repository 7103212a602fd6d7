//! Bakes a scene that never was a file: a table on a floor, its lightmaps read back as plain numbers.
//!
//! Run it with `cargo run --release --example in_memory`.

#![allow(clippy::print_stdout, reason = "an example shows what it did")]

use ambake::{Bake, Layer, Material, Mesh, Scene};

fn main() -> Result<(), ambake::Error> {
    let mut wood = Material::default();
    wood.name = "wood".into();
    wood.albedo = [0.5, 0.3, 0.2];

    let floor = rectangle("floor", [-2.0, 2.0], [-2.0, 2.0], 0.0, 0);
    let table = rectangle("table", [-0.5, 0.5], [-0.5, 0.5], 0.4, 1);
    let scene = Scene::from_meshes(vec![floor, table], vec![Material::default(), wood])?;

    let baked = Bake::new(&scene)
        .size(128)
        .rays(256)
        .layers([Layer::Object])
        .run(&())?;

    for page in baked.pages() {
        let diffuse = page.layer(Layer::Diffuse);
        let object = page.layer(Layer::Object);
        for (index, instance) in scene.instances.iter().enumerate() {
            let texels = || (0..diffuse.len()).filter(|&i| object[i] == index as f32);
            let darkest = texels().map(|i| diffuse[i]).fold(1.0, f32::min);
            println!(
                "{}: {} texels on page {}, the darkest sees {:.0} % of the sky's light",
                instance.name,
                texels().count(),
                page.number(),
                100.0 * darkest,
            );
        }
        println!(
            "error of diffuse: RMSE {:.4}, of which rays leave less than {:.4} with 99.9 % confidence",
            page.stats().rmse(),
            page.stats().rmse_bound(),
        );
    }
    Ok(())
}

/// A rectangle at a height that faces up.
fn rectangle(name: &str, x: [f32; 2], z: [f32; 2], height: f32, material: usize) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.name = name.into();
    mesh.positions = vec![
        [x[0], height, z[0]],
        [x[0], height, z[1]],
        [x[1], height, z[1]],
        [x[1], height, z[0]],
    ];
    mesh.triangles = vec![[0, 1, 2], [0, 2, 3]];
    mesh.material = material;
    mesh
}
