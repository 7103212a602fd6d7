//! What is refused, and how it is told: bad meshes and instances, too little memory, a processor that cannot.

use super::common::{Random, config, device, scene, soup};
use super::{FLAT, IDENTITY, down};
use ambake_embree::{Coherence, Device, DeviceConfig, Error, Isa, Keep, RayPacket, SceneBuilder};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

#[test]
fn bad_meshes_are_errors_that_name_the_place() {
    let Some(device) = device() else { return };
    let mut builder = SceneBuilder::new(&device);
    assert_eq!(builder.triangles(&FLAT, &[]), Err(Error::EmptyMesh));
    assert_eq!(builder.triangles(&[], &[]), Err(Error::EmptyMesh));
    let error = builder.triangles(&FLAT, &[[0, 1, 2], [0, 3, 1]]);
    let expected = Error::IndexOutOfRange {
        triangle: 1,
        vertex: 3,
        vertices: 3,
    };
    assert_eq!(error, Err(expected));
    for bad in [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        1.9e18,
        -f32::MAX,
    ] {
        let positions = [FLAT[0], FLAT[1], [0.0, bad, 0.0]];
        let error = builder
            .triangles(&positions, &[[0, 1, 2]])
            .expect_err("a bad vertex");
        assert!(
            matches!(error, Error::VertexOutOfRange { vertex: 2, .. }),
            "{error}"
        );
        let keep: Keep = Arc::new(|_, _, _| true);
        let masked = builder.masked_triangles(&positions, &[[0, 1, 2]], keep);
        assert!(masked.is_err(), "{masked:?}");
    }
    assert_eq!(
        builder.triangles(&FLAT, &[[0, 1, 2]]),
        Ok(0),
        "failed calls use up no id"
    );
    assert!(builder.commit().expect("a scene").occluded(&down(0.0, 0.0)));
}

#[test]
fn bad_instances_are_errors() {
    let Some(device) = device() else { return };
    let part = scene(&device, false, &(FLAT.to_vec(), vec![[0, 1, 2]]));
    let scaled = |s: f32| [[s, 0.0, 0.0], [0.0, s, 0.0], [0.0, 0.0, s], [0.0; 3]];
    let mut builder = SceneBuilder::new(&device);
    let error = builder.instance(&part, scaled(0.0)).expect_err("flat");
    assert_eq!(error, Error::SingularTransform { determinant: 0.0 });
    let error = builder
        .instance(&part, scaled(f32::NAN))
        .expect_err("a NaN");
    assert!(matches!(error, Error::TransformNotFinite(_)), "{error}");
    let mut far = IDENTITY;
    far[3][1] = 3e18;
    let error = builder.instance(&part, far).expect_err("too far");
    assert!(matches!(error, Error::InstanceOutOfReach(_)), "{error}");
    let mut far = scaled(1e6);
    far[3][1] = 3e18;
    let error = builder
        .instance(&part, far)
        .expect_err("large enough, and too far");
    assert!(matches!(error, Error::InstanceOutOfRange(_)), "{error}");
    builder.instance(&part, IDENTITY).expect("an instance");
    let placed = builder.commit().expect("a scene");
    let mut builder = SceneBuilder::new(&device);
    assert_eq!(
        builder.instance(&placed, IDENTITY),
        Err(Error::NestedInstance)
    );
    let other = Device::new(&config()).expect("a device");
    let mut builder = SceneBuilder::new(&other);
    assert_eq!(builder.instance(&part, IDENTITY), Err(Error::OtherDevice));
    let mut builder = SceneBuilder::new(&device);
    builder.triangles(&FLAT, &[[0, 1, 2]]).expect("a mesh");
    builder.instance(&part, IDENTITY).expect("an instance");
    let error = builder
        .robust(true)
        .commit()
        .expect_err("two kinds of interval");
    assert_eq!(error, Error::RobustMismatch { instance: 1 });
}

