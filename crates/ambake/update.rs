//! `--update`: what of an earlier bake still holds after the scene has changed.

use crate::differ::difference;
use crate::error::Error;
use crate::job::Job;
use crate::state::{self, Facts, Head};
use ::bake::{BakedPage, BakedTile, Baker, Fingerprint, Reach};
use atlas::Claim;
use blake3::Hasher;
use report::UpdateReport;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::convert::Infallible;

/// One of so many kept tiles is baked again by `--verify`, and one a page at least.
const VERIFIED: usize = 100;

/// What the tiles of a bake depend on, and which of them an earlier bake has.
pub(crate) struct Tracker<'a> {
    job: &'a Job,
    baker: &'a Baker<'a>,
    reach: Reach<'a>,
    key: Value,
    columns: usize,
    /// Tiles of the page in work that were kept.
    kept: Vec<u32>,
    report: UpdateReport,
}

impl<'a> Tracker<'a> {
    /// Looks at the scene of a bake.
    pub fn of(job: &'a Job, baker: &'a Baker<'a>) -> Self {
        let reach = job.within(|| Reach::of(baker));
        let key = tile_key(job);
        let mut report = UpdateReport::default();
        let objects = objects(job, &reach);
        if let Some(earlier) = job.earlier() {
            report.reason.clone_from(&earlier.reason);
            if let Some(head) = &earlier.head {
                report.changed = changed(&head.facts.objects, &objects);
                if let Some(what) = difference(&head.key, &key) {
                    report.reason = Some(format!("{what} differs from the earlier bake"));
                }
            }
        }
        let channels = baker.layers().into_iter();
        Self {
            job,
            baker,
            reach,
            key,
            columns: channels.map(|layer| layer.channels().len()).sum(),
            kept: Vec::new(),
            report,
        }
    }

    /// Why nothing or little of the earlier bake can serve.
    pub fn reason(&self) -> Option<&str> {
        self.report.reason.as_deref()
    }

    /// Says which ray library baked, where it was not this process's.
    pub fn baked_with(&mut self, backend: &str) {
        self.key["backend"] = backend.into();
    }

    /// Puts the tiles into a page that an earlier bake has with the same content and the page lacks. Returns what every
    /// tile of the page depends on. What tells of damage goes to `note`; such tiles are baked.
    pub fn keep(&mut self, page: &mut BakedPage, note: &dyn Fn(&str)) -> Vec<(u32, Fingerprint)> {
        let tiles = self.reach.tiles(page.page);
        self.kept.clear();
        let Some(earlier) = self.job.earlier() else {
            return tiles;
        };
        let index_of: HashMap<u32, usize> = (tiles.iter().map(|tile| tile.0)).zip(0..).collect();
        let wanted = |number: u32, fingerprint: &Fingerprint| {
            let index = index_of.get(&number);
            index.is_some_and(|&index| tiles[index].1 == *fingerprint)
        };
        let path = earlier
            .dir
            .join(state::tiles_name(&earlier.stem, page.page));
        let size = page.size;
        let read = state::read_tiles(&path, &self.key, size, self.columns, wanted, |kept| {
            let mut tile = kept.tile;
            tile.index = index_of[&kept.number] as u32;
            if page.store(&tile) {
                self.kept.push(tile.index);
                self.report.kept += tile.stats.texels;
            }
        });
        if let Err(error) = read {
            note(&format!("{error}; its tiles are baked anew"));
        }
        tiles
    }

