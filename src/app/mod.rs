//! The window.
pub mod actions;
pub mod history;
pub mod notices;
pub mod orbit;
pub mod resolution;
pub mod timeline;
pub mod view;
