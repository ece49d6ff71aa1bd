//! Ctrl+C, for commands that clean up behind themselves.

use super::Failure;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// True once Ctrl+C was pressed: whoever asks stops soon, with nothing half done. A second press ends the program at once.
pub(super) fn flag() -> Result<Arc<AtomicBool>, Failure> {
    let pressed = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&pressed);
    let handler = move || {
        if asked.swap(true, Ordering::Relaxed) {
            std::process::exit(2);
        }
    };
    ctrlc::set_handler(handler).map_err(|e| Failure::Other(format!("can't catch Ctrl+C: {e}")))?;
    Ok(pressed)
}
