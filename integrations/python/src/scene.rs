//! Scenes from what Python hands over.

use ambake::{Mesh, Scene};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// A mesh in memory: little-endian 32-bit numbers, row by row, as `python/ambake/__init__.py` makes them.
#[derive(FromPyObject)]
pub struct Given<'py> {
    name: String,
    positions: Bound<'py, PyBytes>,
    triangles: Bound<'py, PyBytes>,
    normals: Option<Bound<'py, PyBytes>>,
    uvs: Option<Bound<'py, PyBytes>>,
}

/// The scene of these meshes.
///
/// # Errors
/// ValueError, with the library's own line.
pub fn of(meshes: Vec<Given<'_>>) -> PyResult<Scene> {
    let mesh = |given: Given<'_>| {
        let mut mesh = Mesh::default();
        mesh.name = given.name;
        mesh.positions = floats(&given.positions);
        mesh.triangles = rows(given.triangles.as_bytes(), u32::from_le_bytes);
        mesh.normals = given.normals.as_ref().map(floats).unwrap_or_default();
        mesh.uvs = given.uvs.as_ref().map(floats).unwrap_or_default();
        mesh
    };
    let meshes = meshes.into_iter().map(mesh).collect();
    Scene::from_meshes(meshes, vec![]).map_err(|e| PyValueError::new_err(e.to_string()))
}

/// Rows of little-endian 32-bit floats.
pub fn floats<const N: usize>(bytes: &Bound<'_, PyBytes>) -> Vec<[f32; N]> {
    rows(bytes.as_bytes(), f32::from_le_bytes)
}

fn rows<T: Copy, const N: usize>(bytes: &[u8], number: impl Fn([u8; 4]) -> T) -> Vec<[T; N]> {
    let at = |row: &[u8], k: usize| number(std::array::from_fn(|byte| row[4 * k + byte]));
    let rows = bytes.chunks_exact(4 * N);
    rows.map(|row| std::array::from_fn(|k| at(row, k)))
        .collect()
}
