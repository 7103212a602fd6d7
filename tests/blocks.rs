//! `--compress`: lightmaps in BC6H and occlusion in BC7, read by an independent decoder and held to the half floats.

use crate::support::{bake, files, report, run, run_well, scene};
use serde_json::json;
use std::fs;
use std::path::Path;

const BAKE: [&str; 5] = [
    "--size=64",
    "--rays=16",
    "--mips=2",
    "--align=4",
    "--sky=0.9,0.6,0.3",
];

fn text(path: &Path) -> &str {
    path.to_str().expect("a UTF-8 path")
}

/// The levels of a KTX2 file of this format: edge in texels, bytes.
fn levels(path: &Path, format: ktx2::Format) -> Vec<(usize, Vec<u8>)> {
    let bytes = fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let container = ktx2::Reader::new(bytes).expect("a KTX2 container");
    let header = container.header();
    assert_eq!(header.format, Some(format));
    assert_eq!(container.dfd_blocks().count(), 1);
    let edge = header.pixel_width as usize;
    assert_eq!(header.pixel_height as usize, edge);
    let levels = container.levels().enumerate();
    levels
        .map(|(i, level)| (edge >> i, level.data.to_vec()))
        .collect()
}

/// Values of the texels of a level of blocks, three or four a texel.
fn decoded<T: Copy + Default, const N: usize>(
    edge: usize,
    blocks: &[u8],
    decode: impl Fn(&[u8], &mut [T]),
) -> Vec<[T; N]> {
    assert_eq!(blocks.len(), edge.div_ceil(4).pow(2) * 16);
    let across = edge.div_ceil(4);
    let mut texels = vec![[T::default(); N]; edge * edge];
    for (i, block) in blocks.chunks(16).enumerate() {
        let mut read = vec![T::default(); 16 * N];
        decode(block, &mut read);
        for (at, texel) in read.as_chunks::<N>().0.iter().enumerate() {
            let (x, y) = (i % across * 4 + at % 4, i / across * 4 + at / 4);
            if x < edge && y < edge {
                texels[y * edge + x] = *texel;
            }
        }
    }
    texels
}

fn bc6h(edge: usize, blocks: &[u8]) -> Vec<[f32; 3]> {
    decoded(edge, blocks, |block, read| {
        bcdec_rs::bc6h_float(block, read, 12, false)
    })
}

#[test]
fn compressed_light_is_that_of_the_half_floats_on_every_level_and_in_gutters() {
    let room = scene("instances_twin.obj");
    let options = [&BAKE[..], &["--for=three,bevy"]].concat();
    let (compressed, _) = bake(&room, &[&options[..], &["--compress"]].concat());
    let (plain, _) = bake(&room, &options);
    let blocks = levels(
        &compressed
            .path()
            .join("instances_twin.0.lightmap.bc6h.ktx2"),
        ktx2::Format::BC6H_UFLOAT_BLOCK,
    );
    let halves = levels(
        &plain.path().join("instances_twin.0.lightmap.ktx2"),
        ktx2::Format::R16G16B16A16_SFLOAT,
    );
    let edges: Vec<usize> = blocks.iter().map(|(edge, _)| *edge).collect();
    assert_eq!(edges, [64, 32, 16]);
    for ((edge, blocks), (_, halves)) in blocks.iter().zip(&halves) {
        let (mut sum, mut squares) = (0.0, 0.0);
        let read = bc6h(*edge, blocks);
        for (found, half) in read.iter().zip(halves.as_chunks::<8>().0) {
            for (c, found) in found.iter().enumerate() {
                let expected = half::f16::from_le_bytes([half[2 * c], half[2 * c + 1]]).to_f64();
                let off = f64::from(*found) - expected;
                sum += off.abs() / expected.max(0.01);
                squares += off * off;
            }
        }
        let count = 3.0 * read.len() as f64;
        let (mean, rms) = (sum / count, (squares / count).sqrt());
        assert!(
            mean < 0.02 && rms < 0.02,
            "level of {edge}: mean {mean}, rms {rms}"
        );
    }
    // The same blocks, the largest level first, for three.js.
    let dds = fs::read(compressed.path().join("instances_twin.0.lightmap.bc6h.dds"));
    let all: Vec<u8> = blocks.into_iter().flat_map(|(_, bytes)| bytes).collect();
    assert_eq!(dds.expect("written")[148..], all[..]);

    let occlusion = compressed.path().join("instances_twin.0.ao.bc7.ktx2");
    let grey = levels(&occlusion, ktx2::Format::BC7_UNORM_BLOCK);
    assert_eq!(grey.len(), 3);
    let deep = image::open(compressed.path().join("instances_twin.0.ao.png"));
    let deep = deep.expect("a PNG").to_luma16();
    let read: Vec<[u8; 4]> = decoded(64, &grey[0].1, |block, read| bcdec_rs::bc7(block, read, 16));
    let off = read.iter().zip(deep.iter()).map(|(found, deep)| {
        assert!(
            found[3] >= 254 && found[0].abs_diff(found[1]) <= 1,
            "{found:?}"
        );
        (f64::from(found[0]) - f64::from(*deep) / 257.0).abs()
    });
    let mean = off.sum::<f64>() / read.len() as f64;
    assert!(mean < 1.5, "{mean} of 255 on the mean");
}

