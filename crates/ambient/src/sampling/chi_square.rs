//! A chi-square test of a sampler against its own pdf.

use super::stream::mix;
use glam::DVec3;
use std::f64::consts::TAU;

const RINGS: usize = 12;
const SECTORS: usize = 8;
const SAMPLES: u32 = 200_000;

/// Compares a histogram of 200,000 independent directions with the integral of the pdf over each cell.
///
/// Cells are rings of equal steps in sin θ up to `edge`, cut into sectors; what lies outside is one more cell.
pub(super) fn check(edge: f64, sample: impl Fn([f64; 2]) -> DVec3, pdf: impl Fn(DVec3) -> f64) {
    let mut counts = [0.0; RINGS * SECTORS + 1];
    for i in 0..u64::from(SAMPLES) {
        let [u, v] = [2 * i, 2 * i + 1].map(|k| (mix(k) >> 11) as f64 + 0.5);
        let scale = 0.5_f64.powi(53);
        counts[cell(sample([u * scale, v * scale]), edge)] += 1.0;
    }
    // Integral of the pdf over a ring and sector in (sin θ, φ): dω = s ds dφ / cos θ, s = edge · sin t tames the
    // horizon.
    let mut expected = [0.0; RINGS * SECTORS + 1];
    for ring in 0..RINGS {
        let bounds = [ring, ring + 1].map(|r| (r as f64 / RINGS as f64).asin());
        let steps = 400;
        let dt = (bounds[1] - bounds[0]) / f64::from(steps);
        for k in 0..steps {
            let t = bounds[0] + (f64::from(k) + 0.5) * dt;
            let s = edge * t.sin();
            let z = ((1.0 - s) * (1.0 + s)).sqrt();
            let strip = s / z * edge * t.cos() * dt * TAU / SECTORS as f64;
            for sector in 0..SECTORS {
                let (y, x) = ((sector as f64 + 0.5) / SECTORS as f64 * TAU).sin_cos();
                let p = pdf(DVec3::new(s * x, s * y, z));
                expected[ring * SECTORS + sector] += p * strip * f64::from(SAMPLES);
            }
        }
    }
    let inside: f64 = expected.iter().sum();
    expected[RINGS * SECTORS] = f64::from(SAMPLES) - inside;

    let (mut chi2, mut cells, mut rest) = (0.0, 0, [0.0; 2]);
    for (&n, &e) in counts.iter().zip(&expected) {
        if e < 10.0 {
            rest = [rest[0] + n, rest[1] + e];
        } else {
            chi2 += (n - e) * (n - e) / e;
            cells += 1;
        }
    }
    if rest[1] >= 10.0 {
        chi2 += (rest[0] - rest[1]).powi(2) / rest[1];
        cells += 1;
    }
    // Wilson and Hilferty's normal form; a fair sampler exceeds 4.75 once in a million.
    let dof = f64::from(cells - 1);
    let spread = 2.0 / (9.0 * dof);
    let z = ((chi2 / dof).cbrt() - (1.0 - spread)) / spread.sqrt();
    assert!(z < 4.75, "chi² {chi2} for {dof} degrees of freedom, z {z}");
}

fn cell(d: DVec3, edge: f64) -> usize {
    let ring = (d.truncate().length() / edge * RINGS as f64) as usize;
    if ring >= RINGS {
        return if edge >= 1.0 {
            RINGS * SECTORS - 1
        } else {
            RINGS * SECTORS
        };
    }
    let turns = d.y.atan2(d.x) / TAU;
    let sector = (turns.rem_euclid(1.0) * SECTORS as f64) as usize;
    ring * SECTORS + sector.min(SECTORS - 1)
}
