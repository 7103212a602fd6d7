//! The library's errors as Python's.

use ambake::Error;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

/// The library's line as the exception that fits.
pub fn error(error: Error) -> PyErr {
    match error {
        Error::Output(_) => PyOSError::new_err(error.to_string()),
        Error::Threads(_) => PyRuntimeError::new_err(error.to_string()),
        other => PyValueError::new_err(other.to_string()),
    }
}
