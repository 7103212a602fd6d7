//! Figures of X. Zhang, Y. Gao, "Generalised Ambient Reflection Models for Lambertian and Phong Surfaces", ICIP 2009.

mod fig1;
mod fig1_svg;
mod fig3;

pub use fig1::{Fig1Point, fig1, fig1_csv};
pub use fig1_svg::fig1_svg;
pub use fig3::{Fig3, fig3};
