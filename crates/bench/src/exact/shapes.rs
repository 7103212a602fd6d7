//! Points below flat shapes: walls, corners, grooves, trenches, rectangles.
//!
//! The classical configuration factors (J. R. Howell, "A Catalog of Radiation Heat Transfer Configuration Factors") and
//! their solid-angle counterparts, with the tangent plane as floor. Lengths are in any one unit and positive.

use super::Open;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A point at `distance` from the foot of an infinitely long wall of `height`, which may be infinite.
pub fn wall(distance: f64, height: f64) -> Open {
    Open {
        visibility: 1.0 - height.atan2(distance) / PI,
        diffuse: 0.5 * (1.0 + distance / distance.hypot(height)),
    }
}

/// The average over a strip `near..far` along the foot of an infinitely long wall: what a texel there holds.
pub fn wall_average(near: f64, far: f64, height: f64) -> Open {
    // ∫ atan(h/d) dd = d atan(h/d) + h/2 ln(d² + h²)
    let blocked = |d: f64| d * height.atan2(d) + 0.5 * height * (d / height).powi(2).ln_1p();
    Open {
        visibility: 1.0 - (blocked(far) - blocked(near)) / (PI * (far - near)),
        // √(far²+h²) − √(near²+h²) as a quotient, without the difference of like numbers.
        diffuse: 0.5 * (1.0 + (far + near) / (far.hypot(height) + near.hypot(height))),
    }
}

/// A point at `distance` from a wall that spans `y[0]..y[1]` along its foot (0 is the point's own foot) and `height`.
pub fn finite_wall(distance: f64, y: [f64; 2], height: f64) -> Open {
    let d = distance;
    let slant = d.hypot(height);
    let corner = |w: f64| {
        let solid = (w * height).atan2(d * slant.hypot(w));
        let factor = (w / d).atan() - d / slant * (w / slant).atan();
        [solid / TAU, factor / TAU]
    };
    let [low, high] = y.map(corner);
    Open {
        visibility: 1.0 - (high[0] - low[0]),
        diffuse: 1.0 - (high[1] - low[1]),
    }
}

/// A point below a horizontal rectangle `x[0]..x[1]` by `y[0]..y[1]` at `height`.
pub fn rectangle_above(x: [f64; 2], y: [f64; 2], height: f64) -> Open {
    let corner = |w: f64, l: f64| {
        let (a, b) = (height.hypot(w), height.hypot(l));
        let solid = (w * l).atan2(height * a.hypot(l));
        let factor = w / a * (l / a).atan() + l / b * (w / b).atan();
        [solid / TAU, factor / TAU]
    };
    let sum = |k: usize| {
        corner(x[1], y[1])[k] - corner(x[0], y[1])[k] - corner(x[1], y[0])[k]
            + corner(x[0], y[0])[k]
    };
    Open {
        visibility: 1.0 - sum(0),
        diffuse: 1.0 - sum(1),
    }
}

/// Any point of a face of a V groove of infinite faces that opens by `opening` radians, `0..=π`.
pub fn groove(opening: f64) -> Open {
    let s = (0.5 * opening).sin();
    Open {
        visibility: opening / PI,
        diffuse: s * s,
    }
}

/// Any point of a face of the corner of three infinite planes at right angles.
pub fn corner() -> Open {
    Open {
        visibility: 0.25,
        diffuse: 0.25,
    }
}

/// A point of the floor of an infinite trench of `width` and `depth`, at `x` from one wall, `0 < x < width`.
pub fn trench(width: f64, depth: f64, x: f64) -> Open {
    let (near, far) = (wall(x, depth), wall(width - x, depth));
    Open {
        visibility: near.visibility + far.visibility - 1.0,
        diffuse: 0.5 * (x / x.hypot(depth) + (width - x) / (width - x).hypot(depth)),
    }
}

/// A point of a wall of an infinite slit of `width`, `depth` below the rim.
pub fn slit_wall(width: f64, depth: f64) -> Open {
    // The sky fills elevations from atan(depth/width) to 90 degrees over the horizontal.
    let down = depth.atan2(width);
    let cosine = width / width.hypot(depth);
    Open {
        visibility: (FRAC_PI_2 - down) / PI,
        // (1 − sin)/2 = cos²/(2(1 + sin))
        diffuse: 0.5 * cosine * cosine / (1.0 + depth / width.hypot(depth)),
    }
}
