//! Every number of the interior point that the theory does not give.

use crate::optimize::methods::ARMIJO;

/// Stages for which barrier terms are stated.
pub(crate) const STAGES: f64 = 100.0;

/// Settings of the interior-point method. The first cost is of order one to ten, and rows are
/// relative to their limits. Barrier terms are stated for [`STAGES`] and scale with the length of a
/// step.
#[derive(Clone, Debug)]
pub(crate) struct Tuning {
    /// Iterations after which the method gives up.
    pub iterations: usize,
    /// Iterations for each that the settings allow to Newton's method: one costs little, and hard
    /// maneuvers take more than a hundred.
    pub for_each: usize,
    /// Residual of all conditions at which the method has converged: a smaller one is nearer to
    /// round-off and takes an iteration or two more.
    pub tolerance: f64,
    /// The same of a maneuver without rows, whose last steps converge quadratically: one more takes
    /// it to round-off (`slew plan problems/free_duration_xte.toml -v`).
    pub tolerance_without_rows: f64,
    /// First barrier term: a larger one takes more iterations and keeps farther from bounds that
    /// the first path crosses.
    pub first: f64,
    /// First barrier term for each unit by which the target of a known optimum has moved, and the
    /// largest one.
    pub beside: f64,
    /// Last barrier term: the cost exceeds the optimum by this for each active row.
    pub last: f64,
    /// Largest barrier term at which a run may end where the path of minima ends, as along a valley
    /// of nearly equal plans: a larger one costs more beside the optimum, a smaller one follows the
    /// valley.
    pub tolerable: f64,
    /// Barrier term below which a monotone rule replaces Mehrotra's, so that the barrier term does
    /// not outrun the residual, and a shift replaces Gauss–Newton, which is slow along faces of
    /// optima.
    pub tail: f64,
    /// Least first slack: a smaller one makes multipliers, and with them the curvature of violated
    /// rows, too large.
    pub slack: f64,
    /// Residual, in barrier terms, at which the tail decreases the barrier term; and mean
    /// complementarity, in that of the tail, at which the tail may begin.
    pub lowered_at: f64,
    /// Multiple of the last barrier term from which the next one is the last: a larger one skips a
    /// term and may lose the path of minima.
    pub snapped: f64,
    /// Factor and power of the decrease in the tail: the smaller of the two results is used.
    pub lowered: (f64, f64),
    /// Part of the way to a bound that a step may go: this, or one minus the barrier term if
    /// larger.
    pub to_boundary: f64,
    /// Price of a unit of violation of an elastic row: it must exceed every multiplier, or rows are
    /// violated although a feasible point exists.
    pub price: f64,
    /// Price of a unit of a terminal error, times the price that the program reports for its own
    /// scale.
    pub terminal_price: f64,
    /// Largest multiplier that a resumed solve begins with, as a part of its price: nearer to it a
    /// violation begins larger.
    pub known_price: f64,
    /// What both prices are multiplied by where a violation or a terminal error remains, and how
    /// often.
    pub dearer: f64,
    pub raises: usize,
    /// Weight of the terminal equations in the Hessian. It changes no step and makes blocks
    /// positive that are positive on the terminal manifold only.
    pub rho: f64,
    /// Proximal term of rows that are equations: a larger one conditions better and converges
    /// slower.
    pub proximal: f64,
    /// Shifts of the Hessian where its inertia is wrong.
    pub shift: Shift,
    /// Shifts of the Hessian after a line search that failed.
    pub shift_of_search: ShiftOfSearch,
    /// Least barrier term that the affine step may propose, as a part of `tail`: a smaller one
    /// enters the tail with products that are farther from it.
    pub proposed: f64,
    /// Shortest part of an affine step from which second-order products are computed.
    pub corrected_from: f64,
    /// Largest second-order product, in mean complementarities.
    pub corrected_to: f64,
    /// Second-order corrections of a step that the filter refuses.
    pub second_order: usize,
    /// Halvings of a step in the line search.
    pub halvings: usize,
    /// Iterations at the last barrier term without a decrease of the residual by a tenth, after
    /// which the method gives up.
    pub patience: usize,
    /// Iterations before the tail in which neither the barrier term nor the violation of the
    /// equations halves, after which the method gives up: a smaller number gives up hard maneuvers,
    /// a larger one follows starts that lead nowhere.
    pub search_patience: usize,
    /// Residual of stationarity and complementarity with which a run that cannot go on is a
    /// solution, as along faces of optima and valleys of saddles: a larger one accepts poorer ones,
    /// which the residual in the plan shows.
    pub acceptable: f64,
    /// Iterations at the last barrier term without a decrease of the residual, after which a run
    /// with such a point ends.
    pub acceptable_patience: usize,
    /// Residual of the equations that such a solution has at most, and the Newton steps that may
    /// take it there.
    pub round_off: f64,
    pub settling: usize,
    /// Corrections of inputs that, replayed from the start, miss the end.
    pub replays: usize,
    /// Factor by which the infeasibility may increase in one step, from where it is one or more: a
    /// larger one accepts steps out of the domain of the derivatives, a factor of ten costs
    /// everyday maneuvers up to a fifth more iterations.
    pub more_infeasible: f64,
    /// Infeasibility, as a part of itself or of one, up to which a step is judged by its cost
    /// alone.
    pub judged_by_cost: f64,
    /// Factor by which the residual must decrease in an iteration that counts as a gain.
    pub gain: f64,
    /// Factor within which multipliers stay of the barrier term divided by the slack.
    pub kept: f64,
    /// Part of the predicted decrease that a step must reach (Armijo): a larger one refuses more
    /// steps.
    pub armijo: f64,
    /// Relative decrease of the infeasibility that the filter requires.
    pub less_infeasible: f64,
    /// Decrease of the barrier cost, per unit of infeasibility, that the filter requires.
    pub less_costly: f64,
    /// Exponents of slope and infeasibility in the switching condition: with a larger first one
    /// fewer steps are judged by the cost alone.
    pub switch: (f64, f64),
    /// Infeasibility up to which a step of the tail needs no decrease: a larger one accepts more
    /// steps.
    pub feasible: f64,
    /// Relative increase of the barrier cost that such a step may cause: at least its round-off.
    pub level: f64,
    /// Entries of the filter, at least one: more of them forbid more returns to earlier points.
    pub filter: usize,
    /// Mean multiplier above which residuals are divided by it: a smaller one converges earlier.
    pub large: f64,
    /// Residual of the equations, and mean complementarity, from which on a run is compared with
    /// known optima: larger ones judge earlier, and take one optimum for another.
    pub judged: f64,
    pub known_from: f64,
    /// Violation or terminal error, relative or in radians, above which a solution is not accepted.
    pub violated: f64,
    /// Factor on the inputs that the first path needs: a smaller one starts nearer the middle of
    /// their limits and farther from the path.
    pub centred: f64,
    /// Rounds in which the first duration is fitted to a path whose ends move with the duration.
    pub fitted: usize,
    /// Relative change of the fitted duration at which the rounds end.
    pub close: f64,
    /// Settings of the maneuver as a program.
    pub program: OfProgram,
}