    /// Bakes some of the kept tiles of a page again and compares them bit for bit, where that was asked for.
    ///
    /// # Errors
    /// [`Error::Differs`].
    pub fn verify(&mut self, page: &BakedPage, tiles: &[(u32, Fingerprint)]) -> Result<(), Error> {
        let Some(earlier) = self.job.earlier().filter(|earlier| earlier.verify) else {
            return Ok(());
        };
        let seed = self.job.options().seed;
        let mut chosen = self.kept.clone();
        chosen.sort_by_key(|&index| mixed(seed ^ u64::from(page.page) << 32 ^ u64::from(index)));
        chosen.truncate(self.kept.len().div_ceil(VERIFIED));
        let mut differing = None;
        let Ok(_) = self
            .baker
            .run_tiles(page.page, &chosen, (&(), 0), &mut |new| {
                let old = page.stored(new.index, tiles[new.index as usize].0);
                self.report.verified += new.stats.texels;
                if !old.is_some_and(|old| same(&old, &new)) {
                    differing = differing.or(new.texels.first().copied());
                }
                Ok::<_, Infallible>(())
            });
        match differing {
            None => Ok(()),
            Some(texel) => Err(Error::Differs {
                dir: earlier.dir.display().to_string(),
                page: page.page,
                texel: [texel % page.size, texel / page.size],
            }),
        }
    }

    /// What is kept with the tiles of every page.
    pub fn key(&self) -> &Value {
        &self.key
    }

    /// What the bake says of itself for later updates.
    ///
    /// # Errors
    /// None for a scene that was laid out.
    pub fn head(&self) -> Result<Head, Error> {
        let scene = self.job.scene();
        let claims = atlas::claims(scene, &self.job.options().layout());
        let claims: Vec<Claim> = claims.map_err(|source| Error::Layout {
            scene: scene.path.display().to_string(),
            source,
        })?;
        Ok(Head {
            key: self.key.clone(),
            facts: Facts {
                claims,
                objects: objects(self.job, &self.reach),
            },
            atlas: self.job.atlas().clone(),
        })
    }

    /// What `bake.json` says of the update; `None` where there was none.
    pub fn report(self) -> Option<UpdateReport> {
        self.job.earlier()?;
        let all = self.job.atlas().audit.texels;
        let mut report = self.report;
        report.baked = all.saturating_sub(report.kept);
        report.share = report.baked as f64 / all.max(1) as f64;
        Some(report)
    }
}

/// Everything but the scene that decides the values of tiles.
fn tile_key(job: &Job) -> Value {
    json!({
        "version": crate::VERSION,
        "revision": crate::REVISION,
        "options": job.options().describe(),
        "backend": job.backend().describe(),
    })
}

/// The objects of a scene and hashes of their content.
fn objects(job: &Job, reach: &Reach<'_>) -> Vec<(String, String)> {
    let contents: Vec<Fingerprint> = reach.instances().collect();
    let named = atlas::object_names(job.scene()).into_iter();
    named
        .map(|object| {
            let mut hasher = Hasher::new();
            for instance in object.instances {
                hasher.update(&contents[instance as usize]);
            }
            (object.name, hasher.finalize().to_hex()[..32].into())
        })
        .collect()
}

/// Names of the objects that differ, in the order of the new ones; those that are gone come last.
fn changed(before: &[(String, String)], now: &[(String, String)]) -> Vec<String> {
    let map = |objects: &[(String, String)]| -> HashMap<String, String> {
        objects.iter().cloned().collect()
    };
    let (old, new) = (map(before), map(now));
    let differs = |(name, hash): &&(String, String)| old.get(name) != Some(hash);
    let gone = |(name, _): &&(String, String)| !new.contains_key(name);
    let names = now.iter().filter(differs).chain(before.iter().filter(gone));
    names.map(|(name, _)| name.clone()).collect()
}

/// True for the same bits.
fn same(a: &BakedTile, b: &BakedTile) -> bool {
    let bits = |tile: &BakedTile| -> Vec<u32> { tile.values.iter().map(|v| v.to_bits()).collect() };
    a.texels == b.texels && a.stats == b.stats && bits(a) == bits(b)
}

/// A number that looks random for each number (the finaliser of splitmix64).
fn mixed(number: u64) -> u64 {
    let mut z = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}
