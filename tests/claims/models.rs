//! Models: shapes, files, clips, poses and how far they reach.

mod shapes;
