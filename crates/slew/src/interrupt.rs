//! Handling of Ctrl-C. The first Ctrl-C stops the computation, and the best result so far is kept.
//! The second Ctrl-C ends the program at once. While results are being written, the first Ctrl-C
//! also ends the program at once. The signals SIGTERM and SIGHUP have the same effect as Ctrl-C.

use super::Exit;
use slewkit::plan::Status;
use slewkit_files::export::remove_temporaries;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};
use std::thread;
use std::time::Duration;

static REQUESTED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
/// True while the command appends results to their file one by one.
static KEEPING: AtomicBool = AtomicBool::new(false);
static WRITING: AtomicBool = AtomicBool::new(false);

/// Time from Ctrl-C to a message that asks the user to wait. It appears if the computation rarely
/// polls for Ctrl-C: a step with large polyhedra or a convex subproblem may take long.
const PATIENCE: Duration = Duration::from_millis(700);

/// Installs the handler of Ctrl-C.
pub fn watch() {
    let installed = ctrlc::set_handler(asked);
    // Without a handler, Ctrl-C ends the program, as it does by default.
    drop(installed);
    #[cfg(unix)]
    unix::watch();
}

/// Prepares the process for limits on file sizes and on memory. It must be called before any other
/// work.
pub fn prepare() {
    #[cfg(unix)]
    {
        unix::survive_file_limit();
        unix::end_without_memory();
    }
}

/// Installs the handler of Ctrl-C, as [`watch`] does, for a command that appends results to their
/// file one by one.
pub fn watch_kept() {
    KEEPING.store(true, Ordering::SeqCst);
    watch();
}

/// Returns whether Ctrl-C was pressed.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}

/// Returns the flag that becomes true on Ctrl-C.
pub fn flag() -> Arc<AtomicBool> {
    Arc::clone(&REQUESTED)
}

/// Marks the start of writing, after which Ctrl-C ends the program at once.
pub fn writing() {
    WRITING.store(true, Ordering::SeqCst);
}

/// Installs the handler for a command that only writes files. Ctrl-C ends the program at once and
/// leaves no incomplete file behind.
pub fn end_at_once() {
    writing();
    watch();
}

fn asked() {
    if REQUESTED.swap(true, Ordering::SeqCst) || WRITING.load(Ordering::SeqCst) {
        remove_temporaries();
        std::process::exit(i32::from(Exit::Plan(Status::Interrupted).code()));
    }
    // If the system cannot start a thread, the message is not printed, but the computation stops.
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

    /// Number of the signal SIGXFSZ (file size limit exceeded) on Linux and most other systems; the
    /// library defines no constant for it.
    const SIGXFSZ: i32 = 25;

    /// Installs the handler of the signals SIGTERM and SIGHUP.
    pub fn watch() {
        let asking = if ignores_hangup() { vec![SIGTERM] } else { vec![SIGTERM, SIGHUP] };
        if let Ok(mut signals) = Signals::new(asking) {
            let listen = move || signals.forever().for_each(|_| super::asked());
            // Without this thread, the signals end the program, as they do by default.
            let _ = std::thread::Builder::new().spawn(listen);
        }
    }

    /// Turns writing beyond the file size limit into an error, because the signal would kill the
    /// program.
    pub fn survive_file_limit() {
        let _ = signal_hook::flag::register(SIGXFSZ, Arc::default());
    }

    /// Makes the program end with the exit code `limit_reached` if an allocation fails. In this
    /// case the standard library prints a message and aborts, and a handler of the signal SIGABRT
    /// sets the exit code. The handler ignores an abort due to a panic during a panic, which is a
    /// bug.
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

    /// Returns whether the process ignores SIGHUP, as under `nohup`. Returns true also if the
    /// system does not report this.
    fn ignores_hangup() -> bool {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
        mask.is_none_or(|mask| mask & (1 << (SIGHUP - 1)) != 0)
    }
}
