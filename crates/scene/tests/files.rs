//! Small files and scenes built on the spot: what is read, what is repaired and what is refused.

#[path = "files/authored.rs"]
mod authored;
#[path = "files/broken.rs"]
mod broken;
#[path = "files/compressed.rs"]
mod compressed;
#[path = "files/document.rs"]
mod document;
#[path = "files/energy.rs"]
mod energy;
#[path = "files/far.rs"]
mod far;
#[path = "files/fuzz.rs"]
mod fuzz;
#[path = "files/gltf.rs"]
mod gltf;
#[path = "files/gltf_materials.rs"]
mod gltf_materials;
#[path = "files/lights.rs"]
mod lights;
#[path = "files/memory.rs"]
mod memory;
#[path = "files/obj.rs"]
mod obj;
#[path = "files/obj_materials.rs"]
mod obj_materials;
#[path = "files/strangers.rs"]
mod strangers;
#[path = "files/support.rs"]
mod support;
#[path = "files/unneeded.rs"]
mod unneeded;
