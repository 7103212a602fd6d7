//! Where things end: shadow rays at their light, paths at their facet, air at a body, and the way that a probe may be
//! moved.

use super::{ROOT, UNIFORM, gathering, sheets};
use crate::fixture::{block, placed};
use crate::{Gather, Sky, State};
use glam::DVec3;
use rays::Light;

#[test]
fn what_stands_behind_a_light_hides_none_of_it() {
    let wall = [
        DVec3::new(-9.0, -9.0, 3.0),
        DVec3::Y * 18.0,
        DVec3::X * 18.0,
    ];
    let black = Sky(&environment::Sky::BLACK);
    gathering(&[sheets(vec![wall], 0.0, 0.0)], black, |gather| {
        let lights = [Light::point([0.0, 0.0, 2.0], [4.0; 3])];
        let gather = Gather {
            lights: &lights,
            ..gather
        };
        // 4 W/sr at a distance of 2.
        let found = gather.probe(0, DVec3::ZERO).parts[1][0].x * ROOT;
        assert!((found - 1.0).abs() < 1e-6, "{found}");
        let behind = gather.probe(0, DVec3::Z * 4.0).parts[1][0];
        assert_eq!(behind, DVec3::ZERO);
    });
}

#[test]
fn a_probe_is_moved_as_far_as_it_may_be_and_no_farther() {
    let solid = sheets(block(DVec3::splat(-0.5), DVec3::splat(0.5)), 0.8, 0.0);
    gathering(&[solid], UNIFORM, |gatherer| {
        // The air is 0.2 away, and a tenth of the way that it may take beyond the face.
        let inside = DVec3::new(0.3, 0.1, 0.0);
        for (most, state) in [(0.2, State::Invalid), (0.25, State::Moved)] {
            let found = placed(&gatherer, &[inside], 0, most);
            assert_eq!(found[0].state, state, "{most}");
            let away = found[0].probe.place.distance(inside);
            assert!(away <= most, "{away} of {most}");
        }
    });
}

#[test]
fn a_closed_body_is_no_place_whichever_sides_of_it_are_drawn() {
    for double_sided in [false, true] {
        let mut solid = sheets(block(DVec3::splat(-0.5), DVec3::splat(0.5)), 0.8, 1.0);
        solid.double_sided = double_sided;
        gathering(&[solid], UNIFORM, |gatherer| {
            // It shines inwards too where both sides are drawn, so that no darkness tells.
            let inside = gatherer.probe(0, DVec3::new(0.3, 0.1, 0.0));
            let is_lit = inside.light[0] != DVec3::ZERO;
            assert_eq!((inside.validity, is_lit), (0.0, double_sided));
            let outside = gatherer.probe(0, DVec3::new(0.8, 0.1, 0.0));
            assert_eq!(outside.validity, 1.0, "{double_sided}");
        });
    }
}

#[test]
fn paths_that_a_bent_normal_sends_below_its_facet_end_there() {
    let mut floor = sheets(
        vec![[DVec3::new(-1e5, -1.0, -1e5), DVec3::Z * 2e5, DVec3::X * 2e5]],
        0.8,
        0.0,
    );
    let bent = 60_f64.to_radians();
    floor.normal = Some(DVec3::new(bent.sin(), bent.cos(), 0.0));
    gathering(&[floor], UNIFORM, |mut gatherer| {
        gatherer.rays = 16_384;
        let probe = gatherer.probe(0, DVec3::ZERO);
        // Of the cosine lobe about a normal at 60 degrees (1 + cos 60°) / 2 lies above the facet, under an open sky.
        let exact = 0.8 * 0.75 * 0.5 * ROOT;
        let found = probe.parts[2][0].x;
        assert!((found - exact).abs() < 0.01 * exact, "{found}, not {exact}");
    });
}
