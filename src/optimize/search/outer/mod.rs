//! Searches that solve a maneuver repeatedly: over the terminal state on a target (roll and arrival
//! time), the schedule of cones, the duration, or the number of steps. Each receives the solver as
//! a parameter.

pub mod alternatives;
pub mod cheapest;
pub mod ends;
pub mod free_end;
mod illinois;
pub mod known;
mod rolls;
pub mod steps;

use crate::maneuver::problem::Problem;
use crate::maneuver::settings::{Method, Settings, Target};
use crate::maneuver::solution::Solution;
use crate::optimize::search::{Guess, Observer, PlanError};

/// The solver that a search repeats: it solves one maneuver with the given settings and guess.
pub type Inner<'a> =
    &'a dyn Fn(&Problem, &Settings, Option<&Guess>, &mut dyn Observer) -> Result<Solution, PlanError>;

/// Returns the settings for the comparison of discrete optima on the chain.
fn of_discrete_optima(settings: &Settings) -> Settings {
    let method = Method::InteriorPoint;
    Settings { target: Target::Discrete, test_second_order: false, method, ..settings.clone() }
}
