//! Closed boxes: no ray may slip through an edge or a corner.

use crate::exact::Open;
use crate::hard::case::{Bound, Case, both};
use crate::hard::setup::Setup;

pub(super) fn cases() -> Vec<Case> {
    let (x, y) = ([-1.0, 1.0], [-1.0, 1.0]);
    let side = |setup: Setup, splits: usize| {
        (0..splits).fold(setup, |setup, i| {
            let cut = |i: usize| -1.0 + 2.0 * i as f64 / splits as f64;
            let (a, b) = (cut(i), cut(i + 1));
            setup
                .quad([
                    [-1.0, a, 0.0],
                    [-1.0, b, 0.0],
                    [-1.0, b, 1.5],
                    [-1.0, a, 1.5],
                ])
                .quad([[1.0, a, 0.0], [1.0, a, 1.5], [1.0, b, 1.5], [1.0, b, 0.0]])
                .quad([
                    [a, -1.0, 0.0],
                    [a, -1.0, 1.5],
                    [b, -1.0, 1.5],
                    [b, -1.0, 0.0],
                ])
                .quad([[a, 1.0, 0.0], [b, 1.0, 0.0], [b, 1.0, 1.5], [a, 1.0, 1.5]])
        })
    };
    let box_of = |splits| side(Setup::over(x, 1.0), splits);
    let simple = || box_of(1).plate(x, y, 1.5);
    // 12 panels round, cut at thirds, and 4 above, cut at halves: corners meet edges.
    let panels = || {
        let halves = [[-1.0, 0.0], [0.0, 1.0]];
        let quarters = halves.iter().flat_map(|&x| halves.map(|y| (x, y)));
        quarters.fold(box_of(3), |setup, (x, y)| setup.plate(x, y, 1.5))
    };
    let dark = Open {
        visibility: 0.0,
        diffuse: 0.0,
    };
    let exact = |name, setup| {
        let why = "exact: watertight traversal, samples kept off edges";
        both(name, setup, dark, [Bound::EveryTexel; 2], why, None)
    };
    vec![
        exact("closed box", simple()),
        exact("closed box, turned", simple().turned()),
        exact("closed box of 16 panels", panels()),
        both(
            "closed box of 16 panels, turned",
            panels().turned(),
            dark,
            [Bound::Single { limit: 1e-5 }; 2],
            "corners that meet edges leave gaps of an ulp (1e-7 by 14 units of edge)",
            None,
        ),
    ]
}
