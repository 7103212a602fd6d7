//! The corpus of the fuzz targets, replayed as it stands and with each file damaged a few times: every reader returns.
//! With `AMBAKE_CORPUS_COPIES=10000` it is a plain fuzzer that needs no nightly Rust; `AMBAKE_CORPUS_FIRST` numbers the
//! first copy.

#[path = "../fuzz/formats.rs"]
#[allow(dead_code)]
mod formats;

use std::path::Path;

/// Damaged copies of each file, where the environment names no other number.
const COPIES: u64 = 24;

fn number(variable: &str, default: u64) -> u64 {
    let given = std::env::var(variable).ok();
    given.map_or(default, |text| text.parse().expect("a number"))
}

#[test]
fn every_reader_returns_from_every_file_of_the_corpus() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
    let first = number("AMBAKE_CORPUS_FIRST", 1);
    let copies = first..first + number("AMBAKE_CORPUS_COPIES", COPIES);
    for (name, read) in formats::FORMATS {
        let folder = corpus.join(name);
        let mut files: Vec<_> = std::fs::read_dir(&folder)
            .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
            .map(|entry| entry.expect("an entry").path())
            .collect();
        files.sort();
        assert!(!files.is_empty(), "{name} has a corpus");
        for path in files {
            let bytes = std::fs::read(&path).expect("it is there");
            assert!(bytes.len() <= 8192, "{} is no small seed", path.display());
            println!("{}", path.display());
            read(&bytes);
            for copy in copies.clone() {
                read(&damaged(&bytes, copy));
            }
        }
    }
}

/// The bytes with up to three of them changed, and every third copy cut.
fn damaged(bytes: &[u8], copy: u64) -> Vec<u8> {
    let mut state = copy;
    // SplitMix64.
    let mut below = |n: usize| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) % n.max(1) as u64) as usize
    };
    let mut damaged = bytes.to_vec();
    for _ in 0..1 + below(3) {
        let at = below(damaged.len());
        if let Some(byte) = damaged.get_mut(at) {
            *byte = match below(3) {
                0 => 0xff,
                1 => *byte ^ (1 << below(8)),
                _ => b"0123456789-.e"[below(13)],
            };
        }
    }
    if copy.is_multiple_of(3) {
        damaged.truncate(below(bytes.len()));
    }
    damaged
}
