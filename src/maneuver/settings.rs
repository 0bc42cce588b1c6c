//! The settings of a solve. The solution repeats them.

use std::f64::consts::PI;
use std::time::Duration;
use thiserror::Error;

/// The choice of the solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The shooting if it is possible, then the interior point. If more than the inputs is limited,
    /// or if time or fuel is the cost: the interior point alone.
    #[default]
    Auto,
    /// Shooting on the costates. It supports limits on the inputs alone, by the saturated control
    /// law.
    Shooting,
    /// Sequential convex programming, whose result the interior point refines: for comparison, with
    /// least effort in a given duration on equal steps.
    Scp,
    /// An interior point on the group with all limits, on equal steps, even if inputs could switch
    /// between the nodes.
    InteriorPoint,
}

impl Method {
    /// Returns the name of the method in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Shooting => "shooting",
            Self::Scp => "scp",
            Self::InteriorPoint => "interior_point",
        }
    }

    /// Returns whether its plans have their inputs at the nodes of equal steps, and multipliers of
    /// all limits.
    #[doc(hidden)]
    pub fn is_on_equal_steps(self) -> bool {
        matches!(self, Self::Scp | Self::InteriorPoint)
    }
}

/// The number of attempts before an answer counts as the best.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Thoroughness {
    /// A few starts of every maneuver.
    Quick,
    /// The number that the maneuver is known to need: few for a free body at rest; more if it
    /// turns fast, is in a field, or lacks inputs.
    #[default]
    Default,
    /// Two hundred starts and more.
    Thorough,
}

impl Thoroughness {
    /// Returns the name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Default => "default",
            Self::Thorough => "thorough",
        }
    }
}

/// The motion that must meet the end of the maneuver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Target {
    /// The true motion under the inputs of the plan, held over its steps: the plan lands.
    #[default]
    Motion,
    /// The discrete motion, as in published plans. The true motion misses the end by the error of
    /// the discretisation.
    Discrete,
}

impl Target {
    /// Returns the name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Motion => "motion",
            Self::Discrete => "discrete",
        }
    }
}

/// Settings of a plan.
///
/// ```
/// use slewkit::{Method, Settings};
/// use std::time::Duration;
///
/// let settings = Settings {
///     method: Method::Scp,
///     time_limit: Some(Duration::from_secs(10)),
///     ..Settings::default()
/// };
/// settings.check()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The choice of the solver. Default: auto. Change it to compare methods, or to obtain
    /// costates to round-off under limits of the inputs (shooting).
    pub method: Method,
    /// The number of attempts before an answer counts as the best.
    pub search: Thoroughness,
    /// Tolerance of the scaled discrete terminal error: radians, and momenta over `J_mean/T`.
    /// Default 1e-12; round-off allows about 4e-15. Loosen it where a hundred thousand steps add up
    /// more round-off than that.
    pub tolerance: f64,
    /// The motion that meets the end: the true motion (the default), or the discrete one, as in
    /// published plans ([`Settings::discrete`]).
    pub target: Target,
    /// Limit on the continuous terminal attitude error \[rad\], beyond which a plan is not called
    /// solved. Default: 1e-4°; where the discrete motion is the target a quarter of the angle that
    /// the body turns, but between 5° and 45°. Constraints hold in the true motion to the same
    /// limit, of rates relative.
    pub continuous_tolerance: Option<f64>,
    /// Wall-clock limit of the whole plan. Default: none. The best iterate is kept.
    pub time_limit: Option<Duration>,
    /// Iteration limit of one Newton run, and of the subproblems of one run of SCP; the interior
    /// point may need four times as many. Default 60.
    pub max_iterations: usize,
    /// Whether the extremal and its rivals are tested to second order, and the recorded conditions
    /// of first order with them. Default: yes. Without the test any extremal counts, also a saddle,
    /// and [`Optimality::tested`] is false. This suits many maneuvers of a known kind, such as rest
    /// to rest by the shortest way.
    ///
    /// [`Optimality::tested`]: crate::maneuver::Optimality::tested
    pub test_second_order: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::Auto,
            search: Thoroughness::Default,
            tolerance: 1e-12,
            target: Target::Motion,
            continuous_tolerance: None,
            time_limit: None,
            max_iterations: 60,
            test_second_order: true,
        }
    }
}

/// A setting out of its range.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{name} is {value}: {reason}")]
pub struct SettingsError {
    /// The name of the setting.
    pub name: &'static str,
    /// Value of the setting.
    pub value: f64,
    /// The allowed values.
    pub reason: &'static str,
}

impl Settings {
    /// The smallest tolerance that double precision can reach.
    pub const MIN_TOLERANCE: f64 = 4e-15;

    /// The default limit on the attitude error of the true motion at the end \[rad\], for a plan
    /// that lands.
    pub const CONTINUOUS_TOLERANCE: f64 = 1e-4 * PI / 180.0;

    /// Returns the settings of published plans: the discrete motion meets the end to round-off,
    /// and the true motion misses it by the error of the discretisation.
    pub fn discrete() -> Self {
        Self { target: Target::Discrete, ..Self::default() }
    }

    /// Returns the limit on the continuous terminal attitude error \[rad\]; `None` if the limit
    /// is proportional to the angle that the body turns.
    pub fn continuous_limit(&self) -> Option<f64> {
        let lands = self.target == Target::Motion;
        self.continuous_tolerance.or_else(|| lands.then_some(Self::CONTINUOUS_TOLERANCE))
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// The first setting out of its range.
    pub fn check(&self) -> Result<(), SettingsError> {
        if !(self.tolerance >= Self::MIN_TOLERANCE && self.tolerance < 1.0) {
            let reason = "must be from 4e-15, the limit of double precision, to below 1";
            return Err(SettingsError { name: "tolerance", value: self.tolerance, reason });
        }
        if let Some(limit) = self.continuous_tolerance
            && !(limit > 0.0 && limit.is_finite())
        {
            let reason = "must be positive";
            return Err(SettingsError { name: "continuous_tolerance", value: limit, reason });
        }
        if self.max_iterations == 0 {
            return Err(SettingsError { name: "max_iterations", value: 0.0, reason: "must be at least 1" });
        }
        Ok(())
    }
}
