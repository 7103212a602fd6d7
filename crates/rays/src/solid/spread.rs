//! Points that are spread over triangles, by their weights of the corners.

/// About so many points of a surface are asked.
const ASKED: usize = 256;
/// Into so many parts an edge is cut at most.
const PARTS: usize = 8;
/// How far from a triangle's border they lie at least, as a share of the way to its middle: two surfaces may end
/// together.
const INSET: f64 = 1.0 / 64.0;

/// The middle of a triangle.
pub(super) const MIDDLE: [f64; 3] = [1.0 / 3.0; 3];

/// Into how many parts the edges of each of so many triangles are cut, so that about [`ASKED`] points are asked.
pub(super) fn parts(triangles: usize) -> usize {
    (ASKED / triangles).isqrt().clamp(1, PARTS)
}

/// Weights of points all over a triangle whose edges are cut into so many parts.
pub(super) fn corners_too(parts: usize) -> impl Iterator<Item = [f64; 3]> {
    let rows = (0..=parts).flat_map(move |i| (0..=parts - i).map(move |j| [i, j, parts - i - j]));
    rows.map(move |steps| {
        steps.map(|step| INSET / 3.0 + (1.0 - INSET) * step as f64 / parts as f64)
    })
}

/// Weights of points spread over a triangle: the middles of some of the parts into which its edges are cut.
pub(super) fn middles(parts: usize) -> impl Iterator<Item = [f64; 3]> {
    let rows = (0..parts).flat_map(move |i| (0..parts - i).map(move |j| [i, j]));
    rows.map(move |steps| {
        let [u, v] = steps.map(|step| (step as f64 + 1.0 / 3.0) / parts as f64);
        [u, v, 1.0 - u - v]
    })
}
