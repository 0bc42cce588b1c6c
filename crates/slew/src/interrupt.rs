//! The handling of Ctrl-C. The first Ctrl-C stops the work and keeps its best result. The second
//! one ends the program at once, and so does the first one while results are written. The signals
//! SIGTERM and SIGHUP have the same effect as Ctrl-C.

use super::Exit;
use slewkit::plan::Status;
use slewkit_files::export::remove_temporaries;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};
use std::thread;
use std::time::Duration;

static REQUESTED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
/// True while results are appended to their final file, one by one.
static KEEPING: AtomicBool = AtomicBool::new(false);
static WRITING: AtomicBool = AtomicBool::new(false);

/// The time after Ctrl-C before a message asks for patience. The work may poll rarely: a step of
/// large polyhedra, or a subproblem, is slow.
const PATIENCE: Duration = Duration::from_millis(700);

/// Installs the handler of Ctrl-C.
pub fn watch() {
    let installed = ctrlc::set_handler(asked);
    // If no handler can be installed, Ctrl-C ends the program, which is its default.
    drop(installed);
    #[cfg(unix)]
    unix::watch();
}

/// Prepares the process for limits on file sizes and memory. Call it before any other work.
pub fn prepare() {
    #[cfg(unix)]
    {
        unix::survive_file_limit();
        unix::end_without_memory();
    }
}

/// Installs the handler as [`watch`] does, for work whose results are kept one by one.
pub fn watch_kept() {
    KEEPING.store(true, Ordering::SeqCst);
    watch();
}

/// Returns whether Ctrl-C was pressed.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}

/// Returns the flag that Ctrl-C sets.
pub fn flag() -> Arc<AtomicBool> {
    Arc::clone(&REQUESTED)
}

/// Marks the start of writing. From then on, Ctrl-C ends the program at once.
pub fn writing() {
    WRITING.store(true, Ordering::SeqCst);
}

/// Installs the handler for a command that only writes files: Ctrl-C ends the program at once and
/// leaves no incomplete file.
pub fn end_at_once() {
    writing();
    watch();
}

fn asked() {
    if REQUESTED.swap(true, Ordering::SeqCst) || WRITING.load(Ordering::SeqCst) {
        remove_temporaries();
        std::process::exit(i32::from(Exit::Plan(Status::Interrupted).code()));
    }
    // If the system cannot start a thread, the message does not appear, but the work stops.
    let _ = thread::Builder::new().spawn(|| {
        thread::sleep(PATIENCE);
        let text = if KEEPING.load(Ordering::SeqCst) {
            "interrupted: waiting for the running cases; a second signal ends at once and keeps \
            finished cases"
        } else if WRITING.load(Ordering::SeqCst) {
            "interrupted: writing the result; a second signal ends at once and keeps nothing"
        } else {
            "interrupted: waiting for the running step; a second signal ends at once and keeps nothing"
        };
        // `eprintln!` panics when stderr is closed.
        let _ = writeln!(std::io::stderr().lock(), "{text}");
    });
}

#[cfg(unix)]
mod unix {
    use super::Exit;
    use signal_hook::consts::{SIGABRT, SIGHUP, SIGTERM};
    use signal_hook::iterator::Signals;
    use slewkit::plan::Status;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    /// The number of SIGXFSZ (file size limit exceeded) on Linux and most other systems. The
    /// library has no constant for it.
    const SIGXFSZ: i32 = 25;

    /// Installs the handler of the signals SIGTERM and SIGHUP.
    pub fn watch() {
        let asking = if ignores_hangup() { vec![SIGTERM] } else { vec![SIGTERM, SIGHUP] };
        if let Ok(mut signals) = Signals::new(asking) {
            let listen = move || signals.forever().for_each(|_| super::asked());
            // If the system cannot start a thread, the signals end the program, as they do by
            // default.
            let _ = std::thread::Builder::new().spawn(listen);
        }
    }

    /// Makes writing beyond the file size limit an error, which would otherwise kill the program.
    pub fn survive_file_limit() {
        let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
    }

    /// Makes a failed allocation end the program with the exit code `limit_reached`. On a failed
    /// allocation, the standard library prints a message and aborts. A panic within a panic also
    /// aborts, but counts as a bug.
    pub fn end_without_memory() {
        let no_panic = Arc::new(AtomicBool::new(true));
        let code = i32::from(Exit::Plan(Status::LimitReached).code());
        let _ = signal_hook::flag::register_conditional_shutdown(SIGABRT, code, Arc::clone(&no_panic));
        let tell = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            no_panic.store(false, Ordering::SeqCst);
            tell(panic);
        }));
    }

    /// Returns whether the process ignores SIGHUP, as under `nohup`. Returns true if the system
    /// does not report this.
    fn ignores_hangup() -> bool {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
        mask.is_none_or(|mask| mask & (1 << (SIGHUP - 1)) != 0)
    }
}
