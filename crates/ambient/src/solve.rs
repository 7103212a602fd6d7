//! A dense symmetric solve, for least squares of a few unknowns.

/// Solves `matrix` x = `right` in place by Cholesky's decomposition; `false` where the matrix is not positive definite.
/// Rows of `matrix` follow each other; what stands below its diagonal is not read. Sums of one row of the factors run
/// side by side, each in its own order.
///
/// ```
/// let (mut matrix, mut right) = ([4.0, 2.0, 0.0, 3.0], [8.0, 8.0]);
/// assert!(ambake_ambient::solve::cholesky(&mut matrix, &mut right));
/// assert!((right[0] - 1.0).abs() < 1e-15 && (right[1] - 2.0).abs() < 1e-15);
/// ```
///
/// # Panics
/// Where the matrix has not as many rows and columns as `right`.
pub fn cholesky(matrix: &mut [f64], right: &mut [f64]) -> bool {
    let n = right.len();
    assert_eq!(matrix.len(), n * n);
    let mut sums = vec![0.0; n];
    for j in 0..n {
        let (before, row) = matrix.split_at_mut(j * n);
        let row = &mut row[j..n];
        let sums = &mut sums[..n - j];
        sums.fill(-0.0);
        for factors in before.chunks_exact(n) {
            let factors = &factors[j..];
            for (sum, factor) in sums.iter_mut().zip(factors) {
                *sum += factor * factors[0];
            }
        }
        let left = row[0] - sums[0];
        if left.is_nan() || left <= 0.0 {
            return false;
        }
        let root = left.sqrt();
        row[0] = root;
        for (value, sum) in row[1..].iter_mut().zip(&sums[1..]) {
            *value = (*value - sum) / root;
        }
    }
    sums.fill(-0.0);
    for (i, factors) in matrix.chunks_exact(n.max(1)).enumerate() {
        right[i] = (right[i] - sums[i]) / factors[i];
        for (known, factor) in sums[i + 1..].iter_mut().zip(&factors[i + 1..]) {
            *known += factor * right[i];
        }
    }
    for i in (0..n).rev() {
        let factors = &matrix[i * n..(i + 1) * n];
        let known: f64 = (i + 1..n).map(|j| factors[j] * right[j]).sum();
        right[i] = (right[i] - known) / factors[i];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_unknowns_whose_factors_are_whole_numbers_are_solved_exactly() {
        // L Lᵀ of L = [2 0 0; 1 3 0; 1 -1 1], times (1, -2, 3). What stands below the diagonal is not read.
        let mut matrix = [4.0, 2.0, 2.0, f64::NAN, 10.0, -2.0, f64::NAN, f64::NAN, 3.0];
        let mut right = [6.0, -24.0, 15.0];
        assert!(cholesky(&mut matrix, &mut right));
        assert_eq!(right, [1.0, -2.0, 3.0]);
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_is_refused() {
        for last in [4.0, 3.0, f64::NAN] {
            let mut matrix = [1.0, 2.0, 0.0, last];
            assert!(!cholesky(&mut matrix, &mut [1.0, 1.0]), "{last}");
        }
        assert!(cholesky(&mut [1.0, 2.0, 0.0, 5.0], &mut [1.0, 1.0]));
    }
}
