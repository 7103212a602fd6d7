//! A finished volume, looked up as engines do.

use super::mean;
use crate::error::Error;
use ::probes::{Grid, fill};
use glam::{DVec3, UVec3};
use report::ProbeReport;
use std::path::Path;

/// The light of a volume of probes at any place: linear interpolation between the eight around it.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbeVolume {
    grid: Grid,
    light: Vec<Vec<DVec3>>,
}

impl ProbeVolume {
    /// That of a report, invalid probes filled from their neighbours; `None` for one of single places.
    pub fn of(report: &ProbeReport) -> Option<Self> {
        let grid = report.grid.as_ref()?;
        let grid = Grid {
            low: grid.low.into(),
            cell: grid.cell.into(),
            counts: UVec3::from(grid.counts),
        };
        if grid.is_empty() || grid.len() != report.probes.len() as u64 {
            return None;
        }
        let mut light: Vec<Vec<DVec3>> = report.lights().collect();
        let valid: Vec<bool> = report.probes.iter().map(|probe| !probe.invalid).collect();
        fill(&grid, &mut light, &valid, mean);
        Some(Self { grid, light })
    }

    /// That of a file `STEM.probes.json`.
    ///
    /// # Errors
    /// The file cannot be read, or holds single places.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let report = report::read_probes(path)?;
        Self::of(&report).ok_or_else(|| {
            let problem = format!(
                "{} holds single places; make a volume with --spacing or --grid",
                path.display()
            );
            Error::option("--probes", problem)
        })
    }

    /// Coefficients of the light of each probe, invalid ones filled.
    pub fn probes(&self) -> &[Vec<DVec3>] {
        &self.light
    }

    /// Coefficients of the light at a place of the scene, linear RGB. Beyond the outermost probes it is theirs.
    pub fn light(&self, place: [f64; 3]) -> Vec<DVec3> {
        let mut sum = vec![DVec3::ZERO; self.light[0].len()];
        for (probe, weight) in self.grid.taps(place.into()) {
            for (sum, value) in sum.iter_mut().zip(&self.light[probe]) {
                *sum += weight * *value;
            }
        }
        sum
    }
}
