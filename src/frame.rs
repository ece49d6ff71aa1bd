//! The recipe: scene → animate → voxelize → resolve → fill → light → march → compose.
//!
//! The window, the headless renderer, the tests and the benchmarks all run this same recipe. It never waits for the
//! device: what the device counts comes back a frame late.
