//! Directions that index the specular table.

/// Which direction indexes S. All point away from the surface and have unit length where N and E have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Index {
    /// R = 2(E·N)N − E, section 3.
    Mirror,
    /// E itself, section 9: lunar dust, reflective signs, cat's eyes.
    Retro,
    /// The direction refracted at one surface, section 9, by Snell's law with η, the refractive index on the eye's side
    /// over the one behind the surface: T = −ηE + (ηc − √(1 − η²(1 − c²)))N with c = E·N. Total reflection gives R.
    Refraction(f32),
    /// R, along which rays are cast into the scene, section 2.2: what they meet is shaded from its own tables, and
    /// where they meet nothing S is read. A surface that is seen in such a mirror reads S at R, as if it stood alone.
    Traced,
}

impl Index {
    /// The direction for a normal and a view.
    #[inline(always)]
    pub fn direction(self, normal: [f32; 3], view: [f32; 3]) -> [f32; 3] {
        let cosine = dot(normal, view);
        match self {
            Index::Mirror | Index::Traced => combine(2.0 * cosine, normal, -1.0, view),
            Index::Retro => view,
            Index::Refraction(eta) => {
                // 1 − η²(1 − c²), which is exactly c² at η = 1.
                let turned = eta * cosine;
                let under = (1.0 - eta * eta) + turned * turned;
                let through = turned - under.max(0.0).sqrt();
                let total = under < 0.0;
                let along = if total { 2.0 * cosine } else { through };
                combine(along, normal, if total { -1.0 } else { -eta }, view)
            }
        }
    }
}

#[inline(always)]
pub(super) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn combine(s: f32, a: [f32; 3], t: f32, b: [f32; 3]) -> [f32; 3] {
    [
        s * a[0] + t * b[0],
        s * a[1] + t * b[1],
        s * a[2] + t * b[2],
    ]
}
