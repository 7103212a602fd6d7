//! EXR pages: what is written comes back, the bytes are fixed, damage is an error, another library reads the file.

#[path = "../../../tests/skip.rs"]
mod skip;

use ambake_report::{Output, Page, PageHeader, PageLayer, read_page_exr, write_page_exr};
use skip::skip;
use std::path::{Path, PathBuf};

/// Values with all kinds of bits, the same on every run.
fn ramp(size: u32, seed: u32) -> Vec<f32> {
    (0..size * size)
        .map(|i| (i.wrapping_mul(2_654_435_761).wrapping_add(seed) >> 8) as f32 / 1.6e7 - 0.25)
        .collect()
}

fn page(size: u32) -> Page {
    let triple =
        |name, suffixes| PageLayer::triple(name, suffixes, [1, 2, 3].map(|s| ramp(size, s)));
    Page {
        size,
        layers: vec![
            PageLayer::scalar("visibility", ramp(size, 5)),
            PageLayer::scalar("coverage", ramp(size, 4)),
            triple("lambert", ["R", "G", "B"]),
            triple("difference.lambert", ["R", "G", "B"]),
            triple("position", ["X", "Y", "Z"]),
        ],
    }
}

fn header() -> PageHeader {
    PageHeader {
        version: "0.1.0".into(),
        options: r#"{"rays":64,"sky":"Grüße.hdr"}"#.into(),
        seed: u64::MAX,
        convention: "visibility = open solid angle / 2 pi".into(),
        view: "normal".into(),
        scene_hash: "00ff".into(),
        layout: "aa00".into(),
        page: 3,
    }
}

fn write(dir: &Path, name: &str, page: &Page) -> PathBuf {
    let mut out = Output::create(dir).unwrap();
    out.stage(name, |file| {
        write_page_exr(file, page.size, &page.named_channels(), &header())
    })
    .unwrap();
    out.publish().unwrap().remove(0)
}

#[test]
fn a_page_comes_back_bit_for_bit() {
    let dir = tempfile::tempdir().unwrap();
    let mut page = page(37);
    let read = read_page_exr(&write(dir.path(), "a.exr", &page)).unwrap();
    page.layers.sort_by(|a, b| a.name.cmp(&b.name));
    assert!(read.page == page);
    assert_eq!(read.attributes["ambakeSeed"], u64::MAX.to_string());
    assert_eq!(read.attributes["ambakeOptions"], header().options);
    assert_eq!(read.attributes["ambakePage"], "3");
    assert_eq!(read.attributes["ambakeSceneHash"], "00ff");
    assert_eq!(read.attributes["ambakeLayout"], "aa00");
}

#[test]
fn bytes_do_not_depend_on_run_threads_or_layer_order() {
    let dir = tempfile::tempdir().unwrap();
    let page = page(130);
    let first = std::fs::read(write(dir.path(), "a.exr", &page)).unwrap();
    let mut turned = page.clone();
    turned.layers.reverse();
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let path = pool.install(|| write(dir.path(), "b.exr", &turned));
        assert!(std::fs::read(path).unwrap() == first, "{threads} threads");
    }
}

#[test]
fn channels_and_attributes_stand_in_the_order_of_their_names() {
    let dir = tempfile::tempdir().unwrap();
    let bytes = std::fs::read(write(dir.path(), "a.exr", &page(4))).unwrap();
    let at = |name: &str| {
        let needle = [name.as_bytes(), b"\0"].concat();
        bytes
            .windows(needle.len())
            .position(|w| w == needle)
            .unwrap_or_else(|| panic!("{name} is missing"))
    };
    let attributes = [
        "ambakeConvention",
        "ambakeVersion",
        "channels",
        "compression",
        "dataWindow",
        "software",
    ];
    assert!(attributes.map(at).is_sorted(), "{:?}", attributes.map(at));
    let channels = [
        "coverage",
        "difference.lambert.B",
        "lambert.B",
        "lambert.G",
        "lambert.R",
        "position.X",
    ];
    assert!(channels.map(at).is_sorted(), "{:?}", channels.map(at));
}

