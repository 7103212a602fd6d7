//! Words of the command line to values, for every verb. Errors say what belongs there; clap names the flag.

use glam::DVec3;

/// A finite number.
pub fn number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{text}` is not a finite number")),
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
    let numbers: Vec<f64> = text.split(',').map(number).collect::<Result<_, _>>()?;
    let values = match *numbers.as_slice() {
        [x, y, z, e] => [x, y, z, e, e, e],
        [x, y, z, r, g, b] => [x, y, z, r, g, b],
        _ => return Err("expected four numbers separated by commas, or six with a colour".into()),
    };
    match values[3..].iter().any(|strength| *strength < 0.0) {
        true => Err("what follows X,Y,Z must be 0 or above".into()),
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
