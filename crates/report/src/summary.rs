//! The summary of a plan as lines of text. [`told`] describes the plan; [`details`] adds the search
//! and the results of the witnesses, for `slew plan -v`.

mod brief;
pub(crate) mod firings;
mod fixed_axis;
pub mod flown;
mod found;
pub(crate) mod inputs;
mod lines;
pub mod sequence;
mod stopped;
mod target;
mod verified;

pub use found::scheme;
pub use lines::{Lines, TEXT, Tone, headline, line, paint, parts, wrapped};
pub use stopped::remedies;
pub use verified::{Judged, verified};

use found::{found, method};
use slewkit::maneuver::{Outcome, Problem, SecondOrder, Settings};
use slewkit::numerics::figures::{short, significant};
use slewkit::plan::{Plan, Status};
use slewkit::verify::Accuracy;
use slewkit_files::identity::Identity;
use slewkit_files::spec::escape;
use stopped::{best, ladder, stopped};

/// Returns the summary of a plan, whether solved or not: the headline and the lines below it.
pub fn plan(
    colour: bool,
    problem: &Problem,
    settings: &Settings,
    plan: &Plan,
    identity: &Identity,
) -> Vec<String> {
    let (verdict, tone) = verdict(plan);
    let mut lines = vec![headline(colour, &problem.name, verdict, tone)];
    lines.extend(told(problem, settings, plan, identity));
    lines
}

/// Returns the verdict on a plan as a short phrase, with its tone.
pub fn verdict(plan: &Plan) -> (&'static str, Tone) {
    let solution = &plan.solution;
    let solved = solution.outcome == Outcome::Converged;
    match plan.status {
        Status::Solved if solution.optimality.second_order() == SecondOrder::Saddle => {
            ("saddle, solved and verified", Tone::Note)
        }
        Status::Solved => ("solved and verified", Tone::Good),
        Status::Infeasible => ("infeasible", Tone::Bad),
        Status::NotConverged => ("not converged", Tone::Bad),
        Status::LimitReached if solved => ("solved, not verified: limit reached", Tone::Bad),
        Status::LimitReached => ("limit reached", Tone::Bad),
        Status::VerificationFailed => ("solved, but verification failed", Tone::Bad),
        Status::Interrupted if solved => ("solved, not verified: interrupted", Tone::Note),
        Status::Interrupted => ("interrupted", Tone::Note),
    }
}

/// Returns the lines of a summary below its headline, without the line that suggests the next
/// command.
pub fn told(problem: &Problem, settings: &Settings, plan: &Plan, identity: &Identity) -> Vec<String> {
    brief::brief(problem, settings, plan, identity)
}

/// Returns the details of the search, and the results of the witnesses.
pub fn details(
    colour: bool,
    problem: &Problem,
    settings: &Settings,
    plan: &Plan,
    identity: &Identity,
) -> Vec<String> {
    let solution = &plan.solution;
    let problem = &solution.on_grid(problem);
    let mut lines = Vec::new();
    // No search ran for a maneuver that was proved infeasible.
    if plan.status != Status::Infeasible {
        lines.line("method", method(problem, solution));
    }
    if solution.outcome == Outcome::Converged {
        lines.extend(found(problem, solution, identity));
        lines.lines("firings", firings::times(problem, solution, identity));
    } else {
        lines.line("stopped", stopped(solution));
        if let Some(proof) = &solution.infeasible {
            lines.line("because", escape(&proof.reason));
        } else {
            lines.extend(solution.shortfall.iter().map(|told| line("missing", &escape(&told.to_string()))));
            lines.line("best", best(&solution.terminal));
            lines.extend(ladder(&solution.ladder));
        }
    }
    if let Some(verification) = &plan.verification {
        let (trajectory, active) = (&solution.trajectory, Some(&solution.active[..]));
        let judged = Judged { problem, identity, trajectory, active };
        lines.extend(verified(colour, &judged, verification));
    }
    if let Some(verification) = plan.verification.as_ref().filter(|_| solution.outcome == Outcome::Converged)
    {
        lines.extend(accuracy(&Accuracy::of(verification, problem, settings.continuous_limit())));
    }
    lines
}

/// Returns a remark if the steps are too long for the required accuracy of the continuous motion.
fn accuracy(found: &Accuracy) -> Option<String> {
    let (missed, wanted) = (found.continuous_attitude_deg, short(found.wanted_deg));
    (missed > found.wanted_deg).then(|| {
        let missed = significant(missed, 3);
        let how = match found.steps {
            Some(steps) => format!("{steps} steps would reduce that below {wanted} deg"),
            None => format!("no number of steps would reduce that below {wanted} deg"),
        };
        line("accuracy", &format!("the motion under these torques ends {missed} deg off the target; {how}"))
    })
}
