//! Options by the names of their flags.

use crate::scene::floats;
use ambake::{
    AmbientCoefficient, Backend, Bake, Bounces, Buried, Choice, Denoise, Engine, Footprint, Layer,
    Light, Model, Pages, Seams, Shading, Sky, Uv, View,
};
use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyString};

/// Every option, as its flag is called with underscores; `for` is a word of Python.
pub const NAMES: [&str; 48] = [
    "size",
    "density",
    "density_of",
    "include",
    "exclude",
    "no_cast",
    "seen_from",
    "pages",
    "one_page_per_mesh",
    "uv",
    "gutter",
    "mips",
    "align",
    "rays",
    "target_error",
    "target_relative",
    "max_rays",
    "footprint",
    "denoise",
    "seams",
    "sky",
    "view",
    "buried",
    "buried_of",
    "under",
    "shading",
    "max_distance",
    "model",
    "bounces",
    "lights",
    "sun",
    "point",
    "sphere",
    "rect",
    "layers",
    "only",
    "to",
    "for_",
    "compress",
    "update",
    "normal_maps",
    "exponent",
    "ambient_coefficient",
    "albedo",
    "specular",
    "seed",
    "backend",
    "threads",
];

/// What happens to what is buried.
const BURIED: [(&str, Buried); 2] = [("drop", Buried::Drop), ("keep", Buried::Keep)];

/// The strength behind so many numbers of a light, grey or in colour.
fn strength(light: &[f64], place: usize, expected: &str) -> PyResult<[f64; 3]> {
    match light.get(place..) {
        Some(&[e]) => Ok([e; 3]),
        Some(&[r, g, b]) => Ok([r, g, b]),
        _ => Err(PyValueError::new_err(format!("each must be {expected}"))),
    }
}

/// Sets the options of a bake. Those that only mean something after `target_error` follow it in [`NAMES`].
///
/// # Errors
/// TypeError for an unknown name or a value of a wrong kind, ValueError for a word or a number that an option cannot
/// have.
pub fn set(mut bake: Bake, options: &Bound<'_, PyDict>) -> PyResult<Bake> {
    for name in options.keys() {
        let name: String = name.extract()?;
        if name != "plan_off" && !NAMES.contains(&name.as_str()) {
            let known = NAMES.join(", ");
            return Err(PyTypeError::new_err(format!(
                "there is no option {name}; there are {known}, plan_off"
            )));
        }
    }
    let given = |name: &str| -> PyResult<Option<Bound<'_, PyAny>>> {
        Ok(options.get_item(name)?.filter(|value| !value.is_none()))
    };
    if given("rays")?.is_some() && given("target_error")?.is_some() {
        return Err(PyValueError::new_err(
            "rays and target_error exclude each other; give one of them",
        ));
    }
    for name in ["target_relative", "max_rays"] {
        if given(name)?.is_some() && given("target_error")?.is_none() {
            let problem = format!("{name} needs target_error beside it");
            return Err(PyValueError::new_err(problem));
        }
    }
    for name in NAMES.into_iter().chain(["plan_off"]) {
        if let Some(value) = given(name)? {
            bake = one(bake, name, &value).map_err(|error| named(options.py(), name, error))?;
        }
    }
    Ok(bake)
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

