//! The ten scenes at few rays: what holds whatever else is done to a page.

use super::bake::Lab;
use super::cases;
use super::row::{Row, markdown};
use rays::{BackendKind, TreeKind};

fn rows(test: &str, rays: u32) -> Vec<Row> {
    let lab = Lab {
        kind: BackendKind::Obvhs(TreeKind::default()),
        backend: "obvhs",
        rays,
    };
    let number: usize = test[1..].parse().expect("T and a number");
    let rows = cases::ALL[number - 1](&lab).expect("every scene is baked");
    assert!(
        rows.iter()
            .all(|row| row.test == test && row.score.points > 0)
    );
    rows
}

/// Asserts that the rows of a scene hold that `pick` takes by their variant, and that there are some.
fn holds(test: &str, rays: u32, pick: impl Fn(&str) -> bool) {
    let mut rows = rows(test, rays);
    rows.retain(|row| pick(&row.variant));
    assert!(!rows.is_empty(), "{test}: no such variant");
    let text = markdown(&rows);
    assert!(rows.iter().all(Row::holds), "\n{text}");
}

#[test]
fn first_texels_before_a_wall_hold_the_average_of_what_is_left_of_them() {
    holds("T1", 64, |_| true);
}

#[test]
fn a_sphere_that_touches_the_floor_leaves_no_light_at_the_contact() {
    holds("T2", 16, |_| true);
}

#[test]
fn look_ups_beside_a_sunk_box_find_the_light_that_is_there() {
    holds("T3", 4096, |_| true);
}

#[test]
fn a_closed_room_of_panels_is_dark_to_the_last_bit() {
    holds("T4", 16, |_| true);
}

#[test]
fn smooth_bodies_of_few_faces_throw_no_shade_on_themselves() {
    holds("T5", 16, |variant| !variant.starts_with("inside"));
}

#[test]
fn a_seam_of_six_charts_is_found_and_solved_at_no_cost() {
    // Of plain texels: what texels may move by must not hold back what only mends their noise. With 16 rays single
    // steps of two 255ths are left.
    holds("T6", 64, |_| true);
}

#[test]
fn triangles_smaller_than_a_texel_have_their_own_value() {
    holds("T7", 16, |_| true);
}

#[test]
fn scale_and_distance_change_nothing() {
    holds("T8", 64, |_| true);
}

#[test]
fn a_thousand_placements_hold_what_a_dozen_does() {
    holds("T10", 16, |_| true);
}

#[test]
fn cards_plates_and_coincident_quads_read_as_they_should() {
    holds("T9", 64, |_| true);
}
