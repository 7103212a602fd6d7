//! What a listener hears of a bake, from the plan to the last gather, and that it may stop it anywhere.

use crate::support::scene;
use ambake::{Bake, Bounces, Error, Progress};
use std::sync::Mutex;

/// Writes down phases and how far each got, and cancels in one of them.
#[derive(Default)]
struct Listener {
    heard: Mutex<Vec<(String, u64, u64)>>,
    until: Option<&'static str>,
}

impl Progress for Listener {
    fn phase(&self, name: &str) {
        self.heard.lock().unwrap().push((name.into(), 0, 0));
    }

    fn advance(&self, done: u64, total: u64) {
        let mut heard = self.heard.lock().unwrap();
        let last = heard.last_mut().expect("a phase comes before its work");
        (last.1, last.2) = (last.1.max(done), total);
    }

    fn cancelled(&self) -> bool {
        let heard = self.heard.lock().unwrap();
        heard
            .last()
            .is_some_and(|(name, ..)| Some(name.as_str()) == self.until)
    }
}

fn bake(listener: &Listener) -> Result<(), Error> {
    let scene = ambake::load(scene("courtyard.obj"))?;
    let bake = Bake::new(&scene)
        .size(256)
        .rays(8)
        .bounces(Bounces::Most(2));
    bake.run(listener).map(drop)
}

#[test]
fn every_phase_of_a_bake_is_told_and_counts_all_texels() {
    let listener = Listener::default();
    bake(&listener).expect("a bake");
    let heard = listener.heard.into_inner().unwrap();
    let names: Vec<&str> = heard.iter().map(|(name, ..)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "planning",
            "building the ray scene",
            "laying out",
            "making charts",
            "packing charts",
            "baking",
            "denoising and closing seams",
            "gather 1",
            "last gather"
        ]
    );
    let (triangles, texels) = (heard[3].2, heard[5].2);
    for (name, done, total) in &heard {
        let all = match name.as_str() {
            "making charts" => triangles,
            "baking" | "gather 1" | "last gather" => texels,
            _ => 0,
        };
        assert_eq!((*done, *total), (all, all), "{name}");
    }
    assert!(
        triangles > 100 && texels > 1000,
        "{triangles} triangles, {texels} texels"
    );
}

#[test]
fn a_bake_is_cancelled_in_any_phase() {
    for until in [
        "planning",
        "building the ray scene",
        "laying out",
        "making charts",
        "packing charts",
        "baking",
        "gather 1",
    ] {
        let listener = Listener {
            until: Some(until),
            ..Listener::default()
        };
        let ended = bake(&listener);
        assert!(matches!(ended, Err(Error::Cancelled)), "{until}: {ended:?}");
        let heard = listener.heard.into_inner().unwrap();
        assert_eq!(heard.last().map(|(name, ..)| name.as_str()), Some(until));
    }
}
