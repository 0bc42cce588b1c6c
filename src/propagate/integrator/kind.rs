//! The methods by name.

use super::adaptive::Reference;
use super::galerkin::{DEGREES, Galerkin, Quadrature};
use super::implicit_midpoint::ImplicitMidpoint;
use super::lagrangian_verlet::LagrangianVerlet;
use super::lie_euler::LieEuler;
use super::lie_group_rk::{Composition, LieGroupRk};
use super::lie_verlet::LieVerlet;
use super::runge_kutta::RungeKutta;
use super::tableau;
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
    /// `galerkin_gauss_1` … `galerkin_lobatto_6`: variational with curves of a degree; order twice that.
    Galerkin {
        /// Degree of the curves, 1 … 6.
        degree: usize,
        /// Where the action is sampled.
        quadrature: Quadrature,
    },
    /// `explicit_midpoint`: Runge's rule of order 2 on the matrix elements (RK).
    ExplicitMidpoint,
    /// `implicit_midpoint`: order 2 on the matrix elements, by fixed-point iteration to 1e-13 (SRK).
    ImplicitMidpoint,
    /// `crouch_grossman_2`: order 2 with products of exponentials (LGM).
    CrouchGrossman2,
    /// `crouch_grossman_3`: order 3 with products of exponentials.
    CrouchGrossman3,
    /// `rkmk4`: Runge–Kutta–Munthe-Kaas with Kutta's method, order 4.
    MuntheKaas4,
    /// `rkf78`: Fehlberg's 7(8) at a fixed step, order 8.
    Fehlberg78,
    /// `rkf78_adaptive`: the same with error control within each step.
    Fehlberg78Adaptive,
    /// `dop853`: Dormand and Prince's 8(5,3) with error control within each step.
    Dop853,
    /// `verner98`: Verner's 9(8) with error control within each step.
    Verner98,
}

/// Settings of the methods that have any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Error that an error control allows per step, relative to the size of each quantity, 1e-14 to 0.1. Default
    /// 1e-13; methods of fixed step length have no use for it.
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

const GAUSS: [&str; 6] = [
    "galerkin_gauss_1",
    "galerkin_gauss_2",
    "galerkin_gauss_3",
    "galerkin_gauss_4",
    "galerkin_gauss_5",
    "galerkin_gauss_6",
];
const LOBATTO: [&str; 6] = [
    "galerkin_lobatto_1",
    "galerkin_lobatto_2",
    "galerkin_lobatto_3",
    "galerkin_lobatto_4",
    "galerkin_lobatto_5",
    "galerkin_lobatto_6",
];

impl Kind {
    /// All methods.
    pub fn all() -> impl Iterator<Item = Self> {
        let galerkin = |quadrature| DEGREES.map(move |degree| Self::Galerkin { degree, quadrature });
        [Self::LieEuler, Self::LieEulerAdjoint, Self::LieVerlet, Self::LieVerletLagrangian]
            .into_iter()
            .chain(galerkin(Quadrature::Gauss))
            .chain(galerkin(Quadrature::Lobatto))
            .chain([
                Self::ExplicitMidpoint,
                Self::ImplicitMidpoint,
                Self::CrouchGrossman2,
                Self::CrouchGrossman3,
                Self::MuntheKaas4,
                Self::Fehlberg78,
                Self::Fehlberg78Adaptive,
                Self::Dop853,
                Self::Verner98,
            ])
    }

    /// Its name in files and commands.
    pub fn name(self) -> &'static str {
        match self {
            Self::LieEuler => "lie_euler",
            Self::LieEulerAdjoint => "lie_euler_adjoint",
            Self::LieVerlet => "lie_verlet",
            Self::LieVerletLagrangian => "lie_verlet_lagrangian",
            Self::Galerkin { degree, quadrature } => {
                let names = if quadrature == Quadrature::Gauss { GAUSS } else { LOBATTO };
                names.get(degree.wrapping_sub(1)).copied().unwrap_or("galerkin")
            }
            Self::ExplicitMidpoint => "explicit_midpoint",
            Self::ImplicitMidpoint => "implicit_midpoint",
            Self::CrouchGrossman2 => "crouch_grossman_2",
            Self::CrouchGrossman3 => "crouch_grossman_3",
            Self::MuntheKaas4 => "rkmk4",
            Self::Fehlberg78 => "rkf78",
            Self::Fehlberg78Adaptive => "rkf78_adaptive",
            Self::Dop853 => "dop853",
            Self::Verner98 => "verner98",
        }
    }

    /// What is known of it.
    pub fn facts(self) -> Facts {
        match self {
            Self::LieEuler | Self::LieEulerAdjoint => LieEuler::facts(),
            Self::LieVerlet => LieVerlet::facts(),
            Self::LieVerletLagrangian => LagrangianVerlet::facts(),
            Self::Galerkin { degree, .. } => Galerkin::facts(degree),
            Self::ExplicitMidpoint => RungeKutta::facts(&tableau::MIDPOINT, false),
            Self::ImplicitMidpoint => ImplicitMidpoint::facts(),
            Self::CrouchGrossman2 => LieGroupRk::facts(&tableau::MIDPOINT),
            Self::CrouchGrossman3 => LieGroupRk::facts(&tableau::CROUCH_GROSSMAN_3),
            Self::MuntheKaas4 => LieGroupRk::facts(&tableau::KUTTA_4),
            Self::Fehlberg78 => RungeKutta::facts(&tableau::FEHLBERG_78, false),
            Self::Fehlberg78Adaptive => RungeKutta::facts(&tableau::FEHLBERG_78, true),
            Self::Dop853 => Reference::facts(8),
            Self::Verner98 => Reference::facts(9),
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
        if !(1e-14..=0.1).contains(&tolerance) {
            return Err(SystemError::Tolerance { tolerance });
        }
        let explicit = |tableau, tolerance| -> Box<dyn Integrator> {
            Box::new(RungeKutta::new(system, state, step, tableau, tolerance))
        };
        let on_group = |tableau, composition| -> Box<dyn Integrator> {
            Box::new(LieGroupRk::new(system, state, step, tableau, composition))
        };
        Ok(match self {
            Self::LieEuler => Box::new(LieEuler::new(system, state, step, false)),
            Self::LieEulerAdjoint => Box::new(LieEuler::new(system, state, step, true)),
            Self::LieVerlet => Box::new(LieVerlet::new(system, state, step)),
            Self::LieVerletLagrangian => Box::new(LagrangianVerlet::new(system, state, step)),
            Self::Galerkin { degree, quadrature } => {
                if !DEGREES.contains(&degree) {
                    return Err(SystemError::Degree { degree });
                }
                Box::new(Galerkin::new(system, state, step, degree, quadrature))
            }
            Self::ExplicitMidpoint => explicit(tableau::MIDPOINT, None),
            Self::ImplicitMidpoint => Box::new(ImplicitMidpoint::new(system, state, step)),
            Self::CrouchGrossman2 => on_group(tableau::MIDPOINT, Composition::CrouchGrossman),
            Self::CrouchGrossman3 => on_group(tableau::CROUCH_GROSSMAN_3, Composition::CrouchGrossman),
            Self::MuntheKaas4 => on_group(tableau::KUTTA_4, Composition::MuntheKaas),
            Self::Fehlberg78 => explicit(tableau::FEHLBERG_78, None),
            Self::Fehlberg78Adaptive => explicit(tableau::FEHLBERG_78, Some(tolerance)),
            Self::Dop853 => Box::new(Reference::dop853(system, state, step, tolerance)),
            Self::Verner98 => Box::new(Reference::verner98(system, state, step, tolerance)),
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
