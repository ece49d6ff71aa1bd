//! What the program claims, a module a subject. One test program, one device for all tests.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test that can't go on has failed")]
#![allow(missing_docs, reason = "test names say it")]

mod animate;
mod assets;
mod cli;
mod compose;
mod csg;
mod determinism;
mod fill;
mod fuzz;
mod goldens;
mod grids;
mod lab;
mod layering;
mod layouts;
mod light;
mod mesh;
mod mesh_rays;
mod models;
mod optics;
mod parts;
mod probe;
mod scene_files;
mod shaders;
mod shipped_goldens;
mod stages;
mod storage;
mod support;
mod surfaces;
mod surroundings;
mod survival;
mod volume;
mod views;
mod voxel_files;
mod voxel_list;
mod voxelizers;
mod window;

use murrine::gpu::{AdapterChoice, Gpu};
use std::sync::OnceLock;

/// The software device, opened once. A machine without one fails: no test is skipped.
pub fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| Gpu::open(&AdapterChoice::Software).unwrap_or_else(|e| panic!("{e}")))
}
