//! Speed against error, measured: how far a bake is from the bare ray loop, and what each technique costs at equal
//! error.
//!
//! # Where what is
//!
//! * What `bench` compares: `speed.rs`, with tables and pictures in `summary`. Other programs:
//!   `crates/cli/bench/peers.rs` with `crates/bench/peers`.
//! * Exact answers: `exact`. Hard cases: `hard`. Two backends on the same rays: `parity`. Whether stated errors are
//!   true: `stated`.
//! * What counts as buried: `burial`, where `scenes.rs` makes the scenes and `rules.rs` has the rules that are
//!   compared.
//! * Lightmaps on their surface, with their seams: `texels`, whose ten scenes are in `cases`;
//!   `crates/bench/lightmaps.py` makes a table of bakes of any scenes.
//! * Figures of the papers: `figures`. What plans predict: `crates/bench/plan.py`. What updates cost:
//!   `crates/bench/update.py`. Raw measurements: `crates/bench/runs`.
#![forbid(unsafe_code)]

use atlas::Atlas;
use bake::{BakedPage, Baker, Options, Plan, Seams};
use rays::{RayBackend, World};

pub mod burial;
pub mod ceiling;
mod clock;
pub mod exact;
pub mod figures;
pub mod grain;
pub mod hard;
pub mod maps;
pub mod parity;
pub mod samplers;
pub mod speed;
pub mod stated;
pub mod summary;
pub mod tables;
mod tables_truth;
pub mod texels;

/// What is baked: page 0 of an atlas over a world.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// The triangles.
    pub world: &'a World,
    /// What is modelled.
    pub plan: &'a Plan,
    /// Where the texels lie.
    pub atlas: &'a Atlas,
}

impl Subject<'_> {
    /// Bakes page 0 in the current pool of threads. Seams are left alone: texels are measured against the mean over
    /// their footprint, which solving seams gives up for what a look-up shows.
    pub fn bake(&self, backend: &dyn RayBackend, options: &Options) -> BakedPage {
        let options = Options {
            seams: Seams::Off,
            ..options.clone()
        };
        let baker = Baker::new(self.world, self.plan, backend, self.atlas, &options);
        let mut page = baker.start(0);
        baker.run(&mut page, &());
        page
    }
}
