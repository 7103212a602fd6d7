//! Probes in parts: each gathers its share into a part file, in any order and on any machine.

use super::task::Task;
use super::{Places, ProbeOptions, Probes};
use crate::Scene;
use crate::differ::difference;
use crate::error::Error;
use crate::parts::{Kind, Shard, failed, is_done};
use crate::write::names::check_length;
use layers::Progress;
use report::{Journal, Output};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// What a shard of probes left.
#[derive(Debug)]
#[non_exhaustive]
pub struct ProbePart {
    /// The part file.
    pub path: PathBuf,
    /// True where it was complete before.
    pub already: bool,
    /// Places of this part that were gathered now: probes, and those between them at which interpolation is tried.
    pub places: u64,
    /// Faces of reflection maps that were captured now.
    pub faces: u64,
}

/// All parts of a scene's probes, complete and of one kind.
#[derive(Debug)]
pub struct ProbeParts {
    dir: PathBuf,
    parts: Vec<(Shard, Journal)>,
}

impl ProbeParts {
    /// True where a directory has parts of probes, in work or done.
    pub fn are_in(dir: &Path) -> bool {
        Kind::Probes.is_in(dir)
    }

    /// The parts in a directory.
    ///
    /// # Errors
    /// There are none, or those of several scenes; one is missing, damaged or unfinished; or they do not belong
    /// together. The message names which, and what to do.
    pub fn find(dir: &Path) -> Result<Self, Error> {
        Ok(Self {
            dir: dir.to_owned(),
            parts: Kind::Probes.find(dir)?,
        })
    }

    /// What whoever ran the shards gave along.
    pub fn given(&self) -> &Value {
        &self.parts[0].1.header()["given"]
    }
}

impl Probes {
    /// Gathers one share of the probes of a scene into `dir`: a part file, which [`ProbeParts`] finds there. One that
    /// was interrupted continues; one that is complete already is left as it is. `given` is kept in the part for
    /// whoever merges.
    ///
    /// # Errors
    /// One line that names the option or the file; another run gathers the same shard; [`Error::Cancelled`].
    pub fn gather_shard(
        scene: &Scene,
        places: &Places,
        options: &ProbeOptions,
        (dir, shard, given): (&Path, Shard, &Value),
        progress: &dyn Progress,
    ) -> Result<ProbePart, Error> {
        if options.refine.is_some() {
            let problem = "parts do not know each other's probes; gather them in one piece";
            return Err(Error::option("--refine", problem));
        }
        Task::with(scene, places, options, |task| {
            let mut output = Output::create(dir)?;
            output.protect(task.inputs.iter().cloned());
            let stem = scene.stem();
            let name = Kind::Probes.state_name(&stem, Some(shard));
            check_length(dir, &name)?;
            output.check(&Kind::Probes.part_name(&stem, shard))?;
            let path = dir.join(Kind::Probes.part_name(&stem, shard));
            let header = json!({
                "key": task.key, "shard": [shard.index, shard.of], "given": given,
            });
            let mut part = ProbePart {
                path,
                already: is_done(&dir.join(Kind::Probes.part_name(&stem, shard)), &header)?,
                places: 0,
                faces: 0,
            };
            if part.already {
                return Ok(part);
            }
            let mut kept = task.nothing();
            kept.save(output, dir.join(name), header);
            if let Some(line) = kept.resume()? {
                progress.note(&line);
            }
            // Neighbours cost much the same: each part takes every so-manieth.
            let wanted =
                |unit: usize| unit as u64 % u64::from(shard.of) + 1 == u64::from(shard.index);
            let lacks = task.lacks(&kept, &wanted);
            let span = task.span(progress, lacks);
            task.gather(&mut kept, &wanted, &span)?;
            let faces = (0..task.faces()).filter(|&face| wanted(task.places() + face as usize));
            let faces: Vec<u32> = faces.filter(|&face| !kept.has_face(face)).collect();
            for (before, face) in faces.into_iter().enumerate() {
                task.face(&mut kept, face, &span.faces(before as u64))?;
            }
            kept.end(&part.path)?;
            [part.places, part.faces] = lacks;
            Ok(part)
        })
    }

    /// The probes of all parts, as [`Self::gather`] makes them in one piece. [`Self::write`] removes the parts.
    ///
    /// # Errors
    /// The parts are of other probes, or something lacks. The message says which, and what to do.
    pub fn merge(
        scene: &Scene,
        places: &Places,
        options: &ProbeOptions,
        parts: ProbeParts,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        Task::with(scene, places, options, |task| {
            let fail = |problem| failed(&parts.dir, problem);
            let theirs = &parts.parts[0].1.header()["key"];
            if let Some(what) = difference(theirs, &task.key) {
                return Err(fail(format!(
                    "{what} differs from when the parts were gathered; run the shards again"
                )));
            }
            let mut kept = task.nothing();
            let mut paths = Vec::new();
            for (shard, journal) in parts.parts {
                let path = journal.path().to_owned();
                if !kept.add(journal)? {
                    let path = path.display();
                    return Err(fail(format!(
                        "{path} does not fit the probes; delete it and run --shard {shard} again"
                    )));
                }
                paths.push(path);
            }
            let lacks = task.lacks(&kept, &|_| true);
            if lacks != [0; 2] {
                let [places, faces] = lacks;
                return Err(fail(format!(
                    "{places} probes and {faces} faces are in no part; run the shards again"
                )));
            }
            let mut probes = task.finish(kept, &task.span(progress, lacks))?;
            probes.leftovers = paths;
            Ok(probes)
        })
    }
}
