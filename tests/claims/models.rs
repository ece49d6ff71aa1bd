//! Models: shapes, files, clips, poses and how far they reach.

mod bounds;
mod clips;
mod environments;
mod files;
mod hostile;
mod layouts;
mod maker;
mod materials;
mod pictures;

mod rigs;
mod shapes;
mod tints;
