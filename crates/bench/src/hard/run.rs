//! Bakes and judges every case.

use super::bake::bake;
use super::cases::cases;
use super::error::Error;
use super::judge::judge;
use super::row::Row;
use super::{equal, input};
use rays::{BackendKind, TreeKind};

/// Every case on every backend of this build, in the current pool of threads.
///
/// # Errors
/// See [`Error`].
pub fn run() -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for (kind, backend) in backends() {
        for case in cases() {
            let page = bake(&case.setup, case.name, kind)?;
            rows.extend(
                case.expected
                    .iter()
                    .map(|e| judge(&case, e, &page, backend)),
            );
        }
        rows.extend(equal::rows(kind, backend)?);
    }
    rows.extend(input::rows()?);
    Ok(rows)
}

fn backends() -> Vec<(BackendKind, &'static str)> {
    let mut all = vec![(BackendKind::Obvhs(TreeKind::default()), "obvhs")];
    if embree::header_version().is_some() {
        all.insert(0, (BackendKind::Embree, "embree"));
    }
    all
}
