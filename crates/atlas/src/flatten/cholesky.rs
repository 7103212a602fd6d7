//! Sparse symmetric systems, solved directly: Cholesky's method, with the unknowns in an order that keeps the factor
//! sparse.
//!
//! The matrices of this crate couple the corners of a flat mesh. Such a mesh is cut in halves again and again, and the
//! corners on a cut come after both halves (nested dissection: George 1973), so n unknowns fill about n log n numbers.
//! The factor is found row by row (Davis 2006, *Direct methods for sparse linear systems*, chapter 4). No vectors of
//! one processor are used: the same numbers everywhere.

use glam::DVec2;

const NONE: u32 = u32::MAX;
/// Parts of so few unknowns are not cut again.
const LEAF: usize = 24;

/// A symmetric matrix by its rows: the diagonal, and what stands beside it on both sides.
pub(super) struct Symmetric {
    pub diagonal: Vec<f64>,
    /// Where the entries of each row begin, and one more.
    pub starts: Vec<u32>,
    pub columns: Vec<u32>,
    pub values: Vec<f64>,
}

impl Symmetric {
    /// The sum of all entries `(row, column, value)` beside the diagonal, each of which stands for both sides.
    pub fn new(diagonal: Vec<f64>, entries: &[(u32, u32, f64)]) -> Self {
        let n = diagonal.len();
        let both = || entries.iter().flat_map(|&(a, b, v)| [(a, b, v), (b, a, v)]);
        let mut starts = vec![0u32; n + 1];
        both().for_each(|(row, ..)| starts[row as usize + 1] += 1);
        for i in 0..n {
            starts[i + 1] += starts[i];
        }
        let mut rows = vec![(0, 0.0); 2 * entries.len()];
        let mut next = starts.clone();
        for (row, column, value) in both() {
            rows[next[row as usize] as usize] = (column, value);
            next[row as usize] += 1;
        }
        let (mut columns, mut values) = (Vec::new(), Vec::new());
        let mut begin = 0;
        for i in 0..n {
            let row = &mut rows[begin..starts[i + 1] as usize];
            begin = starts[i + 1] as usize;
            starts[i] = columns.len() as u32;
            row.sort_by_key(|&(column, _)| column);
            for &(column, value) in row.iter() {
                match columns.last() {
                    Some(&last) if last == column && columns.len() > starts[i] as usize => {
                        *values.last_mut().expect("a value a column") += value;
                    }
                    _ => {
                        columns.push(column);
                        values.push(value);
                    }
                }
            }
        }
        starts[n] = columns.len() as u32;
        Self {
            diagonal,
            starts,
            columns,
            values,
        }
    }

    fn row(&self, i: u32) -> impl Iterator<Item = (u32, f64)> + '_ {
        let range = self.starts[i as usize] as usize..self.starts[i as usize + 1] as usize;
        self.columns[range.clone()]
            .iter()
            .copied()
            .zip(self.values[range].iter().copied())
    }
}

/// The lower triangle L of L Lᵀ, by columns; the diagonal comes first in each.
pub(super) struct Factor {
    /// The unknown that stands at each place.
    order: Vec<u32>,
    starts: Vec<usize>,
    rows: Vec<u32>,
    values: Vec<f64>,
}

impl Factor {
    /// Factors a positive definite matrix, whose unknowns lie at `places` of a plane. `None` where it is not definite.
    pub fn new(matrix: &Symmetric, places: &[DVec2]) -> Option<Self> {
        let n = places.len();
        let order = order(matrix, places);
        let upper = Upper::new(matrix, &order);
        let mut tree = Tree::new(&upper);
        let mut starts = vec![0; n + 1];
        for k in 0..n {
            let path = tree.path(&upper, k as u32);
            path.iter().for_each(|&i| starts[i as usize + 1] += 1);
            starts[k + 1] += 1;
        }
        for k in 0..n {
            starts[k + 1] += starts[k];
        }
        let mut next = starts.clone();
        let (mut rows, mut values) = (vec![0u32; starts[n]], vec![0.0; starts[n]]);
        let mut x = vec![0.0; n];
        tree.seen.fill(NONE);
        for k in 0..n {
            let mut pivot = matrix.diagonal[order[k] as usize];
            for (i, value) in upper.column(k as u32) {
                x[i as usize] = value;
            }
            for &i in tree.path(&upper, k as u32) {
                let i = i as usize;
                let entry = x[i] / values[starts[i]];
                x[i] = 0.0;
                for p in starts[i] + 1..next[i] {
                    x[rows[p] as usize] -= values[p] * entry;
                }
                pivot -= entry * entry;
                (rows[next[i]], values[next[i]]) = (k as u32, entry);
                next[i] += 1;
            }
            if !(pivot > 0.0 && pivot.is_finite()) {
                return None;
            }
            (rows[next[k]], values[next[k]]) = (k as u32, pivot.sqrt());
            next[k] += 1;
        }
        Some(Self {
            order,
            starts,
            rows,
            values,
        })
    }

