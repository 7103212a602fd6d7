//! A dense symmetric solve, for least squares of a few unknowns.

/// Solves `matrix` x = `right` in place by Cholesky's decomposition; `false` where the matrix is not positive definite. Rows of `matrix`
/// follow each other; what stands above its diagonal is not read.
///
/// ```
/// let (mut matrix, mut right) = ([4.0, 0.0, 2.0, 3.0], [8.0, 8.0]);
/// assert!(ambake_ambient::solve::cholesky(&mut matrix, &mut right));
/// assert!((right[0] - 1.0).abs() < 1e-15 && (right[1] - 2.0).abs() < 1e-15);
/// ```
///
/// # Panics
/// Where the matrix has not as many rows and columns as `right`.
pub fn cholesky(matrix: &mut [f64], right: &mut [f64]) -> bool {
    let n = right.len();
    assert_eq!(matrix.len(), n * n);
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| matrix[i * n + k] * matrix[j * n + k]).sum();
            let rest = matrix[i * n + j] - dot;
            if i == j {
                if rest.is_nan() || rest <= 0.0 {
                    return false;
                }
                matrix[i * n + i] = rest.sqrt();
            } else {
                matrix[i * n + j] = rest / matrix[j * n + j];
            }
        }
    }
    for i in 0..n {
        let dot: f64 = (0..i).map(|k| matrix[i * n + k] * right[k]).sum();
        right[i] = (right[i] - dot) / matrix[i * n + i];
    }
    for i in (0..n).rev() {
        let dot: f64 = (i + 1..n).map(|k| matrix[k * n + i] * right[k]).sum();
        right[i] = (right[i] - dot) / matrix[i * n + i];
    }
    true
}
