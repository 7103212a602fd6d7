//! Exact terms under occluders of simple shape: what a bake has to reproduce, exactly.
//!
//! The point is the origin. A polygon is a list of vertices, in either turn, seen from there; the functions return what
//! it *takes away* from an open hemisphere, so that polygons which do not overlap as seen from the point simply add up.
//! **Overlap is not resolved**: for a closed convex body pass only the faces that look at the point. The shapes of
//! [`shapes`] and [`round`] return the terms themselves.
//!
//! ```
//! use ambake_bench::exact::polygon_form_factor;
//! use glam::DVec3;
//!
//! // A square of side 2 at height 1 above the point: 0.5541, H. C. Hottel's parallel plates.
//! let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
//! let blocked = polygon_form_factor(&square, DVec3::Z);
//! let exact = 4.0 / std::f64::consts::PI * 0.5f64.sqrt() * 0.5f64.sqrt().atan();
//! assert!((blocked - exact).abs() < 1e-14);
//! ```

mod clip;
mod lobe;
mod polygon;
mod quadrature;
pub mod round;
pub mod shapes;

pub use lobe::{polygon_specular, tilted_phong};
pub use polygon::{polygon_form_factor, polygon_solid_angle};

/// The two view-independent terms of a point, each 1 when it is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Open {
    /// Open solid angle / 2π.
    pub visibility: f64,
    /// (1/π) ∫ N·L dω over the open directions.
    pub diffuse: f64,
}

impl Open {
    /// Both terms 1: nothing in the way.
    pub const FULL: Open = Open {
        visibility: 1.0,
        diffuse: 1.0,
    };
}

#[cfg(test)]
mod tests;
