//! Every number of the search on equal steps that neither the maneuver nor the theory gives.

/// Settings of the search on equal steps: how many paths it begins from, and which plans it takes
/// for one.
#[derive(Clone, Debug)]
pub struct SearchTuning {
    /// How far a path is bent to either side \[rad\]: of a path that is bent less the optimum is
    /// that of the straight one, and one that is bent more crosses more cones (`cargo bench -p
    /// benches --bench everyday`).
    pub bend: f64,
    /// A turn by more than this may be longer than the other way round \[rad\]: a smaller one takes
    /// more starts (`evidence -- guard --part best_known`).
    pub nearly_half: f64,
    /// Durations in which a body that moves at an end begins, as parts of the stated one, where the
    /// duration is sought: more of them find quicker plans with fewer turns, and take longer
    /// (`evidence -- ends --only spins`).
    pub durations: [f64; 4],
    /// Duration of a motion that is nearly a plan, as a multiple of its own, with which a search of
    /// the duration begins: a larger one leaves more room within the limits, and turns a body that
    /// spins farther.
    pub slowed: f64,
    /// Angle by which a body turns by itself in a maneuver \[rad\] from which turns more and less
    /// are paths too: a smaller one takes more starts (`evidence -- ends --only "matched rates"`).
    pub carried_on: f64,
    /// How far the coarse costs of two plans may lie apart, relative, for both to be carried to the
    /// requested grid: a larger one takes more solves there (`cargo bench -p benches --bench
    /// everyday`).
    pub close: f64,
    /// How many are carried at most: time against optima whose order changes with the grid
    /// (`evidence -- guard --part best_known`).
    pub carried: usize,
    /// By how much coarse costs of one optimum differ, relative: a larger one loses optima that
    /// cost about the same (`cargo bench -p benches --bench everyday`).
    pub one: f64,
    /// A violation on the coarse grid that spares the fine solve of the maneuver without limits: a
    /// smaller one loses its proof that nothing is cheaper (`evidence -- guard --part problems`).
    pub clear_violation: f64,
    /// Largest scaled miss of the true motion at the end of a plan: beyond it the plan is none of
    /// this body (`evidence -- guard --part problems`).
    pub far: f64,
    /// First stride from the roll of the chain \[rad\], of second order in the step: a larger one
    /// takes more plans (`evidence -- rolls`).
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
