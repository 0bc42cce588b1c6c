//! `slew plan --warm`: replans the rest of a plan from the present state of the spacecraft.

use super::{Failure, Message, Watcher, refusal, spec_file};
use slewkit::maneuver::{Problem, Settings};
use slewkit::plan::{self, NotReplanned, Plan, ReplanError, Replanner};
use slewkit_files::epoch::Epoch;
use slewkit_files::export::{ExportError, PlanFile};
use slewkit_files::identity::Identity;
use slewkit_files::spec::Loaded;
use std::path::Path;

/// Largest relative difference between two durations that count as equal.
const SAME: f64 = 1e-9;
/// Largest difference between two epochs that count as equal \[s\].
const SAME_MOMENT: f64 = 1e-3;

/// A plan from which the rest of the maneuver is replanned.
pub struct Warm<'a> {
    path: &'a Path,
    replanner: Replanner,
    at: f64,
}

/// Reads the plan at `path`. The start of `problem` is the state of the spacecraft at the time `at`
/// of this plan \[s\]; the default is 0. The epoch of `identity` is set to this time.
pub fn begun<'a>(
    path: &'a Path,
    at: Option<f64>,
    problem: &Problem,
    identity: &mut Identity,
) -> Result<Warm<'a>, Failure> {
    let unusable = |error| Failure::unusable(path, &error);
    let file = PlanFile::read(spec_file::open_plan(path)?).map_err(unusable)?;
    let held = file.spec.as_ref().ok_or_else(|| unusable(ExportError::NoSpec))?;
    let Loaded { problem: planned, identity: of_plan, .. } =
        held.read(&format!("{}, spec", path.display()), &[])?;
    let planned = file.on_grid(&planned).map_err(unusable)?;
    let solution = file.plan().map_err(unusable)?.solution;
    let refused = |error| refused(path, &error);
    let replanner = Replanner::new(&planned, &solution).map_err(refused)?;
    replanner.fits(problem).map_err(refused)?;
    let at = at.unwrap_or(0.0);
    let moment = replanner.at(at).map_err(refused)?;

    let whole = replanner.problem().seconds();
    let lasts = problem.duration.known().unwrap_or(f64::NAN);
    if ![whole, moment.duration].iter().any(|duration| (lasts - duration).abs() <= SAME * duration) {
        let reason = format!(
            "the spec has a duration of {lasts} s; the plan has {whole} s, of which {} s remain: its \
            end keeps its time",
            moment.duration
        );
        return Err(misfit(reason, "set maneuver.duration_s to one of the two"));
    }
    let (all, left) = (replanner.problem().steps, moment.steps);
    if !problem.chooses_steps && ![all, left].contains(&problem.steps) {
        let reason = format!(
            "the spec has {} steps; the plan has {all}, of which {left} remain: they are not refined",
            problem.steps
        );
        return Err(misfit(reason, "remove maneuver.steps, or set it to one of the two"));
    }
    identity.epoch = epoch(identity.epoch, of_plan.epoch, at)?;
    Ok(Warm { path, replanner, at })
}

/// Returns the epoch at which the remaining maneuver begins: `at` \[s\] after the epoch of the
/// plan.
fn epoch(given: Option<Epoch>, of_plan: Option<Epoch>, at: f64) -> Result<Option<Epoch>, Failure> {
    let Some(of_plan) = of_plan else { return Ok(given) };
    let begins = of_plan.after(at);
    let is = |moment: &Epoch, other: &Epoch| moment.since(other).abs() <= SAME_MOMENT;
    if given.is_some_and(|given| !is(&given, &of_plan) && !is(&given, &begins)) {
        let reason = format!("the epoch of the spec is neither the epoch of the plan nor {at} s after it");
        return Err(misfit(reason, "remove the epoch, or set it to one of the two"));
    }
    Ok(Some(begins))
}

impl Warm<'_> {
    /// Replans the rest of the maneuver. Returns the remaining maneuver, its plan, and a sentence
    /// that states how the plan was found.
    pub fn plan(
        &self,
        problem: &Problem,
        settings: &Settings,
        watcher: &mut Watcher,
    ) -> Result<(Problem, Plan, Option<String>), Failure> {
        let found =
            plan::replan(problem, &self.replanner, self.at, settings, watcher).map_err(
                |error| match error {
                    ReplanError::Unfit(error) => refused(self.path, &error),
                    ReplanError::Plan(error) => refusal(error),
                },
            )?;
        let (name, at) = (self.path.to_string_lossy(), self.at);
        let told = match found.warm {
            Ok(1) => format!("1 Newton step from {name} at {at} s"),
            Ok(steps) => format!("{steps} Newton steps from {name} at {at} s"),
            Err(left) => format!("{name} at {at} s was not used, because {left}: new search"),
        };
        Ok((found.problem, found.plan, Some(told)))
    }
}

/// Creates the failure for a plan from which the maneuver cannot be replanned, with the remedy.
fn refused(path: &Path, error: &NotReplanned) -> Failure {
    let remedy = match error {
        NotReplanned::Time { .. } => return Failure::Usage(format!("--at: {error}")),
        NotReplanned::Other(_) => "give the plan of this maneuver, or plan without --warm",
        NotReplanned::Trajectory => "give a solved plan, or plan without --warm",
        NotReplanned::Limited(_) | NotReplanned::Translation => {
            "start from its path with --guess, or plan without --warm"
        }
        _ => "plan without --warm",
    };
    misfit(format!("{}: {error}", path.display()), remedy)
}

fn misfit(reason: String, remedy: &str) -> Failure {
    Failure::File(Message::new("E0103", reason, remedy))
}
