//! The two output streams: text for people on stderr, data on stdout. A stream that the reader
//! closes is not an error.

use slewkit_files::export::ExportError;
pub use slewkit_report::summary::Tone;
use slewkit_report::summary::paint;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::time::{Duration, Instant};

/// The output of text for people, on stderr.
#[derive(Debug)]
pub struct Console {
    quiet: bool,
    /// True to write colours: stderr is a terminal, and `NO_COLOR` is empty or absent.
    pub colour: bool,
    terminal: bool,
    /// True while a progress line is on the screen.
    progress: bool,
    /// The time at which the progress line was last shown.
    shown: Instant,
    /// True if a text has been written.
    told: bool,
}

impl Console {
    /// Builds a console on stderr. `quiet` suppresses everything except errors.
    pub fn new(quiet: bool) -> Self {
        let terminal = io::stderr().is_terminal();
        let no_colour = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
        let colour = terminal && !no_colour;
        Self { quiet, colour, terminal, progress: false, shown: Instant::now(), told: false }
    }

    /// Returns `text` in the colour of its tone, if the console has colours.
    pub fn paint(&self, tone: Tone, text: &str) -> String {
        paint(self.colour, tone, text)
    }

    /// Prints one or several lines, unless the console is quiet.
    pub fn say(&mut self, text: &str) {
        if !self.quiet {
            self.plain_error(text);
        }
    }

    /// Prints an error with its code, also if the console is quiet.
    pub fn error(&mut self, code: &str, reason: &str, remedy: &str) {
        let label = self.paint(Tone::Bad, &format!("error[{code}]"));
        let mut text = format!("{label}: {reason}");
        if !remedy.is_empty() {
            text.push_str(&format!("\n  help: {}", remedy.replace('\n', "\n        ")));
        }
        self.plain_error(&text);
    }

    /// Prints a warning with its code, unless the console is quiet.
    pub fn warn(&mut self, code: &str, reason: &str, remedy: &str) {
        let label = self.paint(Tone::Note, &format!("warning[{code}]"));
        self.say(&format!("{label}: {reason}\n  help: {remedy}"));
    }

    /// Prints the text of an error, which is already formatted, also if the console is quiet.
    pub fn plain_error(&mut self, text: &str) {
        self.clear_progress();
        self.told = true;
        // `eprintln!` panics when stderr is closed.
        let _ = writeln!(io::stderr().lock(), "{}", text.trim_end_matches('\n'));
    }

    /// Returns whether the console is quiet and has printed nothing.
    pub fn is_silent(&self) -> bool {
        self.quiet && !self.told
    }

    /// Returns whether the progress is visible to the user.
    pub fn shows_progress(&self) -> bool {
        self.terminal && !self.quiet
    }

    /// Returns whether a new progress line is due. It is renewed ten times per second, for the
    /// first time after a tenth of a second.
    pub fn is_due(&self) -> bool {
        self.shows_progress() && self.shown.elapsed() >= Duration::from_millis(100)
    }

    /// Replaces the progress line if a new one is due.
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

/// Writes data to stdout. If the reader closes the stream, as `head` does, writing ends without
/// an error.
pub fn to_stdout(content: impl FnOnce(&mut dyn Write) -> Result<(), ExportError>) -> Result<(), ExportError> {
    // The buffer avoids a write for every line, because stdout flushes at each newline.
    let mut output = BufWriter::new(io::stdout().lock());
    let written = content(&mut output).and_then(|()| Ok(output.flush()?));
    match written {
        Err(error) if error.is_broken_pipe() => {
            // The writer is taken apart, because dropping it would write the buffered data again.
            drop(output.into_parts());
            Ok(())
        }
        other => other,
    }
}
