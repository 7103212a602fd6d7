//! A builder is not shared between threads.
fn shared<T: Sync>(_: &T) {}
fn main() {
    let device = ambake_embree::Device::new(&ambake_embree::DeviceConfig::default()).unwrap();
    shared(&ambake_embree::SceneBuilder::new(&device));
}
