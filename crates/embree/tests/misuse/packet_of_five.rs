//! Packets have 8 or 16 lanes.
fn main() {
    let _ = embree::RayPacket::<5>::new();
}
