//! Walls and grooves beside the receiver: grazing light, very near, very low and very high ones.

use crate::exact::shapes;
use crate::hard::case::{Bound, Case, SAMPLING, both, shaped};
use crate::hard::setup::Setup;

pub(super) fn cases() -> Vec<Case> {
    let wall = |name, x: f64, height: f64, table| {
        let setup = Setup::at(x, 0.25 * x).wall(height, 1e4 * x.max(height));
        shaped(
            name,
            setup,
            shapes::wall(x, height),
            false,
            Some((table, false)),
        )
    };
    let groove = |name, opening: f64, table| {
        // The other face leans over the receiver from the crease at x = 0.
        let (x, z) = (1e4 * opening.cos(), 1e4 * opening.sin());
        let setup = Setup::at(1.0, 1e-4).quad([
            [0.0, -1e4, 0.0],
            [0.0, 1e4, 0.0],
            [x, 1e4, z],
            [x, -1e4, z],
        ]);
        let exact = shapes::groove(opening);
        both(
            name,
            setup,
            exact,
            [Bound::Sampling {
                shape: 2e-4 * opening,
            }; 2],
            "4 stated standard errors + 6/N + faces end at 1e4",
            Some((table, false)),
        )
    };
    let touching = |name, far: f64, table| {
        let setup = Setup::over([0.0, far], 0.5 * far).wall(1.0, 1e4);
        let open = shapes::wall_average(0.0, far, 1.0);
        let bounds = [Bound::Sampling { shape: 1e-8 }; 2];
        both(name, setup, open, bounds, SAMPLING, Some((table, false)))
    };
    vec![
        wall(
            "texels 1e-6 from a wall",
            1e-6,
            1.0,
            "infinite wall d=1e-6 h=1",
        ),
        wall(
            "texels 1e-3 from a wall",
            1e-3,
            1.0,
            "infinite wall d=1e-3 h=1",
        ),
        wall("wall 1e-6 high", 1.0, 1e-6, "infinite wall d=1 h=1e-6"),
        wall("wall 1e6 high", 1.0, 1e6, "infinite wall d=1 h=1e6"),
        touching(
            "texels that touch a wall",
            0.01,
            "infinite wall h=1, texel average d in [0,0.01]",
        ),
        groove(
            "groove of 1e-3 rad",
            1e-3,
            "V-groove, opening 1e-3 rad, infinite faces",
        ),
        groove(
            "groove of 0.1 rad",
            0.1,
            "V-groove, opening 0.1 rad, infinite faces",
        ),
    ]
}
