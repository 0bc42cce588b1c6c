//! Tuning constants of the search on a uniform grid, which neither the maneuver nor the theory
//! determines.

/// Settings of the search on a uniform grid, such as the number of initial paths and the
/// differences below which plans are equal.
#[derive(Clone, Debug)]
pub struct SearchTuning {
    /// Displacement of a bent initial path to either side \[rad\]. A smaller displacement leads to
    /// the optimum of the straight path; a larger one crosses more cones (`cargo bench -p benches
    /// --bench everyday`).
    pub bend: f64,
    /// Angle of the turn from which the short way may no longer be the best one \[rad\]. A smaller
    /// value takes more starts (`evidence -- guard --part best_known`).
    pub nearly_half: f64,
    /// Initial durations if the duration is free and the body moves at an end, as fractions of the
    /// duration of the problem. More values find quicker plans with fewer turns, and take longer
    /// (`evidence -- ends --only spins`).
    pub durations: [f64; 4],
    /// Initial duration of a search for the optimal duration, as a multiple of the duration of a
    /// nearly feasible motion. A larger value leaves more margin to the limits, and turns a
    /// spinning body farther.
    pub slowed: f64,
    /// Angle of the uncontrolled motion \[rad\] from which initial paths with more and fewer turns
    /// are also used. A smaller value takes more starts
    /// (`evidence -- ends --only "matched rates"`).
    pub carried_on: f64,
    /// Relative difference between the coarse-grid costs of two plans below which both are refined
    /// on the requested grid. A larger value takes more solves on the requested grid (`cargo bench
    /// -p benches --bench everyday`).
    pub close: f64,
    /// Largest number of plans that are refined on the requested grid. More plans take longer, but
    /// find optima whose order changes with the grid (`evidence -- guard --part best_known`).
    pub carried: usize,
    /// Relative difference between the coarse-grid costs of two plans below which they are the same
    /// optimum. A larger value loses optima of nearly equal cost (`cargo bench -p benches --bench
    /// everyday`).
    pub one: f64,
    /// Limit violation on the coarse grid above which the maneuver without limits is not solved on
    /// the fine grid. A smaller value loses the proof that no plan is cheaper (`evidence -- guard
    /// --part problems`).
    pub clear_violation: f64,
    /// Largest scaled terminal error of the true motion of a plan. A plan with a larger error is
    /// rejected (`evidence -- guard --part problems`).
    pub far: f64,
    /// First change of the roll from the result of the chain, which differs from the best roll by
    /// second order in the step \[rad\]. A larger change takes more plans (`evidence -- rolls`).
    pub stride: f64,
}

impl Default for SearchTuning {
    fn default() -> Self {
        Self {
            bend: 0.5,
            nearly_half: 150_f64.to_radians(),
            durations: [0.3, 0.45, 0.65, 0.99],
            slowed: 1.001,
            carried_on: 1.0,
            close: 0.02,
            carried: 3,
            one: 1e-5,
            clear_violation: 0.05,
            far: 1.0,
            stride: 0.05,
        }
    }
}
