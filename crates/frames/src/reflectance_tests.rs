//! Reflectance by incidence and colour: the weights and the tables that section 9 of the 1984 text asks for.

use super::*;
use crate::tests::{LOOKUPS, buffer, polar};
use environment::{Image, Projection};
use maps::{Normalise, Reflectance};
use render::Weight;

/// Fresnel's share of unpolarised light that a surface of refractive index n + ik mirrors at a cosine (M. Born, E.
/// Wolf, "Principles of Optics", sections 1.5.2 and 14.2).
fn fresnel(n: f64, k: f64, cosine: f64) -> f64 {
    let sine2 = 1.0 - cosine * cosine;
    let real = n * n - k * k - sine2;
    let length = (real * real + 4.0 * n * n * k * k).sqrt();
    let a = (0.5 * (length + real)).max(0.0).sqrt();
    let across = (length + cosine * cosine - 2.0 * a * cosine)
        / (length + cosine * cosine + 2.0 * a * cosine);
    let square = length * cosine * cosine + sine2 * sine2;
    let cross = 2.0 * a * cosine * sine2;
    0.5 * across * (1.0 + (square - cross) / (square + cross))
}

#[test]
fn the_oracle_is_right_where_fresnel_is_known() {
    let close = |found: f64, exact: f64| assert!((found - exact).abs() < 1e-14, "{found} {exact}");
    close(fresnel(1.5, 0.0, 1.0), 0.04);
    close(fresnel(1.5, 0.0, 0.0), 1.0);
    // ((n − 1)² + k²) / ((n + 1)² + k²).
    close(fresnel(0.25, 3.0, 1.0), (0.5625 + 9.0) / (1.5625 + 9.0));
    // At Brewster's angle the parallel part is 0, and the other ((n² − 1) / (n² + 1))².
    let brewster = 1.5f64.atan().cos();
    close(fresnel(1.5, 0.0, brewster), 0.5 * (1.25f64 / 3.25).powi(2));
}

#[test]
fn a_mirror_of_glass_and_one_of_gold_show_fresnels_share() {
    let sky = Table::new(&polar(64, |_| [1.0; 3])).unwrap();
    // About those of gold for red, green and blue.
    let gold = [[0.18, 3.4], [0.42, 2.35], [1.37, 1.77]];
    for indices in [[[1.5, 0.0]; 3], gold] {
        // A line for each hundredth of the cosine.
        let mut text = String::from("cosine red green blue\n");
        for line in 0..=100 {
            let cosine = f64::from(line) / 100.0;
            let [r, g, b] = indices.map(|[n, k]| fresnel(n, k, cosine));
            text += &format!("{cosine} {r} {g} {b}\n");
        }
        let mirror = Shader {
            specular_weight: Weight::parse(&text).unwrap(),
            ..Shader::of(None, Some(&sky))
        };
        // What is linear between two lines is off by at most an eighth of what three neighbours are bent by.
        let bend = |[n, k]: [f64; 2], cosine: f64| {
            let f = |c: f64| fresnel(n, k, c.clamp(0.0, 1.0));
            let at = cosine.clamp(0.01, 0.99);
            (f(at - 0.01) - 2.0 * f(at) + f(at + 0.01)).abs()
        };
        for step in 0..1000 {
            let cosine = (f64::from(step) + 0.5) / 1000.0;
            let view = [(1.0 - cosine * cosine).sqrt() as f32, 0.0, cosine as f32];
            let found = mirror.point([0.0, 0.0, 1.0], view, [[0.0; 3], [1.0; 3]]);
            for c in 0..3 {
                let exact = fresnel(indices[c][0], indices[c][1], cosine);
                let bound = 0.25 * bend(indices[c], cosine) + 1e-6;
                let error = (f64::from(found[c]) - exact).abs();
                assert!(error < bound, "{cosine} {c}: {error} of {exact}, {bound}");
            }
        }
    }
}

