//! Lines to stdout and stderr that don't panic when nobody reads them any more.

use super::Failure;
use std::fmt::Arguments;
use std::io::Write as _;
use std::time::{Duration, Instant};

/// Where data goes.
#[derive(Debug)]
pub(super) struct Output(std::io::Stdout);

impl Default for Output {
    fn default() -> Self {
        Self(std::io::stdout())
    }
}

impl Output {
    /// Writes a line of data.
    pub(super) fn line(&mut self, text: Arguments<'_>) -> Result<(), Failure> {
        writeln!(self.0, "{text}").map_err(|e| match e.kind() {
            std::io::ErrorKind::BrokenPipe => Failure::PipeClosed,
            _ => Failure::Other(format!("can't write to stdout: {e}")),
        })
    }
}

/// Writes a line for the reader's eyes to stderr. Where even that is closed, there is nobody to tell.
pub(super) fn tell(text: Arguments<'_>) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// A line on how far a long run has come, no more than one each [`Progress::EACH`].
#[derive(Debug)]
pub(super) struct Progress(Instant);

impl Progress {
    const EACH: Duration = Duration::from_millis(500);

    pub(super) fn new() -> Self {
        Self(Instant::now())
    }

    /// Tells it, if it is time.
    pub(super) fn tell(&mut self, text: Arguments<'_>) {
        if self.0.elapsed() >= Self::EACH {
            tell(text);
            self.0 = Instant::now();
        }
    }
}
