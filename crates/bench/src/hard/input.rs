//! What the loader does with triangles and numbers that mean nothing.

use super::error::Error;
use super::row::{Row, count};
use scene::WarningKind;
use std::io::Write;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// Each broken file, with how often its warning is counted; no warning means that the load is refused.
const FILES: [(&str, &str, Option<WarningKind>, &str); 4] = [
    (
        "zero-area triangles",
        "v 2 0 0\nf 1 2 3\nf 1 3 4\nf 1 2 5\nf 1 1 2\n",
        Some(WarningKind::ZeroAreaTriangles),
        "dropped and counted",
    ),
    (
        "NaN normal",
        "vn 0 0 1\nvn nan 0 1\nf 1//1 2//1 3//2\n",
        Some(WarningKind::BadNormals),
        "replaced by the geometric mean and counted",
    ),
    (
        "NaN position",
        "v nan 0 0\nf 1 2 5\n",
        None,
        "the load is refused",
    ),
    (
        "infinite position",
        "v inf 0 0\nf 1 2 5\n",
        None,
        "the load is refused",
    ),
];

/// One row a file.
pub(super) fn rows() -> Result<Vec<Row>, Error> {
    FILES
        .iter()
        .map(|&(case, tail, warning, why)| {
            let source = |source| Error::Write {
                case: case.into(),
                source,
            };
            let mut file = tempfile::Builder::new()
                .suffix(".obj")
                .tempfile()
                .map_err(source)?;
            write!(file, "{SQUARE}{tail}").map_err(source)?;
            let loaded = scene::load(file.path());
            Ok(match warning {
                None => count(case, "refusals", "load", 1, loaded.is_err().into(), why),
                Some(kind) => {
                    let counted = loaded.map_or(0, |scene| scene.warned(kind) as usize);
                    let expected = match kind {
                        WarningKind::BadNormals => 1,
                        _ => 2,
                    };
                    count(case, kind.name(), "load", expected, counted, why)
                }
            })
        })
        .collect()
}
