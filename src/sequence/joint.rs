//! Joints: the states that two legs share at the stop between them.
//!
//! A joint may have free parameters: the roll about a boresight, the angular velocity of a body
//! that passes without stopping, or both. They determine the state at which one leg ends and the
//! next leg begins. In the optimal plan the derivative of the total cost with respect to each
//! parameter is zero, or the parameter is at a bound. With the boresight `b`, the costates `λ`, the
//! angular velocity `ω`, its bound `ω̄`, and − and + for the legs before and after the stop:
//!
//! ```text
//! roll at rest      b·λ^R continuous
//! rate of a passage λ^Π continuous;  with |ω| = ω̄ reached   J λ^Π⁺ = J λ^Π⁻ − ν ω ,  ν ≥ 0
//! ```

use super::leg::Slopes;
use crate::Vector3;
use crate::maneuver::aim::Ends;
use crate::maneuver::problem::State;

/// The state at a stop, which the legs before and after it share.
#[derive(Clone, Debug)]
pub enum Joint {
    /// The state is given, so the joint has no free parameters.
    Given(State),
    /// A boresight points at a target. The roll is free, or limited to a band.
    Roll(Ends),
    /// The body passes through a given attitude at a free angular velocity, whose norm is at most
    /// `fastest` \[rad/s\].
    Passing { at: State, fastest: f64 },
    /// A boresight passes over a target. The roll and the angular velocity are free within their
    /// bounds; the norm of the angular velocity is at most `fastest` \[rad/s\].
    PassingRoll { ends: Ends, fastest: f64 },
}

impl Joint {
    /// Returns the number of free parameters.
    pub fn size(&self) -> usize {
        match self {
            Self::Given(_) => 0,
            Self::Roll(_) => 1,
            Self::Passing { .. } => 3,
            Self::PassingRoll { .. } => 4,
        }
    }

    /// Returns the state for the values `free` of the free parameters: the roll \[rad\] first, then
    /// the angular velocity [rad/s], if they are free.
    pub fn state(&self, free: &[f64]) -> State {
        match self {
            Self::Given(state) => *state,
            Self::Roll(ends) => {
                let (attitude, rate) = ends.at(free[0]);
                State::attitude(attitude, rate)
            }
            Self::Passing { at, .. } => State { angular_velocity: Vector3::from_column_slice(free), ..*at },
            Self::PassingRoll { ends, .. } => {
                State::attitude(ends.at(free[0]).0, Vector3::from_column_slice(&free[1..]))
            }
        }
    }

    /// Returns the values of the free parameters, within their bounds, that are nearest to a state.
    pub fn numbers(&self, state: &State) -> Vec<f64> {
        let rate = state.angular_velocity.iter().copied();
        let mut free = match self {
            Self::Given(_) => Vec::new(),
            Self::Roll(ends) => vec![ends.nearest(&state.attitude)],
            Self::Passing { .. } => rate.collect(),
            Self::PassingRoll { ends, .. } => {
                std::iter::once(ends.nearest(&state.attitude)).chain(rate).collect()
            }
        };
        self.hold(&mut free);
        free
    }

    /// Converts the gradient of a cost with respect to the state to its derivatives with respect to
    /// the free parameters, at their values `free`.
    pub fn slope(&self, free: &[f64], [by_turn, by_rate]: &Slopes) -> Vec<f64> {
        match self {
            Self::Given(_) => Vec::new(),
            Self::Roll(ends) => {
                let (turn, change) = ends.along_roll(&ends.at(free[0]).1);
                vec![by_turn.dot(&turn) + by_rate.dot(&change)]
            }
            Self::Passing { .. } => by_rate.iter().copied().collect(),
            Self::PassingRoll { ends, .. } => {
                // The angular velocity is in body axes and does not change with the roll.
                let (turn, _) = ends.along_roll(&Vector3::zeros());
                std::iter::once(by_turn.dot(&turn)).chain(by_rate.iter().copied()).collect()
            }
        }
    }

    /// Moves the values of the free parameters to the nearest values within their bounds.
    pub fn hold(&self, free: &mut [f64]) {
        let roll = |ends: &Ends, roll: &mut f64| {
            if ends.within() < std::f64::consts::PI {
                *roll = roll.clamp(-ends.within(), ends.within());
            }
        };
        let rate = |rate: &mut [f64], fastest: f64| {
            let norm = rate.iter().map(|part| part * part).sum::<f64>().sqrt();
            if norm > fastest {
                rate.iter_mut().for_each(|part| *part *= fastest / norm);
            }
        };
        match self {
            Self::Given(_) => {}
            Self::Roll(ends) => roll(ends, &mut free[0]),
            Self::Passing { fastest, .. } => rate(free, *fastest),
            Self::PassingRoll { ends, fastest } => {
                roll(ends, &mut free[0]);
                rate(&mut free[1..], *fastest);
            }
        }
    }
}
