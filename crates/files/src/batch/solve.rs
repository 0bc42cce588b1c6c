//! Planning of one case, from its spec to its result. A case is planned as by `slew plan`,
//! independent of all other cases.

use super::{Batch, BatchError, Case, CaseResult, Options, Shard};
use crate::export::{ExportError, PlanFile, SequenceFile, Target};
use crate::spec::{Diagnostics, Loaded, LoadedSequence, Spec};
use slewkit::plan::{Control, Observer, Plan, PlanError, Progress, Status, plan};
use std::collections::HashSet;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::Instant;

/// Observer that stops the planner when the given function returns true.
struct Stoppable<'a>(&'a dyn Fn() -> bool);

impl Observer for Stoppable<'_> {
    fn on_progress(&mut self, _: &Progress) -> Control {
        if (self.0)() { Control::Stop } else { Control::Continue }
    }
}

/// Plans a case with a valid spec. No plan of another case serves as an initial guess.
///
/// # Errors
/// Returns an error if the planner rejects the problem.
pub fn plan_case(loaded: &Loaded, stop: &dyn Fn() -> bool) -> Result<Plan, PlanError> {
    plan(&loaded.problem, &loaded.settings, None, &mut Stoppable(stop))
}

/// Plans a case and returns its result; `None` if `stop` returned true before the plan was
/// complete.
pub(super) fn result(
    batch: &Batch,
    case: &Case,
    options: &Options,
    stop: &dyn Fn() -> bool,
) -> Result<Option<CaseResult>, BatchError> {
    // A bug in one case must not end the batch. The case is counted as failed; the message of the
    // panic has already been printed.
    let found = catch_unwind(AssertUnwindSafe(|| solved(batch, case, options, stop)));
    found.unwrap_or_else(|_| Ok(Some(CaseResult::panicked(case))))
}

fn solved(
    batch: &Batch,
    case: &Case,
    options: &Options,
    stop: &dyn Fn() -> bool,
) -> Result<Option<CaseResult>, BatchError> {
    let loaded = match batch.read(case) {
        Ok(Spec::Maneuver(loaded)) => loaded,
        Ok(Spec::Sequence(loaded)) => return sequence(batch, case, &loaded, options, stop),
        // The reader does not accept simulations in a batch.
        Ok(Spec::Simulation(_)) => return Ok(Some(CaseResult::invalid(case, &Diagnostics(Vec::new())))),
        Err(found) => return Ok(Some(CaseResult::invalid(case, &found))),
    };
    let Loaded { problem, settings, identity, .. } = &*loaded;
    let plan = match plan_case(&loaded, stop) {
        Ok(plan) => plan,
        Err(error) => return Ok(Some(CaseResult::refused(case, "E0121", error.to_string()))),
    };
    if plan.status == Status::Interrupted {
        return Ok(None);
    }
    keep(batch, case, options, |output| {
        PlanFile::new(problem, settings, &plan).with_identity(identity).write(output)
    })?;
    Ok(Some(CaseResult::planned(case, problem, &plan, options.times)))
}

/// Plans a case with stops and returns its result.
fn sequence(
    batch: &Batch,
    case: &Case,
    loaded: &LoadedSequence,
    options: &Options,
    stop: &dyn Fn() -> bool,
) -> Result<Option<CaseResult>, BatchError> {
    let LoadedSequence { sequence, settings, .. } = loaded;
    let began = Instant::now();
    let plan = match sequence.plan(settings, &mut Stoppable(stop)) {
        Ok(plan) => plan,
        Err(error) => {
            let (status, reason) = (error.status(), error.to_string());
            let result = match status {
                Some(Status::Interrupted) => return Ok(None),
                Some(status) => CaseResult::without_plan(case, status, reason),
                None => CaseResult::refused(case, "E0190", reason),
            };
            return Ok(Some(result));
        }
    };
    if plan.status() == Status::Interrupted {
        return Ok(None);
    }
    let seconds = began.elapsed().as_secs_f64();
    let file = SequenceFile::new(loaded, &plan);
    keep(batch, case, options, |output| file.write(output))?;
    let result = CaseResult::of_sequence(case, &file.record, &plan);
    Ok(Some(CaseResult { solve_time_s: options.times.then_some(seconds), ..result }))
}

/// Writes the plan file of a case into the folder of plans. The plan file is written before the
/// result line, so that every case in the file of results has a plan file. A plan file that a
/// killed run left behind is replaced.
fn keep(
    batch: &Batch,
    case: &Case,
    options: &Options,
    write: impl FnOnce(&mut dyn Write) -> Result<(), ExportError>,
) -> Result<(), BatchError> {
    let Some(folder) = &options.plans else { return Ok(()) };
    let target = Target::new(folder.join(plan_name(case.number, batch.count())), true)?;
    Ok(target.write(|output| write(output))?)
}

impl Batch {
    /// Checks that `folder` contains no file with the name of a plan file of `shard`.
    ///
    /// # Errors
    /// Returns [`FileError::Exists`](crate::export::FileError::Exists) for the first such file.
    pub fn check_plans(&self, folder: &Path, shard: Shard) -> Result<(), BatchError> {
        let names: HashSet<_> = std::fs::read_dir(folder)
            .into_iter()
            .flatten()
            .flatten()
            .map(|entry| entry.file_name())
            .collect();
        // The folder is usually empty, in which case no names need to be compared.
        if names.is_empty() {
            return Ok(());
        }
        for place in 0..shard.count(self.count()) {
            let name = plan_name(shard.case(place), self.count());
            if names.contains(std::ffi::OsStr::new(&name)) {
                Target::new(folder.join(name), false)?;
            }
        }
        Ok(())
    }
}

/// Returns the name of the plan file of a case. Case numbers are padded with zeros, so that the
/// names sort in the order of the cases.
fn plan_name(case: u64, cases: u64) -> String {
    format!("case-{case:0width$}.json", width = cases.to_string().len())
}