#[test]
fn an_export_and_any_number_of_threads_make_the_same_blocks() {
    let room = scene("instances_twin.obj");
    let engines = ["--for=three,bevy,unity", "--compress"];
    let at_once = |threads| bake(&room, &[&BAKE[..], &engines, &[threads]].concat()).0;
    let (one, three) = (at_once("--threads=1"), at_once("--threads=3"));
    let (later, _) = bake(&room, &BAKE);
    run_well([&["export", text(later.path()), "--quiet"][..], &engines].concat());
    for other in [&three, &later] {
        assert_eq!(files(one.path()), files(other.path()));
        for name in files(one.path()).iter().filter(|name| *name != "bake.json") {
            let read = |folder: &Path| fs::read(folder.join(name)).expect("a file");
            assert!(read(one.path()) == read(other.path()), "{name}");
        }
    }
    let told = report(one.path());
    assert_eq!(told["options"]["compress"], true);
    let maps = told["lightmaps"].as_array().expect("a list");
    let mut blocks: Vec<_> = maps
        .iter()
        .filter(|map| map["compression"].is_string())
        .collect();
    blocks.retain(|map| {
        map["file"]
            .as_str()
            .is_some_and(|file| file.contains(".0."))
    });
    let found: Vec<_> = blocks
        .iter()
        .map(|map| [&map["engine"], &map["file"]])
        .collect();
    assert_eq!(
        json!(found),
        json!([
            ["three", "instances_twin.0.lightmap.bc6h.dds"],
            ["bevy", "instances_twin.0.lightmap.bc6h.ktx2"],
        ])
    );
    assert!(!files(one.path()).contains(&"instances_twin.0.lightmap.ktx2".into()));
    // Unity gets what it gets without the flag.
    assert!(maps.iter().any(|map| map["engine"] == "unity"));
    // A bake without the flag takes the files away.
    run_well(
        [
            &["bake", text(&room), "-o", text(one.path()), "--quiet"][..],
            &BAKE,
        ]
        .concat(),
    );
    let left = files(one.path());
    assert!(!left.iter().any(|name| name.contains(".bc")), "{left:?}");
}

#[test]
fn what_cannot_be_compressed_is_said_before_a_ray_is_cast() {
    let plane = scene("plane.obj");
    let (whole, _) = bake(&plane, &["--size=16", "--rays=4"]);
    let (odd, _) = bake(&plane, &["--size=18", "--rays=4"]);
    let place = tempfile::tempdir().expect("a temporary directory");
    let bake_odd = [
        "bake",
        text(&plane),
        "-o",
        text(place.path()),
        "--size=18",
        "--for=bevy",
        "--compress",
    ];
    let bake_alone = ["bake", text(&plane), "-o", text(place.path()), "--compress"];
    let exports = |folder, engine| vec!["export", folder, "--compress", "--for", engine];
    for (arguments, words) in [
        (
            exports(text(whole.path()), "unity,godot"),
            "compress: compressed lightmaps are made for",
        ),
        (exports(text(odd.path()), "three"), "a multiple of 4"),
        (bake_odd.to_vec(), "a multiple of 4"),
        (bake_alone.to_vec(), "name one of them by --for"),
    ] {
        let output = run(arguments);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{errors}");
        assert_eq!(errors.lines().count(), 1, "{errors}");
        assert!(errors.contains(words), "{errors}");
    }
    assert!(!files(place.path()).contains(&"bake.json".into()));
}
