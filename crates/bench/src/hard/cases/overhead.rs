//! Plates, strips and a triangle over the receiver, down to a distance that f32 cannot hold.

use crate::exact::{Open, shapes};
use crate::hard::case::{Bound, Case, both, shaped};
use crate::hard::setup::Setup;
use glam::DVec3;

pub(super) fn cases() -> Vec<Case> {
    let square = [-1.0, 1.0];
    let plate = |z: f64| Setup::at(0.0, 1e-4 * z.max(1e-4)).plate(square, square, z);
    let above = |z| shapes::rectangle_above(square, square, z);
    let strip = |name, width: f64, table| {
        let setup = Setup::at(0.0, 1e-4).plate([-1000.0, 1000.0], [1.0, 1.0 + width], 1.0);
        let open = shapes::rectangle_above([-1000.0, 1000.0], [1.0, 1.0 + width], 1.0);
        shaped(name, setup, open, false, table)
    };
    let huge = [
        [-1000.0, -1000.0, 1.0],
        [2500.0, -1000.0, 1.0],
        [-1000.0, 1000.0, 1.0],
    ]
    .map(DVec3::from);
    let tiny = 2f64.powi(-13);
    let tiny = [
        [1.0, 1.0, 0.5],
        [1.0 + tiny, 1.0, 0.5],
        [1.0, 1.0 + tiny, 0.5],
    ]
    .map(DVec3::from);
    let with = |triangles: &[[DVec3; 3]]| {
        let mut setup = Setup::at(0.0, 1e-4);
        setup.blockers = triangles.to_vec();
        setup
    };
    let under_huge = with(&[huge]).on_triangles(false);
    let aligned = with(&[huge, tiny]);
    let flat = both(
        "coplanar plate",
        Setup::at(0.0, 0.5).plate(square, square, 0.0),
        Open::FULL,
        [Bound::EveryTexel; 2],
        "exact: a plane hides nothing of itself",
        None,
    );
    let turned = both(
        "turned plate 1e-6 above",
        Setup::at(0.0, 0.5).plate(square, square, 1e-6).turned(),
        above(1e-6),
        [Bound::Single { limit: 1.0 }; 2],
        "1e-6 is below the rounding of a turned unit plane (1.4e-6): reads as open",
        None,
    );
    vec![
        shaped(
            "plate 1e-2 above",
            plate(1e-2),
            above(1e-2),
            false,
            Some(("plate [-1,1]^2 at height 1e-2 over the point", false)),
        ),
        shaped(
            "plate 1e-6 above",
            plate(1e-6),
            above(1e-6),
            false,
            Some(("plate [-1,1]^2 at height 1e-6 over the point", false)),
        ),
        turned,
        flat,
        strip(
            "strip 2000 x 1e-3",
            1e-3,
            Some(("strip 2000 x 1e-3 at (y=1,z=1)", true)),
        ),
        strip(
            "strip 2000 x 1e-6",
            1e-6,
            Some(("strip 2000 x 1e-6 at (y=1,z=1)", true)),
        ),
        shaped(
            "huge triangle, tiny one below it",
            aligned,
            under_huge,
            false,
            None,
        ),
    ]
}
