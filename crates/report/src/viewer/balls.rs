//! Probes as the viewer embeds them: white balls in their light.

use super::embed::blob;
use crate::ProbeReport;
use crate::probes::polynomial;
use glam::DVec3;
use serde_json::{Value, json};

/// Most probes that are embedded: some 4 MB.
const MOST: usize = 1 << 15;

/// Radius of a ball as a share of the least edge of a cell, and of the scene where there is no volume.
const OF_CELL: f64 = 0.1;
const OF_SCENE: f64 = 0.015;

/// Probes of the scene, ready to be embedded.
pub struct EmbeddedProbes<'a> {
    report: &'a ProbeReport,
    light: &'a [Vec<DVec3>],
}

impl<'a> EmbeddedProbes<'a> {
    /// The probes of a report, and the light that each is shown with, those that are invalid filled; `None` where there
    /// is none, or more than a page can hold.
    pub fn of(report: &'a ProbeReport, light: &'a [Vec<DVec3>]) -> Option<Self> {
        let count = report.probes.len();
        let is_shown = count == light.len() && (1..=MOST).contains(&count);
        is_shown.then_some(Self { report, light })
    }

    /// What the page must know of them; places count from `origin`.
    pub(super) fn head(&self, origin: DVec3, scene_radius: f64) -> Value {
        let volume = self.report.grid.as_ref().map(|grid| {
            let size = [0, 1, 2].map(|k| grid.cell[k] * f64::from(grid.counts[k]));
            json!({ "low": (DVec3::from(grid.low) - origin).to_array(), "size": size, "counts": grid.counts })
        });
        let cell = self.report.grid.as_ref().map(|grid| {
            let edges = (0..3).filter(|&k| grid.counts[k] > 1).map(|k| grid.cell[k]);
            edges.fold(f64::INFINITY, f64::min)
        });
        let radius = match cell {
            Some(cell) if cell.is_finite() && cell > 0.0 => OF_CELL * cell,
            _ => OF_SCENE * scene_radius,
        };
        json!({ "count": self.report.probes.len(), "volume": volume, "radius": radius })
    }

    /// Places as f32, then the light of each as nine triples of f32, then a byte each, 0 for one that stands in no air.
    pub(super) fn blob(&self, origin: DVec3) -> String {
        let probes = &self.report.probes;
        let places = probes
            .iter()
            .flat_map(|probe| (DVec3::from(probe.position) - origin).to_array());
        let light = self.light.iter().flat_map(|light| polynomial(light));
        let light = light.flat_map(|term| term.to_array());
        let numbers = places.chain(light).flat_map(|v| (v as f32).to_le_bytes());
        let valid = probes.iter().map(|probe| u8::from(!probe.invalid));
        blob(&numbers.chain(valid).collect::<Vec<u8>>())
    }
}
