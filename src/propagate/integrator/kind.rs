//! The integration methods and their names.

use super::adaptive::Reference;
use super::course::Course;
use super::drift_and_kick::DriftAndKick;
use super::galerkin::{DEGREES, Galerkin, Quadrature};
use super::implicit_midpoint::ImplicitMidpoint;
use super::lagrangian_verlet::LagrangianVerlet;
use super::lie_group_rk::{Composition, LieGroupRk};
use super::runge_kutta::RungeKutta;
use super::tableau::{self, Tableau};
use super::{Facts, Integrator, System, SystemError, SystemState};
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// An integration method. Its name is stable, because files and commands use it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// `lie_euler`: drift, then kick; first order. Inputs act at the end of a step.
    LieEuler,
    /// `lie_euler_adjoint`: kick, then drift; first order. Inputs act at the start of a step.
    LieEulerAdjoint,
    /// `lie_verlet`: Lie velocity Verlet in Hamiltonian form; second order. The recommended first
    /// choice.
    LieVerlet,
    /// `lie_verlet_lagrangian`: the map of `lie_verlet`, computed as a discrete Lagrangian map.
    LieVerletLagrangian,
    /// `galerkin_gauss_1` … `galerkin_lobatto_6`: variational methods with polynomial curves of
    /// degree 1 to 6; the order is twice the degree.
    Galerkin {
        /// Degree of the curves, 1 to 6.
        degree: usize,
        /// The quadrature rule for the action of a step.
        quadrature: Quadrature,
    },
    /// `explicit_midpoint`: Runge's rule of order 2 on the matrix elements (RK).
    ExplicitMidpoint,
    /// `implicit_midpoint`: order 2 on the matrix elements, by fixed-point iteration to 1e-13
    /// (SRK).
    ImplicitMidpoint,
    /// `crouch_grossman_2`: order 2 with products of exponentials (LGM).
    CrouchGrossman2,
    /// `crouch_grossman_3`: order 3 with products of exponentials.
    CrouchGrossman3,
    /// `rkmk4`: Runge–Kutta–Munthe-Kaas with Kutta's method, order 4.
    MuntheKaas4,
    /// `rkf78`: Fehlberg's 7(8) with a fixed step, order 8.
    Fehlberg78,
    /// `rkf78_adaptive`: Fehlberg's 7(8) with error control within each step.
    Fehlberg78Adaptive,
    /// `dop853`: Dormand and Prince's 8(5,3) with error control within each step.
    Dop853,
    /// `verner98`: Verner's 9(8) with error control within each step.
    Verner98,
}

/// The accuracy of methods with error control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorControl {
    /// Allowed error per step, relative to the size of each quantity, from 1e-14 to 0.1. Default:
    /// 1e-13. Methods with a fixed step ignore it.
    pub tolerance: f64,
}

impl Default for ErrorControl {
    fn default() -> Self {
        Self { tolerance: 1e-13 }
    }
}

/// No integration method has this name.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("no integrator is called '{name}'; the integrators are {}", Kind::NAMES.join(", "))]
pub struct UnknownKind {
    /// The unknown name.
    pub name: String,
}

const fn gauss(degree: usize) -> Kind {
    Kind::Galerkin { degree, quadrature: Quadrature::Gauss }
}

const fn lobatto(degree: usize) -> Kind {
    Kind::Galerkin { degree, quadrature: Quadrature::Lobatto }
}

/// All methods with their names.
const NAMES: [(Kind, &str); 25] = [
    (Kind::LieEuler, "lie_euler"),
    (Kind::LieEulerAdjoint, "lie_euler_adjoint"),
    (Kind::LieVerlet, "lie_verlet"),
    (Kind::LieVerletLagrangian, "lie_verlet_lagrangian"),
    (gauss(1), "galerkin_gauss_1"),
    (gauss(2), "galerkin_gauss_2"),
    (gauss(3), "galerkin_gauss_3"),
    (gauss(4), "galerkin_gauss_4"),
    (gauss(5), "galerkin_gauss_5"),
    (gauss(6), "galerkin_gauss_6"),
    (lobatto(1), "galerkin_lobatto_1"),
    (lobatto(2), "galerkin_lobatto_2"),
    (lobatto(3), "galerkin_lobatto_3"),
    (lobatto(4), "galerkin_lobatto_4"),
    (lobatto(5), "galerkin_lobatto_5"),
    (lobatto(6), "galerkin_lobatto_6"),
    (Kind::ExplicitMidpoint, "explicit_midpoint"),
    (Kind::ImplicitMidpoint, "implicit_midpoint"),
    (Kind::CrouchGrossman2, "crouch_grossman_2"),
    (Kind::CrouchGrossman3, "crouch_grossman_3"),
    (Kind::MuntheKaas4, "rkmk4"),
    (Kind::Fehlberg78, "rkf78"),
    (Kind::Fehlberg78Adaptive, "rkf78_adaptive"),
    (Kind::Dop853, "dop853"),
    (Kind::Verner98, "verner98"),
];

