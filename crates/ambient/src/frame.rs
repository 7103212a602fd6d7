//! An orthonormal frame about a normal.
//!
//! T. Duff, J. Burgess, P. Christensen, C. Hery, A. Kensler, M. Liani, R. Villemin, "Building an Orthonormal Basis,
//! Revisited", JCGT 2017.

use glam::DVec3;

/// Right-handed orthonormal frame: `tangent × bitangent = normal`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Local x axis in world space.
    pub tangent: DVec3,
    /// Local y axis in world space.
    pub bitangent: DVec3,
    /// Local z axis in world space: the normal, or the axis of a lobe.
    pub normal: DVec3,
}

impl Frame {
    /// A frame whose z axis is `normal`, a unit vector. Free of branches and stable for every direction.
    ///
    /// The tangent is a smooth function of the normal except across the plane z = 0.
    ///
    /// ```
    /// let frame = ambake_ambient::Frame::from_normal(glam::DVec3::NEG_Z);
    /// assert_eq!(frame.to_world(glam::DVec3::Z), glam::DVec3::NEG_Z);
    /// ```
    pub fn from_normal(normal: DVec3) -> Frame {
        let sign = 1.0_f64.copysign(normal.z);
        let a = -1.0 / (sign + normal.z);
        let b = normal.x * normal.y * a;
        Frame {
            tangent: DVec3::new(
                1.0 + sign * normal.x * normal.x * a,
                sign * b,
                -sign * normal.x,
            ),
            bitangent: DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
            normal,
        }
    }

    /// A local direction in world space.
    pub fn to_world(&self, local: DVec3) -> DVec3 {
        self.tangent * local.x + self.bitangent * local.y + self.normal * local.z
    }

    /// A world direction in the local frame.
    pub fn to_local(&self, world: DVec3) -> DVec3 {
        DVec3::new(
            self.tangent.dot(world),
            self.bitangent.dot(world),
            self.normal.dot(world),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_normal_gets_a_right_handed_orthonormal_frame() {
        let mut normals = vec![
            DVec3::X,
            DVec3::NEG_X,
            DVec3::Y,
            DVec3::NEG_Y,
            DVec3::Z,
            DVec3::NEG_Z,
            DVec3::new(0.6, 0.8, -0.0),
            DVec3::new(1e-9, -1e-9, -1.0),
            DVec3::new(1e-4, 2e-4, -1.0).normalize(),
        ];
        for i in 0..2000 {
            let z = (f64::from(i) + 0.5) / 1000.0 - 1.0;
            let (s, c) = (f64::from(i) * 2.4).sin_cos();
            let r = ((1.0 - z) * (1.0 + z)).sqrt();
            normals.push(DVec3::new(r * c, r * s, z).normalize());
        }
        for n in normals {
            let f = Frame::from_normal(n);
            // A dozen roundings of numbers of magnitude at most 2.
            let bound = 2e-15;
            for (value, exact) in [
                (f.tangent.length_squared(), 1.0),
                (f.bitangent.length_squared(), 1.0),
                (f.tangent.dot(f.bitangent), 0.0),
                (f.tangent.dot(n), 0.0),
                (f.bitangent.dot(n), 0.0),
                (f.tangent.cross(f.bitangent).dot(n), 1.0),
            ] {
                assert!((value - exact).abs() < bound, "{n}: {value} for {exact}");
            }
            let local = DVec3::new(0.48, -0.6, 0.64);
            assert!((f.to_local(f.to_world(local)) - local).length() < bound);
        }
    }
}
