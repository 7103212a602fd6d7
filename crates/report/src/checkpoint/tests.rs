//! Journals that come back, that were cut short, and that others write.

use super::*;
use serde_json::json;

/// A journal of three blocks, closed.
fn written(path: &Path, header: &Value) -> Vec<u8> {
    let (mut journal, damage) = Journal::resume(path, header, |_| true).unwrap();
    assert_eq!(damage, None);
    for block in [b"one".as_slice(), b"", b"three"] {
        journal.append(block).unwrap();
    }
    std::fs::read(path).unwrap()
}

#[test]
fn blocks_return_for_a_header_that_fits_only() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("state");
    assert!(Journal::open(&path).unwrap().is_none());
    let header = json!({"seed": 1, "numbers": [0.1, 1e300]});
    written(&path, &header);
    let mut journal = Journal::open(&path).unwrap().unwrap();
    assert_eq!((journal.header(), journal.len()), (&header, 3));
    assert_eq!(journal.block(2).unwrap(), b"three");
    assert_eq!(journal.block(1).unwrap(), b"");
    drop(journal);
    let (journal, _) = Journal::resume(&path, &header, |found| *found == header).unwrap();
    assert_eq!(journal.len(), 3);
    drop(journal);
    let other = json!({"seed": 2});
    let (journal, damage) = Journal::resume(&path, &other, |found| *found == other).unwrap();
    assert!(journal.is_empty() && damage.is_none());
    drop(journal);
    assert_eq!(*Journal::open(&path).unwrap().unwrap().header(), other);
}

#[test]
fn a_journal_that_is_closed_is_free_whoever_has_a_copy_of_the_handle() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("state");
    let (journal, _) = Journal::resume(&path, &json!(1), |_| true).unwrap();
    assert!(Journal::resume(&path, &json!(1), |_| true).is_err());
    // A child process has such a copy between its fork and its own program.
    let copy = journal.file.try_clone().unwrap();
    drop(journal);
    assert!(Journal::resume(&path, &json!(1), |_| true).is_ok());
    drop(copy);
}

#[test]
fn a_torn_tail_costs_its_own_block_alone() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("state");
    let header = json!(7);
    let bytes = written(&path, &header);
    for cut in 1..8 + 5 + HASH {
        std::fs::write(&path, &bytes[..bytes.len() - cut]).unwrap();
        let (mut journal, damage) = Journal::resume(&path, &header, |_| true).unwrap();
        assert_eq!((journal.len(), damage), (2, None), "{cut}");
        assert!(!journal.is_empty());
        journal.append(b"three").unwrap();
        assert!(std::fs::read(&path).unwrap() == bytes, "{cut}");
    }
}

#[test]
fn of_a_long_torn_tail_nothing_is_left_behind_a_shorter_block() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("state");
    let (mut journal, _) = Journal::resume(&path, &json!(1), |_| true).unwrap();
    journal.append(&[0; 1000]).unwrap();
    drop(journal);
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
    let (mut journal, damage) = Journal::resume(&path, &json!(1), |_| true).unwrap();
    assert_eq!((journal.len(), damage), (0, None));
    journal.append(b"short").unwrap();
    drop(journal);
    let journal = Journal::open(&path).unwrap();
    assert_eq!(journal.expect("it is there").len(), 1);
}

#[test]
fn a_block_that_changed_since_it_was_found_is_not_handed_out() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("state");
    let mut bytes = written(&path, &json!(1));
    let mut journal = Journal::open(&path).unwrap().unwrap();
    let last = bytes.len() - HASH - 1;
    bytes[last] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    let error = journal.block(2).unwrap_err().to_string();
    assert!(error.contains("does not fit its checksum"), "{error}");
    assert_eq!(journal.block(0).unwrap(), b"one");
}

#[test]
fn flipped_bits_are_found() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("state");
    let header = json!({"seed": 1});
    let bytes = written(&path, &header);
    for at in (0..bytes.len()).step_by(3) {
        let mut bad = bytes.clone();
        bad[at] ^= 4;
        std::fs::write(&path, &bad).unwrap();
        // A length that grew looks like a torn tail: the block is lost, and nothing wrong is read.
        if let Ok(Some(journal)) = Journal::open(&path) {
            assert!(journal.len() < 3, "byte {at}");
            continue;
        }
        let (journal, damage) = Journal::resume(&path, &header, |_| true).unwrap();
        let damage = damage.unwrap_or_else(|| panic!("byte {at} is not told of"));
        assert!(journal.is_empty(), "byte {at}");
        assert!(
            damage.contains("damaged") && !damage.contains('\n'),
            "{damage}"
        );
    }
}

#[cfg(unix)]
#[test]
fn a_journal_is_not_written_through_a_link() {
    let dir = tempfile::tempdir().unwrap();
    let [real, link] = ["real", "link"].map(|name| dir.path().join(name));
    let bytes = written(&real, &json!(1));
    std::os::unix::fs::symlink("real", &link).unwrap();
    for fits in [true, false] {
        let error = Journal::resume(&link, &json!(2), |_| fits).unwrap_err();
        let line = error.to_string();
        let said = "link: it is a symbolic link; remove it";
        assert!(line.ends_with(said), "{line}");
    }
    assert!(std::fs::read(&real).unwrap() == bytes);
    // To read through one harms nothing.
    let mut journal = Journal::open(&link).unwrap().unwrap();
    assert_eq!(journal.len(), 3);
    // Another name is given to the link, and it is the link that goes.
    journal.rename(&dir.path().join("other")).unwrap();
    remove_journal(journal.path());
    assert!(std::fs::read(&real).unwrap() == bytes);
}

#[test]
fn two_writers_do_not_share_a_journal() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("state");
    let (_first, _) = Journal::resume(&path, &json!(1), |_| true).unwrap();
    let error = Journal::resume(&path, &json!(1), |_| true).unwrap_err();
    assert!(error.to_string().contains("another run"), "{error}");
}