    /// Solves for two right-hand sides at once, in place.
    pub fn solve(&self, right: &mut [DVec2]) {
        let mut x: Vec<DVec2> = self.order.iter().map(|&i| right[i as usize]).collect();
        let column = |k: usize| {
            let range = self.starts[k]..self.starts[k + 1];
            (&self.rows[range.clone()], &self.values[range])
        };
        for k in 0..x.len() {
            let (rows, values) = column(k);
            x[k] /= values[0];
            let solved = x[k];
            for (&row, &value) in rows[1..].iter().zip(&values[1..]) {
                x[row as usize] -= value * solved;
            }
        }
        for k in (0..x.len()).rev() {
            let (rows, values) = column(k);
            let rest = rows[1..].iter().zip(&values[1..]);
            x[k] = rest.fold(x[k], |sum, (&row, &value)| sum - value * x[row as usize]) / values[0];
        }
        for (&i, x) in self.order.iter().zip(x) {
            right[i as usize] = x;
        }
    }
}

/// The part above the diagonal of a matrix whose unknowns were put in order, by columns.
struct Upper {
    starts: Vec<u32>,
    rows: Vec<u32>,
    values: Vec<f64>,
}

impl Upper {
    fn new(matrix: &Symmetric, order: &[u32]) -> Self {
        let mut places = vec![0u32; order.len()];
        for (place, &unknown) in order.iter().enumerate() {
            places[unknown as usize] = place as u32;
        }
        let mut upper = Self {
            starts: vec![0],
            rows: Vec::with_capacity(matrix.columns.len() / 2),
            values: Vec::with_capacity(matrix.columns.len() / 2),
        };
        for (k, &unknown) in order.iter().enumerate() {
            for (column, value) in matrix.row(unknown) {
                let row = places[column as usize];
                if (row as usize) < k {
                    upper.rows.push(row);
                    upper.values.push(value);
                }
            }
            upper.starts.push(upper.rows.len() as u32);
        }
        upper
    }

    fn column(&self, k: u32) -> impl Iterator<Item = (u32, f64)> + '_ {
        let range = self.starts[k as usize] as usize..self.starts[k as usize + 1] as usize;
        let rows = self.rows[range.clone()].iter().copied();
        rows.zip(self.values[range].iter().copied())
    }
}

/// The elimination tree (Liu 1990): the first row below the diagonal that each column of L holds.
struct Tree {
    parents: Vec<u32>,
    /// The last row in which each unknown was met.
    seen: Vec<u32>,
    path: Vec<u32>,
    branch: Vec<u32>,
}

impl Tree {
    fn new(upper: &Upper) -> Self {
        let n = upper.starts.len() - 1;
        let (mut parents, mut roots) = (vec![NONE; n], vec![NONE; n]);
        for k in 0..n as u32 {
            for (mut i, _) in upper.column(k) {
                while i != NONE && i < k {
                    let above = std::mem::replace(&mut roots[i as usize], k);
                    if above == NONE {
                        parents[i as usize] = k;
                    }
                    i = above;
                }
            }
        }
        Self {
            parents,
            seen: vec![NONE; n],
            path: Vec::new(),
            branch: Vec::new(),
        }
    }

    /// The columns that row `k` of L holds beside its diagonal, each after all that it depends on.
    fn path(&mut self, upper: &Upper, k: u32) -> &[u32] {
        self.path.clear();
        self.seen[k as usize] = k;
        for (mut i, _) in upper.column(k) {
            while self.seen[i as usize] != k {
                self.seen[i as usize] = k;
                self.branch.push(i);
                i = self.parents[i as usize];
            }
            // Turned about at the end: branches that were found later come first, and each from its leaf.
            self.path.extend(self.branch.drain(..).rev());
        }
        self.path.reverse();
        &self.path
    }
}

