//! Probes as Python sees them.

use crate::error::error;
use crate::options;
use ambake::ProbeRecord;
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

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
