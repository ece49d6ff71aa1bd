//! The `murrine` program: see [`murrine::cli`].

fn main() {}
