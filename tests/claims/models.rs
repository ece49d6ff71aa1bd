//! Models: shapes, files, clips, poses and how far they reach.

mod bounds;
mod files;
mod shapes;
