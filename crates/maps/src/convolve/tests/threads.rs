//! The same bits on any number of threads.

use super::*;

#[test]
fn one_and_seven_threads_give_the_same_bits() {
    for projection in [Projection::Polar, Projection::Cube, Projection::Ball] {
        let mut image = painted(projection, 64, 2, |d| 1.0 + dot(d, AXIS)).into_image();
        image.pixels[1000] = [1e7, 1e6, 1.0];
        let map = IlluminationMap::new(image, projection).unwrap();
        let to = |lobe, projection: Projection| Request {
            projection,
            size: projection.size(24),
            ..request(lobe)
        };
        let requests = [
            to(Lobe::Lambert, Projection::Polar),
            to(Lobe::Phong(20.0), Projection::Polar),
            to(Lobe::Phong(200.0), Projection::Cube),
            to(Lobe::Varnish(20.0), Projection::Octahedral),
        ];
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let results = pool.build().unwrap().install(|| convolve(&map, &requests));
            let bits = |map: &ReflectionMap| -> Vec<u32> {
                map.image()
                    .pixels
                    .iter()
                    .flatten()
                    .map(|v| v.to_bits())
                    .collect()
            };
            results.unwrap().iter().map(bits).collect::<Vec<_>>()
        };
        assert!(on(1) == on(7), "{projection:?}");
    }
}
