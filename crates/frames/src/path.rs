//! Where the camera stands in each frame.

use glam::DVec3;
use render::{Error, rows};

/// A camera path through key frames.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPath {
    /// Eye and point that is looked at; at least one.
    keys: Vec<[DVec3; 2]>,
}

impl CameraPath {
    /// The path through these eyes and looked-at points; `None` where there are none.
    pub fn new(keys: Vec<[DVec3; 2]>) -> Option<CameraPath> {
        (!keys.is_empty()).then_some(CameraPath { keys })
    }

    /// The path in a text of one line a key frame: X,Y,Z of the eye and of the point that is looked at, in scene units,
    /// apart by commas or blanks; `#` begins a comment.
    ///
    /// # Errors
    /// [`Error::Line`] with the first line that is none, [`Error::Text`] where there are no lines.
    pub fn parse(text: &str) -> Result<CameraPath, Error> {
        let keys = rows(text, &[6], "eye X,Y,Z and looked-at X,Y,Z")?;
        let keys = keys
            .into_iter()
            .map(|key| [0, 3].map(|from| DVec3::from_slice(&key[from..])));
        CameraPath::new(keys.collect()).ok_or(Error::Text(
            "it has no lines; one a key frame belongs there",
        ))
    }

    /// The same path where coordinates count from `origin`.
    pub fn counted_from(mut self, origin: DVec3) -> CameraPath {
        self.keys
            .as_flattened_mut()
            .iter_mut()
            .for_each(|place| *place -= origin);
        self
    }

    /// Number of key frames.
    pub fn keys(&self) -> usize {
        self.keys.len()
    }

    /// Eye and looked-at point of frame `frame` of `frames`: the first key at the first frame, the last at the last,
    /// between them the spline of E. Catmull, R. Rom (1974), whose tangents at the ends point to the next key.
    pub fn at(&self, frame: u32, frames: u32) -> [DVec3; 2] {
        let last = self.keys.len() - 1;
        let steps = frames.saturating_sub(1).max(1);
        // Whole numbers give keys exactly.
        let place = u64::from(frame) * last as u64;
        let (index, rest) = (place / u64::from(steps), place % u64::from(steps));
        let t = rest as f64 / f64::from(steps);
        let key = |offset: i64| {
            let at = (index as i64 + offset).clamp(0, last as i64);
            self.keys[at as usize]
        };
        let [a, b, c, d] = [key(-1), key(0), key(1), key(2)];
        std::array::from_fn(|k| {
            let (before, after) = (0.5 * (c[k] - a[k]), 0.5 * (d[k] - b[k]));
            let rise = c[k] - b[k];
            b[k] + t
                * (before
                    + t * ((3.0 * rise - 2.0 * before - after) + t * (before + after - 2.0 * rise)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_without_keys_or_with_a_short_line_is_no_path() {
        let path = CameraPath::parse("# eye, look\n0,0,4, 0,0,0\n4 0 0\t0 0 1\n").unwrap();
        assert_eq!(path.at(1, 2), [DVec3::X * 4.0, DVec3::Z]);
        let error = |text| CameraPath::parse(text).unwrap_err().to_string();
        assert!(error("# nothing\n").contains("no lines"));
        assert!(error("0,0,4,0,0,0\n1,2,3\n").starts_with("line 2: eye"));
    }

    #[test]
    fn a_path_meets_its_keys_and_runs_straight_between_keys_on_a_line() {
        let key = |x: f64| [DVec3::X * x, DVec3::Y * (2.0 * x)];
        let path = CameraPath::new(vec![key(0.0), key(1.0), key(2.0), key(3.0)]).unwrap();
        for frame in 0..10 {
            // Tangents at the ends are half a step of a clamped spline, so only the middle is linear.
            let [eye, look] = path.at(frame, 10);
            if frame.is_multiple_of(3) || (3..=6).contains(&frame) {
                let x = f64::from(frame) / 3.0;
                assert!((eye - DVec3::X * x).length() < 1e-15, "{frame}: {eye}");
                assert!((look - DVec3::Y * (2.0 * x)).length() < 1e-15, "{look}");
            }
        }
        assert_eq!(path.at(0, 1), key(0.0));
    }
}
