//! Speed against error, measured: how far a bake is from the bare ray loop, and what each technique costs at equal error.
#![forbid(unsafe_code)]

pub mod samplers;
