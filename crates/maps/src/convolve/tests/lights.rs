//! One texel that outshines the sky, of the same flux at every resolution: section 4's delta.

use super::*;

/// A sky of 1 with a sun of the flux of one texel of a 64x32 map at a million times the sky.
fn sun(projection: Projection, texels: usize) -> (IlluminationMap, Direction, f64) {
    let size = projection.size(texels);
    let mut image = Image::filled(size.0, size.1, [1.0; 3]);
    let at = IlluminationMap::new(image.clone(), projection)
        .unwrap()
        .texel(AXIS);
    let (i, j) = (at % size.0, at / size.0);
    let flux = 1e6 * 4.0 * PI / 2048.0;
    let radiance = flux / projection.solid_angle(size, i, j);
    image.pixels[at] = [radiance as f32, 0.5 * radiance as f32, 1.0];
    let middle = projection.direction(size, i as f64 + 0.5, j as f64 + 0.5);
    let map = IlluminationMap::new(image, projection).unwrap();
    let omega = projection.solid_angle(size, i, j);
    (map, middle.unwrap(), flux - omega)
}

/// The largest relative difference of red from sky and sun, and of blue from the sky alone.
fn off(map: &IlluminationMap, lobe: &Lobe, middle: Direction, flux: f64) -> f64 {
    let request = request(lobe.clone());
    let result = convolve(map, std::slice::from_ref(&request))
        .unwrap()
        .remove(0);
    let scale = lobe.scale(Normalise::Seed);
    let sky = scale / lobe.scale(Normalise::Radiance);
    let mut worst = 0.0f64;
    for (at, pixel) in result.image().pixels.iter().enumerate() {
        let (x, y) = ((at % 36) as f64 + 0.5, (at / 36) as f64 + 0.5);
        let n = Projection::Polar.direction((36, 18), x, y).unwrap();
        let exact = sky + scale * flux * lobe.value(dot(n, middle).min(1.0));
        worst = worst.max((f64::from(pixel[0]) / exact - 1.0).abs());
        worst = worst.max((f64::from(pixel[2]) / sky - 1.0).abs());
    }
    worst
}

#[test]
fn a_sun_keeps_its_flux_from_every_projection() {
    for projection in Projection::all() {
        let (map, middle, flux) = sun(projection, 64);
        let direct = matches!(projection, Projection::Cube | Projection::Ball);
        let exponents = [10.0, 1000.0, 0.0, 1.0];
        for n in &exponents[..if direct { 4 } else { 2 }] {
            let error = off(&map, &Lobe::Phong(*n), middle, flux);
            // Below 5 the horizon cuts two million areas as if they were squares.
            let bound = [(0.0, 1e-4), (1.0, 5e-6)].iter().find(|(m, _)| m == n);
            let bound = bound.map_or(1e-6, |(_, bound)| *bound);
            assert!(error < bound, "{projection:?}, n = {n}: off by {error:e}");
        }
    }
}

#[test]
fn a_sun_gives_the_same_maps_at_any_resolution() {
    let some = [0.0, 1.0, 10.0, 1000.0];
    let all = [0.0, 0.5, 1.0, 10.0, 1000.0, 1e5];
    for (texels, exponents) in [(64, &all[..]), (256, &some), (2048, &some)] {
        let (map, middle, flux) = sun(Projection::Polar, texels);
        for n in exponents {
            let error = off(&map, &Lobe::Phong(*n), middle, flux);
            assert!(error < 1e-6, "{texels}, n = {n}: off by {error:e}");
        }
    }
}

#[test]
fn a_point_on_black_is_the_lobe_itself_and_nothing_is_negative() {
    for projection in Projection::all() {
        let (map, middle, _) = sun(projection, 64);
        let mut image = map.into_image();
        image
            .pixels
            .iter_mut()
            .filter(|p| p[0] == 1.0)
            .for_each(|p| *p = [0.0; 3]);
        let map = IlluminationMap::new(image, projection).unwrap();
        let flux = map.integral()[0];
        for lobe in [Lobe::Lambert, Lobe::Phong(20.0), Lobe::Phong(200.5)] {
            let result = convolve(&map, &[request(lobe.clone())]).unwrap().remove(0);
            let peak = flux * lobe.scale(Normalise::Seed) * lobe.value(1.0);
            for (at, pixel) in result.image().pixels.iter().enumerate() {
                let (x, y) = ((at % 36) as f64 + 0.5, (at / 36) as f64 + 0.5);
                let n = Projection::Polar.direction((36, 18), x, y).unwrap();
                let exact = peak * lobe.value(dot(n, middle).min(1.0)) / lobe.value(1.0);
                let error = (f64::from(pixel[0]) - exact).abs() / peak;
                assert!(
                    pixel[0] >= 0.0 && error < 1e-7,
                    "{projection:?}, {lobe:?}: {error:e}"
                );
            }
        }
    }
}

#[test]
fn two_bright_neighbours_are_an_area() {
    let size = (64, 32);
    let mut image = Image::filled(64, 32, [0.0; 3]);
    image.pixels[10 * 64 + 20] = [1e6; 3];
    let map = |image| IlluminationMap::new(image, Projection::Polar).unwrap();
    assert!(Lights::of(&map(image.clone())).is_some());
    image.pixels[10 * 64 + 21] = [1e6; 3];
    assert!(Lights::of(&map(image.clone())).is_none());
    // Over the seam and over the pole.
    for (a, b) in [(5 * 64, 5 * 64 + 63), (3, 35)] {
        let mut image = Image::filled(size.0, size.1, [0.0; 3]);
        (image.pixels[a], image.pixels[b]) = ([1e6; 3], [1e6; 3]);
        assert!(Lights::of(&map(image)).is_none(), "{a} {b}");
    }
}