fn one(mut bake: Bake, name: &str, value: &Bound<'_, PyAny>) -> PyResult<Bake> {
    Ok(match name {
        "size" => bake.size(value.extract()?),
        "density" => match value.cast::<PyString>() {
            Ok(_) => {
                word(value, &[("even", ())])?;
                bake.even_density()
            }
            Err(_) => bake.density(value.extract()?),
        },
        "density_of" => {
            let each: Vec<(String, f64)> = value.cast::<PyDict>()?.items().extract()?;
            each.into_iter()
                .fold(bake, |bake, (name, density)| bake.density_of(name, density))
        }
        "include" => texts(value)?.into_iter().fold(bake, Bake::include),
        "exclude" => texts(value)?.into_iter().fold(bake, Bake::exclude),
        "no_cast" => texts(value)?.into_iter().fold(bake, Bake::no_cast),
        "seen_from" => match value.cast::<PyString>() {
            Ok(_) => {
                word(value, &[("auto", ())])?;
                bake.seen_from_within()
            }
            Err(_) => bake.seen_from(value.extract::<Vec<[f64; 3]>>()?),
        },
        "pages" => bake.pages(match value.cast::<PyString>() {
            Ok(_) => word(value, &[("auto", Pages::Auto)])?,
            Err(_) => Pages::Most(value.extract()?),
        }),
        "one_page_per_mesh" => bake.one_page_per_mesh(value.extract()?),
        "uv" => {
            let words = [
                ("auto", Uv::Auto),
                ("keep", Uv::Keep),
                ("unwrap", Uv::Unwrap),
            ];
            bake.uv(word(value, &words)?)
        }
        "gutter" => bake.gutter(value.extract()?),
        "mips" => bake.mips(value.extract()?),
        "align" => bake.align(value.extract()?),
        "rays" => bake.rays(value.extract()?),
        "target_error" => bake.target_error(value.extract()?),
        "target_relative" => bake.target_relative(value.extract()?),
        "max_rays" => bake.max_rays(value.extract()?),
        "footprint" => {
            let words = [("texel", Footprint::Texel), ("centre", Footprint::Centre)];
            bake.footprint(word(value, &words)?)
        }
        "denoise" => {
            let words = [
                ("off", Denoise::Off),
                ("regression", Denoise::Regression),
                ("oidn", Denoise::Oidn),
            ];
            bake.denoise(word(value, &words)?)
        }
        "seams" => {
            let words = [
                ("off", Seams::Off),
                ("object", Seams::Object),
                ("scene", Seams::Scene),
            ];
            bake.seams(word(value, &words)?)
        }
        "sky" => bake.sky(sky(value)?),
        "view" => bake.view(match value.cast::<PyString>() {
            Ok(_) => word(value, &[("normal", View::Normal)])?,
            Err(_) => View::Eye(value.extract::<[f64; 3]>()?.into()),
        }),
        "buried" => bake.buried(word(value, &BURIED)?),
        "buried_of" => {
            for (name, buried) in value.cast::<PyDict>()?.iter() {
                bake = bake.buried_of(name.extract::<String>()?, word(&buried, &BURIED)?);
            }
            bake
        }
        "shading" => {
            let words = [
                ("production", Shading::Production),
                ("exact", Shading::Exact),
            ];
            bake.shading(word(value, &words)?)
        }
        "under" => bake.under(value.extract()?),
        "max_distance" => bake.max_distance(value.extract()?),
        "model" => bake.model(word(
            value,
            &[("phong", Model::Phong), ("ggx", Model::Ggx)],
        )?),
        "bounces" => bake.bounces(bounces(value)?),
        "sun" | "point" | "sphere" | "rect" => {
            lights(name, value)?.into_iter().fold(bake, Bake::light)
        }
        "lights" => bake.file_lights(word(value, &[("file", true), ("none", false)])?),
        "layers" => bake.layers(layers(value)?),
        "only" => bake.only(layers(value)?),
        "to" => bake.to_vertices(word(value, &[("pages", false), ("vertices", true)])?),
        "for_" => bake.for_engines(engines(value)?),
        "compress" => bake.compress(value.extract()?),
        "update" => bake.update(value.extract::<std::path::PathBuf>()?),
        "normal_maps" => bake.normal_maps(value.extract()?),
        "exponent" => bake.exponent(value.extract()?),
        "ambient_coefficient" => bake.ambient_coefficient(match value.extract() {
            Ok(rgb) => AmbientCoefficient::Rgb(rgb),
            Err(_) => word(
                value,
                &[
                    ("albedo", AmbientCoefficient::Albedo),
                    ("file", AmbientCoefficient::Material),
                ],
            )?,
        }),
        "albedo" => bake.albedo(value.extract()?),
        "specular" => bake.specular(value.extract()?),
        "seed" => bake.seed(value.extract()?),
        "backend" => bake.backend(backend(value)?),
        "threads" => match value.extract()? {
            0 => return Err(PyValueError::new_err("must be at least 1")),
            threads => bake.threads(threads),
        },
        _ => {
            let names = words(value)?;
            let choice = |name: &String| {
                Choice::from_name(name)
                    .ok_or_else(|| PyValueError::new_err(format!("there is no choice {name}")))
            };
            bake.plan_off(names.iter().map(choice).collect::<PyResult<Vec<_>>>()?)
        }
    })
}

/// A polar map as `python/ambake/__init__.py` hands it over: rows of little-endian 32-bit numbers, red, green and blue.
#[derive(FromPyObject)]
struct Pixels<'py> {
    width: usize,
    height: usize,
    pixels: Bound<'py, PyBytes>,
}

