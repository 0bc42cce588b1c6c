//! Every number of the search for arcs that the theory does not give.

/// Settings of the grids; `cargo run --release -p evidence -- limited_arcs` counts what they find.
pub(super) struct OnEvents {
    /// Steps of the first grid in all, of one attempt after the other: more resolve shorter arcs,
    /// and take longer.
    pub steps: [usize; 3],
    /// Attempts of a search that is not thorough: time against arcs that are found.
    pub by_default: usize,
    /// Iterations times steps of the interior point that a search takes at most, if it is not
    /// thorough: time where inputs chatter against arcs that are found late.
    pub most: usize,
    /// Equal steps on which the events are read first, as a multiple of those of the first grid:
    /// more of them tell shorter arcs.
    pub read: usize,
    /// Steps of an arc on the first grid, at least: the values of an input that holds a limit are
    /// continued from two cells to its ends.
    pub of_arc: usize,
    /// Events that are nearer to each other than this part of the duration are one, and pulses that
    /// are shorter are none.
    pub apart: f64,
    /// Rounds on one grid, at most.
    pub rounds: usize,
    /// Rounds after which no event is dropped any more.
    pub free: usize,
    /// Part of the duration within which two events of two rounds are one.
    pub near: f64,
    /// Move of an event, as a part of the duration, at which the rounds end.
    pub settled: f64,
    /// Last barrier term: the cost exceeds the optimum by this for each active row.
    pub barrier: f64,
    /// Largest error of the extrapolated cost, relative, with which arcs are told.
    pub error: f64,
    /// Paths that are farther apart somewhere than this are those of two plans \[rad\].
    pub of_the_plan: f64,
    /// Cells of one arc, at least, of an input that is within its limits: fewer are those of a
    /// switch.
    pub cells: usize,
    /// A touch within this part of a step of its ends is one at a node.
    pub at_node: f64,
    /// Levels of neighbouring arcs that differ by less than this part of the limit are no switch:
    /// an input that passes from one arc to the next without a jump needs no node there.
    pub same_level: f64,
}

/// The settings.
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
