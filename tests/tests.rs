//! The integration tests: the built program against answers known on paper, real models and broken input.

#![forbid(unsafe_code)]

mod alpha;
mod any_view;
mod armour;
mod authored;
mod bounces;
mod broken;
mod buried;
mod capture;
mod cli;
mod closed;
mod corpus;
mod denoise;
mod directional;
mod engines;
mod exact;
mod figures;
mod fit;
mod frames;
mod furnace;
mod ggx;
mod habits;
mod hard_cases;
mod layout;
mod maps;
mod methods;
mod models;
mod normal_maps;
mod outputs;
mod pages;
mod parity;
mod peers;
mod photo;
mod plan;
mod quads;
mod readme;
mod render;
mod report;
mod shading;
mod shards;
mod sky;
mod stopped;
mod support;
mod texels;
mod update;
