//! `slew plan` for a spec with stops.

use super::super::{Console, Destination, Exit, Failure, Message, export, interrupt, report, summary};
use super::{Args, Watcher};
use slewkit::plan::Status;
use slewkit::sequence::SequenceError;
use slewkit_files::exchange::Tables;
use slewkit_files::export::{SequenceFile, Target};
use slewkit_files::formats;
use slewkit_files::spec::{LoadedSequence, escape};
use slewkit_report::{sequence_page, summary::sequence};

/// Plans a sequence, prints its summary, and writes the requested files.
pub(super) fn run(
    args: &Args,
    loaded: &LoadedSequence,
    (destination, tables, page): (&Destination, Tables, Option<&Target>),
    console: &mut Console,
) -> Result<Exit, Failure> {
    let LoadedSequence { sequence: asked, settings, identity, files, .. } = loaded;
    destination.distinct_from(files)?;
    if let Some(page) = page {
        files.iter().try_for_each(|file| page.distinct_from(file))?;
    }
    if args.guess.is_some() || args.warm.is_some() {
        let reason = "--guess and --warm apply to a single maneuver, and the spec has stops".to_string();
        return Err(Failure::Usage(reason));
    }
    export::check(destination, &asked.craft, identity)?;
    interrupt::watch();
    let planned = asked.plan(settings, &mut Watcher(console));
    let plan = planned.map_err(|error| refusal(&error))?;
    let file = SequenceFile::new(loaded, &plan);
    let mut lines = sequence::sequence(console.colour, &file, loaded);
    if file.record.status == Status::Solved {
        // Sequences have no details of the search, so `next` does not suggest to show them.
        let flies = loaded.closed_loop.uncertainty.is_some();
        lines.push(summary::line("next", &summary::next(&args.spec, destination.plan_file(), true, flies)));
    }
    console.say(&lines.join("\n"));
    interrupt::writing();
    let format = destination.format().map(|format| format.of_data().unwrap_or(formats::Format::Json));
    if let Some(format) = format {
        destination.write(console, |_, output| {
            format.write_sequence(&file, &asked.craft, identity, tables, output)
        })?;
    }
    if let Some(target) = page {
        report::write(target, &sequence_page(&file, loaded, super::EULER), console)?;
    }
    Ok(match file.record.status {
        Status::Solved => Exit::Solved,
        status => Exit::Plan(status),
    })
}

/// Creates the failure for a sequence without a plan.
pub fn refusal(error: &SequenceError) -> Failure {
    let reason = escape(&error.to_string());
    if interrupt::requested() {
        let message = Message::new("E0191", format!("interrupted: {reason}"), "run it again");
        return Failure::Plan(Status::Interrupted, message);
    }
    let remedy = match error {
        SequenceError::Windows { .. } => {
            "widen the window, shorten the holds before it, or allow more torque"
        }
        SequenceError::NoPlan { .. } => {
            "to see why, plan that leg alone: write a spec with its two ends; or allow more time"
        }
        SequenceError::Stopped(_) => "allow more time: solver.time_limit_s",
        SequenceError::Beyond { .. } => {
            "shorten the holds, or give maneuver.duration_s or a window as long as the whole"
        }
        _ => "change the stops accordingly",
    };
    match error.status() {
        Some(status) => Failure::Plan(status, Message::new("E0191", reason, remedy)),
        None => Failure::Problem(Message::new("E0190", reason, remedy)),
    }
}
