//! The output streams of a command: text for people on stderr, and data on stdout. If the program
//! that reads a stream closes it, this is not an error.

use slewkit_files::export::ExportError;
pub use slewkit_report::summary::Tone;
use slewkit_report::summary::paint;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::time::{Duration, Instant};

/// The output of text for people, on stderr.
#[derive(Debug)]
pub struct Console {
    quiet: bool,
    /// True if colours are written: stderr is a terminal, and `NO_COLOR` is empty or absent.
    pub colour: bool,
    terminal: bool,
    /// True while a progress line is visible on the screen.
    progress: bool,
    /// Time at which the progress line was last updated.
    shown: Instant,
    /// True if the console has printed any text.
    told: bool,
}

impl Console {
    /// Creates a console on stderr. If `quiet` is true, it prints errors only.
    pub fn new(quiet: bool) -> Self {
        let terminal = io::stderr().is_terminal();
        let no_colour = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
        let colour = terminal && !no_colour;
        Self { quiet, colour, terminal, progress: false, shown: Instant::now(), told: false }
    }

    /// Returns `text` in the colour of the tone, or unchanged if the console has no colours.
    pub fn paint(&self, tone: Tone, text: &str) -> String {
        paint(self.colour, tone, text)
    }

    /// Prints one or several lines, unless the console is quiet.
    pub fn say(&mut self, text: &str) {
        if !self.quiet {
            self.plain_error(text);
        }
    }

    /// Prints an error with its code, reason and remedy, even if the console is quiet.
    pub fn error(&mut self, code: &str, reason: &str, remedy: &str) {
        let label = self.paint(Tone::Bad, &format!("error[{code}]"));
        let mut text = format!("{label}: {reason}");
        if !remedy.is_empty() {
            text.push_str(&format!("\n  help: {}", remedy.replace('\n', "\n        ")));
        }
        self.plain_error(&text);
    }

    /// Prints a warning with its code, reason and remedy, unless the console is quiet.
    pub fn warn(&mut self, code: &str, reason: &str, remedy: &str) {
        let label = self.paint(Tone::Note, &format!("warning[{code}]"));
        self.say(&format!("{label}: {reason}\n  help: {remedy}"));
    }

    /// Prints the formatted text of an error, even if the console is quiet.
    pub fn plain_error(&mut self, text: &str) {
        self.clear_progress();
        self.told = true;
        // `eprintln!` panics when stderr is closed.
        let _ = writeln!(io::stderr().lock(), "{}", text.trim_end_matches('\n'));
    }

    /// Returns true if the console is quiet and has printed nothing.
    pub fn is_silent(&self) -> bool {
        self.quiet && !self.told
    }

    /// Returns whether the console shows progress lines.
    pub fn shows_progress(&self) -> bool {
        self.terminal && !self.quiet
    }

    /// Returns whether the progress line is due for an update. It is updated ten times per second;
    /// the first update follows after a tenth of a second.
    pub fn is_due(&self) -> bool {
        self.shows_progress() && self.shown.elapsed() >= Duration::from_millis(100)
    }

    /// Replaces the progress line by `text` if an update is due.
    pub fn progress(&mut self, text: impl FnOnce() -> String) {
        if self.is_due() {
            let mut stderr = io::stderr().lock();
            let _ = write!(stderr, "\r\x1b[K{}", text());
            let _ = stderr.flush();
            (self.progress, self.shown) = (true, Instant::now());
        }
    }

    /// Removes the progress line from the screen.
    pub fn clear_progress(&mut self) {
        if std::mem::take(&mut self.progress) {
            let _ = write!(io::stderr().lock(), "\r\x1b[K");
        }
    }
}

/// Writes data to stdout with the function `content`. If the program that reads the stream closes
/// it, as `head` does, writing ends without an error.
pub fn to_stdout(content: impl FnOnce(&mut dyn Write) -> Result<(), ExportError>) -> Result<(), ExportError> {
    // Stdout is flushed at each newline; the buffer avoids a write operation for every line.
    let mut output = BufWriter::new(io::stdout().lock());
    let written = content(&mut output).and_then(|()| Ok(output.flush()?));
    match written {
        Err(error) if error.is_broken_pipe() => {
            // The writer is taken apart instead of dropped, because dropping it would write the
            // data that remain in its buffer.
            drop(output.into_parts());
            Ok(())
        }
        other => other,
    }
}
