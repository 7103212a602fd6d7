//! The written GLB: validated by Khronos' validator, loaded again, compared with the input.

#[path = "../../../tests/skip.rs"]
mod skip;

#[path = "gltf/built.rs"]
mod built;
#[path = "gltf/kept.rs"]
mod kept;
#[path = "gltf/layouts.rs"]
mod layouts;
#[path = "gltf/models.rs"]
mod models;
#[path = "gltf/patching.rs"]
mod patching;
#[path = "gltf/rich.rs"]
mod rich;
#[path = "gltf/support.rs"]
mod support;
