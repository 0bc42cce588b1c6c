//! Constants of the interior-point method that the theory does not determine.

use crate::optimize::methods::ARMIJO;

/// Number of stages to which the barrier parameters of [`Tuning`] apply; for other numbers they are
/// scaled.
pub(crate) const STAGES: f64 = 100.0;

/// Settings of the interior-point method. The cost at the start is of order one to ten, and rows
/// are relative to their limits. Barrier parameters apply to [`STAGES`] stages and scale with the
/// length of a step.
#[derive(Clone, Debug)]
pub(crate) struct Tuning {
    /// Largest number of iterations.
    pub iterations: usize,
    /// Number of interior-point iterations for each Newton iteration that the user's settings
    /// allow: an iteration costs little, and difficult maneuvers take more than a hundred.
    pub for_each: usize,
    /// Residual of all conditions at which the method has converged: a smaller one is closer to
    /// round-off and takes one or two more iterations.
    pub tolerance: f64,
    /// Residual at which a maneuver without rows has converged. Its last steps converge
    /// quadratically, so one more iteration reaches round-off
    /// (`slew plan problems/free_duration_xte.toml -v`).
    pub tolerance_without_rows: f64,
    /// Initial barrier parameter: a larger one takes more iterations and stays farther from bounds
    /// that the first path crosses.
    pub first: f64,
    /// Initial barrier parameter of a warm start from a known optimum, per unit by which the target
    /// has moved relative to the size of the maneuver. It is also the largest initial barrier
    /// parameter of a warm start.
    pub beside: f64,
    /// Final barrier parameter: the cost exceeds the optimum by this amount for each active row.
    pub last: f64,
    /// Largest barrier parameter at which a run may end if the central path ends there, as in a
    /// valley of nearly equal plans. A larger one adds more to the cost, a smaller one follows the
    /// valley.
    pub tolerable: f64,
    /// Barrier parameter below which the final phase of the iteration begins. In this phase a
    /// monotone update replaces Mehrotra's rule, so that the barrier parameter does not decrease
    /// faster than the residual, and a shift of the Hessian replaces Gauss–Newton, which is slow
    /// along faces of optima.
    pub tail: f64,
    /// Smallest initial slack: a smaller one makes multipliers, and thus the curvature of violated
    /// rows, too large.
    pub slack: f64,
    /// Residual, relative to the barrier parameter, at which the final phase decreases the barrier
    /// parameter; also the mean complementarity, relative to `tail`, at which the final phase may
    /// begin.
    pub lowered_at: f64,
    /// Multiple of the final barrier parameter below which the next parameter is the final one: a
    /// larger multiple skips a parameter and may lose the central path.
    pub snapped: f64,
    /// Factor and power of the decrease of the barrier parameter in the final phase; the smaller
    /// result is used.
    pub lowered: (f64, f64),
    /// Largest fraction of the distance to a bound that a step may take; one minus the barrier
    /// parameter, if that is larger.
    pub to_boundary: f64,
    /// Penalty per unit of violation of an elastic row: it must exceed every multiplier, or rows
    /// are violated although a feasible point exists.
    pub price: f64,
    /// Penalty per unit of terminal error, as a factor on the penalty that the program sets for its
    /// scale.
    pub terminal_price: f64,
    /// Largest initial multiplier of a warm start, relative to its penalty: a multiplier closer to
    /// the penalty starts with a larger violation.
    pub known_price: f64,
    /// Factor by which the penalties of violations and of terminal errors are increased if a
    /// violation or a terminal error remains.
    pub dearer: f64,
    /// Largest number of such increases of the penalties of violations and terminal errors.
    pub raises: usize,
    /// Weight of the terminal equations in the Hessian. It changes no step, and it makes blocks
    /// positive definite that are so only on the terminal manifold.
    pub rho: f64,
    /// Proximal term of rows that are equations: a larger one improves the conditioning and slows
    /// the convergence.
    pub proximal: f64,
    /// Shifts of the Hessian if its inertia is wrong.
    pub shift: Shift,
    /// Shifts of the Hessian after a failed line search.
    pub shift_of_search: ShiftOfSearch,
    /// Smallest barrier parameter that the affine step may propose, relative to `tail`: with a
    /// smaller one, complementarity products are farther from the barrier parameter when the final
    /// phase begins.
    pub proposed: f64,
    /// Smallest step length of the affine step for which second-order products are used.
    pub corrected_from: f64,
    /// Largest second-order product, relative to the mean complementarity.
    pub corrected_to: f64,
    /// Largest number of second-order corrections of a step that the filter rejects.
    pub second_order: usize,
    /// Largest number of halvings of a step in the line search.
    pub halvings: usize,
    /// Number of iterations after which the method gives up, at the final barrier parameter, if the
    /// residual has not decreased by a tenth.
    pub patience: usize,
    /// Number of iterations after which the method gives up, before the final phase, if neither the
    /// mean complementarity nor the violation of the equations has halved: a smaller number gives
    /// up difficult maneuvers, a larger one spends more time on starts that do not converge.
    pub search_patience: usize,
    /// Residual of stationarity and complementarity up to which a stalled run counts as a solution,
    /// as along faces of optima and valleys of saddles. A larger value accepts poorer solutions;
    /// the plan states their residual.
    pub acceptable: f64,
    /// Number of iterations after which a run with an acceptable point ends, at the final barrier
    /// parameter, if the residual has not decreased by a tenth.
    pub acceptable_patience: usize,
    /// Largest residual of the equations of an acceptable solution.
    pub round_off: f64,
    /// Largest number of Newton steps that reduce the residual of the equations to `round_off`.
    pub settling: usize,
    /// Largest number of corrections of inputs whose simulation from the start misses the end.
    pub replays: usize,
    /// Factor by which the infeasibility may increase in one step, if it is one or more: a larger
    /// factor accepts steps out of the domain of the derivatives; a factor of ten takes up to a
    /// fifth more iterations for everyday maneuvers.
    pub more_infeasible: f64,
    /// Infeasibility up to which a step is judged by its cost alone, as a fraction of the current
    /// infeasibility or, if that is below one, as an absolute value.
    pub judged_by_cost: f64,
    /// Factor by which the residual must decrease for an iteration to count as progress.
    pub gain: f64,
    /// Factor by which a multiplier may differ, in either direction, from the barrier parameter
    /// divided by the slack.
    pub kept: f64,
    /// Fraction of the predicted decrease that a step must reach (Armijo condition): a larger one
    /// rejects more steps.
    pub armijo: f64,
    /// Relative decrease of the infeasibility that the filter requires.
    pub less_infeasible: f64,
    /// Decrease of the barrier cost, per unit of infeasibility, that the filter requires.
    pub less_costly: f64,
    /// Exponents of slope and infeasibility in the switching condition: with a larger first
    /// exponent fewer steps are judged by the cost alone.
    pub switch: (f64, f64),
    /// Infeasibility up to which a step of the final phase need not decrease infeasibility or cost:
    /// a larger one accepts more steps.
    pub feasible: f64,
    /// Largest relative increase of the barrier cost in a step of the final phase that need not
    /// decrease it: at least the round-off of the cost.
    pub level: f64,
    /// Largest number of filter entries, at least one: more entries forbid more returns to earlier
    /// points.
    pub filter: usize,
    /// Mean multiplier above which residuals are divided by the mean multiplier: with a smaller
    /// value runs converge earlier.
    pub large: f64,
    /// Residual of the equations below which a run is compared with known optima: a larger value
    /// decides earlier but may mistake one optimum for another.
    pub judged: f64,
    /// Mean complementarity below which a run is compared with known optima: a larger value decides
    /// earlier but may mistake one optimum for another.
    pub known_from: f64,
    /// Violation of a limit (relative) or of a cone \[rad\], or terminal error, above which a
    /// solution is rejected.
    pub violated: f64,
    /// Factor on the inputs of the first path: a smaller factor starts closer to the middle of
    /// their limits, and the motion follows the path less closely.
    pub centred: f64,
    /// Largest number of iterations that fit the initial duration to a path whose ends depend on
    /// the duration.
    pub fitted: usize,
    /// Relative change of the fitted duration at which the fit ends.
    pub close: f64,
    /// Settings of the program that represents the maneuver.
    pub program: OfProgram,
}

