//! One wall, scaled and moved far away: how rounding of coordinates grows.

use crate::exact::{Open, shapes};
use crate::hard::case::{Bound, Case, TRIANGLES, both};
use crate::hard::setup::{SIZE, Setup};
use glam::DVec3;

pub(super) fn cases() -> Vec<Case> {
    let wall = || Setup::over([0.9375, 1.0625], 0.0625).wall(1.0, 1e3);
    let open = shapes::wall_average(0.9375, 1.0625, 1.0);
    let scaled = |name, factor: f64| {
        // The wall ends at 1e3; its corners round to 6e-8 of themselves.
        let bounds = [Bound::Sampling { shape: 1e-6 }; 2];
        both(
            name,
            wall().map(|p| p * factor),
            open,
            bounds,
            TRIANGLES,
            None,
        )
    };
    vec![
        scaled("scaled by 1e-4", 1e-4),
        scaled("scaled by 1e5", 1e5),
        both(
            "moved by 1e6",
            wall().map(|p| p + DVec3::splat(1e6)),
            open,
            [
                Bound::Columns {
                    exact: |u| moved(u).visibility,
                    limit: 0.004_896_7,
                },
                Bound::Columns {
                    exact: |u| moved(u).diffuse,
                    limit: 0.005_396_9,
                },
            ],
            "worst column of texels; ray origins round to 1/16: half of that in d, + 4 stated standard errors + 6/N",
            None,
        ),
    ]
}

/// The moved wall at a column of texels that begins at the share `u` of the chart.
fn moved(u: f64) -> Open {
    let near = 0.9375 + 0.125 * u;
    shapes::wall_average(near, near + 0.125 / f64::from(SIZE), 1.0)
}
