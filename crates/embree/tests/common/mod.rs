//! What the tests share: a device, random numbers, a few meshes.
#![allow(dead_code)]

#[path = "../../../../tests/skip.rs"]
pub mod skip;

use ambake_embree::{
    Coherence, Device, DeviceConfig, Error, Hit, Ray, RayPacket, Scene, SceneBuilder,
};

/// A mesh: vertices and triangles.
pub type Mesh = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// What to ask of a device: `AMBAKE_EMBREE_ISA` chooses the kernels, since valgrind knows nothing above AVX2.
pub fn config() -> DeviceConfig {
    let isa = std::env::var("AMBAKE_EMBREE_ISA").ok();
    DeviceConfig {
        threads: 2,
        isa: isa.map(|name| name.parse().expect("AMBAKE_EMBREE_ISA")),
        ..DeviceConfig::default()
    }
}

/// A device, or `None` and a printed line where Embree is not built in.
pub fn device() -> Option<Device> {
    match Device::new(&config()) {
        Ok(device) => Some(device),
        Err(Error::NotBuilt) => {
            skip::skip("this build has no Embree");
            None
        }
        Err(e) => panic!("no device: {e}"),
    }
}

/// SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in -1..1.
    pub fn signed(&mut self) -> f32 {
        (self.bits() >> 40) as f32 * (2.0 / (1u64 << 24) as f32) - 1.0
    }

    pub fn point(&mut self) -> [f32; 3] {
        [self.signed(), self.signed(), self.signed()]
    }
}

/// Random triangles with edges of about 0.2 in the cube -1..1.
pub fn soup(random: &mut Random, count: u32) -> Mesh {
    let mut positions = Vec::new();
    for _ in 0..count {
        let centre = random.point();
        for _ in 0..3 {
            let offset = random.point();
            positions.push(std::array::from_fn(|axis| {
                centre[axis] + 0.1 * offset[axis]
            }));
        }
    }
    let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    (positions, triangles)
}

/// Random rays that start in the cube -1..1; some are short, some are empty.
pub fn ray(random: &mut Random) -> Ray {
    let t_max = match random.bits() % 4 {
        0 => f32::INFINITY,
        1 => 0.25,
        2 => 1.0,
        _ => 0.5 + random.signed(),
    };
    Ray {
        origin: random.point(),
        direction: random.point(),
        t_min: 0.05 * (1.0 + random.signed()),
        t_max,
    }
}

/// A scene of one mesh.
pub fn scene(device: &Device, robust: bool, (positions, triangles): &Mesh) -> Scene {
    let mut builder = SceneBuilder::new(device).robust(robust);
    builder
        .triangles(positions, triangles)
        .expect("a sound mesh");
    builder.commit().expect("a scene")
}

/// Every way to ask whether a ray is blocked, and the closest hit; they must all agree.
pub fn ask(scene: &Scene, ray: &Ray) -> Option<Hit> {
    let hit = scene.closest(ray);
    let mut narrow = RayPacket::<8>::new();
    let mut wide = RayPacket::<16>::new();
    (0..8).for_each(|lane| narrow.set(lane, ray));
    (0..16).for_each(|lane| wide.set(lane, ray));
    let expected = |mask| if hit.is_some() { mask } else { 0 };
    assert_eq!(
        scene.occluded(ray),
        hit.is_some(),
        "single against closest, {ray:?}"
    );
    for coherence in [Coherence::Incoherent, Coherence::Coherent] {
        for mask in [RayPacket::<8>::ALL, 0x81, 0] {
            let blocked = scene.occluded_packet(&narrow, mask, coherence);
            assert_eq!(blocked, expected(mask), "8 lanes, {coherence:?}, {ray:?}");
        }
        for mask in [RayPacket::<16>::ALL, 0x8421, 0] {
            let blocked = scene.occluded_packet(&wide, mask, coherence);
            assert_eq!(blocked, expected(mask), "16 lanes, {coherence:?}, {ray:?}");
        }
    }
    hit
}