/// Settings of a maneuver as a program of stages.
#[derive(Clone, Debug)]
pub(crate) struct OfProgram {
    /// Cost at the first point: a larger one makes the initial barrier parameter smaller in
    /// comparison.
    pub cost: f64,
    /// Largest rotation of an attitude in one iteration \[rad\]: the linearisation is valid up to
    /// about this angle.
    pub longest_turn: f64,
    /// Factors by which the duration may decrease and increase in one iteration.
    pub longest_stretch: [f64; 2],
    /// Excess of the fuel variable of a set over the norm of its inputs at the first point,
    /// relative to the limit of the inputs.
    pub spare: f64,
    /// Largest relative decrease of the fuel variable of a set in one iteration, less than one: a
    /// larger one leaves the domain in which the row of the norm is nearly linear.
    pub to_nothing: f64,
    /// Squared radius of the smoothing of a norm at zero in the fuel cost, divided by the barrier
    /// parameter: a smaller one adds less to the cost and has a larger curvature.
    pub rounding: f64,
    /// Multiplier of a cone constraint below which the second derivatives of the constraint are
    /// neglected.
    pub felt: f64,
    /// Ratio of the initial duration to the shortest duration in which the path is within the
    /// limits: a ratio of one leaves no slack.
    pub room: f64,
    /// Smallest size of a maneuver, in scaled units, relative to which terminal errors are
    /// measured.
    pub least_size: f64,
    /// Distance of a path from the path of a known optimum \[rad, and relative to the duration\]
    /// below which the run counts as converging to this optimum. A larger value ends more runs
    /// early and misses optima that are equally near.
    pub same: f64,
    /// Largest relative decrease of the cost below a known optimum that a run may still promise if
    /// it counts as converging to this optimum. A larger value ends more runs early and misses
    /// cheaper optima.
    pub same_cost: f64,
    /// Step of the central differences of a cone's gradient with respect to the logarithm of the
    /// duration, for moving directions: truncation and round-off slow the last iterations.
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

/// Shifts of the Hessian for inertia correction: a larger shift gives shorter, safer steps.
#[derive(Clone, Debug)]
pub(crate) struct Shift {
    /// Initial shift of a run.
    pub first: f64,
    /// Growth factor of the first increase of the initial shift.
    pub growth_first: f64,
    /// Growth factor of all further increases.
    pub growth: f64,
    /// Fraction of the last shift that the next iteration tries first.
    pub decay: f64,
    /// Largest shift, beyond which the method stalls.
    pub largest: f64,
}

/// Shifts of the Hessian after a failed line search: a larger shift gives shorter, safer steps.
#[derive(Clone, Debug)]
pub(crate) struct ShiftOfSearch {
    /// Shift after the first failure.
    pub first: f64,
    /// Growth factor if the next search fails too, and divisor after an accepted step.
    pub growth: f64,
    /// Factor on the last shift of the inertia correction; the shift is at least the product.
    pub over: f64,
    /// Shift below which it is set to zero.
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
    /// Returns the settings for a start near an optimum, such as the optimum of a coarser grid: a
    /// large barrier parameter or slack would lead to another optimum. The penalty of a terminal
    /// error is higher, which known multipliers allow and which leaves a smaller error.
    pub fn near() -> Self {
        let plan = Self::default();
        let terminal_price = plan.terminal_price * plan.dearer;
        Self { first: 1e-4, slack: 1e-3, terminal_price, ..plan }
    }

    /// Returns the settings for a warm start from an optimum on the same grid whose target has
    /// moved by `distance`, relative to the maneuver. A smaller initial barrier parameter takes
    /// fewer iterations unless the active set changes.
    pub fn beside(distance: f64) -> Self {
        let plan = Self::near();
        let first = (plan.beside * distance).clamp(plan.last, plan.beside);
        Self { first, slack: plan.beside, ..plan }
    }

    /// Returns the settings with a final barrier parameter of at least `last`.
    pub fn down_to(self, last: f64) -> Self {
        let last = self.last.max(last);
        Self { first: self.first.max(last), last, ..self }
    }

    /// Returns settings of low accuracy, for runs on a coarse grid whose optima are only compared.
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
