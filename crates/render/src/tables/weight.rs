//! The weights Wd and Ws of the 1984 text: reflectance by the cosine of the angle of view.

/// A weight as a function of E·N.
#[derive(Debug, Clone, PartialEq)]
pub enum Weight {
    /// 1 at every angle.
    Constant,
    /// F0 + (1 − F0)(1 − E·N)⁵: C. Schlick, "An Inexpensive BRDF Model for Physically-based Rendering" (1994). F0 in 0..=1.
    Schlick(f32),
    /// Linear between (cosine, weight) pairs with ascending cosines; constant beyond the ends. Not empty.
    Table(Vec<[f32; 2]>),
}

impl Weight {
    /// The weight at a cosine; below 0 counts as 0.
    #[inline(always)]
    pub fn at(&self, cosine: f32) -> f32 {
        let cosine = cosine.clamp(0.0, 1.0);
        match self {
            Weight::Constant => 1.0,
            Weight::Schlick(f0) => {
                let m = 1.0 - cosine;
                f0 + (1.0 - f0) * (m * m) * (m * m) * m
            }
            Weight::Table(pairs) => between(pairs, cosine),
        }
    }
}

fn between(pairs: &[[f32; 2]], cosine: f32) -> f32 {
    let after = pairs.partition_point(|p| p[0] <= cosine);
    match (after.checked_sub(1).map(|k| pairs[k]), pairs.get(after)) {
        (Some([x0, w0]), Some([x1, w1])) => w0 + (w1 - w0) * (cosine - x0) / (x1 - x0),
        (Some([_, w]), None) | (None, Some(&[_, w])) => w,
        (None, None) => unreachable!("a table of weights is not empty"),
    }
}
