//! Tuning constants of the search for arcs, which the theory does not determine.

/// Settings of the grids; `cargo run --release -p evidence -- limited_arcs` counts the arcs that
/// are found.
pub(super) struct OnEvents {
    /// Total number of steps of the first grid, one entry for each attempt. More steps resolve
    /// shorter arcs, and take longer.
    pub steps: [usize; 3],
    /// Number of attempts unless the search is thorough. More attempts find more arcs and take
    /// longer.
    pub by_default: usize,
    /// Largest product of iterations and steps of the interior-point method unless the search is
    /// thorough. It bounds the run time if inputs chatter. A larger value finds arcs that need many
    /// iterations.
    pub most: usize,
    /// Steps of the uniform grid on which events are first read, as a multiple of the steps of the
    /// first grid: more steps resolve shorter arcs.
    pub read: usize,
    /// Fewest steps of an arc on the first grid. The values of an input on an arc along a limit are
    /// extrapolated to its ends from two cells.
    pub of_arc: usize,
    /// Time difference, as a fraction of the duration, below which two events are merged; also the
    /// pulse width below which a pulse is ignored.
    pub apart: f64,
    /// Largest number of rounds of the fixed-point iteration on one grid.
    pub rounds: usize,
    /// Number of rounds after which no event is dropped any more.
    pub free: usize,
    /// Time difference, as a fraction of the duration, below which events of two rounds are the
    /// same.
    pub near: f64,
    /// Largest change of an event time, as a fraction of the duration, with which the iteration has
    /// converged.
    pub settled: f64,
    /// Last barrier parameter of the interior-point method: the cost exceeds the optimum by this
    /// value for each active row.
    pub barrier: f64,
    /// Largest relative error of the extrapolated cost for which arcs are reported.
    pub error: f64,
    /// Largest distance between two paths that count as the same plan \[rad\].
    pub of_the_plan: f64,
    /// Fewest cells of an arc on which an input is between its limits. Fewer cells belong to a
    /// switch.
    pub cells: usize,
    /// Distance between the end of a step and the point at which a cone is touched, as a fraction
    /// of the step, below which the cone is touched at the node.
    pub at_node: f64,
    /// Difference of the levels of neighbouring arcs, as a fraction of the limit, below which there
    /// is no switch: an input that continues without a jump needs no node there.
    pub same_level: f64,
}

/// Tuned values of [`OnEvents`].
pub(super) const ON_EVENTS: OnEvents = OnEvents {
    steps: [24, 48, 96],
    by_default: 2,
    most: 40_000,
    read: 4,
    of_arc: 3,
    apart: 1e-4,
    rounds: 10,
    free: 2,
    near: 3e-3,
    settled: 1e-8,
    barrier: 1e-13,
    error: 1e-6,
    of_the_plan: 0.1,
    cells: 3,
    at_node: 0.01,
    same_level: 1e-2,
};
