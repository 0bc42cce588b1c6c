//! The methods by name.

use super::lagrangian_verlet::LagrangianVerlet;
use super::lie_euler::LieEuler;
use super::lie_verlet::LieVerlet;
use super::{Facts, Integrator, System, SystemError, SystemState};
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// A method. Its name is stable: files and commands use it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// `lie_euler`: drift, then kick; first order. Inputs act at the end of a step.
    LieEuler,
    /// `lie_euler_adjoint`: kick, then drift; first order. Inputs act at the start of a step.
    LieEulerAdjoint,
    /// `lie_verlet`: Lie velocity Verlet, Hamiltonian form; second order. The one to start with.
    LieVerlet,
    /// `lie_verlet_lagrangian`: the same map as a discrete Lagrangian map.
    LieVerletLagrangian,
}

/// Settings of the methods that have any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Error that an error control allows per step, relative to the size of each quantity. Default 1e-13;
    /// methods of fixed step length have no use for it.
    pub tolerance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { tolerance: 1e-13 }
    }
}

/// No method has this name.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("no integrator is called '{name}'; there are {}", names())]
pub struct UnknownKind {
    /// The name given.
    pub name: String,
}

fn names() -> String {
    Kind::all().map(Kind::name).collect::<Vec<_>>().join(", ")
}

impl Kind {
    /// All methods.
    pub fn all() -> impl Iterator<Item = Self> {
        [Self::LieEuler, Self::LieEulerAdjoint, Self::LieVerlet, Self::LieVerletLagrangian].into_iter()
    }

    /// Its name in files and commands.
    pub fn name(self) -> &'static str {
        match self {
            Self::LieEuler => "lie_euler",
            Self::LieEulerAdjoint => "lie_euler_adjoint",
            Self::LieVerlet => "lie_verlet",
            Self::LieVerletLagrangian => "lie_verlet_lagrangian",
        }
    }

    /// What is known of it.
    pub fn facts(self) -> Facts {
        match self {
            Self::LieEuler | Self::LieEulerAdjoint => LieEuler::facts(),
            Self::LieVerlet => LieVerlet::facts(),
            Self::LieVerletLagrangian => LagrangianVerlet::facts(),
        }
    }

    /// Starts the method at `state` with steps of `step` seconds.
    ///
    /// # Errors
    /// A [`SystemError`] when the state is not one of the system or the step not a positive number.
    pub fn start(
        self,
        system: &System,
        state: &SystemState,
        step: f64,
        settings: &Settings,
    ) -> Result<Box<dyn Integrator>, SystemError> {
        system.check(state)?;
        if !(step > 0.0 && step.is_finite()) {
            return Err(SystemError::Step { step });
        }
        let tolerance = settings.tolerance;
        if !(1e-15..=0.1).contains(&tolerance) {
            return Err(SystemError::Tolerance { tolerance });
        }
        Ok(match self {
            Self::LieEuler => Box::new(LieEuler::new(system, state, step, false)),
            Self::LieEulerAdjoint => Box::new(LieEuler::new(system, state, step, true)),
            Self::LieVerlet => Box::new(LieVerlet::new(system, state, step)),
            Self::LieVerletLagrangian => Box::new(LagrangianVerlet::new(system, state, step)),
        })
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Kind {
    type Err = UnknownKind;

    fn from_str(name: &str) -> Result<Self, UnknownKind> {
        Self::all().find(|kind| kind.name() == name).ok_or_else(|| UnknownKind { name: name.into() })
    }
}
