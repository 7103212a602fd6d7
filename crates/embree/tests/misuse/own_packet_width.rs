//! The packet widths are sealed.
impl embree::PacketWidth for embree::Lanes<4> {}
fn main() {}
