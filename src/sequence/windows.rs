//! Windows that no plan can keep, as lower bounds on the legs prove ([`super::leg_bound`]).
//!
//! If the body begins and ends at rest, a motion from one stop to another by way of further stops
//! is also a motion between the two, so the lower bound of the direct leg applies to it. For a
//! given order the bounds of the legs add up. In a free order any stop may come first, and of two
//! stops one precedes the other. A rate limit gives a lower bound for every leg from its angle,
//! whether or not the body rests at the ends.

use super::leg_bound::LegBound;
use super::{Ordering, Place, Sequence, carried, tracked};
use crate::lie;
use crate::maneuver::constraint::{Rule, angle_between};
use crate::{Matrix3, Vector3};

/// Windows that no plan can keep, with the least possible delay.
#[derive(Clone, Debug, PartialEq)]
pub struct Missed {
    /// Index of the stop with such a window, or the indices of two stops whose windows exclude each
    /// other.
    pub stops: Vec<usize>,
    /// Lower bound of the delay by which a hold begins too late \[s\].
    pub late: f64,
}

/// Returns windows that no plan of a sequence can keep; `None` if the bounds prove nothing.
pub fn missed(sequence: &Sequence) -> Option<Missed> {
    let bounds = Bounds::of(sequence);
    let visits: Vec<_> = sequence.stops.iter().map(|stop| stop.visit).collect();
    if sequence.order == Ordering::Given {
        let (mut from, mut time) = (None, 0.0);
        for (stop, visit) in visits.iter().enumerate() {
            let (end, late) = visit.after(time + bounds.least(from, stop));
            if late > 0.0 {
                return Some(Missed { stops: vec![stop], late });
            }
            (from, time) = (Some(stop), end);
        }
        return None;
    }
    let first = |stop: usize| visits[stop].after(bounds.least(None, stop));
    let alone = (0..visits.len()).map(|stop| Missed { stops: vec![stop], late: first(stop).1 });
    let second = |from: usize, to: usize| visits[to].after(first(from).0 + bounds.least(Some(from), to)).1;
    let pairs = (0..visits.len()).flat_map(|one| (0..one).map(move |other| (other, one)));
    let pairs = pairs.map(|(one, other)| Missed {
        stops: vec![one, other],
        late: second(one, other).min(second(other, one)),
    });
    alone.chain(pairs).find(|missed| missed.late > 0.0)
}

/// Lower bounds on the durations of the legs between stops.
struct Bounds<'a> {
    sequence: &'a Sequence,
    /// Bounds for legs from rest to rest; `None` if the body does not begin at rest, or if wheels
    /// store momentum.
    legs: Option<LegBound>,
    /// The rate limit [rad/s]; infinite if the craft has none.
    fastest: f64,
}

impl<'a> Bounds<'a> {
    fn of(sequence: &'a Sequence) -> Self {
        let craft = &sequence.craft;
        let rests = craft.start.angular_velocity == Vector3::zeros()
            && carried::momentum(craft) == Vector3::zeros()
            && craft.is_free_turn();
        let fastest = craft.constraints.iter().map(|constraint| match &constraint.rule {
            Rule::RateNorm(limit) => *limit,
            Rule::RateAxes(limits) => limits.norm(),
            Rule::Pointing(_) => f64::INFINITY,
        });
        let fastest = fastest.fold(f64::INFINITY, f64::min);
        Self { sequence, legs: rests.then(|| LegBound::new(craft)), fastest }
    }

    /// Returns a lower bound of the time \[s\] from the start (`None`) or from a stop to a stop.
    fn least(&self, from: Option<usize>, to: usize) -> f64 {
        let stops = &self.sequence.stops;
        let moves = |stop: usize| tracked::moves(&stops[stop]);
        if moves(to) || from.is_some_and(moves) {
            return 0.0;
        }
        let passes = |stop: usize| stops[stop].passing.is_some();
        let legs = self.legs.as_ref().filter(|_| !passes(to) && !from.is_some_and(passes));
        let given =
            |place: &Place| if let Place::Attitude(attitude) = place { Some(*attitude) } else { None };
        let begins = match from {
            None => Some(self.sequence.craft.start.attitude),
            Some(from) => given(&stops[from].place),
        };
        let (angle, rest) = match (begins, given(&stops[to].place)) {
            (Some(begins), Some(ends)) => {
                let turn = begins.transpose() * ends;
                (lie::log(&turn).norm(), legs.map(|legs| legs.time(&turn)))
            }
            (begins, ends) => {
                let angle = self.least_angle(from, to, begins, ends);
                (angle, legs.map(|legs| legs.time_of_angle(angle)))
            }
        };
        rest.unwrap_or(0.0).max(angle / self.fastest)
    }

    /// Returns a lower bound of the angle \[rad\] of all turns between two places of which at least
    /// one leaves the roll free: the angle between the directions of the boresight.
    fn least_angle(
        &self,
        from: Option<usize>,
        to: usize,
        begins: Option<Matrix3>,
        ends: Option<Matrix3>,
    ) -> f64 {
        let stops = &self.sequence.stops;
        let aim = |stop: usize| if let Place::Aim(aim) = &stops[stop].place { Some(aim) } else { None };
        let direction = |stop: usize| aim(stop).map(|aim| aim.at.at(0.0, &Vector3::zeros()));
        match (from.and_then(aim), aim(to), begins, ends) {
            (_, Some(to_aim), Some(begins), _) => {
                direction(to).map_or(0.0, |at| angle_between(&(begins * to_aim.boresight), &at))
            }
            (Some(from_aim), None, _, Some(ends)) => {
                from.and_then(direction).map_or(0.0, |at| angle_between(&(ends * from_aim.boresight), &at))
            }
            (Some(from_aim), Some(to_aim), ..) if from_aim.boresight == to_aim.boresight => from
                .and_then(direction)
                .zip(direction(to))
                .map_or(0.0, |(one, other)| angle_between(&one, &other)),
            _ => 0.0,
        }
    }
}