impl Kind {
    /// The names of all methods, in the order of [`Kind::all`].
    pub const NAMES: [&'static str; NAMES.len()] = {
        let mut names = [""; NAMES.len()];
        let mut index = 0;
        while index < NAMES.len() {
            names[index] = NAMES[index].1;
            index += 1;
        }
        names
    };

    /// Returns all methods, in the order of [`Kind::NAMES`].
    pub fn all() -> impl Iterator<Item = Self> {
        NAMES.into_iter().map(|(kind, _)| kind)
    }

    /// Returns the name of the method in files and commands.
    pub fn name(self) -> &'static str {
        NAMES.iter().find(|(kind, _)| *kind == self).map_or("galerkin", |(_, name)| name)
    }

    /// Returns the theoretical properties of the method.
    pub fn facts(self) -> Facts {
        let variational = Facts::VARIATIONAL;
        let on_group = |tableau: &Tableau| Facts {
            order: tableau.order,
            symplectic: false,
            preserves_momentum: false,
            force_evaluations: Some(tableau.c.len() as u32),
            ..variational
        };
        let explicit = |tableau: &Tableau| Facts { preserves_group: false, ..on_group(tableau) };
        let adaptive =
            |order: u32| Facts { order, force_evaluations: None, ..explicit(&tableau::FEHLBERG_78) };
        match self {
            Self::LieEuler | Self::LieEulerAdjoint => Facts { order: 1, ..variational },
            Self::LieVerlet | Self::LieVerletLagrangian => variational,
            Self::Galerkin { degree, .. } => Galerkin::facts(degree),
            Self::ExplicitMidpoint => explicit(&tableau::MIDPOINT),
            Self::ImplicitMidpoint => {
                Facts { explicit: false, force_evaluations: None, ..on_group(&tableau::MIDPOINT) }
            }
            Self::CrouchGrossman2 => on_group(&tableau::MIDPOINT),
            Self::CrouchGrossman3 => on_group(&tableau::CROUCH_GROSSMAN_3),
            Self::MuntheKaas4 => on_group(&tableau::KUTTA_4),
            Self::Fehlberg78 => explicit(&tableau::FEHLBERG_78),
            Self::Fehlberg78Adaptive | Self::Dop853 => adaptive(8),
            Self::Verner98 => adaptive(9),
        }
    }

    /// Starts the method at `state`, with steps of length `step` \[s\].
    ///
    /// # Errors
    /// A [`SystemError`] if the state does not fit the system, or if the step is not a positive
    /// number.
    pub fn start(
        self,
        system: &System,
        state: &SystemState,
        step: f64,
        settings: &ErrorControl,
    ) -> Result<Box<dyn Integrator>, SystemError> {
        system.check(state)?;
        if !(step > 0.0 && step.is_finite()) {
            return Err(SystemError::Step { step });
        }
        let tolerance = settings.tolerance;
        if !(1e-14..=0.1).contains(&tolerance) {
            return Err(SystemError::Tolerance { tolerance });
        }
        let course = || Course::new(system, state, step, self.facts());
        let explicit = |tableau, tolerance| Box::new(RungeKutta::new(course(), tableau, tolerance));
        let on_group = |tableau, composition| Box::new(LieGroupRk::new(course(), tableau, composition));
        let drift_and_kick = |before| Box::new(DriftAndKick::new(course(), before));
        Ok(match self {
            Self::LieEuler => drift_and_kick(0.0),
            Self::LieEulerAdjoint => drift_and_kick(1.0),
            Self::LieVerlet => drift_and_kick(0.5),
            Self::LieVerletLagrangian => Box::new(LagrangianVerlet::new(course())),
            Self::Galerkin { degree, quadrature } => {
                if !DEGREES.contains(&degree) {
                    return Err(SystemError::Degree { degree });
                }
                Box::new(Galerkin::new(system, state, step, degree, quadrature))
            }
            Self::ExplicitMidpoint => explicit(tableau::MIDPOINT, None),
            Self::ImplicitMidpoint => Box::new(ImplicitMidpoint::new(course())),
            Self::CrouchGrossman2 => on_group(tableau::MIDPOINT, Composition::CrouchGrossman),
            Self::CrouchGrossman3 => on_group(tableau::CROUCH_GROSSMAN_3, Composition::CrouchGrossman),
            Self::MuntheKaas4 => on_group(tableau::KUTTA_4, Composition::MuntheKaas),
            Self::Fehlberg78 => explicit(tableau::FEHLBERG_78, None),
            Self::Fehlberg78Adaptive => explicit(tableau::FEHLBERG_78, Some(tolerance)),
            Self::Dop853 => Box::new(Reference::dop853(course(), tolerance)),
            Self::Verner98 => Box::new(Reference::verner98(course(), tolerance)),
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
