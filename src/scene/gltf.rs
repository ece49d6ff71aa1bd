//! Reads glTF 2.0, defensively.
