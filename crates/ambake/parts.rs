//! Parts of a job in a directory: how their files are called, and which are there.

use crate::differ::difference;
use crate::error::Error;
use crate::resume::END;
use report::Journal;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// Shards that a message names at most.
const NAMED: usize = 8;

/// Which part of a bake: `index` of `of`, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Shard {
    /// From 1.
    pub index: u32,
    /// How many there are, at least `index`.
    pub of: u32,
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

/// A job that is done in parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Bake,
    Probes,
}

impl Kind {
    /// What stands between the stem of a name and its ending.
    fn label(self) -> &'static str {
        match self {
            Self::Bake => "",
            Self::Probes => "probes-",
        }
    }

    /// The name of a part file.
    pub fn part_name(self, stem: &str, shard: Shard) -> String {
        let (label, Shard { index, of }) = (self.label(), shard);
        format!("{stem}.{label}{index}-of-{of}.part")
    }

    /// The name of a part file in work, and with no shard that of a whole job's state.
    pub fn state_name(self, stem: &str, shard: Option<Shard>) -> String {
        let label = self.label();
        match (shard, self) {
            (Some(Shard { index, of }), _) => {
                format!(".{stem}.{label}{index}-of-{of}.ambake-resume")
            }
            (None, Self::Bake) => format!(".{stem}.ambake-resume"),
            (None, Self::Probes) => format!(".{stem}.probes.ambake-resume"),
        }
    }

    /// The stem and the shard of a part's name without its ending.
    fn parse(self, name: &str) -> Option<(String, Shard)> {
        let (stem, shard) = name.rsplit_once('.')?;
        let (index, of) = shard.strip_prefix(self.label())?.split_once("-of-")?;
        let shard = Shard {
            index: index.parse().ok()?,
            of: of.parse().ok()?,
        };
        (1..=shard.of)
            .contains(&shard.index)
            .then(|| (stem.into(), shard))
    }

    /// The stems of parts in a directory, and how many parts each has. Those in work count too, so that an array of
    /// which no shard is done yet is not taken for none.
    fn sets(self, dir: &Path) -> std::io::Result<BTreeSet<(String, u32)>> {
        let entries = std::fs::read_dir(dir)?;
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let set = |name: String| {
            let work = name.strip_prefix('.');
            let work = work.and_then(|name| name.strip_suffix(".ambake-resume"));
            let (stem, shard) = self.parse(name.strip_suffix(".part").or(work)?)?;
            Some((stem, shard.of))
        };
        Ok(names.filter_map(set).collect())
    }

    /// True where a directory has parts of this kind.
    pub fn is_in(self, dir: &Path) -> bool {
        self.sets(dir).is_ok_and(|sets| !sets.is_empty())
    }

    /// All parts of the one job in a directory, complete and of one kind, in order.
    ///
    /// # Errors
    /// There are none, or those of several jobs; one is missing, damaged or unfinished; or they do not belong
    /// together. The message names which, and what to do.
    pub fn find(self, dir: &Path) -> Result<Vec<(Shard, Journal)>, Error> {
        let fail = |problem: String| failed(dir, problem);
        let found = self.sets(dir).map_err(|e| fail(e.to_string()))?;
        let mut found = found.into_iter();
        let (stem, of) = match (found.next(), found.next()) {
            (Some(set), None) => set,
            (None, _) => {
                return Err(fail(
                    "no part of a sharded bake is here; `ambake bake SCENE -o DIR --shard I/N` makes them, as `ambake \
                     probes` does".into(),
                ));
            }
            (Some((a, n)), Some((b, m))) => {
                return Err(fail(format!(
                    "parts of several bakes are here (`{a}` in {n} and `{b}` in {m}); remove those that are not wanted"
                )));
            }
        };
        let (mut parts, mut missing) = (Vec::new(), Vec::new());
        for shard in (1..=of).map(|index| Shard { index, of }) {
            let open = Journal::open(&dir.join(self.part_name(&stem, shard)));
            let mut journal = open.map_err(|error| {
                fail(format!("{error}; delete it and run --shard {shard} again"))
            })?;
            if let Some(found) = &mut journal
                && !is_complete(found)?
            {
                journal = None;
            }
            match journal {
                Some(journal) => parts.push((shard, journal)),
                _ if missing.len() > NAMED => missing.push(String::new()),
                _ => {
                    let begun = dir.join(self.state_name(&stem, Some(shard))).exists();
                    let word = if begun { " (begun)" } else { "" };
                    missing.push(format!("{shard}{word}"));
                }
            }
        }
        if !missing.is_empty() {
            let count = missing.len();
            let more = match count.saturating_sub(NAMED) {
                0 => String::new(),
                more => format!(" and {more} more"),
            };
            missing.truncate(NAMED);
            return Err(fail(format!(
                "{count} of {of} parts of `{stem}` missing: {}{more}; run these with `--shard I/{of}`, \
                 then merge again",
                missing.join(", ")
            )));
        }
        let (first, others) = parts.split_at(1);
        for (shard, journal) in others {
            let (a, b) = (first[0].1.header(), journal.header());
            if let Some(what) = difference(&a["key"], &b["key"]) {
                return Err(fail(format!(
                    "parts {} and {shard} do not belong together: {what} differs; run one of them again",
                    first[0].0
                )));
            }
        }
        Ok(parts)
    }
}

/// True where a complete part with this header is there.
pub(crate) fn is_done(path: &Path, header: &Value) -> Result<bool, Error> {
    let Ok(Some(mut done)) = Journal::open(path) else {
        return Ok(false);
    };
    let is_same = (["key", "shard"].iter()).all(|of| done.header()[of] == header[of]);
    Ok(is_same && is_complete(&mut done)?)
}

/// True where a part's last block says that nothing is missing.
fn is_complete(journal: &mut Journal) -> Result<bool, Error> {
    Ok(match journal.len() {
        0 => false,
        blocks => journal.tag(blocks - 1)? == Some(END),
    })
}

/// What keeps the parts in a directory from being merged.
pub(crate) fn failed(dir: &Path, problem: String) -> Error {
    Error::Parts {
        dir: dir.display().to_string(),
        problem,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_parts_are_taken_apart_from_behind() {
        let shard = |index, of| Shard { index, of };
        let stem = "a.b 50%";
        for kind in [Kind::Bake, Kind::Probes] {
            let name = kind.part_name(stem, shard(3, 12));
            let name = name.strip_suffix(".part").unwrap();
            assert_eq!(kind.parse(name), Some((stem.into(), shard(3, 12))));
        }
        // Neither kind takes the other's.
        assert_eq!(Kind::Bake.parse("a.probes-1-of-2"), None);
        assert_eq!(Kind::Probes.parse("a.1-of-2"), None);
        for wrong in [
            "a.0-of-3",
            "a.4-of-3",
            "a.-1-of-3",
            "a",
            "a.1-of-",
            "3-of-4",
        ] {
            assert_eq!(Kind::Bake.parse(wrong), None, "{wrong}");
        }
    }
}
