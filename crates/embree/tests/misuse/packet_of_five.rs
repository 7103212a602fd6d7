//! Packets have 8 or 16 lanes.
fn main() {
    let _ = ambake_embree::RayPacket::<5>::new();
}
