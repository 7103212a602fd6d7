//! What rays bring: stated errors, targets, and the same bits by any number of threads.

use super::{UNIFORM, gathering, sheets};
use crate::fixture::{placed, room};
use crate::{LEAST_RAYS, Placed, Probe};
use glam::DVec3;

#[test]
fn stated_errors_are_those_that_are_made() {
    // Above a lit corner with a lamp: a thousand probes at one place differ by their points alone.
    let floor = [DVec3::new(-2.0, -1.0, -2.0), DVec3::Z * 4.0, DVec3::X * 4.0];
    let wall = [DVec3::new(-2.0, -1.0, -2.0), DVec3::Y * 3.0, DVec3::Z * 4.0];
    let lamp = [DVec3::new(0.5, 2.0, 0.0), DVec3::X * 0.5, DVec3::Z * 0.5];
    let scene = [
        sheets(vec![floor, wall], 0.6, 0.0),
        sheets(vec![lamp], 0.0, 20.0),
    ];
    gathering(&scene, UNIFORM, |mut gatherer| {
        gatherer.rays = 256;
        let places = vec![DVec3::new(-0.7, 0.1, 0.3); 1000];
        let probes = placed(&gatherer, &places, 0, 0.0);
        let squares = (0..9).map(|k| {
            let values: Vec<f64> = probes.iter().map(|p| p.probe.light[k].x).collect();
            let mean = values.iter().sum::<f64>() / 1000.0;
            let z = probes
                .iter()
                .map(|p| (p.probe.light[k].x - mean) / p.probe.std_err[k].x);
            let square = z.map(|z| z * z).sum::<f64>() / 1000.0;
            assert!(
                (0.8..=1.2).contains(&square),
                "{k}: squared z-scores {square}"
            );
            square
        });
        // Together the nine tell 4 % of an error: sixteen sets spread 7 % wider than they say, which is counted in.
        let spread = (squares.sum::<f64>() / 9.0).sqrt();
        assert!((0.97..=1.03).contains(&spread), "{spread}");
    });
}

#[test]
fn a_target_is_met_by_as_many_rays_as_it_takes_and_biases_nothing() {
    let floor = [DVec3::new(-2.0, -1.0, -2.0), DVec3::Z * 4.0, DVec3::X * 4.0];
    let lamp = [DVec3::new(0.5, 2.0, 0.0), DVec3::X * 0.5, DVec3::Z * 0.5];
    let scene = [sheets(vec![floor], 0.6, 0.0), sheets(vec![lamp], 0.0, 20.0)];
    gathering(&scene, UNIFORM, |mut gatherer| {
        let place = DVec3::new(-0.7, 0.1, 0.3);
        let first = |probes: &[Probe]| {
            let count = probes.len() as f64;
            let mean = probes.iter().map(|p| p.light[0].x).sum::<f64>() / count;
            let variance = probes
                .iter()
                .map(|p| (p.light[0].x - mean).powi(2))
                .sum::<f64>();
            (mean, (variance / (count * (count - 1.0))).sqrt())
        };
        gatherer.rays = 4096;
        let (plain, plain_error) = first(
            &(0..50)
                .map(|k| gatherer.probe(k, place))
                .collect::<Vec<_>>(),
        );
        (gatherer.rays, gatherer.target) = (65_536, Some(0.02));
        let probes: Vec<Probe> = (0..200).map(|k| gatherer.probe(k, place)).collect();
        for probe in &probes {
            assert!(probe.error() <= 0.02, "{} by {}", probe.error(), probe.rays);
        }
        let (mean, error) = first(&probes);
        let off = (mean - plain).abs();
        assert!(
            off < 4.0 * error.hypot(plain_error),
            "{mean} {plain}: {error} {plain_error}"
        );
        // Half the error takes more rays, and what is exact takes the fewest.
        let spent = |probe: &Probe| probe.rays;
        gatherer.target = Some(0.01);
        let finer: u32 = (0..20).map(|k| spent(&gatherer.probe(k, place))).sum();
        let coarse: u32 = probes[..20].iter().map(spent).sum();
        assert!(finer > 2 * coarse, "{finer} {coarse}");
        let open = gatherer.probe(0, DVec3::new(0.0, 1e6, 0.0));
        assert!(
            open.error() <= 0.01 && open.rays == LEAST_RAYS,
            "{}",
            open.rays
        );
    });
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let scene = [sheets(room(DVec3::NEG_ONE, DVec3::ONE), 0.7, 0.5)];
    gathering(&scene, UNIFORM, |mut gatherer| {
        gatherer.rays = 100;
        let places: Vec<DVec3> = (0..20).map(|k| DVec3::splat(0.04 * f64::from(k))).collect();
        let by = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().unwrap();
            pool.install(|| placed(&gatherer, &places, 5, 0.0))
        };
        assert_eq!(by(1), by(3));
        // And those of a part are those of the whole.
        assert_eq!(by(1)[7..], placed(&gatherer, &places[7..], 12, 0.0));
        // One that was kept as numbers is the same, but for the way out, which is taken by then.
        let again = by(1).into_iter().map(|mut whole| {
            whole.probe.way_out = None;
            let numbers = whole.numbers();
            let back = Placed::of_numbers(&numbers, gatherer.order, whole.asked);
            assert_eq!(
                Placed::of_numbers(&numbers[1..], gatherer.order, whole.asked),
                None
            );
            (whole, back)
        });
        for (whole, back) in again {
            assert_eq!(back, Some(whole));
        }
    });
}
