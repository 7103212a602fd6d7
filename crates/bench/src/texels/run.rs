//! Bakes and judges the ten scenes.

use super::bake::Lab;
use super::cases;
use super::error::Error;
use super::row::Row;
use rays::{BackendKind, TreeKind};

/// Every row of the ten scenes at so many rays a texel, on the named backend, or on every one of this build. `each`
/// hears of the rows of a scene as soon as they are there.
///
/// # Errors
/// See [`Error`].
pub fn run(
    backend: Option<BackendKind>,
    rays: u32,
    each: &mut dyn FnMut(&[Row]),
) -> Result<Vec<Row>, Error> {
    let kinds = match backend {
        Some(kind) => vec![kind],
        None if rays::has_embree() => {
            vec![BackendKind::Embree, BackendKind::Obvhs(TreeKind::default())]
        }
        None => vec![BackendKind::Obvhs(TreeKind::default())],
    };
    let mut rows = Vec::new();
    for kind in kinds {
        let backend = match kind {
            BackendKind::Embree => "embree",
            BackendKind::Obvhs(TreeKind::Cwbvh) => "obvhs",
            BackendKind::Obvhs(TreeKind::Bvh2) => "obvhs-bvh2",
        };
        let lab = Lab {
            kind,
            backend,
            rays,
        };
        for case in cases::ALL {
            let found = case(&lab)?;
            each(&found);
            rows.extend(found);
        }
    }
    Ok(rows)
}
