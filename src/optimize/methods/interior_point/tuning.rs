//! Every number of the interior point that the theory does not give.

/// What the interior point may do. Costs are of order one to ten where the iteration begins, rows relative to their limits; barrier
/// terms are those of a hundred stages, and go with the length of a step.
#[derive(Clone, Debug)]
pub(crate) struct Tuning {
    /// Iterations after which it gives up.
    pub iterations: usize,
    /// Residual of all conditions at which it has converged: the smaller, the nearer to round-off, for an iteration or two.
    pub tolerance: f64,
    /// First barrier term: a larger one takes more iterations and keeps farther from bounds that the first path crosses.
    pub first: f64,
    /// Last barrier term: the cost is above the optimum by this for each row that acts.
    pub last: f64,
    /// Barrier term below which the rule of Mehrotra gives way to a monotone one, which outruns no residual, and Gauss–Newton to a
    /// shift, since it creeps along faces of optima.
    pub tail: f64,
    /// The mean complementarity at which the tail may begin.
    pub tail_mean: f64,
    /// Least first slack: a smaller one makes multipliers, and with them the curvature of violated rows, too large.
    pub slack: f64,
    /// How many barrier terms the conditions may be off when the term is lowered in the tail.
    pub lowered_at: f64,
    /// By what it is lowered: a factor, or a power where that is smaller.
    pub lowered: (f64, f64),
    /// Least part of the way to a bound that a step may go; one less the barrier term where that is more.
    pub to_boundary: f64,
    /// Price of a violated unit of an elastic row: above all multipliers, or the row gives way where it need not.
    pub price: f64,
    /// The same of terminal equations, on what the program says of its own scale.
    pub terminal_price: f64,
    /// Weight of the terminal equations in the Hessian: changes no step, and makes blocks positive that only the terminal manifold does.
    pub rho: f64,
    /// What an equation of a row gives way by: its proximal term.
    pub proximal: f64,
    /// First shift of the Hessian where its inertia is wrong, what it grows by first and then, what is left of it for the next time,
    /// and the largest.
    pub shift: Shift,
    /// First shift after a line search that failed, and its growth.
    pub shift_of_search: (f64, f64),
    /// Affine steps shorter than this part say nothing of the second order.
    pub corrected_from: f64,
    /// Products of the affine step count up to this many mean complementarities.
    pub corrected_to: f64,
    /// Corrections of second order of a step that the filter refuses.
    pub second_order: usize,
    /// Halvings of a step in the line search.
    pub halvings: usize,
    /// Iterations in the last barrier term without a gain of a tenth, after which it gives up.
    pub patience: usize,
    /// Multipliers stay within this factor of what the barrier asks for.
    pub kept: f64,
}

/// How the Hessian is shifted.
#[derive(Clone, Debug)]
pub(crate) struct Shift {
    pub first: f64,
    pub growth_first: f64,
    pub growth: f64,
    pub decay: f64,
    pub largest: f64,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            iterations: 250,
            tolerance: 1e-11,
            first: 0.1,
            last: 1e-11,
            tail: 1e-6,
            tail_mean: 1e-5,
            slack: 0.1,
            lowered_at: 10.0,
            lowered: (0.2, 1.5),
            to_boundary: 0.99,
            price: 100.0,
            terminal_price: 100.0,
            rho: 1e3,
            proximal: 1e-8,
            shift: Shift { first: 1e-4, growth_first: 100.0, growth: 8.0, decay: 1.0 / 3.0, largest: 1e10 },
            shift_of_search: (1e-3, 10.0),
            corrected_from: 0.1,
            corrected_to: 10.0,
            second_order: 3,
            halvings: 12,
            patience: 40,
            kept: 1e10,
        }
    }
}
