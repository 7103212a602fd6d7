use super::*;
use crate::options::{Bounces, Options};
use crate::plan::Plan;
use std::collections::HashMap;
use std::sync::Arc;

/// Keeps so many tiles in memory, and no more.
#[derive(Default)]
struct Kept {
    found: HashMap<(u32, u32), Vec<BakedTile>>,
    kept: Vec<(u32, u32, BakedTile)>,
    room: usize,
}

impl KeepGathers for Kept {
    type Error = &'static str;

    fn found(&mut self, gather: u32, page: u32) -> Result<Vec<BakedTile>, &'static str> {
        Ok(self.found.remove(&(gather, page)).unwrap_or_default())
    }

    fn keep(&mut self, gather: u32, page: u32, tile: &BakedTile) -> Result<(), &'static str> {
        if self.kept.len() == self.room {
            return Err("full");
        }
        self.kept.push((gather, page, tile.clone()));
        Ok(())
    }
}

/// Rays and seconds of pages.
fn spent(pages: &[BakedPage]) -> (u64, f64) {
    let stats = || pages.iter().map(|page| &page.stats);
    (
        stats().map(|stats| stats.rays).sum(),
        stats().map(|stats| stats.seconds).sum(),
    )
}

#[test]
fn gathers_go_on_from_the_tiles_that_were_kept_to_the_same_light() {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/resting_sphere.obj"
    );
    let scene = Arc::new(scene::load(file.as_ref()).expect("a scene"));
    let options = Options {
        effort: Effort::Rays(8),
        bounces: Bounces::Most(2),
        layers: vec![Layer::Irradiance, Layer::Rays],
        ..Options::default()
    };
    let (plan, world) = Plan::of(&scene, &options).expect("a plan");
    let layout = atlas::Options {
        page_size: 64,
        pages: atlas::Pages::Most(2),
        ..Default::default()
    };
    let atlas = atlas::layout(&scene, &layout, &|| false).expect("a layout");
    let kind = rays::BackendKind::Obvhs(rays::TreeKind::default());
    let backend = rays::build(kind, &world, 0).expect("a backend");
    let baker = Baker::new(&world, &plan, backend.as_ref(), &atlas, &options);
    let pages: Vec<BakedPage> = (0..atlas.page_count)
        .map(|page| {
            let mut page = baker.start(page);
            baker.run(&mut page, &());
            page
        })
        .collect();
    let bounce = |kept: &mut Kept| {
        let mut pages = pages.clone();
        let before = spent(&pages);
        let stats = baker.bounce(&mut pages, kept, &());
        let (rays, seconds) = spent(&pages);
        let added = matches!(&stats, Ok(Some(_)));
        assert_eq!(seconds > before.1, added, "time is told with the rays");
        if let Ok(Some(stats)) = &stats {
            assert_eq!(rays, before.0 + stats.rays, "those of all gathers");
        }
        (pages.iter_mut()).for_each(|page| page.stats.seconds = 0.0);
        (stats, pages)
    };
    let mut all = Kept {
        room: usize::MAX,
        ..Kept::default()
    };
    let (stats, whole) = bounce(&mut all);
    let stats = stats.expect("room").expect("not cancelled");
    let tiles = all.kept.len();
    assert!(stats.gathers == 2 && tiles > 16, "{stats:?}, {tiles} tiles");
    assert!(whole != pages, "light was added");

    // Amid the second gather there is no room for more.
    let mut part = Kept {
        room: tiles * 3 / 4,
        ..Kept::default()
    };
    let (ended, left) = bounce(&mut part);
    assert_eq!(ended, Err("full"));
    let mut before = pages.clone();
    (before.iter_mut()).for_each(|page| page.stats.seconds = 0.0);
    assert!(left == before, "pages stand as they were");
    assert_eq!(part.kept.len(), tiles * 3 / 4);

    let mut rest = Kept {
        room: usize::MAX,
        ..Kept::default()
    };
    for (gather, page, tile) in part.kept {
        rest.found.entry((gather, page)).or_default().push(tile);
    }
    // What does not fit is gathered anew.
    let first = rest.found.get_mut(&(0, 0)).expect("tiles");
    first[0].values.pop();
    let (again, same) = bounce(&mut rest);
    assert_eq!(again, Ok(Some(stats)));
    assert!(same == whole, "the values differ");
    assert_eq!(rest.kept.len(), tiles - tiles * 3 / 4 + 1);
}