/// A uniform sky, the path of a map, or its pixels.
pub fn sky(value: &Bound<'_, PyAny>) -> PyResult<Sky> {
    if let Ok(radiance) = value.extract::<[f32; 3]>() {
        return Ok(Sky::uniform(radiance));
    }
    let sky = match value.extract::<Pixels<'_>>() {
        Ok(map) => Sky::from_pixels(map.width, map.height, floats(&map.pixels)),
        Err(_) => Sky::load(value.extract::<std::path::PathBuf>().map_err(|_| {
            let expected = "(red, green, blue), the path of a map or an array (height, width, 3)";
            PyTypeError::new_err(format!("expected {expected}"))
        })?),
    };
    sky.map_err(|e| PyValueError::new_err(e.to_string()))
}

/// So many bounces, or `auto`.
pub fn bounces(value: &Bound<'_, PyAny>) -> PyResult<Bounces> {
    match value.cast::<PyString>() {
        Ok(_) => word(value, &[("auto", Bounces::Auto)]),
        Err(_) => Ok(match value.extract()? {
            0 => Bounces::Off,
            most => Bounces::Most(most),
        }),
    }
}

/// A ray library.
pub fn backend(value: &Bound<'_, PyAny>) -> PyResult<Backend> {
    let words = [
        ("embree", Backend::Embree),
        ("obvhs", Backend::Obvhs),
        ("obvhs-bvh2", Backend::ObvhsBvh2),
    ];
    word(value, &words)
}

/// The lights of the option `sun`, `point`, `sphere` or `rect`.
pub fn lights(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Light>> {
    let (place, expected) = match name {
        "sphere" => (4, "(x, y, z, radius, l) or (x, y, z, radius, r, g, b)"),
        "rect" => (
            9,
            "a corner (x, y, z), two sides of three numbers each, and l or r, g, b",
        ),
        _ => (3, "(x, y, z, e) or (x, y, z, r, g, b)"),
    };
    let light = |numbers: Vec<f64>| {
        let strength = strength(&numbers, place, expected)?;
        let vector = |k: usize| [numbers[k], numbers[k + 1], numbers[k + 2]];
        Ok(match name {
            "sun" => Light::sun(vector(0), strength),
            "sphere" => Light::sphere(vector(0), numbers[3], strength),
            "rect" => Light::rect(vector(0), [vector(3), vector(6)], strength),
            _ => Light::point(vector(0), strength),
        })
    };
    let each = value.extract::<Vec<Vec<f64>>>()?;
    each.into_iter().map(light).collect()
}

/// The value that a word stands for.
pub fn word<T: Clone>(value: &Bound<'_, PyAny>, words: &[(&str, T)]) -> PyResult<T> {
    let text: String = value.extract()?;
    match words.iter().find(|(word, _)| *word == text) {
        Some((_, meaning)) => Ok(meaning.clone()),
        None => {
            let known: Vec<_> = words.iter().map(|(word, _)| *word).collect();
            let problem = format!("{text:?} is none of {}", known.join(", "));
            Err(PyValueError::new_err(problem))
        }
    }
}

/// One text or several.
fn texts(value: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    match value.cast::<PyString>() {
        Ok(text) => Ok(vec![text.extract()?]),
        Err(_) => value.extract(),
    }
}

/// Words in a list, or in one text with commas between them.
fn words(value: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    match value.cast::<PyString>() {
        Ok(text) => {
            let text: String = text.extract()?;
            Ok(text.split(',').map(|word| word.trim().into()).collect())
        }
        Err(_) => value.extract(),
    }
}

/// The engines of these names.
pub fn engines(value: &Bound<'_, PyAny>) -> PyResult<Vec<Engine>> {
    let engine = |name: &String| {
        Engine::from_name(name).ok_or_else(|| {
            let known: Vec<_> = Engine::all().map(Engine::name).collect();
            let problem = format!(
                "there is no engine {name:?}; there are {}",
                known.join(", ")
            );
            PyValueError::new_err(problem)
        })
    };
    words(value)?.iter().map(engine).collect()
}

fn layers(value: &Bound<'_, PyAny>) -> PyResult<Vec<Layer>> {
    let layer = |name: &String| {
        Layer::from_name(name).ok_or_else(|| {
            let known: Vec<_> = Layer::all().map(Layer::name).collect();
            let problem = format!("there is no layer {name:?}; there are {}", known.join(", "));
            PyValueError::new_err(problem)
        })
    };
    words(value)?.iter().map(layer).collect()
}
