//! Real spherical harmonics over the whole sphere, and what a matt surface receives from light that they describe.
//!
//! R. Ramamoorthi, P. Hanrahan, "An Efficient Representation for Irradiance Environment Maps", SIGGRAPH 2001 (light on
//! a matt surface); P.-P. Sloan, "Deringing Spherical Harmonics", SIGGRAPH Asia 2017 (the window that keeps it from
//! being negative).

use glam::DVec3;
use std::f64::consts::PI;

/// The largest order.
pub const MAX_ORDER: usize = 3;

/// Harmonics up to the largest order.
pub const MOST: usize = count(MAX_ORDER);

/// How many harmonics there are up to an order.
pub const fn count(order: usize) -> usize {
    (order + 1) * (order + 1)
}

/// The order of the harmonic at an index of [`basis`].
pub const fn order_of(index: usize) -> usize {
    index.isqrt()
}

/// All harmonics up to order 3 at a unit direction, orthonormal over the sphere, without the sign (-1)^m of some books.
///
/// Their order is by l, then by m from -l to l: 1; y, z, x; xy, yz, 3z² - 1, xz, x² - y²; y(3x² - y²), xyz, y(5z² - 1),
/// z(5z² - 3), x(5z² - 1), z(x² - y²), x(x² - 3y²), each times its constant.
///
/// ```
/// use ambake_ambient::harmonics::basis;
/// use glam::DVec3;
/// let up = basis(DVec3::Y);
/// assert!((up[0] - 0.282095).abs() < 1e-6 && (up[1] - 0.488603).abs() < 1e-6 && up[2] == 0.0);
/// ```
pub fn basis(direction: DVec3) -> [f64; MOST] {
    let DVec3 { x, y, z } = direction;
    let root = |value: f64| (value / PI).sqrt();
    let (first, second, third) = (root(3.0) / 2.0, root(15.0) / 2.0, root(7.0) / 4.0);
    let (edge, side) = (root(35.0 / 2.0) / 4.0, root(21.0 / 2.0) / 4.0);
    [
        root(1.0) / 2.0,
        first * y,
        first * z,
        first * x,
        second * x * y,
        second * y * z,
        root(5.0) / 4.0 * (3.0 * z * z - 1.0),
        second * x * z,
        second / 2.0 * (x * x - y * y),
        edge * y * (3.0 * x * x - y * y),
        root(105.0) / 2.0 * x * y * z,
        side * y * (5.0 * z * z - 1.0),
        third * z * (5.0 * z * z - 3.0),
        side * x * (5.0 * z * z - 1.0),
        root(105.0) / 4.0 * z * (x * x - y * y),
        edge * x * (x * x - 3.0 * y * y),
    ]
}

/// What a harmonic of radiance is multiplied with for the light E / π on a matt surface: 1, 2/3, 1/4 and 0.
pub const COSINE: [f64; MAX_ORDER + 1] = [1.0, 2.0 / 3.0, 0.25, 0.0];

/// E / π on a matt surface with this unit normal, of radiance with these coefficients, linear RGB.
///
/// ```
/// use ambake_ambient::harmonics::matt;
/// use glam::DVec3;
/// // A sky of radiance 1 everywhere.
/// let sky = [DVec3::splat((4.0 * std::f64::consts::PI).sqrt())];
/// assert!((matt(&sky, DVec3::X).x - 1.0).abs() < 1e-15);
/// ```
pub fn matt(coefficients: &[DVec3], normal: DVec3) -> DVec3 {
    let basis = basis(normal);
    let term = |(k, value): (usize, &DVec3)| *value * (basis[k] * COSINE[order_of(k)]);
    coefficients.iter().enumerate().map(term).sum()
}

/// The same light toward +x, -x, +y, -y, +z and -z: the ambient cube of J. Mitchell, G. McTaggart, C. Green, "Shading
/// in Valve's Source Engine" (2006).
pub fn ambient_cube(coefficients: &[DVec3]) -> [DVec3; 6] {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    std::array::from_fn(|k| {
        let axis = axes[k / 2];
        matt(coefficients, if k % 2 == 0 { axis } else { -axis })
    })
}

/// Root mean square over all normals of the light E / π of these coefficients, linear RGB.
pub fn matt_rms(coefficients: &[DVec3]) -> DVec3 {
    let term = |(k, value): (usize, &DVec3)| (*value * COSINE[order_of(k)]).powf(2.0);
    let sum: DVec3 = coefficients.iter().enumerate().map(term).sum();
    (sum / (4.0 * PI)).powf(0.5)
}

