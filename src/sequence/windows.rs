//! Windows that cannot be kept, proved by the lower bounds of the legs ([`super::leg_bound`]).
//!
//! Where the body begins and ends at rest, a motion by way of other stops is a motion from the one
//! to the other too, so the bound of the straight leg holds for it. A given order adds up its legs.
//! In a free order a stop may come first; and of two stops one comes before the other. A limit of the
//! rate bounds every leg by its angle, whether the body rests at its ends or not.

use super::leg_bound::LegBound;
use super::{Ordering, Place, Sequence, carried, tracked};
use crate::lie;
use crate::maneuver::constraint::{Rule, angle_between};
use crate::{Matrix3, Vector3};

/// Windows that no plan can keep.
#[derive(Clone, Debug, PartialEq)]
pub struct Missed {
    /// The stop, or both stops, whose windows these are.
    pub stops: Vec<usize>,
    /// By how much the hold begins too late at least \[s\].
    pub late: f64,
}

/// Returns windows that no plan of a sequence can keep; `None` where the bounds prove nothing.
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

/// Lower bounds of the legs between stops.
struct Bounds<'a> {
    sequence: &'a Sequence,
    /// Those from rest to rest; `None` where the body does not begin at rest, or wheels store momentum.
    legs: Option<LegBound>,
    /// The limit of the rate [rad/s]; infinite without one.
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

    /// Returns the least time from the start, or from a stop, to a stop \[s\].
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

    /// Returns an angle \[rad\] that every turn between two places has, of which one leaves the roll
    /// free: that between the directions of its boresight.
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
