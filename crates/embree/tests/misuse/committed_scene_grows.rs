//! A committed scene takes no more triangles.
fn main() {
    let device = embree::Device::new(&embree::DeviceConfig::default()).unwrap();
    let mut scene = embree::SceneBuilder::new(&device).commit().unwrap();
    let _ = scene.triangles(&[], &[]);
}
