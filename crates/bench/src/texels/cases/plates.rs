//! T9: a card of holes, plates a millimetre apart, and quads that coincide.

use super::scene;
use crate::exact::shapes;
use crate::texels::Error;
use crate::texels::bake::{Baked, Lab, PER_EDGE, STEP, Texels, largest, score};
use crate::texels::build::{level, material, sheet};
use crate::texels::row::Row;
use glam::{DVec3, Vec2};
use scene::authored::{AlphaMode, Mesh, Texture};
use scene::{Alpha, Scene};

const SIZE: u32 = 64;
const FLOOR: [f64; 4] = [4.0, 4.0, 28.0, 28.0];
const OTHER: [f64; 4] = [34.0, 4.0, 58.0, 28.0];

pub(super) fn rows(lab: &Lab) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for (variant, double_sided) in [
        ("double-sided card", true),
        ("single-sided card from below", false),
    ] {
        rows.push(card(lab, variant, double_sided)?);
    }
    rows.push(gap(lab)?);
    rows.extend(coincident(lab)?);
    Ok(rows)
}

/// A card of 200 x 200 at height 1 over a floor of 4 x 4, a checker of 32 cells a unit. Kept cells have an alpha of
/// exactly the cutoff: glTF keeps alpha >= cutoff. Half of the card is left, in cells far smaller than their distance.
fn card(lab: &Lab, variant: &str, double_sided: bool) -> Result<Row, Error> {
    const HALF: f64 = 100.0;
    let floor = sheet("floor", SIZE, level([-2.0, 2.0], [-2.0, 2.0], 0.0), FLOOR);
    let mut card = sheet(
        "card",
        SIZE,
        level([-HALF, HALF], [-HALF, HALF], 1.0),
        OTHER,
    );
    card.material = 1;
    let mut leaf = material(double_sided);
    let (kept, hole) = ([255; 4], [255, 255, 255, 0]);
    leaf.albedo_texture = Some(Texture::new(2, 2, vec![kept, hole, hole, kept]));
    (leaf.alpha, leaf.alpha_mode) = (0.5, AlphaMode::Mask { cutoff: 0.5 });
    let mut made = scene("T9", vec![floor, card], vec![material(true), leaf])?;
    tile(&mut made, 16.0 * 2.0 * HALF as f32);
    let baked = lab.bake("T9", made, Texels::Authored(SIZE))?;
    let judged = baked.judge(PER_EDGE, |point| {
        let [x, y, _] = point.position.to_array();
        let open = || shapes::rectangle_above([-HALF - x, HALF - x], [-HALF - y, HALF - y], 1.0);
        (point.instance == 0).then(|| 1.0 - 0.5 * (1.0 - open().diffuse))
    });
    // Cells are smaller than the spacing of rays: each ray is kept or not as a coin falls.
    let (score, texels) = (
        score(&judged),
        judged.len() as f64 / f64::from(PER_EDGE * PER_EDGE),
    );
    let criterion = (
        "mean of the floor to one half: 4 standard errors",
        score.bias.abs(),
        Some(4.0 * 0.5 / (texels * f64::from(lab.rays)).sqrt()),
    );
    Ok(lab.row("T9", variant, score, criterion))
}

/// Gives the card texture coordinates that repeat its picture `times` over, read without a filter, beside its lightmap
/// coordinates.
fn tile(scene: &mut Scene, times: f32) {
    for mesh in &mut scene.meshes {
        let own = mesh
            .positions
            .iter()
            .map(|p| (p.truncate() / 200.0 + 0.5) * times);
        let own: Vec<Vec2> = own.collect();
        mesh.uv_sets.insert(0, own);
    }
    for material in &mut scene.materials {
        if let Alpha::Mask { map: Some(map), .. } = &mut material.alpha {
            map.linear = false;
        }
    }
}

/// Two plates of 4 x 4, 0.001 apart, in texels of 0.1: dark but for their rims.
fn gap(lab: &Lab) -> Result<Row, Error> {
    const GAP: f64 = 1e-3;
    const TEXEL: f64 = 0.1;
    let span = [-2.0, 2.0];
    let low = sheet("low", 128, level(span, span, 0.0), [4.0, 4.0, 44.0, 44.0]);
    let mut corners = level(span, span, GAP);
    corners.reverse();
    let high = sheet("high", 128, corners, [60.0, 4.0, 100.0, 44.0]);
    let baked = lab.bake(
        "T9",
        scene("T9", vec![low, high], vec![])?,
        Texels::Authored(128),
    )?;
    let judged = baked.judge(PER_EDGE, |point| {
        let [x, y, _] = point.position.to_array();
        // Seen from the upper plate the scene is the same.
        Some(shapes::rectangle_above([-2.0 - x, 2.0 - x], [-2.0 - y, 2.0 - y], GAP).diffuse)
    });
    // The last texels hold the mean of the light that comes in under the rim. A look-up that blends them cannot be
    // dark: exact ones leave 0.0037 a texel inside a corner.
    let inner = |p: DVec3| p.abs().truncate().max_element() < 2.0 - 1.5 * TEXEL;
    let criterion = (
        "error where no last texel is blended in: 1/255 at 4,096 rays",
        largest(&judged, |j| inner(j.point.position)),
        Some(lab.noise(STEP)),
    );
    Ok(lab.row("T9", "plates 0.001 apart", score(&judged), criterion))
}

/// A floor before a wall, alone and with a second one in its place that looks up, or down.
fn coincident(lab: &Lab) -> Result<Vec<Row>, Error> {
    let (x, y) = ([0.0, 3.0], [-1.5, 1.5]);
    let wall = || {
        let corners = [
            [0.0, -9.0, 0.0],
            [0.0, 9.0, 0.0],
            [0.0, 9.0, 1.0],
            [0.0, -9.0, 1.0],
        ];
        sheet(
            "wall",
            SIZE,
            corners.map(DVec3::from),
            [4.0, 36.0, 60.0, 42.0],
        )
    };
    let floor = || sheet("floor", SIZE, level(x, y, 0.0), FLOOR);
    let mut under = level(x, y, 0.0);
    under.reverse();
    let bake = |meshes: Vec<Mesh>| -> Result<Baked, Error> {
        lab.bake("T9", scene("T9", meshes, vec![])?, Texels::Authored(SIZE))
    };
    let truth = |instance: u32, position: DVec3| {
        let open = || shapes::finite_wall(position.x, [-9.0 - position.y, 9.0 - position.y], 1.0);
        (instance == 0 && position.x > 0.0).then(|| open().diffuse)
    };
    let judge = |baked: &Baked| baked.judge(PER_EDGE, |p| truth(p.instance, p.position));
    let single = judge(&bake(vec![floor(), wall()])?);
    let mut rows = Vec::new();
    for (variant, corners) in [
        ("coincident quads, same facing", level(x, y, 0.0)),
        ("coincident quads, opposite facing", under),
    ] {
        let second = sheet("second", SIZE, corners, OTHER);
        let judged = judge(&bake(vec![floor(), second, wall()])?);
        let change = judged
            .iter()
            .zip(&single)
            .map(|(a, b)| (a.value - b.value).abs());
        let criterion = (
            "change against one quad: 0.003 at 4,096 rays",
            change.fold(f64::NAN, f64::max),
            Some(lab.noise(0.003)),
        );
        rows.push(lab.row("T9", variant, score(&judged), criterion));
    }
    Ok(rows)
}