#[test]
fn a_nan_is_refused_with_layer_and_texel() {
    let dir = tempfile::tempdir().unwrap();
    let mut page = page(8);
    page.layers[2].channels[1].values[8 * 3 + 5] = f32::NAN;
    let mut out = Output::create(dir.path()).unwrap();
    let error = out
        .stage("a.exr", |file| {
            write_page_exr(file, page.size, &page.named_channels(), &header())
        })
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("lambert.G") && error.contains("(5, 3)") && error.contains("NaN"),
        "{error}"
    );
    drop(out);
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
}

#[test]
fn every_truncation_is_an_error_and_flipped_bytes_never_panic() {
    let dir = tempfile::tempdir().unwrap();
    let path = write(dir.path(), "a.exr", &page(6));
    let good = std::fs::read(&path).unwrap();
    let bad = dir.path().join("bad.exr");
    for length in 0..good.len() {
        std::fs::write(&bad, &good[..length]).unwrap();
        let error = read_page_exr(&bad)
            .err()
            .unwrap_or_else(|| panic!("{length} of {} bytes pass", good.len()));
        assert!(
            error.to_string().contains("bad.exr") && !error.to_string().contains('\n'),
            "{error}"
        );
    }
    for at in 0..good.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut bytes = good.clone();
            bytes[at] ^= flip;
            std::fs::write(&bad, bytes).unwrap();
            let _ = read_page_exr(&bad);
        }
    }
}

#[test]
fn absent_foreign_and_lying_files_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let says = |path: &Path, word: &str| {
        let error = read_page_exr(path).unwrap_err().to_string();
        assert!(
            error.contains(path.to_str().unwrap()) && error.contains(word),
            "{error}"
        );
    };
    says(&dir.path().join("none.exr"), "No such file");
    says(dir.path(), "directory");
    let text = dir.path().join("text.exr");
    std::fs::write(&text, "not an exr").unwrap();
    says(&text, "not an EXR page");
    // A header that promises 16,000 by 16,000 texels over a file of a few kilobytes.
    let path = write(dir.path(), "a.exr", &page(4));
    let mut bytes = std::fs::read(&path).unwrap();
    let window = bytes
        .windows(11)
        .position(|w| w == b"dataWindow\0")
        .unwrap()
        + 11
        + 6
        + 4;
    bytes[window + 8..window + 12].copy_from_slice(&15_999i32.to_le_bytes());
    bytes[window + 12..window + 16].copy_from_slice(&15_999i32.to_le_bytes());
    let count = bytes
        .windows(11)
        .position(|w| w == b"chunkCount\0")
        .unwrap()
        + 11
        + 4
        + 4;
    bytes[count..count + 4].copy_from_slice(&1_000i32.to_le_bytes());
    std::fs::write(&path, bytes).unwrap();
    says(&path, "cannot hold");
}

#[test]
fn openexr_itself_reads_the_page() {
    let dir = tempfile::tempdir().unwrap();
    let path = write(dir.path(), "a.exr", &page(21));
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/tools/read_exr.py");
    let run = std::process::Command::new("python3")
        .arg(script)
        .arg(&path)
        .output();
    let run = match run {
        Ok(run) if run.status.code() == Some(77) => {
            return skip("python3 has no module OpenEXR");
        }
        Ok(run) => run,
        Err(_) => return skip("python3 is not installed"),
    };
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    let seen: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(
        (&seen["width"], &seen["height"], &seen["compression"]),
        (&21.into(), &21.into(), &"ZIP".into())
    );
    assert_eq!(seen["attributes"]["ambakeOptions"], header().options);
    let page = page(21);
    let named = page.named_channels();
    assert_eq!(seen["channels"].as_object().unwrap().len(), named.len());
    for (name, values) in named {
        let channel = &seen["channels"][&name];
        assert_eq!(channel["type"], "float32", "{name}");
        assert_eq!(
            channel["first"].as_f64().unwrap(),
            f64::from(values[0]),
            "{name}"
        );
        assert_eq!(
            channel["last"].as_f64().unwrap(),
            f64::from(*values.last().unwrap()),
            "{name}"
        );
        let hash = values.iter().fold(0u32, |hash, v| {
            hash.wrapping_mul(31).wrapping_add(v.to_bits())
        });
        assert_eq!(channel["hash"].as_u64().unwrap(), u64::from(hash), "{name}");
    }
}
