//! Where fits end: at the range of a term, and where a surface turns.

use super::{SIZE, made, one_object, seam};

#[test]
fn what_is_fitted_stays_within_the_range_of_its_term() {
    // Half of the plain values lie beyond one end, and so would every second fit.
    for (truth, end) in [(1.0, 1.0f32), (0.0, 0.0)] {
        let made = made(11, |_, _| truth, |_, _| 0.05, one_object);
        let (values, _) = made.denoised();
        let mut at_end = 0;
        for i in made.covered() {
            assert!((0.0..=1.0).contains(&values[i]), "texel {i}: {}", values[i]);
            at_end += usize::from(values[i] == end);
        }
        assert!(at_end > 1000, "{at_end} texels at {end}");
    }
}

#[test]
fn fits_do_not_go_on_around_a_corner() {
    let side = |x: usize, _: usize| f32::from(u8::from(x >= SIZE / 2));
    let mut made = made(5, |x, _| 0.2 + 0.3 * x, |_, _| 0.05, side);
    let seam = seam([0, 1]);
    let alone = made.denoised().0;
    let differs = |made: &super::Made, alone: &[f32]| {
        let values = made.denoised_by(&made.denoiser_across(&seam)).0;
        made.covered().any(|i| values[i] != alone[i])
    };
    assert!(differs(&made, &alone), "one plane");
    // The right half stands upright; its light is what it was.
    for i in made.covered().collect::<Vec<_>>() {
        if i % SIZE >= SIZE / 2 {
            (made.normal[0][i], made.normal[1][i]) = (-1.0, 0.0);
            made.position[1][i] = (i % SIZE - SIZE / 2) as f32;
            made.position[0][i] = (SIZE / 2) as f32;
        }
    }
    let alone = made.denoised().0;
    assert!(!differs(&made, &alone), "a corner");
}
