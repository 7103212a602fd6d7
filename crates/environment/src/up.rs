//! Which axis of a scene points upward.

use std::ops::Neg;

/// The axis of a scene that points upward. Maps have y there, as glTF does. What they show stands upright in a scene
/// with z upward too, where its (x, y, z) is the map's (x, z, -y): by that, programs export such scenes as glTF.
///
/// ```
/// use ambake_environment::Up;
/// assert_eq!(Up::Z.to_map(Up::Z.direction()), Up::Y.direction());
/// assert_eq!(Up::Z.of_map(Up::Y.direction()), Up::Z.direction());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Up {
    /// y.
    #[default]
    Y,
    /// z.
    Z,
}

impl Up {
    /// The unit direction upward, in the scene's axes.
    pub fn direction(self) -> [f64; 3] {
        match self {
            Up::Y => [0.0, 1.0, 0.0],
            Up::Z => [0.0, 0.0, 1.0],
        }
    }

    /// A direction of the scene in the map's axes.
    #[inline(always)]
    pub fn to_map<T: Neg<Output = T>>(self, [x, y, z]: [T; 3]) -> [T; 3] {
        match self {
            Up::Y => [x, y, z],
            Up::Z => [x, z, -y],
        }
    }

    /// A direction of the map in the scene's axes.
    #[inline(always)]
    pub fn of_map<T: Neg<Output = T>>(self, [x, y, z]: [T; 3]) -> [T; 3] {
        match self {
            Up::Y => [x, y, z],
            Up::Z => [x, -z, y],
        }
    }
}
