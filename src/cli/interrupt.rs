//! Ctrl-C: the first asks the solve to stop and keeps its best result, the second ends at once.

use super::failure::Exit;
use slewkit::plan::Status;
use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Takes Ctrl-C over from here on.
pub fn watch() {
    let installed = ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(Exit::Plan(Status::Interrupted).code()));
        }
    });
    // Without a handler Ctrl-C ends the program, which is what it would do anyway.
    drop(installed);
}

/// Whether Ctrl-C was pressed.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}
