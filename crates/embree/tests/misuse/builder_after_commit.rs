//! A builder is consumed by its commit.
fn main() {
    let device = ambake_embree::Device::new(&ambake_embree::DeviceConfig::default()).unwrap();
    let mut builder = ambake_embree::SceneBuilder::new(&device);
    let _scene = builder.commit();
    let _ = builder.triangles(&[], &[]);
}