/// Settings of a maneuver as a program of stages.
#[derive(Clone, Debug)]
pub(crate) struct OfProgram {
    /// The cost at the first point: a larger one makes the first barrier term smaller beside it.
    pub cost: f64,
    /// Largest turn of an attitude in one iteration \[rad\]: derivatives hold for less than about
    /// this.
    pub longest_turn: f64,
    /// Factors by which the duration may decrease and increase in one iteration.
    pub longest_stretch: [f64; 2],
    /// Difference between what a set is counted to burn at the first point and the norm of its
    /// inputs, as a part of their limit.
    pub spare: f64,
    /// Part of what a set is counted to burn that one iteration may remove, less than one: a larger
    /// one leaves the domain in which the row of the norm is nearly linear.
    pub to_nothing: f64,
    /// The square of the length by which a norm in the cost of fuel is rounded at nothing, over the
    /// barrier term: a smaller one costs less beside the optimum and bends more.
    pub rounding: f64,
    /// Multiplier of a cone below which its second derivatives are left out.
    pub felt: f64,
    /// Factor on a duration in which a path is just within the limits: one leaves no slack.
    pub room: f64,
    /// Least size of a maneuver, in its units, by which errors at its end are measured.
    pub least_size: f64,
    /// Distance of a path from that of a known optimum \[rad, and parts of a duration\] within
    /// which it is the same, and what it may foresee to cost less: larger ones end more runs early
    /// and miss optima that are as near.
    pub same: f64,
    pub same_cost: f64,
    /// Step of the central differences of a cone's gradient by the logarithm of the duration, where
    /// a direction moves: its truncation and round-off slow the last iterations.
    pub difference: f64,
}

