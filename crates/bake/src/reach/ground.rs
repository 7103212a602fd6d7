//! A piece of surface that rays leave from, and what they can reach.
//!
//! Rays leave into the half-space above the plane of their triangle: a direction below it is mirrored there (`--shading
//! production`) or takes no ray (`exact`). They end at `--max-distance`. So a box is out of reach where it lies wholly
//! below the plane, or where its distance from the box of the piece is larger than the longest ray. Slack covers the
//! rounding of origins and directions.

use glam::DVec3;

/// A piece of surface in the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ground {
    /// The box of all ray origins.
    pub low: DVec3,
    pub high: DVec3,
    /// The unit normal on the side that rays leave to, and the least height along it of what they can meet; `None`
    /// where all counts.
    pub plane: Option<(DVec3, f64)>,
    /// The longest ray.
    pub distance: f64,
}

impl Ground {
    /// All that meets a box, and nothing else.
    pub fn meeting(low: DVec3, high: DVec3) -> Self {
        Self {
            low,
            high,
            plane: None,
            distance: 0.0,
        }
    }

    /// False where no ray can meet anything in this box.
    pub fn may_see(&self, low: DVec3, high: DVec3) -> bool {
        let apart = (low - self.high).max(self.low - high).max(DVec3::ZERO);
        apart.length() <= self.distance
            && self
                .plane
                .is_none_or(|(normal, least)| support(normal, low, high) >= least)
    }

    /// True where [`Ground::may_see`] holds for every box within this one.
    pub fn sees_all(&self, low: DVec3, high: DVec3) -> bool {
        let apart = (high - self.high).max(self.low - low).max(DVec3::ZERO);
        apart.length() <= self.distance
            && self
                .plane
                .is_none_or(|(normal, least)| -support(-normal, low, high) >= least)
    }
}

/// The largest height of a box along a direction.
fn support(direction: DVec3, low: DVec3, high: DVec3) -> f64 {
    (direction * low).max(direction * high).element_sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_support_of_a_box_is_its_highest_corner() {
        let (low, high) = (DVec3::new(-1.0, 2.0, -3.0), DVec3::new(5.0, 7.0, 11.0));
        let at = |x, y, z| support(DVec3::new(x, y, z), low, high);
        assert_eq!(at(1.0, 0.0, 0.0), 5.0);
        assert_eq!(at(0.0, -1.0, 0.0), -2.0);
        assert_eq!(at(-2.0, 1.0, -1.0), 2.0 + 7.0 + 3.0);
    }
}
