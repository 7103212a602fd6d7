//! Sharp lobes: seen at the horizon, from below it, and with the axis on a silhouette.

use crate::hard::case::{Case, TableEntry, leaning, lobe};
use crate::hard::setup::Setup;
use ambient::closed_form::phong_open_angle;
use std::f64::consts::FRAC_PI_4;

pub(super) fn cases() -> Vec<Case> {
    let open = |name, exponent: f64, degrees: f64, case| {
        let mut setup = Setup::at(0.0, 1e-4);
        setup.view = Some(leaning(degrees.to_radians()));
        setup.exponent = Some(exponent);
        let value = phong_open_angle(exponent, degrees.to_radians());
        let table = TableEntry {
            case,
            quantity: "G=",
            complement: false,
        };
        lobe(name, setup, value, Some(table))
    };
    let silhouette = |name, exponent: f64| {
        let mut setup = Setup::at(1.0, 1e-4).wall(1.0, 1e4);
        setup.view = Some(leaning(FRAC_PI_4));
        setup.exponent = Some(exponent);
        let hidden = 0.5 - phong_open_angle(exponent, 3.0 * FRAC_PI_4);
        lobe(
            name,
            setup,
            phong_open_angle(exponent, FRAC_PI_4) - hidden,
            None,
        )
    };
    vec![
        open(
            "n = 100 seen at 89 deg",
            100.0,
            89.0,
            "open plane Phong n=100 theta=89",
        ),
        open(
            "n = 1e4 seen at 89.99 deg",
            1e4,
            89.99,
            "open plane Phong n=1e4 theta=89.99",
        ),
        open(
            "n = 1e6 seen at 0 deg",
            1e6,
            0.0,
            "open plane Phong n=1e6 theta=0",
        ),
        open(
            "n = 1e6 seen at 89.9 deg",
            1e6,
            89.9,
            "open plane Phong n=1e6 theta=89.9",
        ),
        open(
            "n = 1e6 seen at 90 deg",
            1e6,
            90.0,
            "open plane Phong n=1e6 theta=90",
        ),
        open(
            "n = 1e6 from below, 90.01 deg",
            1e6,
            90.01,
            "open plane Phong n=1e6 theta=90.01",
        ),
        open(
            "n = 1e6 from below, 90.1 deg",
            1e6,
            90.1,
            "open plane Phong n=1e6 theta=90.1",
        ),
        open(
            "n = 1e6 from below, 91 deg",
            1e6,
            91.0,
            "open plane Phong n=1e6 theta=91",
        ),
        open(
            "n = 1 from below, 91 deg",
            1.0,
            91.0,
            "open plane Phong n=1 theta=91",
        ),
        silhouette("n = 10, axis on a silhouette", 10.0),
        silhouette("n = 1000, axis on a silhouette", 1000.0),
        silhouette("n = 1e5, axis on a silhouette", 1e5),
    ]
}
