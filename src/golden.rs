//! Golden frames.

/// What can go wrong with golden frames.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct GoldenError(String);
