//! The integration tests: the built program against answers known on paper, real models and broken input.

#![forbid(unsafe_code)]
#![allow(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "tests say what they skip"
)]

mod alpha;
mod any_view;
mod any_view_shaders;
mod armour;
mod authored;
mod blocks;
mod bounces;
mod bounces_stopped;
mod broken;
mod buried;
mod capture;
mod cases;
mod casts;
mod cli;
mod cliffs;
mod closed;
mod compressed;
mod corpus;
mod denoise;
mod directional;
mod engines;
mod engines_three;
mod estimate;
mod exact;
mod facing;
mod figures;
mod fit;
mod frames;
mod furnace;
mod ggx;
mod godot;
mod habits;
mod hard_cases;
mod kept;
mod killed;
mod layout;
mod lights;
mod maps;
mod memory;
mod methods;
mod models;
mod mosaic;
mod normal_maps;
mod orm;
mod outputs;
mod pages;
mod parity;
mod peers;
mod phases;
mod photo;
mod photo_series;
mod pipes;
mod probe_balls;
mod probe_glb;
mod probe_parts;
mod probes;
mod quads;
mod readme;
mod render;
mod report;
mod saved;
mod shading;
mod shards;
mod shores;
mod shut;
mod sky;
mod stands;
mod stated;
mod stopped;
mod support;
mod texels;
mod to_vertices;
mod together;
mod under;
mod update;
mod walls;
