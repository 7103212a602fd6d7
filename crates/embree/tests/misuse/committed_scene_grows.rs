//! A committed scene takes no more triangles.
fn main() {
    let device = ambake_embree::Device::new(&ambake_embree::DeviceConfig::default()).unwrap();
    let mut scene = ambake_embree::SceneBuilder::new(&device).commit().unwrap();
    let _ = scene.triangles(&[], &[]);
}
