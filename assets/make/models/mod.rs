//! The models, one a file, and what they are made with: [`mesh`], [`field`] (smooth implicit surfaces and their
//! polygons) and [`glb`] (the file).

mod blob;
mod field;
mod fish;
mod glb;
mod mesh;
mod paperweight;
mod shell;
mod studio;
mod tree;

/// Makes the bytes of a file.
pub(crate) type Make = fn() -> Vec<u8>;

/// Every file, by its name in `assets/`.
pub(crate) const ALL: &[(&str, Make)] = &[
    ("fish.glb", fish::make),
    ("blob.glb", blob::make),
    ("paperweight.glb", paperweight::make),
    ("tree.glb", tree::make),
    ("shell.glb", shell::make),
    ("studio.hdr", studio::make),
];
