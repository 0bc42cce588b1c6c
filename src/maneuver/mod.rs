//! The maneuver: the problem, the settings, the solution, and proofs that no plan exists.

pub mod aim;
pub mod constraint;
pub mod duration;
pub mod grid;
pub mod infeasible;
pub mod objective;
pub mod problem;
pub mod proved;
pub mod reserve;
pub mod settings;
pub mod shortfall;
pub mod solution;
pub mod switching;

pub use aim::{Aim, AimError, AimRate, Roll};
pub use constraint::{
    Alternatives, AlternativesError, BOUNDARY_ROUNDING, Constraint, ConstraintError, Direction, During,
    Pointing, Rule, Shift, Side, Turns,
};
pub use duration::Duration;
pub use grid::{Grid, GridError, Scheme};
pub use infeasible::{Proof, fixed_axis_duration};
pub use objective::{Fuel, Objective, WeightError, Weighted, Weights};
#[doc(hidden)]
pub use problem::Stepping;
pub use problem::{EndCondition, Formulation, Motion, Path, Problem, ProblemError, State, Unsuited};
pub use proved::Proved;
pub use reserve::Reserve;
pub use settings::{Method, Settings, SettingsError, Target, Thoroughness};
pub use shortfall::{Excess, Shortfall, Violation};
pub use solution::{
    ActiveConstraint, ChosenSteps, ContinuousCost, ContinuousGap, ConvexWork, InteriorWork, Landing,
    Optimality, Outcome, Rival, Rung, RungReport, SecondOrder, Sense, Solution, TerminalError, Trajectory,
};
pub use switching::{Pulses, Structure, Switching, SwitchingArc};
