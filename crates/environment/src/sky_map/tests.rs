//! Floors, densities and drawn directions, each against the picture.

use super::*;
use crate::Image;
use ambient::sampling::Stream;

fn polar(height: usize, pixels: Vec<[f32; 3]>) -> Result<SkyMap, Error> {
    let image = Image {
        width: 2 * height,
        height,
        pixels,
    };
    SkyMap::new(&IlluminationMap::new(image, Projection::Polar).unwrap())
}

/// Any map: values between 0 and 1 by a fixed rule, and one texel a thousand times as bright.
fn map(height: usize) -> (SkyMap, Vec<[f32; 3]>) {
    let width = 2 * height;
    let value = |i: usize, c: usize| ((i * 37 + c * 11) % 101) as f32 / 100.0;
    let mut pixels: Vec<[f32; 3]> = (0..width * height)
        .map(|i| [value(i, 0), value(i, 1), value(i, 2)])
        .collect();
    pixels[width * (height / 3) + 1] = [900.0, 1000.0, 1100.0];
    (polar(height, pixels.clone()).unwrap(), pixels)
}

/// Samples for sixteen points of a stream.
fn draw(map: &SkyMap, stream: &Stream, first: u32) -> ([Wide; 3], [u32; LANES]) {
    let coordinate = |d: usize| std::array::from_fn(|l| stream.point(first + l as u32)[d] as f32);
    map.sample16(&coordinate(0), &coordinate(1))
}

#[test]
fn a_constant_map_is_a_floor_alone() {
    let map = polar(4, vec![[0.3, 2.0, 0.0]; 32]).unwrap();
    assert_eq!(map.floor(), [0.3_f32, 2.0, 0.0].map(f64::from));
    assert_eq!(map.mean(), map.floor());
    assert_eq!(map.scale(), 0.0);
}

#[test]
fn a_map_stands_upright_over_a_scene_whose_z_points_upward() {
    let (upright, _) = map(24);
    let turned = upright.clone().with_up(Up::Z);
    let zenith = [0.0, 0.0, 1.0].map(|v| [v; LANES]);
    let row = |texels: [u32; LANES]| texels[0] as usize / turned.size().0;
    assert_eq!(
        (
            row(turned.texels16(&zenith)),
            row(upright.texels16(&zenith))
        ),
        (0, 12)
    );
    let stream = Stream::new(5, 0, 0, 0, 0);
    for first in (0..256).step_by(LANES) {
        let ([x, y, z], texels) = draw(&turned, &stream, first);
        let ([a, b, c], same) = draw(&upright, &stream, first);
        // The scene's (x, y, z) is the map's (x, z, -y).
        assert_eq!([x, z, y.map(f32::neg)], [a, b, c]);
        assert_eq!(texels, same);
        assert_eq!(turned.texels16(&[x, y, z]), upright.texels16(&[a, b, c]));
        let one = |wide: [Wide; 3]| wide.map(|v| f64::from(v[3]));
        assert_eq!(turned.seen(one([x, y, z])), upright.seen(one([a, b, c])));
    }
    assert_eq!(turned.mean(), upright.mean());
}

#[test]
fn a_map_that_is_no_sky_is_refused_with_a_reason() {
    let ball = Image::filled(8, 8, [1.0; 3]);
    let ball = IlluminationMap::new(ball, Projection::Ball).unwrap();
    let text = SkyMap::new(&ball).unwrap_err().to_string();
    assert!(text.contains("ball") && text.contains("convert"), "{text}");
    for value in [f32::NAN, f32::INFINITY, -1.0] {
        let mut pixels = vec![[1.0; 3]; 32];
        pixels[13][2] = value;
        let error = polar(4, pixels).unwrap_err();
        assert!(matches!(error, Error::Pixel { x: 5, y: 1, .. }), "{error}");
    }
}

#[test]
fn floor_and_excess_give_back_the_picture_and_density_adds_up_to_one() {
    let (map, pixels) = map(9);
    for (i, pixel) in pixels.iter().enumerate() {
        let excess = map.excess(i as u32);
        for c in 0..3 {
            let value = map.floor()[c] + map.scale() * f64::from(excess[c]);
            // Roundings of the excess to f32.
            let close = 2e-7 * f64::from(pixel[c]);
            assert!((value - f64::from(pixel[c])).abs() <= close, "{i}, {c}");
        }
    }
    let mut density = 0.0;
    for i in 0..18 * 9 {
        let (top, bottom) = ((i / 18) as f64 / 9.0 * PI, (i / 18 + 1) as f64 / 9.0 * PI);
        let omega = (top.cos() - bottom.cos()) * TAU / 18.0;
        density += omega * map.excess(i).iter().map(|&v| f64::from(v)).sum::<f64>();
    }
    assert!((density - 1.0).abs() < 1e-6, "{density}");
}

#[test]
fn directions_lie_in_their_texels() {
    for height in [9, 1, 2, 33] {
        let (map, _) = map(height);
        let stream = Stream::new(0, 0, 0, 0, 0);
        let mut outside = 0;
        for first in (0..4096).step_by(LANES) {
            let (directions, texels) = draw(&map, &stream, first);
            let found = map.texels16(&directions);
            for l in 0..LANES {
                let square: f32 = directions.iter().map(|axis| axis[l] * axis[l]).sum();
                assert!((square - 1.0).abs() < 1e-6, "{square}");
                outside += u32::from(found[l] != texels[l]);
            }
        }
        // Rounding may take a direction over an edge: within 1e-6 of one, which few of 4,096 are.
        assert!(outside <= 2, "{height} rows: {outside}");
    }
}

#[test]
fn texels_are_drawn_by_their_flux() {
    let (map, _) = map(9);
    let n = 1 << 18;
    let stream = Stream::new(3, 0, 0, 0, 0);
    let mut counts = vec![0.0; 18 * 9];
    for first in (0..n).step_by(LANES) {
        for texel in draw(&map, &stream, first).1 {
            counts[texel as usize] += 1.0 / f64::from(n);
        }
    }
    for (i, count) in counts.iter().enumerate() {
        let (top, bottom) = ((i / 18) as f64 / 9.0 * PI, (i / 18 + 1) as f64 / 9.0 * PI);
        let omega = (top.cos() - bottom.cos()) * TAU / 18.0;
        let share = omega
            * map
                .excess(i as u32)
                .iter()
                .map(|&v| f64::from(v))
                .sum::<f64>();
        // Star discrepancy of a (0, m, 2)-net, H. Niederreiter (1987): (m / 3 + 19 / 9) / 2^m; four times for a box
        // anywhere.
        let bound = 4.0 * (18.0 / 3.0 + 19.0 / 9.0) / f64::from(n) + 2e-6;
        assert!((count - share).abs() < bound, "{i}: {count} for {share}");
    }
}
