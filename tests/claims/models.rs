//! Models: shapes, files, clips, poses and how far they reach.

mod bounds;
mod environments;
mod files;
mod shapes;
