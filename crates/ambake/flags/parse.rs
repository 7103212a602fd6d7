//! Words of the command line to values, for every verb. Errors say what belongs there; clap names the flag.

use glam::DVec3;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// Up to here 64-bit numbers hold all whole ones.
const EXACT: f64 = (1u64 << 53) as f64;

/// A finite number.
pub fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{text}` is not a finite number")),
    }
}

/// A whole number within some bounds. It may be written as `1e3` too.
pub fn whole<T: Copy + Display + PartialOrd + TryFrom<u64>>(
    bounds: RangeInclusive<T>,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let rounded = || {
            let value = number(text).ok()?;
            let is_exact = value.fract() == 0.0 && (0.0..=EXACT).contains(&value);
            is_exact.then_some(value as u64)
        };
        let value = text.trim().parse().ok().or_else(rounded);
        let value = value.and_then(|value| T::try_from(value).ok());
        value.filter(|value| bounds.contains(value)).ok_or_else(|| {
            let (least, most) = (bounds.start(), bounds.end());
            format!("must be a whole number from {least} to {most}")
        })
    }
}

/// A number above 0, also when rounded to f32.
pub fn positive(text: &str) -> Result<f64, String> {
    match number(text)? {
        value if value > 0.0 && (value as f32).is_finite() && value as f32 > 0.0 => Ok(value),
        value if value > 1.0 => Err("must be at most 3.4e38".into()),
        _ => Err("must be above 0".into()),
    }
}

/// A number of at least 0 that f32 holds.
pub fn at_least_zero(text: &str) -> Result<f64, String> {
    match number(text)? {
        value if value >= 0.0 && (value as f32).is_finite() => Ok(value),
        value if value > 0.0 => Err("must be at most 3.4e38".into()),
        _ => Err("must be at least 0".into()),
    }
}

/// A lobe exponent.
pub fn exponent(text: &str) -> Result<f64, String> {
    match number(text)? {
        value if (0.0..=1e6).contains(&value) => Ok(value),
        _ => Err("must be between 0 and 1e6".into()),
    }
}

/// X,Y,Z.
pub fn triple(text: &str) -> Result<[f64; 3], String> {
    let parts: Vec<&str> = text.split(',').collect();
    match parts.as_slice() {
        [a, b, c] => Ok([number(a)?, number(b)?, number(c)?]),
        _ => Err("expected three numbers separated by commas".into()),
    }
}

/// R,G,B, each 0 or above.
pub fn color(text: &str) -> Result<[f32; 3], String> {
    let values = triple(text)?.map(|v| v as f32);
    if values.iter().all(|v| v.is_finite() && *v >= 0.0) {
        Ok(values)
    } else {
        Err("each must be 0 or above, and at most 3.4e38".into())
    }
}

/// X,Y,Z,E or X,Y,Z,R,G,B, the strength 0 or above; the first is grey.
pub fn light(text: &str) -> Result<[f64; 6], String> {
    with_strength(text)
}

/// X,Y,Z,RADIUS,L or X,Y,Z,RADIUS,R,G,B, as [`light`].
pub fn sphere(text: &str) -> Result<[f64; 7], String> {
    let values: [f64; 7] = with_strength(text)?;
    match values[3] > 0.0 {
        true => Ok(values),
        false => Err(format!("the radius {} must be above 0", values[3])),
    }
}

/// X,Y,Z of a corner and of two sides, then L or R,G,B, as [`light`].
pub fn rect(text: &str) -> Result<[f64; 12], String> {
    let values: [f64; 12] = with_strength(text)?;
    let [_, _, _, a, b, c, d, e, f, ..] = values;
    let area = DVec3::new(a, b, c).cross(DVec3::new(d, e, f)).length();
    match area > 0.0 && area.is_finite() {
        true => Ok(values),
        false => Err(format!(
            "the sides {a},{b},{c} and {d},{e},{f} enclose no area"
        )),
    }
}

/// So many numbers of which the last three are a strength, 0 or above; one stands for three that are alike.
fn with_strength<const ALL: usize>(text: &str) -> Result<[f64; ALL], String> {
    let mut numbers: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
    if numbers.len() + 2 == ALL {
        numbers.extend([numbers[ALL - 3]; 2]);
    }
    let values: [f64; ALL] = numbers.try_into().map_err(|_| {
        let one = ALL - 2;
        format!("expected {one} numbers separated by commas, or {ALL} with a colour")
    })?;
    match values[ALL - 3..].iter().any(|strength| *strength < 0.0) {
        true => Err("the strength at the end must be 0 or above".into()),
        false => Ok(values),
    }
}

/// [`light`] whose place is a direction: not 0,0,0, nor so short or long that its length cannot be told.
pub fn sun(text: &str) -> Result<[f64; 6], String> {
    let values @ [x, y, z, ..] = light(text)?;
    match DVec3::new(x, y, z).try_normalize() {
        None => Err(format!("{x},{y},{z} is no direction")),
        Some(_) => Ok(values),
    }
}

/// Degrees above 0 and below 180.
pub fn field_of_view(text: &str) -> Result<f64, String> {
    match number(text)? {
        value if value > 0.0 && value < 180.0 => Ok(value),
        _ => Err("must be above 0 and below 180".into()),
    }
}

/// WIDTHxHEIGHT in pixels or texels.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let edge = |text: &str| match text.trim().parse::<u32>() {
        Ok(edge) if (1..=16_384).contains(&edge) => Ok(edge),
        _ => Err(format!("`{text}` is not a number between 1 and 16384")),
    };
    match text.split_once('x') {
        Some((width, height)) => Ok([edge(width)?, edge(height)?]),
        None => Err("expected WIDTHxHEIGHT, such as 960x540".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_finite_and_stay_in_their_range() {
        assert_eq!(number(" -1e3 "), Ok(-1e3));
        assert_eq!(positive("1e-3"), Ok(1e-3));
        assert_eq!(exponent("1e6"), Ok(1e6));
        assert_eq!(field_of_view("179.9"), Ok(179.9));
        for wrong in ["", "nan", "inf", "1,2", "one"] {
            assert!(number(wrong).is_err(), "{wrong}");
        }
        // Above 0, but 0 or infinite once it is a float of 32 bits.
        for wrong in ["0", "-1", "1e-60", "1e60"] {
            assert!(positive(wrong).is_err(), "{wrong}");
        }
        assert!(exponent("-1").is_err() && exponent("2e6").is_err());
        assert!(field_of_view("0").is_err() && field_of_view("180").is_err());
    }

    #[test]
    fn whole_numbers_say_what_is_allowed() {
        let size = whole::<u32>(1..=16_384);
        assert_eq!((size("1024"), size(" 1e3 ")), (Ok(1024), Ok(1000)));
        for wrong in ["1e9", "0", "-4", "1.5", "1e60", "inf", "large", ""] {
            let allowed = "must be a whole number from 1 to 16384";
            assert_eq!(size(wrong), Err(allowed.into()), "{wrong}");
        }
        let seed = whole::<u64>(0..=u64::MAX);
        assert_eq!(seed("18446744073709551615"), Ok(u64::MAX));
        assert!(seed("18446744073709551616").is_err() && seed("1e20").is_err());
    }

    #[test]
    fn lists_have_their_length_and_colours_their_sign() {
        assert_eq!(triple("1,-2, 3"), Ok([1.0, -2.0, 3.0]));
        assert!(triple("1,2").is_err() && triple("1,2,3,4").is_err());
        assert_eq!(color("0,0.5,2"), Ok([0.0, 0.5, 2.0]));
        assert!(color("0,-0.5,2").is_err() && color("0,1e60,2").is_err());
        assert_eq!(size("960x540"), Ok([960, 540]));
        for wrong in ["960", "0x9", "9x16385", "9x9x9", "-1x2"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn balls_and_panels_have_a_size() {
        assert_eq!(
            sphere("1,2,3,0.5,4"),
            Ok([1.0, 2.0, 3.0, 0.5, 4.0, 4.0, 4.0])
        );
        assert_eq!(
            sphere("1,2,3,0.5,4,5,6"),
            Ok([1.0, 2.0, 3.0, 0.5, 4.0, 5.0, 6.0])
        );
        assert_eq!(
            rect("0,1,0,1,0,0,0,0,1,7").map(|values| values[8..].to_vec()),
            Ok(vec![1.0, 7.0, 7.0, 7.0])
        );
        for wrong in [
            "1,2,3,0,4",
            "1,2,3,-1,4",
            "1,2,3,4",
            "1,2,3,1,-4",
            "1,2,3,1,4,5",
        ] {
            assert!(sphere(wrong).is_err(), "{wrong}");
        }
        for wrong in [
            "0,1,0,1,0,0,2,0,0,7",
            "0,1,0,1,0,0,0,0,1",
            "0,1,0,1,0,0,0,0,1,-7",
        ] {
            assert!(rect(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_sun_has_a_direction() {
        assert_eq!(sun("0,1,0,2"), Ok([0.0, 1.0, 0.0, 2.0, 2.0, 2.0]));
        assert_eq!(light("0,0,0,2"), Ok([0.0, 0.0, 0.0, 2.0, 2.0, 2.0]));
        assert_eq!(light("1,2,3,4,0,6"), Ok([1.0, 2.0, 3.0, 4.0, 0.0, 6.0]));
        for wrong in [
            "0,0,0,1",
            "1e-200,0,0,1",
            "1e200,0,0,1",
            "0,1,0,-1",
            "0,1,0",
            "0,1,0,1,1",
            "0,1,0,1,-1,1",
        ] {
            assert!(sun(wrong).is_err(), "{wrong}");
        }
    }
}
