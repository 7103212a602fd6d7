//! The values of flags, as they are typed.

use super::parse::{color, number, positive, triple};
use crate::parts::Shard;
pub use crate::words::Words;
use ::bake::{AmbientCoefficient, Bounces, Buried, Choice, View};
use atlas::Pages;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use layers::Layer;
use report::Engine;

/// The value that a word stands for.
pub fn word<T: Words>() -> impl TypedValueParser<Value = T> {
    let known = T::ALL.iter().map(|(word, _, help)| match *help {
        "" => PossibleValue::new(*word),
        help => PossibleValue::new(*word).help(help),
    });
    PossibleValuesParser::new(known.collect::<Vec<_>>()).try_map(|word| meaning(&word))
}

fn meaning<T: Words>(word: &str) -> Result<T, String> {
    let found = T::ALL.iter().find(|(known, ..)| *known == word);
    let found = found.map(|(_, value, _)| *value);
    found.ok_or_else(|| format!("invalid variant: {word}"))
}

/// One of two words, and whether it is `yes`.
pub fn either(words: [&'static str; 2], yes: &'static str) -> impl TypedValueParser<Value = bool> {
    PossibleValuesParser::new(words).map(move |word| word == yes)
}

pub fn density_of(text: &str) -> Result<(String, f64), String> {
    // A name may hold the sign too.
    let (name, density) = text
        .rsplit_once('=')
        .ok_or("expected NAME=D, such as `wall*=20`")?;
    Ok((name.into(), positive(density)?))
}

pub fn buried_of(text: &str) -> Result<(String, Buried), String> {
    let (name, word) = text
        .rsplit_once('=')
        .ok_or("expected NAME=drop or NAME=keep, such as `wall*=keep`")?;
    Ok((name.into(), meaning(word)?))
}

/// What `--density` asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Density {
    /// Texels per scene unit.
    Of(f64),
    /// One for all.
    Even,
}

pub fn density(text: &str) -> Result<Density, String> {
    match text {
        "even" => Ok(Density::Even),
        _ => positive(text).map(Density::Of),
    }
}

/// What `--seen-from` asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum Eyes {
    /// Wherever people stand in rooms.
    Within,
    /// These places.
    At(Vec<[f64; 3]>),
}

/// `auto`, an eye point, or 27 of a box: corners, middles of edges and faces, and the centre.
pub fn eyes(text: &str) -> Result<Eyes, String> {
    if text == "auto" {
        return Ok(Eyes::Within);
    }
    let Some((low, high)) = text.split_once(':') else {
        return Ok(Eyes::At(vec![triple(text)?]));
    };
    let (low, high) = (triple(low)?, triple(high)?);
    let at = |k: usize, axis: usize| low[axis] + (high[axis] - low[axis]) * 0.5 * k as f64;
    let point = |k: usize| [at(k % 3, 0), at(k / 3 % 3, 1), at(k / 9, 2)];
    Ok(Eyes::At((0..27).map(point).collect()))
}

/// A number of bytes: `8G`, `512M`, `1.5GiB`; without a unit, bytes. Units are powers of 1024.
pub fn memory(text: &str) -> Result<u64, String> {
    let digits = text.find(|c: char| c.is_ascii_alphabetic());
    let (value, unit) = text.split_at(digits.unwrap_or(text.len()));
    let power = match unit
        .to_ascii_uppercase()
        .trim_end_matches('B')
        .trim_end_matches('I')
    {
        "" => 0,
        "K" => 1,
        "M" => 2,
        "G" => 3,
        "T" => 4,
        _ => return Err("expected a size such as 8G or 512M".into()),
    };
    let bytes = positive(value.trim())? * 1024f64.powi(power);
    match bytes {
        1.0..1e18 => Ok(bytes as u64),
        _ => Err("expected a size such as 8G or 512M".into()),
    }
}

/// Parts of a bake at most.
const MAX_SHARDS: u32 = 100_000;

pub fn shard(text: &str) -> Result<Shard, String> {
    let number = |text: &str| text.parse::<u32>().ok();
    let shard = text.split_once('/').map(|(i, n)| (number(i), number(n)));
    match shard {
        Some((Some(index), Some(of))) if (1..=of).contains(&index) && of <= MAX_SHARDS => {
            Ok(Shard { index, of })
        }
        _ => Err(format!(
            "expected I/N with I from 1 to N, such as 2/4, and N at most {MAX_SHARDS}"
        )),
    }
}

pub fn pages(text: &str) -> Result<Pages, String> {
    match text.parse() {
        _ if text == "auto" => Ok(Pages::Auto),
        Ok(pages) if pages > 0 => Ok(Pages::Most(pages)),
        _ => Err("expected auto or a number of pages from 1".into()),
    }
}

/// `auto`, or how often light bounces.
pub fn bounces(text: &str) -> Result<Bounces, String> {
    match text.parse() {
        _ if text == "auto" => Ok(Bounces::Auto),
        Ok(0) => Ok(Bounces::Off),
        Ok(gathers) if gathers <= 1000 => Ok(Bounces::Most(gathers)),
        _ => Err("expected auto or a number of gathers from 0 to 1000".into()),
    }
}

pub fn coefficient(text: &str) -> Result<AmbientCoefficient, String> {
    match text {
        "file" => Ok(AmbientCoefficient::Material),
        "albedo" => Ok(AmbientCoefficient::Albedo),
        _ => color(text)
            .map(AmbientCoefficient::Rgb)
            .map_err(|e| format!("expected `albedo`, `file` or R,G,B: {e}")),
    }
}

pub fn target_error(text: &str) -> Result<f64, String> {
    match number(text)? {
        value if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("must be above 0 and below 1".into()),
    }
}

pub fn view(text: &str) -> Result<View, String> {
    if text == "normal" {
        return Ok(View::Normal);
    }
    triple(text)
        .map(|eye| View::Eye(eye.into()))
        .map_err(|e| format!("expected `normal` or X,Y,Z: {e}"))
}

pub fn layer(text: &str) -> Result<Layer, String> {
    let found = Layer::from_name(text);
    named("layer", found, Layer::all().map(Layer::name))
}

/// An engine by its name.
pub fn engine(text: &str) -> Result<Engine, String> {
    let found = Engine::from_name(text);
    named("engine", found, Engine::all().map(Engine::name))
}

pub fn choice(text: &str) -> Result<Choice, String> {
    let names = Choice::ALL.iter().map(|choice| choice.name());
    named("choice", Choice::from_name(text), names)
}

/// What was found under a name, or all names that there are.
pub fn named<T>(
    what: &str,
    found: Option<T>,
    names: impl Iterator<Item = &'static str>,
) -> Result<T, String> {
    found.ok_or_else(|| {
        let names: Vec<_> = names.collect();
        format!("unknown {what}; there are {}", names.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_has_a_unit_or_none() {
        assert_eq!(memory("8G"), Ok(8 << 30));
        assert_eq!(memory("1.5GiB"), Ok(3 << 29));
        assert_eq!(memory("512m"), Ok(512 << 20));
        assert_eq!(memory("4096"), Ok(4096));
        for wrong in ["", "G", "-1G", "0", "8X", "1e30G", "nan", "8 G G"] {
            assert!(memory(wrong).is_err(), "{wrong}");
        }
    }
}
