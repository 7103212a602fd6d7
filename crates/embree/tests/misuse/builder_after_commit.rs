//! A builder is consumed by its commit.
fn main() {
    let device = embree::Device::new(&embree::DeviceConfig::default()).unwrap();
    let mut builder = embree::SceneBuilder::new(&device);
    let _scene = builder.commit();
    let _ = builder.triangles(&[], &[]);
}
