//! A flat page of one surface, of which some columns are buried: what their texels are made of is known on paper.

use super::{MendedPlanes, Mends};

const SIZE: usize = 16;
/// The first texel of the buried columns, in the middle row.
const FIRST: usize = SIZE / 2 * SIZE + SIZE / 2;

/// The planes of a page whose texels are a unit apart.
struct Planes {
    validity: Vec<f32>,
    position: [Vec<f32>; 3],
    normal: [Vec<f32>; 3],
    object: Vec<f32>,
}

/// All texels of a page, by column and row.
fn plane(of: impl Fn(usize, usize) -> f32) -> Vec<f32> {
    (0..SIZE * SIZE)
        .map(|texel| of(texel % SIZE, texel / SIZE))
        .collect()
}

impl Planes {
    /// A page of which nothing is seen from the middle column on.
    fn half() -> Self {
        let is_seen = |x: usize, _| if x < SIZE / 2 { 1.0 } else { 0.0 };
        Self {
            validity: plane(is_seen),
            position: [
                plane(|x, _| x as f32),
                plane(|_, y| y as f32),
                plane(|_, _| 0.0),
            ],
            normal: [plane(|_, _| 0.0), plane(|_, _| 0.0), plane(|_, _| 1.0)],
            object: plane(|_, _| 0.0),
        }
    }

    /// The same, but of the last seen column the part on the left alone is seen: its middle is a quarter of a texel to
    /// the left.
    fn with_a_part() -> Self {
        let mut planes = Self::half();
        for y in 0..SIZE {
            let texel = y * SIZE + SIZE / 2 - 1;
            planes.validity[texel] = 0.5;
            planes.position[0][texel] -= 0.25;
        }
        planes
    }

