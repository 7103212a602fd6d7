//! The finished bake that `--update` starts from.

use crate::error::Error;
use crate::layout::DECIDING;
use crate::options::Options;
use crate::scene::Scene;
use crate::state::{self, Head};
use atlas::{Atlas, Seen};
use std::path::{Path, PathBuf};

/// The finished bake that an update starts from.
pub(crate) struct Earlier {
    pub dir: PathBuf,
    /// How the names of its files begin.
    pub stem: String,
    pub head: Option<Head>,
    /// Why it cannot serve.
    pub reason: Option<String>,
    /// Some of what is kept is baked again and compared.
    pub verify: bool,
}

impl Earlier {
    /// The bake in `dir`, of a scene of any name.
    ///
    /// # Errors
    /// No finished bake is there.
    pub fn open(dir: &Path, scene: &Scene, verify: bool) -> Result<Self, Error> {
        let last = || report::read_bake_report(&dir.join(report::REPORT_FILE));
        let own = report::read_record(dir, &scene.stem());
        let report = own.map_or_else(last, Ok).map_err(|error| {
            let problem = format!("no finished bake to update from: {error}");
            Error::option("--update", problem)
        })?;
        let own = state::head_name(&scene.stem());
        let states = report.files.iter().filter(|name| {
            Path::new(name).file_name() == Some(name.as_ref()) && name.ends_with(".state")
        });
        // Names of pages are longer than the head's.
        let head = match report.files.contains(&own) {
            true => Some(&own),
            false => states.min_by_key(|name| name.len()),
        };
        let mut earlier = Self {
            dir: dir.into(),
            stem: String::new(),
            head: None,
            reason: None,
            verify,
        };
        let Some(name) = head else {
            let dir = dir.display();
            earlier.reason = Some(format!("{dir} keeps no state; this bake does"));
            return Ok(earlier);
        };
        earlier.stem = name.trim_end_matches(".state").into();
        match Head::read(&dir.join(name)) {
            Ok(Some(head)) => earlier.head = Some(head),
            Ok(None) => earlier.reason = Some(format!("{name} is missing")),
            Err(error) => earlier.reason = Some(error.to_string()),
        }
        Ok(earlier)
    }

    /// The folder that was named, and whether what is kept is tried.
    pub fn asked(&self) -> (&Path, bool) {
        (&self.dir, self.verify)
    }

    /// The earlier layout for this scene, with places for what is new; `None` where it does not serve.
    ///
    /// * `seen`: as [`atlas::layout_seen`] takes it.
    pub fn layout(
        &mut self,
        scene: &Scene,
        options: &Options,
        seen: Option<&Seen<'_>>,
    ) -> Option<Atlas> {
        let head = self.head.as_ref()?;
        let described = options.describe();
        let changed = |name: &&str| head.key["options"][*name] != described[*name];
        if let Some(name) = DECIDING.into_iter().find(changed) {
            self.reason = Some(format!("--{} is another", name.replace('_', "-")));
            return None;
        }
        let options = options.layout();
        let now = atlas::claims(scene, &options).ok()?;
        let claims = &head.facts.claims;
        let kept = atlas::reuse(&head.atlas, claims, &scene.0, &now, &options, seen);
        if kept.is_none() {
            let reason = "an object is new or has another shape and no place among the others, so the texels were \
                laid out anew";
            self.reason = Some(reason.into());
        }
        kept
    }
}
