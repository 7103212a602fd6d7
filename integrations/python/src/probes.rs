//! Probes as Python asks for them and sees them.

use crate::error::error;
use crate::options;
use ambake::{Light, Places, ProbeOptions, ProbeRecord, Scene};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyDict};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// Every option, as its flag is called with underscores.
const NAMES: [&str; 22] = [
    "at",
    "grid",
    "spacing",
    "within",
    "bake",
    "sky",
    "lights",
    "sun",
    "point",
    "sphere",
    "rect",
    "bounces",
    "max_distance",
    "rays",
    "target_error",
    "max_rays",
    "refine",
    "order",
    "window",
    "tried",
    "seed",
    "backend",
];

/// What the options ask for.
///
/// # Errors
/// TypeError for an unknown name or a value of a wrong kind, ValueError for a value that an option cannot have.
pub fn asked(scene: &Scene, given: &Bound<'_, PyDict>) -> PyResult<(Places, ProbeOptions)> {
    let (mut places, mut options) = (Vec::new(), ProbeOptions::default());
    let mut lights: Option<Vec<Light>> = None;
    for (name, value) in given.iter() {
        let name: String = name.extract()?;
        if !NAMES.contains(&name.as_str()) {
            let problem = format!("there is no option {name}; there are {}", NAMES.join(", "));
            return Err(PyTypeError::new_err(problem));
        }
        if !value.is_none() {
            one(&name, &value, scene, &mut places, &mut options, &mut lights)
                .map_err(|error| options::named(given.py(), &name, error))?;
        }
    }
    options.lights = lights;
    match <[Places; 1]>::try_from(places) {
        Ok([places]) => Ok((places, options)),
        Err(_) => Err(PyValueError::new_err("give one of at, grid and spacing")),
    }
}

fn one(
    name: &str,
    value: &Bound<'_, PyAny>,
    scene: &Scene,
    places: &mut Vec<Places>,
    options: &mut ProbeOptions,
    lights: &mut Option<Vec<Light>>,
) -> PyResult<()> {
    match name {
        "at" => places.push(Places::At(value.extract()?)),
        "grid" => places.push(Places::Grid(value.extract()?)),
        "spacing" => places.push(Places::Spacing(value.extract()?)),
        "within" => {
            let [a, b]: [[f64; 3]; 2] = value.extract()?;
            let corner = |of: fn(f64, f64) -> f64| [0, 1, 2].map(|k| of(a[k], b[k]));
            options.within = Some([corner(f64::min), corner(f64::max)]);
        }
        "bake" => options.bake = Some(value.extract()?),
        "sky" => options.sky = Some(options::sky(value)?),
        "lights" => {
            let own = lights.get_or_insert_default();
            if options::word(value, &[("file", true), ("none", false)])? {
                own.extend(scene.lights.iter().map(Light::from));
            }
        }
        "sun" | "point" | "sphere" | "rect" => {
            lights
                .get_or_insert_default()
                .extend(options::lights(name, value)?);
        }
        "bounces" => options.bounces = options::bounces(value)?,
        "max_distance" => options.max_distance = Some(value.extract()?),
        "rays" => options.rays = value.extract()?,
        "target_error" => options.target_error = Some(value.extract()?),
        "max_rays" => options.max_rays = value.extract()?,
        "refine" => options.refine = value.extract()?,
        "order" => options.order = value.extract()?,
        "window" => options.window = value.extract()?,
        "tried" => options.tried = value.extract()?,
        "seed" => options.seed = value.extract()?,
        _ => options.backend = options::backend(value)?,
    }
    Ok(())
}

/// Probes of a scene.
#[pyclass(frozen, module = "ambake._ambake")]
pub struct Probes(Mutex<ambake::Probes>);

impl Probes {
    pub fn new(probes: ambake::Probes) -> Self {
        Self(Mutex::new(probes))
    }

    /// Numbers of each probe as bytes.
    fn bytes<'py, const N: usize>(
        &self,
        py: Python<'py>,
        of: impl Fn(&ProbeRecord) -> Vec<[u8; N]>,
    ) -> Bound<'py, PyByteArray> {
        let probes = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let numbers = probes.report().probes.iter().flat_map(of);
        PyByteArray::new(py, &numbers.flatten().collect::<Vec<u8>>())
    }
}

#[pymethods]
impl Probes {
    /// Along x, y and z: of a volume the corner with the least coordinates, the edges of a cell and their number.
    #[getter]
    fn grid(&self) -> Option<([f64; 3], [f64; 3], [u32; 3])> {
        let probes = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let grid = probes.report().grid.as_ref()?;
        Some((grid.low, grid.cell, grid.counts))
    }

    /// Places, as 64-bit floats.
    fn positions<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        self.bytes(py, |probe| probe.position.map(f64::to_le_bytes).to_vec())
    }

    /// Coefficients, as 32-bit floats.
    fn sh<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        self.bytes(py, |probe| floats(&probe.sh))
    }

    /// Their standard errors.
    fn std_err<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        self.bytes(py, |probe| floats(&probe.std_err))
    }

    /// Shares of directions that meet no back, as 32-bit floats.
    fn validity<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        self.bytes(py, |probe| vec![probe.validity.to_le_bytes()])
    }

    /// A byte each, 1 where a probe stands in no air.
    fn invalid<'py>(&self, py: Python<'py>) -> Bound<'py, PyByteArray> {
        self.bytes(py, |probe| vec![[u8::from(probe.invalid)]])
    }

    /// Writes what the command line writes; the files.
    fn write(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        engines: &Bound<'_, PyAny>,
    ) -> PyResult<Vec<PathBuf>> {
        let engines = options::engines(engines)?;
        py.detach(|| {
            let mut probes = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            probes.write(folder, &engines).map_err(error)
        })
    }
}

fn floats(values: &[[f32; 3]]) -> Vec<[u8; 4]> {
    values
        .as_flattened()
        .iter()
        .map(|v| v.to_le_bytes())
        .collect()
}