    fn mends(&self, of: fn(&MendedPlanes<'_>) -> Mends) -> Mends {
        let three = |planes| <[Vec<f32>; 3]>::each_ref(planes).map(Vec::as_slice);
        of(&MendedPlanes {
            size: SIZE,
            coverage: &plane(|_, _| 1.0),
            validity: &self.validity,
            position: three(&self.position),
            normal: three(&self.normal),
            object: &self.object,
            moved: false,
        })
    }

    /// A plane of these values mended, and the spans of what each is made of.
    fn apply(&self, values: &[f32]) -> Vec<f32> {
        let mut mended = values.to_vec();
        self.mends(Mends::of).apply(&mut mended, -1e9, 1e9);
        mended
    }

    /// What each texel counts in a mended one: what that gains where the texel does. Rows that differ by much leave it
    /// room.
    fn weights(&self, of: fn(&MendedPlanes<'_>) -> Mends, mended: usize) -> Vec<f64> {
        let mends = self.mends(of);
        let found = |brighter: Option<usize>| {
            let mut values = plane(|_, y| if y % 2 == 0 { 8.0 } else { -8.0 });
            brighter.into_iter().for_each(|texel| values[texel] += 1.0);
            mends.apply(&mut values, -1e9, 1e9);
            f64::from(values[mended])
        };
        let before = found(None);
        let gain = |texel: usize| found(Some(texel)) - before;
        (0..SIZE * SIZE).map(gain).collect()
    }
}

#[test]
fn what_is_seen_as_a_whole_is_mended_nowhere() {
    let planes = Planes {
        validity: plane(|_, _| 1.0),
        ..Planes::half()
    };
    let mut values = plane(|x, y| ((x * 7 + y * 3) % 5) as f32);
    let before = values.clone();
    let spans = planes.mends(Mends::of).apply(&mut values, 0.0, 9.0);
    assert!(
        spans.is_empty() && values == before,
        "{} texels",
        spans.len()
    );
}

#[test]
fn an_even_rise_goes_on_below_a_contact_by_half_its_span_at_most() {
    let values = plane(|x, _| x as f32);
    let mended = Planes::half().apply(&values);
    let at = |column: usize| mended[FIRST + column];
    // Of both the columns of 6 and 7 are within reach, and 8 and 9 are more than half of what these differ by above the
    // larger.
    for column in 0..2 {
        assert!((at(column) - 7.5).abs() < 1e-5, "{column}: {}", at(column));
    }
    // Three columns on, 7 alone is within reach; four on, nothing.
    assert_eq!(at(2), 7.0);
    assert_eq!(at(3), values[FIRST + 3]);
}

#[test]
fn a_rise_along_a_contact_is_met_exactly_as_far_as_it_is_seen() {
    let mended = Planes::half().apply(&plane(|_, y| y as f32));
    for column in 0..3 {
        let found = mended[FIRST + column];
        assert!(
            (found - (SIZE / 2) as f32).abs() < 1e-5,
            "{column}: {found}"
        );
    }
}

#[test]
fn mended_values_stay_in_the_range_of_their_layer() {
    let mut values = plane(|x, _| x as f32);
    Planes::half()
        .mends(Mends::of)
        .apply(&mut values, 0.0, 7.25);
    assert_eq!(values[FIRST], 7.25);
    let mut values = plane(|x, _| -(x as f32));
    Planes::half()
        .mends(Mends::of)
        .apply(&mut values, -7.25, 0.0);
    assert_eq!(values[FIRST], -7.25);
}

#[test]
fn what_is_seen_in_part_is_moved_from_the_middle_of_that_to_its_own() {
    // Means over what is seen of a light that rises evenly: of the columns within reach of the buried one they are 6
    // and 6.75.
    let planes = Planes::with_a_part();
    let values = planes.position[0].clone();
    let mended = planes.apply(&values);
    for (texel, expected) in [(FIRST - 1, 7.0), (FIRST, 7.125)] {
        let found = mended[texel];
        assert!((found - expected).abs() < 0.02, "{expected}: {found}");
    }
    // Once it has been moved it is not moved again, and counts as one that is seen as a whole.
    let mut again = plane(|x, _| x as f32);
    planes.mends(Mends::of_unseen).apply(&mut again, -1e9, 1e9);
    assert_eq!(again[FIRST - 1], 7.0);
    let found = planes.weights(Mends::of_unseen, FIRST);
    let whole = Planes::half().weights(Mends::of, FIRST);
    let far = found.iter().zip(whole).map(|(a, b)| (a - b).abs());
    let far = far.fold(0.0, f64::max);
    assert!(far < 1e-4, "{far}");
}

#[test]
fn errors_of_mended_texels_are_those_of_sums_of_independent_ones() {
    let planes = Planes::half();
    for column in 0..2 {
        let weights = planes.weights(Mends::of, FIRST + column);
        let sum: f64 = weights.iter().sum();
        assert!((sum - 1.0).abs() < 1e-4, "{sum}");
        let of_texel = |texel: usize| 0.01 * (1 + texel % 7) as f64;
        let squares = weights.iter().enumerate();
        let squares = squares.map(|(texel, w)| (w * of_texel(texel)).powi(2));
        let expected = squares.sum::<f64>().sqrt();
        let mut errors: Vec<f32> = (0..SIZE * SIZE)
            .map(|texel| of_texel(texel) as f32)
            .collect();
        let mends = planes.mends(Mends::of);
        let spans = mends.apply(&mut plane(|x, _| x as f32), -1e9, 1e9);
        mends.apply_to_errors(&mut errors, &spans);
        let found = f64::from(errors[FIRST + column]);
        assert!(
            (found - expected).abs() < 1e-3 * expected,
            "{column}: {found}, not {expected}"
        );
        // Where neighbours agree, the mended value is theirs, and as uncertain as the worst of them at most.
        let mut errors = vec![0.01; SIZE * SIZE];
        let spans = mends.apply(&mut vec![1.0; SIZE * SIZE], 0.0, 9.0);
        mends.apply_to_errors(&mut errors, &spans);
        assert!(errors[FIRST + column] <= 0.01, "{}", errors[FIRST + column]);
    }
}

#[test]
fn texels_of_other_objects_and_around_a_corner_have_no_part() {
    let above = |y: usize| y < SIZE / 2;
    let mut other = Planes::half();
    other.object = plane(|_, y| f32::from(u8::from(above(y))));
    let mut corner = Planes::half();
    // 45 degrees away; 30 degrees would be one bent surface.
    let lean = 0.5f32.sqrt();
    corner.normal[1] = plane(|_, y| if above(y) { lean } else { 0.0 });
    corner.normal[2] = plane(|_, y| if above(y) { lean } else { 1.0 });
    for (name, planes) in [("object", other), ("corner", corner)] {
        let weights = planes.weights(Mends::of, FIRST);
        let (beyond, own) = weights.split_at(SIZE / 2 * SIZE);
        assert!(beyond.iter().all(|w| *w == 0.0), "{name}: {beyond:?}");
        assert!(own.iter().any(|w| *w > 0.1), "{name}: {own:?}");
    }
}