#[test]
fn a_weight_of_one_and_equal_tables_change_nothing() {
    let map = polar(64, |[x, y, z]| [1.0 + x as f32, 1.0 + (y * z) as f32, 2.0]);
    let (d, s) = (Table::new(&map).unwrap(), Table::new(&map).unwrap());
    let plain = Shader::of(Some(&d), Some(&s));
    let one = Weight::parse("degrees red green blue\n0 1 1 1\n50 1 1 1\n90 1 1 1\n").unwrap();
    let weighted = Shader {
        diffuse_weight: one.clone(),
        specular_weight: one,
        ..plain.clone()
    };
    let by_incidence = Shader {
        specular: None,
        glosses: vec![(0.0, vec![&s; 4])],
        incidences: vec![0.0, 0.25, 0.5, 1.0],
        ..plain.clone()
    };
    let (_, buffer) = buffer(60, 2);
    let picture = |shader: &Shader<'_>, lookup| {
        let mut picture = Image::filled(60, 60, [0.0; 3]);
        shader.frame(&buffer, lookup, &mut picture);
        picture
    };
    for lookup in LOOKUPS {
        let exact = picture(&plain, lookup);
        assert_eq!(picture(&weighted, lookup), exact, "{lookup:?}");
        let found = picture(&by_incidence, lookup);
        for (found, exact) in found.pixels.iter().zip(&exact.pixels) {
            for c in 0..3 {
                // Shares of two tables add up to 1 but for rounding.
                assert!((found[c] - exact[c]).abs() < 1e-6, "{found:?} {exact:?}");
            }
        }
    }
}

#[test]
fn a_pixel_shows_the_reflectance_of_its_incidence_and_colour() {
    // Lobes (1 + x)/2 · v about the mirror direction reflect 2π v of a constant map.
    let mut text = String::from("incidence degrees red green blue\n");
    let values = |angle: f64| [0.01 + 0.001 * angle, 0.05, 0.1 - 0.001 * angle];
    let incidences = [0.0, 30.0, 60.0, 90.0];
    for angle in incidences {
        let [r, g, b] = values(angle);
        text += &format!("{angle} 0 {r} {g} {b}\n{angle} 180 0 0 0\n");
    }
    let table = Reflectance::parse(&text).unwrap();
    assert_eq!(table.incidences(), incidences);
    let sky = polar(64, |_| [1.0, 2.0, 3.0]);
    let maps = table.convolve(&sky, Normalise::Radiance, Projection::Polar, (32, 16));
    let tables: Vec<Table> = maps
        .unwrap()
        .iter()
        .rev()
        .map(|map| Table::new(map).unwrap())
        .collect();
    let cosines = incidences.map(|angle: f64| angle.to_radians().cos());
    let shader = Shader {
        glosses: vec![(0.0, tables.iter().collect())],
        incidences: cosines.iter().rev().map(|c| *c as f32).collect(),
        ..Shader::of(None, None)
    };
    let exact = |cosine: f64, c: usize| {
        let at = cosines[1..].partition_point(|own| *own > cosine);
        let part = (cosines[at] - cosine) / (cosines[at] - cosines[at + 1]);
        let of = |k: usize| values(incidences[k])[c];
        let value = of(at) + part * (of(at + 1) - of(at));
        std::f64::consts::TAU * value * [1.0, 2.0, 3.0][c]
    };
    let (_, buffer) = buffer(60, 1);
    for lookup in LOOKUPS {
        let mut picture = Image::filled(60, 60, [0.0; 3]);
        shader.frame(&buffer, lookup, &mut picture);
        for (k, place) in buffer.places().enumerate() {
            let dot = (0..3).map(|c| buffer.normal[c][k] * buffer.view[c][k]);
            let cosine = f64::from(dot.sum::<f32>());
            for (c, ks) in [0.25, 0.5, 0.0].into_iter().enumerate() {
                let exact = ks * exact(cosine, c);
                let found = f64::from(picture.pixels[place][c]);
                assert!(
                    (found - exact).abs() < 2e-6,
                    "{lookup:?} {k} {c}: {found} {exact}"
                );
            }
        }
    }
}

#[test]
fn incidences_of_one_cosine_are_refused() {
    let read = |incidences: &[f64]| TableSet::read(&[], None, [&[], incidences], None);
    let error = read(&[45.0, 0.01, 0.0]).unwrap_err().to_string();
    assert!(error.contains("0 and 0.01 are too close"), "{error}");
    // The same one twice is one.
    assert_eq!(read(&[45.0, 0.0, 45.0]).unwrap().incidences, [45.0, 0.0]);
}
