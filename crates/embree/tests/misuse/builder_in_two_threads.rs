//! A builder is not shared between threads.
fn shared<T: Sync>(_: &T) {}
fn main() {
    let device = embree::Device::new(&embree::DeviceConfig::default()).unwrap();
    shared(&embree::SceneBuilder::new(&device));
}
