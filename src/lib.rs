//! Moving glass, made of voxels every frame.
//!
//! Read [`frame`] next: it is the whole recipe. The modules below mirror its stages, in order:
//! animate → voxelize → resolve → fill → light → march → compose.

pub mod papers;

pub mod gpu;
pub mod scene;

pub mod grid;
pub mod voxel_cameras;
pub mod volume;

pub mod animate;
pub mod voxelize;
pub mod resolve;
pub mod fill;
pub mod csg;
pub mod voxel_list;
pub mod surroundings;
pub mod light;
pub mod plane_light;
pub mod march;
pub mod compose;
pub mod dense;

pub mod stale;
pub mod frame;

pub mod image;
pub mod voxel_file;

pub mod headless;
pub mod sheets;
pub mod golden;
pub mod marking;
pub mod bench;
pub mod lab;

pub mod app;
pub mod cli;
