//! A finished bake as Python sees it.

use crate::error::error;
use ambake::{Layer, Page};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use std::path::PathBuf;

/// The names of all layers with the suffixes of their channels.
pub fn layer_names() -> Vec<(&'static str, Vec<&'static str>)> {
    let row = |layer: Layer| (layer.name(), layer.channels().to_vec());
    Layer::all().map(row).collect()
}

/// A finished bake.
#[pyclass(frozen, module = "ambake._ambake")]
pub struct Baked(pub ambake::Baked);

/// An object: its name, whether it is mirrored, then as bytes the numbers of its triangles (u32), their pages (u32),
/// and their corners' coordinates on the page (f32) and in the scene (f64).
type ObjectBytes<'py> = (String, bool, [Bound<'py, PyByteArray>; 4]);

#[pymethods]
impl Baked {
    /// Edge of the pages in texels.
    #[getter]
    fn size(&self) -> u32 {
        self.0.page(0).size()
    }

    /// For each layer its name and, page by page, its values as bytes of 32-bit floats: rows of texels of channels.
    fn layers<'py>(&self, py: Python<'py>) -> Vec<(&'static str, Vec<Bound<'py, PyByteArray>>)> {
        let layers = self.0.page(0).layers();
        let of = |layer: Layer| {
            let pages = self.0.pages();
            let bytes = pages.map(|page| PyByteArray::new(py, &interleaved(page, layer)));
            (layer.name(), bytes.collect())
        };
        layers.map(of).collect()
    }

    /// The objects that took texels.
    fn objects<'py>(&self, py: Python<'py>) -> Vec<ObjectBytes<'py>> {
        let bytes = |bytes: Vec<u8>| PyByteArray::new(py, &bytes);
        let numbers = |values: &[u32]| bytes(values.iter().flat_map(|v| v.to_le_bytes()).collect());
        let (scene, atlas) = (self.0.job().scene(), self.0.job().atlas());
        let placed = scene.instances.iter().zip(&atlas.placements);
        let placed = placed.filter(|(_, placement)| placement.is_somewhere());
        let rows = self.0.objects().zip(placed).map(|(object, (instance, _))| {
            let (mesh, place) = (&scene.meshes[instance.mesh as usize], instance.transform);
            let corners = mesh.triangles.as_flattened().iter();
            let corners = corners.flat_map(|&v| {
                let at = place.transform_point3(mesh.positions[v as usize].as_dvec3());
                at.to_array().map(f64::to_le_bytes).concat()
            });
            let uvs = object.uvs.as_flattened().as_flattened().iter();
            let parts = [
                numbers(&object.triangles),
                numbers(&object.pages),
                bytes(uvs.flat_map(|v| v.to_le_bytes()).collect()),
                bytes(corners.collect()),
            ];
            (object.name, place.matrix3.determinant() < 0.0, parts)
        });
        rows.collect()
    }

    /// For each page (texels, rays, root mean square error of diffuse).
    fn stats(&self) -> Vec<(u64, u64, f64)> {
        let row = |page: &Page| {
            let stats = page.stats();
            (stats.texels, stats.rays, stats.rmse())
        };
        self.0.pages().map(row).collect()
    }

    /// What was repaired, ignored or is doubtful, a sentence each.
    fn warnings(&self) -> Vec<String> {
        let warnings = self.0.job().warnings();
        warnings.into_iter().map(|w| w.message).collect()
    }

    /// Writes what the command line writes into a folder; the files.
    fn write(&self, py: Python<'_>, folder: PathBuf) -> PyResult<Vec<PathBuf>> {
        py.detach(|| self.0.write(folder)).map_err(error)
    }

    /// Writes the scene with lightmap coordinates and occlusion as a GLB file.
    fn write_gltf(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.0.write_gltf(path)).map_err(error)
    }
}

fn interleaved(page: &Page, layer: Layer) -> Vec<u8> {
    let values = page.layer(layer);
    let channels = layer.channels().len();
    let texels = values.len() / channels;
    let mut bytes = Vec::with_capacity(4 * values.len());
    for texel in 0..texels {
        for channel in 0..channels {
            bytes.extend_from_slice(&values[channel * texels + texel].to_le_bytes());
        }
    }
    bytes
}