#[test]
fn a_memory_limit_turns_into_an_error_and_leaves_the_device_usable() {
    if device().is_none() {
        return;
    }
    let (positions, triangles) = soup(&mut Random(4), 100_000);
    let build = |memory_limit| {
        let device = Device::new(&DeviceConfig {
            memory_limit,
            ..config()
        })?;
        let mut builder = SceneBuilder::new(&device);
        builder.triangles(&positions, &triangles)?;
        let scene = builder.commit()?;
        Ok((device.memory(), scene))
    };
    let (memory, _) = build(None).expect("a scene without a limit");
    println!("{memory:?} for 100000 triangles");
    assert!(
        memory.peak >= memory.current && memory.current > 4_000_000,
        "{memory:?}"
    );
    for part in [1, 4, 16, 64] {
        let limit = memory.peak / 64 * part - 1;
        match build(Some(limit)) {
            Ok((memory, _)) => assert!(
                memory.peak <= limit + limit / 4,
                "{memory:?} against {limit}"
            ),
            Err(error) => assert!(matches!(error, Error::OutOfMemory { .. }), "{error}"),
        }
    }
    assert!(matches!(
        build(Some(100_000)),
        Err(Error::OutOfMemory { .. })
    ));
    let device = Device::new(&DeviceConfig {
        memory_limit: Some(memory.peak / 2),
        ..config()
    });
    let device = device.expect("a device");
    for _ in 0..3 {
        let mut builder = SceneBuilder::new(&device);
        let made = builder.triangles(&positions, &triangles);
        let failed = made
            .and_then(|_| builder.commit().map(drop))
            .expect_err("half is too little");
        assert!(matches!(failed, Error::OutOfMemory { .. }), "{failed}");
        let small = scene(&device, false, &(FLAT.to_vec(), vec![[0, 1, 2]]));
        assert!(small.occluded(&down(0.0, 0.0)));
    }
}

#[test]
fn memory_returns_when_scenes_go() {
    let Some(device) = device() else { return };
    let mesh = soup(&mut Random(6), 20_000);
    let first = scene(&device, false, &mesh);
    let with_one = device.memory().current;
    let second = scene(&device, false, &mesh);
    assert!(device.memory().current > with_one);
    drop((first, second));
    let left = device.memory().current;
    assert_eq!(left, 0, "{left} bytes are left of {with_one}");
}

#[test]
fn errors_belong_to_the_thread_that_caused_them() {
    let Some(device) = device() else { return };
    std::thread::scope(|scope| {
        for k in 0..4 {
            let device = &device;
            scope.spawn(move || {
                for _ in 0..100 {
                    let mut builder = SceneBuilder::new(device);
                    let index = if k % 2 == 0 { 2 } else { 9 };
                    let made = builder.triangles(&FLAT, &[[0, 1, index]]);
                    assert_eq!(made.is_ok(), k % 2 == 0);
                    assert!(builder.commit().is_ok());
                }
            });
        }
    });
}

#[test]
fn a_device_tells_what_was_loaded() {
    let Some(device) = device() else {
        assert_eq!(ambake_embree::header_version(), None);
        return;
    };
    let info = device.info();
    println!("{info:?}");
    assert_eq!(Some(info.headers), ambake_embree::header_version());
    assert_eq!(info.library.major, info.headers.major);
    assert!(info.filter_functions && !info.backface_culling);
    let low = Device::new(&DeviceConfig {
        isa: Some(Isa::Sse2),
        ..config()
    });
    let low = low.expect("every x86-64 has SSE2").info();
    assert_eq!(low.isa, Isa::Sse2);
    assert!(!low.native_packet_8 && !low.native_packet_16);
}

#[test]
fn a_cpu_without_the_instruction_set_is_an_error() {
    if device().is_none() {
        return;
    }
    let best = Device::new(&DeviceConfig::default())
        .expect("a device")
        .info()
        .isa;
    let asked = Device::new(&DeviceConfig {
        isa: Some(Isa::Avx512),
        ..config()
    });
    if best == Isa::Avx512 {
        assert_eq!(asked.expect("this CPU has it").info().isa, best);
    } else {
        let expected = Error::UnsupportedCpu {
            isa: Some(Isa::Avx512),
        };
        assert_eq!(asked.map(drop), Err(expected));
    }
}

#[test]
fn packets_of_other_lengths_than_their_masks_are_a_bug_that_is_told() {
    let Some(device) = device() else { return };
    let scene = scene(&device, false, &(FLAT.to_vec(), vec![[0, 1, 2]]));
    let packets = [RayPacket::<8>::new(); 2];
    let mut blocked = [0; 2];
    let query = AssertUnwindSafe(|| {
        scene.occluded_packets(&packets, &[1], &mut blocked, Coherence::Coherent)
    });
    assert!(catch_unwind(query).is_err());
}
