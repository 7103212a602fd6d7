//! Points below discs and spheres, and inside bowls and wells. Lengths are in any one unit and positive.

use super::Open;
use super::quadrature::adaptive;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A point that sees an ellipse `centre + axes[0] cos s + axes[1] sin s`, wholly above the horizon of `normal`.
///
/// The visibility comes by quadrature (it is an elliptic integral), absolute error a few 1e-15.
pub fn ellipse(centre: DVec3, axes: [DVec3; 2], normal: DVec3) -> Open {
    let [solid, factor] = ellipse_shares(centre, axes, normal);
    Open {
        visibility: 1.0 - solid,
        diffuse: 1.0 - factor,
    }
}

/// Solid angle over 2π and form factor: ∮ (1 − x) dφ / 2π and ∮ (1 − x²) dφ / 2π, φ the azimuth and x the height of the
/// boundary's direction.
fn ellipse_shares(centre: DVec3, axes: [DVec3; 2], normal: DVec3) -> [f64; 2] {
    let edge = |s: f64| {
        let (sine, cosine) = s.sin_cos();
        let p = centre + axes[0] * cosine + axes[1] * sine;
        let along = axes[1] * cosine - axes[0] * sine;
        // (1 − x²) dφ/ds, and x.
        (
            normal.dot(p.cross(along)) / p.length_squared(),
            normal.dot(p) / p.length(),
        )
    };
    let around = |f: &dyn Fn(f64) -> f64| -> f64 {
        (0..4)
            .map(|k| adaptive(&f, f64::from(k) * FRAC_PI_2, f64::from(k + 1) * FRAC_PI_2))
            .sum()
    };
    let solid = around(&|s| {
        let (swept, x) = edge(s);
        swept / (1.0 + x)
    });
    let factor = around(&|s| edge(s).0);
    [(solid / TAU).abs(), (factor / TAU).abs()]
}

/// A point below a horizontal disc of `radius` at `height`, its centre moved sideways by `offset`.
pub fn disc_above(radius: f64, height: f64, offset: f64) -> Open {
    let (h2, a2, r2) = (height * height, offset * offset, radius * radius);
    let total = h2 + a2 + r2;
    let diffuse = 0.5 + 0.5 * (h2 + a2 - r2) / (total * total - 4.0 * a2 * r2).sqrt();
    let visibility = if offset == 0.0 {
        height / height.hypot(radius)
    } else {
        let centre = DVec3::new(offset, 0.0, height);
        ellipse(centre, [DVec3::X * radius, DVec3::Y * radius], DVec3::Z).visibility
    };
    Open {
        visibility,
        diffuse,
    }
}

/// A point that sees a sphere of `radius` at `distance` (to the centre, beyond `radius`), `zenith` radians off its
/// normal.
///
/// Holds whether the sphere is above the horizon, cut by it, or below.
pub fn sphere(radius: f64, distance: f64, zenith: f64) -> Open {
    let sin_a = radius / distance;
    let cos_a = ((1.0 - sin_a) * (1.0 + sin_a)).sqrt();
    let half_angle = sin_a.asin();
    let (sin_t, cos_t) = zenith.sin_cos();
    if zenith + half_angle <= FRAC_PI_2 {
        return Open {
            visibility: cos_a,
            diffuse: 1.0 - sin_a * sin_a * cos_t,
        };
    }
    if zenith - half_angle >= FRAC_PI_2 {
        return Open::FULL;
    }
    // Half the arc of the rim above the horizon, about the centre of the sphere's disc.
    let arc = (-cos_a * cos_t / (sin_a * sin_t)).clamp(-1.0, 1.0).acos();
    let solid = PI - (cos_t / sin_a).clamp(-1.0, 1.0).acos() - arc * cos_a;
    let factor = arc * sin_a * sin_a * cos_t - sin_a * cos_a * sin_t * arc.sin()
        + (cos_a / sin_t).clamp(-1.0, 1.0).acos();
    Open {
        visibility: 1.0 - solid / PI,
        diffuse: 1.0 - factor / PI,
    }
}

/// A point of a plane at `rho` from where a sphere of `radius` rests on it.
pub fn resting_sphere(radius: f64, rho: f64) -> Open {
    let ratio = rho / radius;
    Open {
        visibility: ratio / 1.0_f64.hypot(ratio),
        diffuse: -(-1.5 * (ratio * ratio).ln_1p()).exp_m1(),
    }
}

/// A point inside a hemispherical bowl, `angle` radians from its bottom, `0..π/2`, with its normal to the centre.
///
/// The diffuse term is 1/2 everywhere.
pub fn bowl(angle: f64) -> Open {
    let (sine, cosine) = angle.sin_cos();
    let inward = DVec3::new(-sine, 0.0, cosine);
    let [rim, _] = ellipse_shares(inward, [DVec3::X, DVec3::Y], inward);
    Open {
        visibility: rim,
        diffuse: 0.5,
    }
}

/// The centre of the floor of a cylindrical well; also the point below a round hole in a closed lid.
pub fn well(radius: f64, depth: f64) -> Open {
    let slope = radius / depth;
    let cosine = 1.0 / 1.0_f64.hypot(slope);
    let sine2 = slope * slope / (1.0 + slope * slope);
    Open {
        // 1 − cos = sin²/(1 + cos)
        visibility: sine2 / (1.0 + cosine),
        diffuse: sine2,
    }
}
