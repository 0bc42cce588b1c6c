//! The windows of a plan over which finer runs are made: a few time intervals, spread from the
//! start to the end.
//!
//! A fault of the scheme acts in every step. Both the error due to the fault and the discretisation
//! error over a window are proportional to the length of the window. A window therefore shows the
//! order of convergence of the whole plan, with less round-off. The continuous witness passes the
//! whole plan and records its state at both ends of each window. Every finer run starts from these
//! states.

use super::continuous::Continuous;
use super::motion::Phase;
use crate::maneuver::grid::Grid;
use crate::maneuver::problem::Problem;
use std::ops::Range;

/// Number of windows. The first and the last step of the plan each lie in a window.
const WINDOWS: usize = 8;

/// The number of steps of the plan divided by this number, rounded up, is the number of steps of a
/// window, unless `SHORTEST` is larger.
const ONE_OF: usize = 256;
/// Smallest number of steps of a window.
const SHORTEST: usize = 2;

/// A window of a plan, with the state of the continuous witness at its ends.
#[derive(Clone, Debug)]
pub(super) struct Window {
    /// Indices of the steps of the plan in the window.
    pub(super) steps: Range<usize>,
    pub(super) start: Phase,
    pub(super) end: Phase,
    /// Largest angular velocity at the nodes of the window [rad/s].
    pub(super) peak_rate: f64,
}

/// Returns the steps of each window of a plan with this number of steps. The whole plan is one
/// window if the windows would cover it.
pub(super) fn spread(steps: usize) -> Vec<Range<usize>> {
    let length = steps.div_ceil(ONE_OF).max(SHORTEST);
    if WINDOWS * length >= steps {
        return std::iter::once(0..steps).collect();
    }
    let first = |index: usize| index * (steps - length) / (WINDOWS - 1);
    (0..WINDOWS).map(|index| first(index)..first(index) + length).collect()
}

/// Records the windows of a plan while the continuous witness passes through them.
pub(super) struct Marks<'a> {
    problem: &'a Problem,
    grid: &'a Grid,
    windows: Vec<Window>,
    /// Index of the current window, or of the next one if the motion is between windows.
    at: usize,
}

impl<'a> Marks<'a> {
    pub(super) fn new(problem: &'a Problem, grid: &'a Grid, start: &Phase) -> Self {
        let window = |steps| Window { steps, start: *start, end: *start, peak_rate: 0.0 };
        Self { problem, grid, windows: spread(problem.steps).into_iter().map(window).collect(), at: 0 }
    }

    /// Records the motion at a node.
    pub(super) fn pass(&mut self, node: usize, body: &Continuous) {
        while let Some(window) = self.windows.get_mut(self.at).filter(|window| window.steps.start <= node) {
            let phase = body.phase(self.grid.after(node));
            window.peak_rate = window.peak_rate.max(phase.angular_velocity(self.problem).norm());
            if node == window.steps.start {
                window.start = phase;
            }
            if node < window.steps.end {
                return;
            }
            window.end = phase;
            self.at += 1;
        }
    }

    pub(super) fn windows(self) -> Vec<Window> {
        self.windows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_reach_from_the_first_to_the_last_step_and_do_not_overlap() {
        for steps in (1..300).chain([1000, 10_000, 123_457, 1_000_000]) {
            let windows = spread(steps);
            assert_eq!((windows[0].start, windows[windows.len() - 1].end), (0, steps));
            assert!(windows.windows(2).all(|pair| pair[0].end <= pair[1].start), "{steps}: {windows:?}");
            let covered: usize = windows.iter().map(ExactSizeIterator::len).sum();
            assert!(covered >= steps.min(16) && covered * 32 >= steps, "{steps}: {windows:?}");
        }
    }
}
