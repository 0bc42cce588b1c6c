//! The settings of a solve: method, search, target motion, tolerances and limits.

use std::f64::consts::PI;
use std::time::Duration;
use thiserror::Error;

/// The choice of the solution method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The method that suits the problem. Minimum effort under input limits alone is solved by the
    /// shooting, and by the interior point if the shooting fails. Minimum time and minimum fuel of
    /// a free body under torque limits alone are solved by Newton's method on the switching times.
    /// The interior point solves all other problems.
    #[default]
    Auto,
    /// Shooting on the costates. The saturated control law supports limits on the inputs; no other
    /// limits are supported.
    Shooting,
    /// Sequential convex programming, whose result the interior point refines. It serves for
    /// comparison, and supports minimum effort in a given duration on a uniform grid.
    Scp,
    /// An interior-point method on the Lie group with all limits, on a uniform grid, even if inputs
    /// could switch between the nodes.
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

    /// Returns whether plans of this method have inputs at the nodes of a uniform grid, and
    /// multipliers of all limits.
    #[doc(hidden)]
    pub fn is_on_equal_steps(self) -> bool {
        matches!(self, Self::Scp | Self::InteriorPoint)
    }
}

/// The number of starts that the search tries before it returns the best plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Thoroughness {
    /// A few starts for every maneuver.
    Quick,
    /// As many starts as the kind of maneuver is known to need: few for a free body at rest; more
    /// if the body turns fast, is in a force field, or lacks inputs.
    #[default]
    Default,
    /// Two hundred starts or more.
    Thorough,
}

impl Thoroughness {
    /// Returns the name of the search setting in files.
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
    /// The true motion under inputs that are held over the steps of the plan: the plan lands.
    #[default]
    Motion,
    /// The discrete motion, as in published plans. The true motion misses the end by the error of
    /// the discretisation.
    Discrete,
}

impl Target {
    /// Returns the name of the target motion in files.
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
    /// The solution method. Default: auto. Other values serve to compare methods, or to obtain
    /// costates to round-off under limits of the inputs (shooting).
    pub method: Method,
    /// The number of starts that the search tries before it returns the best plan.
    pub search: Thoroughness,
    /// Tolerance of the scaled terminal error of the discrete motion: radians, and momenta over
    /// `J_mean/T`. Default 1e-12; round-off allows about 4e-15. Increase it for grids of a hundred
    /// thousand steps or more, whose round-off may exceed the default.
    pub tolerance: f64,
    /// The motion that meets the end: the true motion (the default), or the discrete one, as in
    /// published plans ([`Settings::discrete`]).
    pub target: Target,
    /// Largest attitude error of the true motion at the end \[rad\]; a plan that exceeds it is not
    /// reported as solved. The default is 1e-4° for a plan that lands. If the target is the
    /// discrete motion, the default is a quarter of the angle that the body turns, clamped to
    /// 5°–45°. The true motion must keep constraints to this tolerance too: in radians for cones,
    /// relative for rates.
    pub continuous_tolerance: Option<f64>,
    /// Wall-clock limit of the whole plan. Default: none. The best iterate is kept.
    pub time_limit: Option<Duration>,
    /// Limit on the iterations of one Newton run, and on the subproblems of one SCP run. The
    /// interior point may use four times as many iterations. Default 60.
    pub max_iterations: usize,
    /// Whether the second-order conditions of the extremal and its rivals are tested, and the
    /// first-order conditions recorded. Default: yes. Without the test any extremal is accepted,
    /// even a saddle, and [`Optimality::tested`] is false. Turning the test off suits large numbers
    /// of maneuvers of a known kind, such as rest to rest by the short way.
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
    /// Name of the setting.
    pub name: &'static str,
    /// Value of the setting.
    pub value: f64,
    /// The allowed values, in words.
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

    /// Checks that every setting is in its range.
    ///
    /// # Errors
    /// Returns the first setting that is out of its range.
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
