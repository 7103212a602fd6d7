//! Associated Legendre functions on many rings at once.
//!
//! P̄ is orthonormal with its azimuth: Y_lm = P̄_lm(cos θ) e^{imφ} has ∫ |Y_lm|² dω = 1. Going up in l at constant m is
//! stable.

/// The functions of one m on a set of rings, order by order.
pub(super) struct Legendre<'a> {
    cos: &'a [f64],
    m: usize,
    /// P̄ of the current order and of the one before, by ring.
    pub current: Vec<f64>,
    last: Vec<f64>,
    l: usize,
}

impl<'a> Legendre<'a> {
    /// Order l = m. `first` is P̄_mm(θ) / sinᵐθ, see [`diagonal`].
    pub(super) fn new(m: usize, first: f64, cos: &'a [f64], sin: &[f64]) -> Self {
        let current = sin.iter().map(|s| first * s.powi(m as i32)).collect();
        Self {
            cos,
            m,
            current,
            last: vec![0.0; cos.len()],
            l: m,
        }
    }

    /// Goes on to the next order.
    pub(super) fn step(&mut self) {
        self.l += 1;
        let (l, m) = (self.l as f64, self.m as f64);
        let a = ((4.0 * l * l - 1.0) / ((l - m) * (l + m))).sqrt();
        let k = l - 1.0;
        let b = ((k - m) * (k + m) / (4.0 * k * k - 1.0)).max(0.0).sqrt();
        let ab = a * b;
        for ((last, current), cos) in self.last.iter_mut().zip(&self.current).zip(self.cos) {
            *last = a * cos * current - ab * *last;
        }
        std::mem::swap(&mut self.last, &mut self.current);
    }
}

/// P̄_mm(θ) / sinᵐθ for m from 0 to `order`.
pub(super) fn diagonal(order: usize) -> Vec<f64> {
    let mut value = (0.25 * std::f64::consts::FRAC_1_PI).sqrt();
    let mut values = vec![value];
    for m in 1..=order {
        value *= ((2 * m + 1) as f64 / (2 * m) as f64).sqrt();
        values.push(value);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_of_one_order_add_up_to_a_constant() {
        // Unsöld: Σ_m |Y_lm|² = (2l+1)/4π on every ring, to the highest order and close to the pole.
        let order = 1900;
        let angles = [1e-3, 0.01, 0.1, 0.5, 1.0, 1.5];
        let (sin, cos): (Vec<f64>, Vec<f64>) = angles.iter().map(|a: &f64| a.sin_cos()).unzip();
        let first = diagonal(order);
        let mut sums = vec![[0.0; 6]; order + 1];
        for m in 0..=order {
            let mut p = Legendre::new(m, first[m], &cos, &sin);
            for sum in &mut sums[m..] {
                for (s, p) in sum.iter_mut().zip(&p.current) {
                    *s += p * p * if m == 0 { 1.0 } else { 2.0 };
                }
                p.step();
            }
        }
        for (l, sum) in sums.iter().enumerate() {
            let exact = (2 * l + 1) as f64 * 0.25 * std::f64::consts::FRAC_1_PI;
            for s in sum {
                assert!((s / exact - 1.0).abs() < 1e-10, "l = {l}: {s} {exact}");
            }
        }
    }
}
