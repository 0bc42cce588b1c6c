//! What two legs share at the stop between them.
//!
//! A joint leaves numbers free: the roll about a boresight, the rate of the body that passes, or
//! both. The legs on either side have the state that these give for an end, and the slope of both
//! costs by them vanishes in the best plan, or leads out of their bounds:
//!
//! ```text
//! roll at rest      b·λ^R continuous
//! rate of a passage λ^Π continuous;  with |ω| = ω̄ reached   J λ^Π⁺ = J λ^Π⁻ − ν ω ,  ν ≥ 0
//! ```

use super::leg::Slopes;
use crate::Vector3;
use crate::maneuver::aim::Ends;
use crate::maneuver::problem::State;

/// A stop as an end of two legs.
#[derive(Clone, Debug)]
pub enum Joint {
    /// The state is given: the legs share nothing.
    Given(State),
    /// A boresight points at a target: the roll is free, or within a band.
    Roll(Ends),
    /// The body passes through an attitude, at a rate whose norm has a bound \[rad/s\].
    Passing { at: State, fastest: f64 },
    /// A boresight passes over a target: the roll and the rate are free up to their bounds.
    PassingRoll { ends: Ends, fastest: f64 },
}

impl Joint {
    /// Returns how many numbers are free.
    pub fn size(&self) -> usize {
        match self {
            Self::Given(_) => 0,
            Self::Roll(_) => 1,
            Self::Passing { .. } => 3,
            Self::PassingRoll { .. } => 4,
        }
    }

    /// Returns the state for numbers that are free.
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

    /// Returns the numbers of a state that the joint may have.
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

    /// Returns the slope by the numbers that are free from those by the state.
    pub fn slope(&self, free: &[f64], [by_turn, by_rate]: &Slopes) -> Vec<f64> {
        match self {
            Self::Given(_) => Vec::new(),
            Self::Roll(ends) => {
                let (turn, change) = ends.along_roll(&ends.at(free[0]).1);
                vec![by_turn.dot(&turn) + by_rate.dot(&change)]
            }
            Self::Passing { .. } => by_rate.iter().copied().collect(),
            Self::PassingRoll { ends, .. } => {
                // The rate is given in body axes, whatever the roll.
                let (turn, _) = ends.along_roll(&Vector3::zeros());
                std::iter::once(by_turn.dot(&turn)).chain(by_rate.iter().copied()).collect()
            }
        }
    }

    /// Moves numbers into their bounds, by as little as possible.
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
