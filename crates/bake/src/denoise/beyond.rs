//! What lies beyond the borders of a chart, where its surface goes on in other charts.
//!
//! A fit at the border of a chart has texels on one side only, and two charts that abut show how each of them went on.
//! So a chart is fitted together with texels beyond its borders. These are texels of other charts, put where the
//! surface would go on: from each point of a seam one walks outward on the chart's own side and inward on the other,
//! and each step there is the same way in space as here.

use super::charts::{Chart, Charts, NONE};
use super::field::Field;
use crate::seams::SeamPoint;
use glam::Vec2;

/// Texels that a chart is carried on, at most: what windows of the widest stride see of a border.
const FARTHEST: usize = 32;

/// A chart is carried on by so large a share of its width, lest small charts be made of others.
const SHARE: f32 = 0.25;

/// Cosine of the angle by which a surface may turn on the way, 0.8 degrees: it is flat. A map goes on straight only
/// there; carried round bends of some degrees, charts of real models got more error than they had without.
const ALIKE: f32 = 0.9999;

/// Texels of one step.
const STEP: f32 = 0.5;

/// Steps after which a way must have come to a texel with data: those that a border cuts may be buried, or belong to
/// nobody.
const BLIND: usize = 3;

/// A texel of another chart, and the column and row where this chart would have it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Beyond {
    pub place: [i32; 2],
    pub texel: u32,
}

/// The sides of the seams of a page, sorted by charts.
#[derive(Debug)]
pub(super) struct Borders<'a> {
    points: &'a [SeamPoint],
    /// Chart, point, side, and how many steps it goes on.
    sides: Vec<[u32; 4]>,
    page: usize,
}

impl<'a> Borders<'a> {
    /// Of a page of this many texels to the edge.
    pub fn new(points: &'a [SeamPoint], charts: &Charts, field: &Field<'_>) -> Self {
        let mut sides = Vec::new();
        for (number, point) in points.iter().enumerate() {
            for side in 0..2 {
                let found = side_of(point, side, charts, field);
                sides.extend(found.map(|(own, steps)| [own, number as u32, side as u32, steps]));
            }
        }
        sides.sort_unstable();
        Self {
            points,
            sides,
            page: field.size,
        }
    }

    /// What lies beyond the borders of a chart, row by row; of other objects too if `crosses`. `number`: the chart of
    /// each texel.
    pub fn beyond(&self, own: u32, chart: &Chart, number: &[u32], crosses: bool) -> Vec<Beyond> {
        let first = self.sides.partition_point(|side| side[0] < own);
        let sides = self.sides[first..].iter().take_while(|side| side[0] == own);
        let width = (chart.texels as f32).sqrt();
        let far = ((SHARE * width).ceil() / STEP) as u32;
        // The place, how far it is from the border, the texel.
        let mut found: Vec<([i32; 2], u32, u32)> = Vec::new();
        for &[_, point, side, steps] in sides {
            let point = &self.points[point as usize];
            if !crosses && point.charts[0][0] != point.charts[1][0] {
                continue;
            }
            let [here, there] = [side as usize, 1 - side as usize];
            let Some(ways) = ways(point, here) else {
                continue;
            };
            for step in 1..=far.min(steps) {
                let way = step as f32 * STEP;
                let place = point.sides[here].as_vec2() + ways.out * way;
                let at = point.sides[there].as_vec2() + ways.into * way;
                let is_own = chart_at(number, place, self.page).is_some_and(|(of, _)| of == own);
                if let (Some((_, texel)), false) = (chart_at(number, at, self.page), is_own) {
                    let place = place.floor();
                    found.push(([place.x as i32, place.y as i32], step, texel));
                }
            }
        }
        found.sort_unstable_by_key(|&([x, y], step, texel)| (y, x, step, texel));
        found.dedup_by_key(|(place, ..)| *place);
        let beyond = found.into_iter();
        beyond
            .map(|(place, _, texel)| Beyond { place, texel })
            .collect()
    }
}

/// The chart on one side of a seam, and so many steps as there is one chart beyond in the same plane.
fn side_of(
    point: &SeamPoint,
    side: usize,
    charts: &Charts,
    field: &Field<'_>,
) -> Option<(u32, u32)> {
    let ways = ways(point, side)?;
    let at = |way: Vec2, from: usize, step: usize| {
        let place = point.sides[from].as_vec2() + way * (step as f32 * STEP);
        chart_at(&charts.number, place, field.size)
    };
    let (own, texel) = (1..=BLIND).find_map(|step| at(-ways.out, side, step))?;
    let normal = field.normal(texel as usize);
    let mut other = None;
    let goes_on = |&step: &usize| match at(ways.into, 1 - side, step) {
        None => other.is_none() && step < BLIND,
        Some((chart, texel)) => {
            let is_alike = field.normal(texel as usize).dot(normal) >= ALIKE;
            *other.get_or_insert(chart) == chart && is_alike
        }
    };
    let steps = (1..=(FARTHEST as f32 / STEP) as usize).take_while(goes_on);
    Some((own, steps.count() as u32))
}

/// The ways from a point of a seam out of a chart and into the other, for one texel of this chart.
struct Ways {
    out: Vec2,
    into: Vec2,
}

/// Those of the chart on this side; `None` where it has no extent.
fn ways(point: &SeamPoint, side: usize) -> Option<Ways> {
    let unit = point.inward[side].length();
    (unit > 0.0).then(|| Ways {
        out: -point.inward[side] / unit,
        into: point.inward[1 - side] / unit,
    })
}

/// The chart and the texel at a place of the page.
fn chart_at(number: &[u32], at: Vec2, page: usize) -> Option<(u32, u32)> {
    let inside = |v: f32| (0.0..page as f32).contains(&v);
    if !(inside(at.x) && inside(at.y)) {
        return None;
    }
    let texel = at.y as usize * page + at.x as usize;
    let chart = number[texel];
    (chart != NONE).then_some((chart, texel as u32))
}
