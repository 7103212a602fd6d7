//! A bake on the layout and the ray scene of another job is the bake by itself.

use crate::{
    Backend, Bake, Baked, Bounces, Buried, Error, Layer, Light, Material, Mesh, Pages, Scene, Uv,
    View,
};
use glam::DVec3;

/// An axis-aligned box whose faces look outward.
fn body(name: &str, low: [f32; 3], high: [f32; 3]) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.name = name.into();
    let at = |k: usize| [0, 1, 2].map(|axis| [low, high][k >> axis & 1][axis]);
    mesh.positions = (0..8).map(at).collect();
    let faces = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    mesh.triangles = faces.into_iter().flat_map(halves).collect();
    mesh
}

/// A stone that looks inward, a pillar, and the floor under both.
fn yard() -> Scene {
    let mut stone = body("stone", [-1.0, 0.5, -1.0], [-0.2, 1.2, -0.2]);
    stone.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let pillar = body("pillar", [0.2, 0.0, 0.2], [0.6, 1.5, 0.6]);
    let floor = body("floor", [-2.0, -0.1, -2.0], [2.0, 0.0, 2.0]);
    let mut clay = Material::default();
    clay.albedo = [0.7, 0.4, 0.2];
    Scene::from_meshes(vec![floor, pillar, stone], vec![clay]).expect("a scene")
}

fn plain(scene: &Scene) -> Bake {
    Bake::new(scene).size(64).rays(16)
}

/// All numbers of all pages, as bits.
fn bits(baked: &Baked) -> Vec<(Layer, Vec<u32>)> {
    let pages = baked.pages();
    let layers = pages.flat_map(|page| page.layers().map(move |layer| (layer, page.layer(layer))));
    layers
        .map(|(layer, values)| (layer, values.iter().map(|v| v.to_bits()).collect()))
        .collect()
}

#[test]
fn a_bake_on_an_earlier_job_has_the_bytes_of_one_by_itself() {
    let scene = yard();
    let bake = plain(&scene);
    let day = bake.prepare().expect("a job");
    let first = bits(&day.run(&()).expect("it bakes"));
    let sun = Light::sun([1.0, 2.0, 0.5], [3.0, 2.0, 1.0]);
    let others: [(&str, Bake); 6] = [
        ("sky", bake.clone().sky([0.2, 0.4, 0.9])),
        ("rays", bake.clone().rays(64).seed(7)),
        ("target", bake.clone().target_error(0.02)),
        ("light", bake.clone().light(sun).bounces(Bounces::Most(2))),
        ("layers", bake.clone().only([Layer::Bent, Layer::Object])),
        (
            "coefficients",
            bake.clone()
                .albedo([0.5; 3])
                .specular([0.1; 3])
                .exponent(20.0),
        ),
    ];
    for (what, other) in others {
        let fresh = other.run(&()).expect("it bakes");
        let again = other
            .prepare_on(&day)
            .expect("it serves")
            .run(&())
            .expect("it bakes");
        let (fresh_bits, again_bits) = (bits(&fresh), bits(&again));
        assert!(fresh_bits == again_bits, "{what}");
        assert!(fresh_bits != first, "{what} changes something");
        let told = |baked: &Baked| (baked.job().options().describe(), baked.job().decisions());
        assert_eq!(
            format!("{:?}", told(&fresh)),
            format!("{:?}", told(&again)),
            "{what}"
        );
    }
    assert!(
        bits(&day.run(&()).expect("it bakes")) == first,
        "the same job"
    );
}

#[test]
fn nothing_is_laid_out_or_built_again() {
    let scene = yard();
    let day = plain(&scene).prepare().expect("a job");
    let night = plain(&scene).sky([0.1; 3]).prepare_on(&day).expect("a job");
    assert!(std::ptr::eq(day.atlas(), night.atlas()));
    assert!(std::ptr::eq(day.world(), night.world()));
    assert!(std::ptr::addr_eq(day.backend(), night.backend()));
    let phases: Vec<_> = night.phases().iter().map(|of| of.phase.as_str()).collect();
    assert_eq!(phases, ["plan"]);
}

#[test]
fn what_layout_or_ray_scene_depend_on_is_named() {
    let scene = yard();
    let bake = plain(&scene);
    let job = bake.prepare().expect("a job");
    let inside = Light::point([-0.6, 0.8, -0.6], [1.0; 3]);
    let eye = View::Eye(DVec3::new(-0.6, 0.8, -0.6));
    let other = Scene::from_meshes(vec![body("box", [0.0; 3], [1.0; 3])], vec![]);
    let refused: [(&str, Bake); 12] = [
        ("scene", plain(&other.expect("a scene"))),
        ("size", bake.clone().size(32)),
        ("density", bake.clone().density(4.0)),
        ("pages", bake.clone().pages(Pages::Most(2))),
        ("uv", bake.clone().uv(Uv::Unwrap)),
        ("gutter", bake.clone().gutter(3)),
        ("exclude", bake.clone().exclude("pillar")),
        ("no_cast", bake.clone().no_cast("pillar")),
        ("buried", bake.clone().buried(Buried::Keep)),
        ("normal_maps", bake.clone().normal_maps(true)),
        ("backend", bake.clone().backend(Backend::ObvhsBvh2)),
        ("lights or view", bake.clone().light(inside)),
    ];
    for (option, other) in refused
        .into_iter()
        .chain([("lights or view", bake.clone().view(eye))])
    {
        match other.prepare_on(&job) {
            Err(Error::Option { name, .. }) => assert_eq!(name, option),
            other => panic!("{option}: {other:?}"),
        }
    }
    let outside = Light::point([0.0, 3.0, 0.0], [1.0; 3]);
    assert!(bake.clone().light(outside).prepare_on(&job).is_ok());
}

#[test]
fn pages_come_one_by_one_as_a_whole_bake_has_them() {
    let scene = yard();
    let small = Bake::new(&scene).size(64).density(12.0).rays(4);
    let sun = Light::sun([1.0, 2.0, 0.5], [3.0, 2.0, 1.0]);
    for bake in [small.clone(), small.light(sun).bounces(Bounces::Most(1))] {
        let job = bake.prepare().expect("a job");
        let whole = job.run(&()).expect("it bakes");
        assert!(whole.pages().len() > 1, "one page tells nothing");
        let mut number = 0;
        let bounces = job.run_pages(&(), |page| {
            let other = whole.page(number);
            assert_eq!(page.number(), other.number());
            for layer in page.layers() {
                assert!(page.layer(layer) == other.layer(layer), "{}", layer.name());
            }
            number += 1;
        });
        assert_eq!(bounces.expect("it bakes").as_ref(), whole.bounces());
        assert_eq!(number, whole.pages().len());
    }
}

#[test]
fn a_layout_in_memory_is_taken_where_it_fits() {
    let scene = yard();
    let bake = plain(&scene).uv(Uv::Unwrap);
    let layout = bake.lay_out().expect("it fits");
    let with = bake
        .clone()
        .rays(8)
        .layout(layout.clone())
        .prepare()
        .expect("a job");
    assert_eq!(report::layout_hash(with.atlas()), layout.hash());
    let whole = bake.clone().rays(8).run(&()).expect("it bakes");
    assert!(bits(&with.run(&()).expect("it bakes")) == bits(&whole));
    match bake.size(32).layout(layout).prepare() {
        Err(Error::Option { name, .. }) => assert_eq!(name, "layout"),
        other => panic!("{other:?}"),
    }
}