/// The order of nested dissection.
fn order(matrix: &Symmetric, places: &[DVec2]) -> Vec<u32> {
    let mut unknowns: Vec<u32> = (0..places.len() as u32).collect();
    // 1 for the unknowns of the half that is cut off.
    let mut far = vec![false; places.len()];
    let mut out = Vec::with_capacity(places.len());
    dissect(&mut unknowns, matrix, places, &mut far, &mut out);
    out
}

fn dissect(
    part: &mut [u32],
    matrix: &Symmetric,
    places: &[DVec2],
    far: &mut [bool],
    out: &mut Vec<u32>,
) {
    if part.len() <= LEAF {
        out.extend_from_slice(part);
        return;
    }
    let at = |i: &u32| places[*i as usize];
    let low = part.iter().map(at).fold(DVec2::INFINITY, DVec2::min);
    let size = part.iter().map(at).fold(DVec2::NEG_INFINITY, DVec2::max) - low;
    let axis = usize::from(size.y > size.x);
    let middle = part.len() / 2;
    part.select_nth_unstable_by(middle, |a, b| {
        at(a)[axis].total_cmp(&at(b)[axis]).then(a.cmp(b))
    });
    let (near, beyond) = part.split_at_mut(middle);
    beyond.iter().for_each(|&i| far[i as usize] = true);
    let cut = |i: &u32| matrix.row(*i).any(|(j, _)| far[j as usize]);
    let mut inner: Vec<u32> = near.iter().copied().filter(|i| !cut(i)).collect();
    let between: Vec<u32> = near.iter().copied().filter(cut).collect();
    beyond.iter().for_each(|&i| far[i as usize] = false);
    dissect(&mut inner, matrix, places, far, out);
    dissect(beyond, matrix, places, far, out);
    out.extend(between);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The five-point Laplacian of a square grid plus `shift`, with places in an order that is not the grid's.
    fn laplacian(n: u32, shift: f64) -> (Symmetric, Vec<DVec2>) {
        let number = |i: u32, j: u32| (i * n + j) * 7 % (n * n);
        let mut places = vec![DVec2::ZERO; (n * n) as usize];
        let mut entries = Vec::new();
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            places[number(i, j) as usize] = DVec2::new(i.into(), j.into());
            let beside = [
                (i + 1 < n).then_some((i + 1, j)),
                (j + 1 < n).then_some((i, j + 1)),
            ];
            for (k, l) in beside.into_iter().flatten() {
                // In two parts, which are to be added.
                entries.push((number(i, j), number(k, l), -0.25));
                entries.push((number(k, l), number(i, j), -0.75));
            }
        }
        (
            Symmetric::new(vec![4.0 + shift; places.len()], &entries),
            places,
        )
    }

    fn product(matrix: &Symmetric, x: &[DVec2]) -> Vec<DVec2> {
        let beside = |i: usize| matrix.row(i as u32).map(|(j, v)| v * x[j as usize]);
        let row = |i: usize| matrix.diagonal[i] * x[i] + beside(i).sum::<DVec2>();
        (0..x.len()).map(row).collect()
    }

    #[test]
    fn solves_what_it_was_given() {
        // 7 shares no factor with the number of unknowns, so each place has a number of its own.
        for n in [1, 2, 5, 12, 40] {
            let (matrix, places) = laplacian(n, 1e-3);
            let wanted: Vec<DVec2> = (0..n * n)
                .map(|i| DVec2::new((0.37 * f64::from(i)).sin(), f64::from(i % 5)))
                .collect();
            let mut x = product(&matrix, &wanted);
            let factor = Factor::new(&matrix, &places).expect("a definite matrix");
            factor.solve(&mut x);
            for (x, wanted) in x.iter().zip(&wanted) {
                assert!(x.distance(*wanted) < 1e-10, "{n}: {x} for {wanted}");
            }
        }
    }

    #[test]
    fn cuts_keep_the_factor_sparse() {
        let (matrix, places) = laplacian(100, 0.0);
        let factor = Factor::new(&matrix, &places).expect("a definite matrix");
        // In the order of rows it would hold a million.
        assert!(factor.values.len() < 350_000, "{}", factor.values.len());
    }

    #[test]
    fn what_is_not_definite_is_refused() {
        let (matrix, places) = laplacian(8, -4.0);
        assert!(Factor::new(&matrix, &places).is_none());
    }
}
