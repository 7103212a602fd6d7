//! The native half of the Python package `ambake`. Arrays come and go as bytes, `python/ambake/__init__.py` gives them
//! shape; so one wheel serves every Python, whatever its numpy.
#![forbid(unsafe_code)]

mod baked;
mod error;
mod options;
mod probes;
mod run;
mod scene;

use pyo3::prelude::*;

/// ambake as Python imports it.
#[pymodule]
fn _ambake(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", ambake::VERSION)?;
    module.add("LAYERS", baked::layer_names())?;
    module.add("OPTIONS", options::names())?;
    module.add_class::<baked::Baked>()?;
    module.add_function(wrap_pyfunction!(run::bake_meshes, module)?)?;
    module.add_class::<probes::Probes>()?;
    module.add_function(wrap_pyfunction!(run::bake_file, module)?)?;
    module.add_function(wrap_pyfunction!(run::probes_file, module)?)
}
