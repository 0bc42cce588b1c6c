//! Plan a maneuver: solve it, then have it verified.

pub use crate::optimize::search::{Control, Guess, Observer, PlanError, Progress, Silent};

use crate::maneuver::problem::Problem;
use crate::maneuver::settings::Settings;
use crate::maneuver::solution::{Outcome, Solution};
use crate::optimize::search;
use crate::verify::{self, Verification};
use serde::{Deserialize, Serialize};

/// What became of a plan; one for each exit code of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Solved, and the independent witnesses agree.
    Solved,
    /// Proved infeasible.
    Infeasible,
    /// No extremal was found.
    NotConverged,
    /// The time limit came first.
    LimitReached,
    /// Solved, but a witness disagrees.
    VerificationFailed,
    /// The caller asked to stop.
    Interrupted,
}

impl Status {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Infeasible => "infeasible",
            Self::NotConverged => "not_converged",
            Self::LimitReached => "limit_reached",
            Self::VerificationFailed => "verification_failed",
            Self::Interrupted => "interrupted",
        }
    }

    /// Its exit code.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Solved => 0,
            Self::Infeasible => 4,
            Self::NotConverged => 5,
            Self::LimitReached => 6,
            Self::VerificationFailed => 7,
            Self::Interrupted => 130,
        }
    }
}

/// A solution and what the witnesses say of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The solution, converged or the best iterate.
    pub solution: Solution,
    /// The witnesses' findings; `None` when there was no converged solution to judge.
    pub verification: Option<Verification>,
    /// What became of it.
    pub status: Status,
}

/// Plans a maneuver: every sense and winding, the ladder for hard cases, verification.
///
/// `guess` is tried first: its costates by the shooting, its path by SCP.
///
/// # Errors
/// [`PlanError`] when problem, settings or guess cannot be used. A solver that stops is no error: see
/// [`Plan::status`].
pub fn plan(
    problem: &Problem,
    settings: &Settings,
    guess: Option<&Guess>,
    observer: &mut dyn Observer,
) -> Result<Plan, PlanError> {
    Ok(judged(problem, settings, search::solve(problem, settings, guess, observer)?))
}

/// A solution with what the witnesses say of it, where it converged.
pub(crate) fn judged(problem: &Problem, settings: &Settings, solution: Solution) -> Plan {
    if solution.outcome != Outcome::Converged {
        let status = match solution.outcome {
            Outcome::TimeLimit => Status::LimitReached,
            Outcome::Interrupted => Status::Interrupted,
            Outcome::Infeasible => Status::Infeasible,
            _ => Status::NotConverged,
        };
        return Plan { solution, verification: None, status };
    }
    let (tolerance, continuous) = (settings.tolerance, settings.continuous_tolerance);
    let verification = verify::verify(problem, &solution.trajectory, tolerance, continuous);
    let status = if verification.passed() { Status::Solved } else { Status::VerificationFailed };
    Plan { solution, verification: Some(verification), status }
}