impl Default for OfProgram {
    fn default() -> Self {
        Self {
            cost: 3.0,
            longest_turn: 1.0,
            longest_stretch: [0.5, 3.0],
            spare: 0.1,
            to_nothing: 0.6,
            rounding: 1e-4,
            felt: 1e-9,
            room: 1.1,
            least_size: 1e-12,
            same: 5e-3,
            same_cost: 1e-4,
            difference: 1e-5,
        }
    }
}

/// Shifts of the Hessian: a larger one gives shorter, safer steps.
#[derive(Clone, Debug)]
pub(crate) struct Shift {
    /// First shift of a run.
    pub first: f64,
    /// First growth of the first shift.
    pub growth_first: f64,
    /// Growth of all further shifts.
    pub growth: f64,
    /// Part of the last shift that the next iteration tries first.
    pub decay: f64,
    /// Largest shift: beyond it the method stalls.
    pub largest: f64,
}

/// Shifts of the Hessian after a line search that failed: a larger one gives shorter, safer steps.
#[derive(Clone, Debug)]
pub(crate) struct ShiftOfSearch {
    /// The first one.
    pub first: f64,
    /// Growth where the next search fails too, and decay after a step that was taken.
    pub growth: f64,
    /// Factor on the last shift that the inertia needed: the shift is at least this.
    pub over: f64,
    /// The shift below which it is dropped.
    pub least: f64,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            iterations: 240,
            for_each: 4,
            tolerance: 1e-11,
            tolerance_without_rows: 1e-12,
            first: 0.1,
            beside: 1e-5,
            last: 1e-12,
            tolerable: 5e-9,
            tail: 1e-7,
            slack: 0.1,
            lowered_at: 10.0,
            snapped: 30.0,
            lowered: (0.2, 1.5),
            to_boundary: 0.99,
            price: 100.0,
            terminal_price: 100.0,
            known_price: 0.9,
            dearer: 100.0,
            raises: 2,
            rho: 1e3,
            proximal: 1e-8,
            shift: Shift { first: 1e-4, growth_first: 100.0, growth: 8.0, decay: 1.0 / 3.0, largest: 1e10 },
            shift_of_search: ShiftOfSearch { first: 1e-3, growth: 10.0, over: 4.0, least: 5e-7 },
            proposed: 0.1,
            judged_by_cost: 1e-4,
            gain: 0.9,
            corrected_from: 0.1,
            corrected_to: 10.0,
            second_order: 3,
            halvings: 12,
            patience: 40,
            search_patience: usize::MAX,
            acceptable: 1e-6,
            acceptable_patience: 15,
            round_off: 1e-13,
            settling: 12,
            replays: 2,
            more_infeasible: 1e3,
            kept: 1e10,
            armijo: ARMIJO,
            less_infeasible: 1e-5,
            less_costly: 1e-8,
            switch: (2.3, 1.1),
            feasible: 1e-7,
            level: 1e-9,
            filter: 64,
            large: 100.0,
            judged: 1e-2,
            known_from: 0.0,
            violated: 1e-8,
            centred: 0.5,
            fitted: 3,
            close: 0.05,
            program: OfProgram::default(),
        }
    }
}

impl Tuning {
    /// Returns the settings for a start near an optimum, as that of a coarser grid: a large barrier
    /// term or slack would lead to another one. With known multipliers the price of an error at the
    /// end may be higher, and what is left of it is less.
    pub fn near() -> Self {
        let plan = Self::default();
        let terminal_price = plan.terminal_price * plan.dearer;
        Self { first: 1e-4, slack: 1e-3, terminal_price, ..plan }
    }

    /// Returns the settings for a start from an optimum on the same grid, towards a target that has
    /// moved by `distance`, a part of the maneuver: a smaller first barrier term takes fewer
    /// iterations, and more if what acts changes.
    pub fn beside(distance: f64) -> Self {
        let plan = Self::near();
        let first = (plan.beside * distance).clamp(plan.last, plan.beside);
        Self { first, slack: plan.beside, ..plan }
    }

    /// Returns the settings with a last barrier term of at least this.
    pub fn down_to(self, last: f64) -> Self {
        let last = self.last.max(last);
        Self { first: self.first.max(last), last, ..self }
    }

    /// Returns the settings for comparing optima on a coarse grid.
    pub fn roughly() -> Self {
        let (tolerance, last) = (1e-5, 1e-6);
        Self {
            search_patience: 25,
            tolerance,
            tolerance_without_rows: tolerance,
            acceptable: 1e-3,
            last,
            tail: last,
            raises: 1,
            replays: 0,
            known_from: tolerance,
            ..Self::default()
        }
    }
}
