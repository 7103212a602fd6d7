//! Options by the names of their flags: keyword arguments become words of the command line, which one parser reads.

use crate::error::error;
use crate::scene::floats;
use ambake::flags::keywords::{Keyword, Kind, keywords, parsed, problem};
use ambake::flags::{self, values};
use ambake::{Bake, Engine, Places, ProbeOptions, Scene, Sky};
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyString};
use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

/// Every option of a bake, as its flag is called with underscores; `for` is a word of Python.
pub fn names() -> Vec<String> {
    shown(&keywords::<flags::Bake>())
}

fn shown(keywords: &[Keyword]) -> Vec<String> {
    let shown = keywords.iter().filter(|keyword| !keyword.is_hidden);
    shown.map(|keyword| keyword.name.clone()).collect()
}

/// The bake that is asked for.
///
/// # Errors
/// TypeError for an unknown name or a value of a wrong kind, ValueError for a word or a number that an option cannot
/// have.
pub fn bake(scene: &Scene, given: &Bound<'_, PyDict>) -> PyResult<Bake> {
    let (asked, sky) = asked::<flags::Bake>(given)?;
    let bake = asked
        .bake(scene)
        .map_err(|of| named(given.py(), "sky", error(of)))?;
    Ok(match sky {
        Some(sky) => bake.sky(sky),
        None => bake,
    })
}

/// The probes that are asked for, and their number of threads.
///
/// # Errors
/// As [`bake`].
pub fn probes(scene: &Scene, given: &Bound<'_, PyDict>) -> PyResult<(Places, ProbeOptions, usize)> {
    let (asked, sky) = asked::<flags::Probes>(given)?;
    let options = asked.job.options(scene, asked.common.seed);
    let mut options = options.map_err(|of| named(given.py(), "sky", error(of)))?;
    options.sky = sky.or(options.sky);
    let threads = asked.common.threads.unwrap_or_default() as usize;
    Ok((asked.job.places(), options, threads))
}

/// What a table of flags reads from the keyword arguments, and a sky of pixels, which no flag can say.
fn asked<T: flags::Parser>(given: &Bound<'_, PyDict>) -> PyResult<(T, Option<Sky>)> {
    let keywords = keywords::<T>();
    let (mut said, mut sky) = (Vec::new(), None);
    for (name, value) in given.iter() {
        let name: String = name.extract()?;
        let Some(keyword) = keywords.iter().find(|keyword| keyword.name == name) else {
            let known = shown(&keywords).join(", ");
            let problem = format!("there is no option {name}; there are {known}");
            return Err(PyTypeError::new_err(problem));
        };
        let is_sky = name == "sky";
        let read = || match is_sky.then(|| pixels(&value)).transpose()?.flatten() {
            Some(pixels) => Ok((Vec::new(), Some(pixels))),
            None => Ok((words(keyword, &value)?, None)),
        };
        if !value.is_none() {
            let (words, pixels) = read().map_err(|error| named(given.py(), &name, error))?;
            said.extend(words);
            sky = sky.or(pixels);
        }
    }
    Ok((parsed(&said).map_err(PyValueError::new_err)?, sky))
}

/// The error of a value that cannot be converted, with the name of the option before it.
pub fn named(py: Python<'_>, name: &str, error: PyErr) -> PyErr {
    let problem = match error.is_instance_of::<PyOverflowError>(py) {
        true => "below 0 or too large".into(),
        false => error.value(py).to_string(),
    };
    let text = format!("{name}: {problem}");
    match error.is_instance_of::<PyTypeError>(py) {
        true => PyTypeError::new_err(text),
        false => PyValueError::new_err(text),
    }
}

/// The words of the command line for a value.
fn words(keyword: &Keyword, value: &Bound<'_, PyAny>) -> PyResult<Vec<OsString>> {
    let said: OsString = match keyword.kind {
        Kind::Switch if !value.extract::<bool>()? => return Ok(Vec::new()),
        Kind::Switch => OsString::new(),
        Kind::Whole => value.extract::<u64>()?.to_string().into(),
        Kind::Number => value.extract::<f64>()?.to_string().into(),
        Kind::Path => value.extract::<PathBuf>()?.into(),
        Kind::Word(_) => value.extract::<String>()?.into(),
        Kind::Text(_) => match (value.cast::<PyDict>(), value.cast::<PyString>()) {
            (Ok(each), _) => {
                let word = |(name, value): (String, Bound<'_, PyAny>)| {
                    Ok(keyword.with(format!("{name}={}", text(&value)?.display())))
                };
                let each: Vec<(String, Bound<'_, PyAny>)> = each.items().extract()?;
                return each.into_iter().map(word).collect();
            }
            (_, Ok(list)) if keyword.is_list => {
                let list: String = list.extract()?;
                let each: Vec<_> = list.split(',').map(str::trim).collect();
                each.join(",").into()
            }
            (_, Err(_)) if keyword.repeats && value.try_iter().is_ok() => {
                let words = value.try_iter()?;
                let words = words.map(|item| Ok(keyword.with(text(&item?)?)));
                let words: Vec<OsString> = words.collect::<PyResult<_>>()?;
                // Nothing in particular, unlike nothing said: what every page has.
                return Ok(match (&*keyword.name, words.is_empty()) {
                    ("only", true) => vec![keyword.with("coverage")],
                    _ => words,
                });
            }
            _ => text(value)?,
        },
    };
    Ok(vec![keyword.with(said)])
}

/// A value as flags say it: text, a path, a number, several of them between commas, several such between colons.
fn text(value: &Bound<'_, PyAny>) -> PyResult<OsString> {
    if let Ok(path) = value.extract::<PathBuf>() {
        return Ok(path.into());
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(number.to_string().into());
    }
    let items: Vec<Bound<'_, PyAny>> = value.try_iter()?.collect::<PyResult<_>>()?;
    let is_flat = |item: &Bound<'_, PyAny>| item.extract::<f64>().is_ok();
    let between = if items.iter().all(is_flat) { "," } else { ":" };
    let items: Vec<OsString> = items.iter().map(text).collect::<PyResult<_>>()?;
    Ok(items.join(OsStr::new(between)))
}

/// A polar map as `python/ambake/__init__.py` hands it over: rows of little-endian 32-bit numbers, red, green and blue.
#[derive(FromPyObject)]
struct Pixels<'py> {
    width: usize,
    height: usize,
    pixels: Bound<'py, PyBytes>,
}

fn pixels(value: &Bound<'_, PyAny>) -> PyResult<Option<Sky>> {
    if value.extract::<f64>().is_ok() {
        let expected = "(red, green, blue), the path of a map or an array (height, width, 3)";
        return Err(PyTypeError::new_err(format!("expected {expected}")));
    }
    let Ok(map) = value.extract::<Pixels<'_>>() else {
        return Ok(None);
    };
    let sky = Sky::from_pixels(map.width, map.height, floats(&map.pixels));
    sky.map(Some)
        .map_err(|e| PyValueError::new_err(e.to_string()))
}

/// The engines of these names, in a list or in one text with commas between them.
pub fn engines(value: &Bound<'_, PyAny>) -> PyResult<Vec<Engine>> {
    let names: Vec<String> = match value.cast::<PyString>() {
        Ok(text) => text
            .extract::<String>()?
            .split(',')
            .map(|name| name.trim().into())
            .collect(),
        Err(_) => value.extract()?,
    };
    let engine = |name: &String| {
        values::engine(name).map_err(|of| PyValueError::new_err(problem(name, &of)))
    };
    names.iter().map(engine).collect()
}