/// The mildest window under which no normal receives less than nothing: orders l are divided by 1 + λ l² (l + 1)², and
/// λ is returned, 0 where nothing rings. All channels share it, so that no hue changes.
///
/// Ringing is what is left of a bright light in few harmonics: dark, even negative light on the other side. The window
/// takes contrast and leaves the mean.
pub fn window(coefficients: &mut [DVec3]) -> f64 {
    /// Normals at which light is looked at: a Fibonacci spiral.
    const NORMALS: usize = 1024;
    /// Halvings of the interval of λ.
    const STEPS: usize = 24;
    let normal = |k: usize| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / NORMALS as f64;
        let (y, x) = (k as f64 * PI * (3.0 - 5.0f64.sqrt())).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * x, r * y, z)
    };
    let normals: Vec<DVec3> = (0..NORMALS).map(normal).collect();
    let windowed = |strength: f64| -> Vec<DVec3> {
        let term = |(k, value): (usize, &DVec3)| {
            let l = order_of(k) as f64;
            *value / (1.0 + strength * (l * (l + 1.0)).powi(2))
        };
        coefficients.iter().enumerate().map(term).collect()
    };
    let rings = |strength: f64| {
        let tried = windowed(strength);
        normals
            .iter()
            .any(|&normal| matt(&tried, normal).min_element() < 0.0)
    };
    if !rings(0.0) {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while rings(high) && high < 1e6 {
        (low, high) = (high, 4.0 * high);
    }
    for _ in 0..STEPS {
        let middle = 0.5 * (low + high);
        if rings(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    coefficients.copy_from_slice(&windowed(high));
    high
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss_legendre;

    /// ∫ f dω: 16 Gauss points in z by 32 even longitudes, exact for these polynomials.
    fn integral(f: impl Fn(DVec3) -> f64) -> f64 {
        let mut sum = 0.0;
        for (z, weight) in gauss_legendre(16) {
            let r = (1.0 - z * z).sqrt();
            for k in 0..32 {
                let (y, x) = (PI * k as f64 / 16.0).sin_cos();
                sum += weight * PI / 16.0 * f(DVec3::new(r * x, r * y, z));
            }
        }
        sum
    }

    #[test]
    fn harmonics_are_orthonormal_over_the_sphere() {
        for i in 0..MOST {
            for j in 0..MOST {
                let found = integral(|d| basis(d)[i] * basis(d)[j]);
                let exact = f64::from(u8::from(i == j));
                assert!((found - exact).abs() < 1e-12, "{i} {j}: {found}");
            }
        }
    }

    #[test]
    fn light_on_a_matt_surface_is_the_clamped_cosine_integral() {
        // Radiance 1 + z + xy - x² + y²: quadratic, so order 2 holds all of it.
        let light = |d: DVec3| 1.5 + d.z + d.x * d.y - d.x * d.x + d.y * d.y;
        let coefficients: Vec<DVec3> = (0..9)
            .map(|k| DVec3::splat(integral(|d| light(d) * basis(d)[k])))
            .collect();
        // Toward +z by hand: the mean over the cosine-weighted hemisphere of 1.5 + z is 1.5 + 2/3, the rest cancels.
        let up = matt(&coefficients, DVec3::Z).x;
        assert!((up - (1.5 + 2.0 / 3.0)).abs() < 1e-12, "{up}");
        // Toward +x, x² has the mean 1/2 and y² 1/4.
        let side = matt(&coefficients, DVec3::X).x;
        assert!((side - (1.5 - 0.5 + 0.25)).abs() < 1e-12, "{side}");
        let cube = ambient_cube(&coefficients);
        assert_eq!((cube[4].x, cube[0].x), (up, side));
    }

    #[test]
    fn a_window_leaves_the_mean_and_takes_what_is_negative() {
        let sun = DVec3::new(0.6, 0.0, 0.8);
        let exact: Vec<DVec3> = basis(sun)[..9].iter().map(|&v| DVec3::splat(v)).collect();
        let mut windowed = exact.clone();
        let strength = window(&mut windowed);
        assert!(strength > 0.0 && windowed[0] == exact[0]);
        let least = |of: &[DVec3]| {
            let normals = (0..=180).map(|k| {
                let (s, c) = (k as f64).to_radians().sin_cos();
                DVec3::new(0.6 * c - 0.8 * s, 0.0, 0.8 * c + 0.6 * s)
            });
            normals.map(|n| matt(of, n).x).fold(f64::INFINITY, f64::min)
        };
        // 4 % of the peak below nothing without; normals between those looked at may ring by a hundredth of that.
        assert!(least(&exact) < -0.01, "{}", least(&exact));
        assert!(least(&windowed) > -2e-4, "{}", least(&windowed));
        let mut even = [DVec3::ONE; 1];
        assert_eq!((window(&mut even), even), (0.0, [DVec3::ONE]));
    }
}
