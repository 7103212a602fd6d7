//! The packet widths are sealed.
impl ambake_embree::PacketWidth for ambake_embree::Lanes<4> {}
fn main() {}
