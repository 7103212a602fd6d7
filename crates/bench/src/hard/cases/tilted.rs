//! Shading normals that lean away from the face.

use crate::exact::{Open, tilted_phong};
use crate::hard::case::{Bound, Case, SAMPLING, TableEntry, both, leaning, lobe};
use crate::hard::setup::Setup;
use ambient::closed_form::{tilted_diffuse, tilted_visibility};
use glam::DVec3;

pub(super) fn cases() -> Vec<Case> {
    let mut all = Vec::new();
    let plain = [
        (
            "shading normal tilted 10 deg",
            "plane, shading normal tilted 10 deg",
            10.0f64,
        ),
        (
            "shading normal tilted 30 deg",
            "plane, shading normal tilted 30 deg",
            30.0,
        ),
        (
            "shading normal tilted 60 deg",
            "plane, shading normal tilted 60 deg",
            60.0,
        ),
    ];
    for (name, line, degrees) in plain {
        let delta = degrees.to_radians();
        let mut setup = Setup::at(0.0, 0.5);
        setup.normal = Some(leaning(delta));
        let open = Open {
            visibility: tilted_visibility(delta),
            diffuse: tilted_diffuse(delta),
        };
        // The normal itself rounds to f32.
        let bounds = [Bound::Sampling { shape: 1e-7 }; 2];
        all.push(both(
            name,
            setup,
            open,
            bounds,
            SAMPLING,
            Some((line, false)),
        ));
    }
    let seen = [
        (
            "tilted 10 deg, seen at 80 deg from behind",
            "  view 80 deg az 180, Ns tilt 10",
            10.0f64,
            -80.0f64,
        ),
        (
            "tilted 30 deg, seen at 60 deg from behind",
            "  view 60 deg az 180, Ns tilt 30",
            30.0,
            -60.0,
        ),
        (
            "tilted 60 deg, seen at 60 deg",
            "  view 60 deg az 0, Ns tilt 60",
            60.0,
            60.0,
        ),
    ];
    for (name, case, tilt, view) in seen {
        let (normal, view) = (leaning(tilt.to_radians()), leaning(view.to_radians()));
        let mut setup = Setup::at(0.0, 1e-4);
        (setup.normal, setup.view, setup.exponent) = (Some(normal), Some(view), Some(20.0));
        let mirror = 2.0 * normal.dot(view) * normal - view;
        let value = tilted_phong(normal, DVec3::Z, mirror, 20.0);
        let table = TableEntry {
            case,
            quantity: "norm. Phong",
            complement: false,
        };
        all.push(lobe(name, setup, value, Some(table)));
    }
    all
}
