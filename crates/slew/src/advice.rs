//! Suggestions for the next command after a plan, the most promising one first.

use super::SpecArgs;
use slewkit::maneuver::{Outcome, Problem, Settings};
use slewkit::numerics::figures::{about, rounded_up, short};
use slewkit::plan::{Plan, Status};
use slewkit::verify::Accuracy;

/// Largest ratio of the terminal error to its tolerance at which a search counts as nearly
/// converged.
const NEARLY: f64 = 1e4;

/// Formats a suggested command: `slew plan` with the spec and the overrides of this run, and with a
/// further override that sets `key` to `value`. The reason `why` follows as a shell comment.
fn again(args: &SpecArgs, key: &str, value: impl std::fmt::Display, why: &str) -> String {
    let (path, other) = (args.spec.to_string_lossy(), |set: &&String| !set.starts_with(&format!("{key}=")));
    let mut words = vec!["slew".into(), "plan".into(), word(&path)];
    if let Some(notation) = args.reading.input {
        words.extend(["--input".into(), format!("{notation:?}").to_lowercase()]);
    }
    let kept = args.reading.set.iter().filter(other).map(|set| word(set));
    words.extend(kept.chain([format!("{key}={value}")]).flat_map(|set| ["--set".into(), set]));
    format!("{}   # {why}", words.join(" "))
}

/// Returns a word for a command line. It is quoted if it contains characters that a shell would
/// interpret.
pub fn word(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+%@".contains(c);
    let text = slewkit_files::spec::escape(text);
    if !text.is_empty() && text.chars().all(plain) {
        text
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

/// Returns suggestions for the next command, according to the status of the plan and the outcome of
/// the search, the most promising one first.
pub fn advice(args: &SpecArgs, problem: &Problem, settings: &Settings, plan: &Plan) -> Vec<String> {
    let solution = &plan.solution;
    let more_steps =
        || again(args, "maneuver.steps", (2 * solution.steps).min(Problem::MAX_STEPS), "more steps");
    let (key, stated) = match problem.duration.at_most() {
        Some(longest) => ("maneuver.duration_at_most_s", longest),
        None => ("maneuver.duration_s", solution.duration(problem)),
    };
    let longer = || match solution.longer {
        Some(longer) => again(args, key, longer, "more time"),
        None => again(args, key, rounded_up(1.5 * stated), "more time, by a guess"),
    };
    let neighbour = || {
        "plan an easier neighbour (longer, or a smaller turn) with `-o neighbour.json`, then start \
        from it: --guess neighbour.json"
            .to_string()
    };
    let convex = solution.method.is_on_equal_steps();
    let witnessed = plan.verification.as_ref();
    let accuracy = witnessed.map(|found| Accuracy::of(found, problem, settings.continuous_limit()));
    // Shorter steps help if the discrete problem is solved but the continuous motion misses the
    // target.
    let finer = accuracy.and_then(|found| {
        let why = format!("ends within {} deg", short(found.wanted_deg));
        found.steps.map(|steps| again(args, "maneuver.steps", steps, &why))
    });
    // The terminal error is so small that only round-off can have prevented convergence.
    let reached = solution.terminal.largest();
    let nearly = reached.is_finite() && reached < NEARLY * solution.tolerance;
    match (plan.status, solution.outcome) {
        (Status::Solved, _) => finer.into_iter().collect(),
        (Status::VerificationFailed, _) => vec![finer.unwrap_or_else(more_steps)],
        (_, Outcome::Stalled) if problem.objective.switches() && solution.longer.is_some() => vec![longer()],
        // A longer duration cannot be suggested, because the duration is free.
        (_, Outcome::Stalled | Outcome::NotFinite) if problem.switches() || problem.seeks_duration() => {
            vec![more_steps(), again(args, "solver.search", "thorough", "more starts")]
        }
        (_, Outcome::StepTooLong) if problem.seeks_duration() => vec![more_steps()],
        (_, Outcome::StepTooLong) => vec![more_steps(), longer()],
        (_, Outcome::IterationLimit) => {
            let iterations = 2 * settings.max_iterations;
            vec![
                again(args, "solver.max_iterations", iterations, "more iterations"),
                more_steps(),
                neighbour(),
            ]
        }
        (_, Outcome::Stalled) if nearly => {
            let tolerance = format!("{:e}", 10_f64.powi(reached.log10().ceil() as i32));
            vec![again(args, "solver.tolerance", tolerance, "a larger tolerance"), more_steps()]
        }
        (_, Outcome::Stalled) if convex && solution.longer.is_some() => vec![longer(), neighbour()],
        (_, Outcome::Stalled) if convex && solution.shortfall.is_some() => {
            vec!["larger limits, smaller cones or other ends".into(), neighbour()]
        }
        (_, Outcome::Stalled | Outcome::NotFinite) => vec![more_steps(), longer(), neighbour()],
        (_, Outcome::Singular) => {
            vec!["other torque axes, or terminal rates that the present axes can reach".into()]
        }
        (_, Outcome::Infeasible) => {
            let bound = solution.infeasible.as_ref().and_then(|proof| proof.duration_lower_bound);
            let shorter = bound
                .map_or_else(String::new, |bound| format!("; no plan is shorter than {} s", about(bound)));
            let longer = match (solution.longer, bound) {
                (Some(longer), _) => {
                    Some(again(args, key, longer, &format!("enough time for a fixed axis{shorter}")))
                }
                (None, Some(bound)) => {
                    let (key, bound) = (key.trim_start_matches("maneuver."), about(bound));
                    Some(format!("{key} above {bound}: no plan is shorter, and a plan may need more"))
                }
                (None, None) => None,
            };
            let others = "changes of the quantities in the reason; or other torque axes, terminal rates or \
             attitudes";
            longer.into_iter().chain([others.into()]).collect()
        }
        (_, Outcome::TimeLimit) => {
            let limit = settings.time_limit.map_or(60.0, |limit| rounded_up(2.0 * limit.as_secs_f64()));
            let fewer = (solution.steps / 4).max(10);
            vec![
                again(args, "solver.time_limit_s", limit, "more time to search"),
                again(args, "maneuver.steps", fewer, "a coarser plan, for a guess"),
            ]
        }
        (_, Outcome::Interrupted | Outcome::Converged) => vec![],
    }
}
