//! Progress lines of a batch: finished cases, cases per second, and remaining time.

use crate::Console;
use slewkit::numerics::figures::significant;
use std::cell::Cell;
use std::time::{Duration, Instant};

/// Interval between two progress lines if stderr is not a terminal.
const SELDOM: Duration = Duration::from_secs(10);

/// Progress of a batch, from which progress lines are made.
pub struct Progress {
    cases: u64,
    /// Number of results that the file contained before this run.
    before: u64,
    began: Instant,
    /// Time of the last progress line; `None` unless `--progress` requests progress lines and
    /// stderr is not a terminal.
    told: Option<Cell<Instant>>,
}

impl Progress {
    pub fn new(cases: u64, before: u64, insist: bool) -> Self {
        let began = Instant::now();
        Self { cases, before, began, told: insist.then(|| Cell::new(began)) }
    }

    /// Prints a progress line if the interval since the last one has passed. `done` and `failed`
    /// include the results from before this run.
    pub fn tell(&self, console: &mut Console, (done, failed): (u64, u64)) {
        if console.shows_progress() {
            console.progress(|| self.text(done, failed));
        } else if let Some(told) = self.told.as_ref().filter(|told| told.get().elapsed() >= SELDOM) {
            told.set(Instant::now());
            console.say(&self.text(done, failed));
        }
    }

    fn text(&self, done: u64, failed: u64) -> String {
        let seconds = self.began.elapsed().as_secs_f64();
        let rate = (done - self.before) as f64 / seconds.max(1e-3);
        let left = (self.cases - done) as f64 / rate;
        let to_go = if left.is_finite() { format!(", {} to go", span(left)) } else { String::new() };
        let failed = if failed > 0 { format!(", {failed} failed") } else { String::new() };
        format!("  {done} of {} cases{failed}, {} a second{to_go}", self.cases, significant(rate, 3))
    }
}

/// Formats a time span \[s\].
pub fn span(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}
