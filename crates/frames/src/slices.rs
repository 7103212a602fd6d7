//! A quad as a few rectangles of the pre-integrated table: section 8.3 of the 1984 text without losing small lights.
//!
//! One rectangle of the quad's place and size is what the text has. Where the quad is turned against rows and columns,
//! rectangles of neighbouring pixels overlap in places and leave others out: a sun of one texel is seen twice by some
//! views and not at all by others. So the quad is cut across its longer side, and each slice is the rectangle between
//! its two edges. No rectangle is narrower than a texel, which interpolates where texels are large; a slice that is
//! narrower has two, side by side.

use crate::summed::Summed;

/// Slices of a quad, at most.
const MOST: f32 = 64.0;

/// Slices of a texel of its longer side: more than one, so that no row of texels falls between the rectangles of two
/// pixels.
const FINE: f32 = 2.0;

/// The least chord, in texels: it keeps the mean of a quad without an area.
const LEAST: f32 = 1e-3;

/// The mean radiance over the quad of these places in texels, whose columns may lie beyond the seam.
pub(super) fn mean(table: &Summed, places: [[f32; 2]; 4]) -> [f32; 3] {
    let range = |axis: usize| {
        let values = places.map(|p| p[axis]);
        let least = values.into_iter().fold(f32::INFINITY, f32::min);
        let most = values.into_iter().fold(f32::NEG_INFINITY, f32::max);
        [least, most]
    };
    let ranges = [range(0), range(1)];
    let [wide, high] = ranges.map(|[least, most]| most - least);
    let along = usize::from(high > wide);
    let [start, end] = ranges[along];
    let count = (FINE * (end - start)).ceil().clamp(2.0, MOST);
    let thick = (end - start) / count;
    let mut sum = [0.0; 4];
    for slice in 0..count as usize {
        let middle = start + (slice as f32 + 0.5) * thick;
        let [near, far] = chord(&places, along, middle);
        let width = far - near;
        // Two beside each other where one would be wider than its slice.
        let parts: &[f32] = if width < 1.0 { &[0.25, 0.75] } else { &[0.5] };
        for part in parts {
            let mut sides = [at_least_one(middle, thick); 2];
            sides[1 - along] = at_least_one(near + part * width, width / parts.len() as f32);
            let [across, down] = sides;
            let area = (across[1] - across[0]) * (down[1] - down[0]) * parts.len() as f32;
            let found = table.sum(across, down);
            let share = f64::from(width.max(LEAST) / area);
            (0..4).for_each(|c| sum[c] += share * found[c]);
        }
    }
    [0, 1, 2].map(|c: usize| (sum[c] / sum[3]) as f32)
}

/// A range of this middle, at least one texel long.
fn at_least_one(middle: f32, length: f32) -> [f32; 2] {
    let half = 0.5 * length.max(1.0);
    [middle - half, middle + half]
}

/// Where the line `axis` = `at` enters and leaves the quad, on the other axis.
fn chord(places: &[[f32; 2]; 4], axis: usize, at: f32) -> [f32; 2] {
    let mut ends = [f32::INFINITY, f32::NEG_INFINITY];
    for k in 0..4 {
        let (p, q) = (places[k], places[(k + 1) % 4]);
        let (a, b) = (p[axis] - at, q[axis] - at);
        if a * b <= 0.0 {
            let t = if a == b { 0.5 } else { a / (a - b) };
            let met = p[1 - axis] + t * (q[1 - axis] - p[1 - axis]);
            ends = [ends[0].min(met), ends[1].max(met)];
        }
    }
    ends
}
