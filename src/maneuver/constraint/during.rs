//! The times at which a constraint is active.

use std::sync::Arc;

/// The times at which a constraint is active: always, or in closed intervals \[s\], counted from
/// the start of the maneuver.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct During(Option<Arc<[[f64; 2]]>>);

impl During {
    /// Builds the times of a constraint that is active in these intervals \[s\], in order; an empty
    /// list means never. [`super::Constraint::check`] checks the order.
    pub fn intervals(intervals: impl Into<Arc<[[f64; 2]]>>) -> Self {
        Self(Some(intervals.into()))
    }

    /// Returns the active intervals \[s\]; `None` if the constraint is always active.
    pub fn given(&self) -> Option<&[[f64; 2]]> {
        self.0.as_deref()
    }

    /// Returns the intersection of the active times with these intervals \[s\], in order.
    pub fn within(&self, intervals: &[[f64; 2]]) -> Self {
        let Some(own) = self.given() else { return Self::intervals(intervals) };
        let common = |[from, to]: &[f64; 2]| {
            let both = own.iter().map(move |[begin, end]| [begin.max(*from), end.min(*to)]);
            both.filter(|[from, to]| from < to).collect::<Vec<_>>()
        };
        Self::intervals(intervals.iter().flat_map(common).collect::<Vec<_>>())
    }

    /// Returns the active times on a clock that starts `by` \[s\] later.
    pub fn later(&self, by: f64) -> Self {
        let moved = |times: &[[f64; 2]]| times.iter().map(|times| times.map(|time| time - by)).collect();
        Self(self.given().map(moved))
    }

    /// Returns whether the constraint is active at a time \[s\].
    pub fn contains(&self, time: f64) -> bool {
        let Some(intervals) = self.given() else { return true };
        let next = intervals.partition_point(|[_, to]| *to < time);
        intervals.get(next).is_some_and(|[from, _]| *from <= time)
    }

    /// Returns the parts of the step from `time` on in which the constraint is active, as fractions
    /// of the step from 0 to 1.
    pub fn parts(&self, time: f64, step: f64) -> impl Iterator<Item = [f64; 2]> + use<'_> {
        let always = self.0.is_none().then_some([0.0, 1.0]);
        let intervals = self.given().unwrap_or_default();
        let first = intervals.partition_point(|[_, to]| *to <= time);
        let within = intervals[first..].iter().take_while(move |[from, _]| *from < time + step);
        let part = move |[from, to]: &[f64; 2]| [(from - time) / step, (to - time) / step];
        always.into_iter().chain(within.map(part).map(|[from, to]| [from.max(0.0), to.min(1.0)]))
    }

    /// Returns the interval from the start of the first to the end of the last active part of a
    /// step, as fractions of the step; `None` if the constraint is not active in the step.
    pub fn hull(&self, time: f64, step: f64) -> Option<[f64; 2]> {
        self.parts(time, step).reduce(|[from, _], [_, to]| [from, to])
    }

    /// Returns whether the intervals are finite and follow each other.
    pub(super) fn is_in_order(&self) -> bool {
        let times: Vec<f64> = self.given().into_iter().flatten().flatten().copied().collect();
        times.iter().all(|time| time.is_finite()) && times.windows(2).all(|pair| pair[0] <= pair[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_cut_where_intervals_begin_and_end() {
        let during = During::intervals([[1.0, 2.0], [2.5, 2.75], [7.0, 9.0]]);
        let parts = |time: f64| during.parts(time, 2.0).collect::<Vec<_>>();
        assert_eq!(parts(0.0), [[0.5, 1.0]]);
        assert_eq!(parts(1.0), [[0.0, 0.5], [0.75, 0.875]]);
        assert_eq!(parts(3.0), [[0.0; 2]; 0]);
        assert_eq!(parts(7.5), [[0.0, 0.75]]);
        assert_eq!(during.hull(1.0, 2.0), Some([0.0, 0.875]));
        assert_eq!(during.hull(4.0, 2.0), None);
        for (time, acts) in [(0.9, false), (1.0, true), (2.0, true), (2.2, false), (8.0, true), (9.1, false)]
        {
            assert_eq!(during.contains(time), acts, "{time}");
        }
        let common = during.within(&[[0.0, 1.5], [1.7, 2.6], [6.0, 8.0]]);
        assert_eq!(common.given().unwrap(), [[1.0, 1.5], [1.7, 2.0], [2.5, 2.6], [7.0, 8.0]]);
        assert_eq!(During::default().within(&[[1.0, 2.0]]), During::intervals([[1.0, 2.0]]));
        assert!(During::default().contains(1e9));
        assert_eq!(During::default().hull(4.0, 2.0), Some([0.0, 1.0]));
        assert_eq!(During::intervals([]).hull(0.0, 1e9), None);
    }
}
