//! Tuning constants of the minimum-time and minimum-fuel methods: numbers that the theory does not
//! determine, grouped by what they decide.
//!
//! The smoothing parameter ε is in units of the switching functions, which are of the size of the
//! price of time or of fuel. Residuals are scaled. The trade-offs are measured by these commands:
//!
//! | measured | command |
//! |---|---|
//! | how often the best known minimum-time extremal is found, and how long that takes | `cargo run --release -p evidence -- minimum_time plain` |
//! | how often the best known minimum-fuel extremal is found | `cargo run --release -p evidence -- best_known` |
//! | fuel of plans with pulses, and how often a plan exists | `cargo run --release -p evidence -- minimum_fuel` |
//! | whether plans of symmetric maneuvers cost the same | `cargo run --release -p evidence -- images` |

/// Relative difference below which two costs, gaps, times or values of ε are considered equal. A
/// smaller value is lost in round-off; a larger one merges different solutions.
pub(super) const SAME: f64 = 1e-9;

/// Relative size below which a quantity is considered zero: an arc's length on the grid, relative
/// to the duration (Newton resolves shorter times); a gain in cost; a switching function or
/// curvature relative to the largest one; and a residual in intermediate solutions.
pub(super) const NOTHING: f64 = 1e-6;

/// Singular values below this fraction of the largest are treated as zero. With a smaller
/// threshold, round-off changes the costates strongly; with a larger one, components that are
/// determined only by short arcs are lost.
pub(super) const UNDETERMINED: f64 = 1e-9;

/// Residual of the terminal conditions below which they are met. A smaller value takes more
/// iterations; a larger one leaves a visible terminal error.
pub(super) const MET: f64 = 1e-11;

/// Residual at which Newton's method on switching times stops, and the value below which a
/// switching function is zero: the accuracy of the flow along an arc.
pub(super) const ZERO: f64 = 1e-12;

/// Residual at round-off level; also the length, relative to the duration, below which an arc has
/// no length because two inputs switch together.
pub(crate) const NO_LENGTH: f64 = 1e-14;

/// Largest number of Newton iterations from an initial guess near a solution of the same kind. More
/// of them seldom lead to convergence.
pub(super) const NEAR_ITERATIONS: usize = 12;
/// Largest number of Newton iterations from a distant initial guess. More of them seldom lead to
/// convergence.
pub(super) const FAR_ITERATIONS: usize = 20;

/// Longest step of the eighth-order integrator, as a fraction of the duration. The error of such a
/// step is at round-off level; longer steps are faster and less accurate.
pub(super) const FINE: f64 = 0.03;
/// Factor on `FINE` for intermediate iterations: a larger one makes them faster and less
/// accurate.
pub(super) const COARSER: f64 = 4.0;

/// Number of sample points of an integral over two fine steps, or over one interval of cubic
/// interpolation. More points resolve shorter times with a wrong sign of an input, and take longer.
pub(super) const POINTS: usize = 4;

/// Factor from one ε to the next in continuations whose solution at every ε is used. A larger
/// factor finds more plans and takes longer.
pub(super) const SMALLER: f64 = 0.4;

/// Constants of the initial paths (`base`, `long`). They decide whether any extremal is found, and
/// which.
pub(super) mod paths {
    use crate::optimize::methods::continuation::Pace;

    /// Largest input of an initial path, as a fraction of its limit, for a minimum-time problem.
    /// The levels are tried in this order until a path is found. A higher level gives a shorter
    /// path, whose inputs are closer to saturation.
    pub const LEVELS: [f64; 3] = [0.7, 0.4, 0.9];
    /// Largest input of an initial path, as a fraction of its limit, for a minimum-fuel problem
    /// with free duration. All levels are tried, because a longer duration may cost less. A lower
    /// level gives a longer duration; more levels take longer.
    pub const LEVELS_FUEL: [f64; 5] = [0.7, 0.4, 0.2, 0.1, 0.05];

    /// Smallest excess of the input level of an initial path over the level that zero torque needs.
    /// Unequal one-sided thrusters are on even without motion. A larger value leaves more torque
    /// for the motion and gives a shorter duration.
    pub const ABOVE_IDLE: f64 = 0.25;

    /// Values of ε of the initial paths for a given duration, tried in this order. They are so
    /// large that fuel hardly affects the smoothed law; from a smaller ε Newton converges less
    /// often.
    pub const EASY: [f64; 3] = [4.0, 12.0, 1.5];

    /// Upper bound of the search for the costate (in units of ε) that produces a torque under a
    /// norm limit. A larger bound allows torques closer to the limit.
    pub const LARGEST_COSTATE: f64 = 32.0;

    /// Number of bisections of a bracket. Each one halves the error and takes one more evaluation.
    pub const HALVINGS: usize = 40;

    /// Residual at which a smoothed extremal is accurate enough to be the initial guess of another
    /// one. A smaller value takes more iterations; with a larger one the next solve starts from a
    /// worse guess.
    pub const RELAXED: f64 = 1e-3;

    /// Step sizes of the homotopy from one problem to another, whose parameter runs from 0 to 1.
    /// Larger steps need fewer solves, and fail or change the branch more often.
    pub const HOMOTOPY: Pace = Pace { first: 0.34, least: 0.02, most: 1.0, longer: 1.5, shorter: 0.4 };

    /// Step sizes in the logarithm of the duration, in units of `ln STRETCH`, of the continuations
    /// that shorten smoothed extremals and lengthen arcs. Larger steps need fewer solves and fail
    /// more often.
    pub const STRETCHING: Pace = Pace { first: 1.0, least: 0.03, most: 1.0, longer: 2.0, shorter: 0.5 };
    /// Largest factor on the duration in one step of a continuation in the duration.
    pub const STRETCH: f64 = 1.3;
    /// Displacements of the end that break the symmetry of a maneuver, as fractions of its size.
    /// More of them find more branches and take longer (`--test it -- problems::found::plans_cost`).
    pub const DISPLACED: [f64; 4] = [0.02, -0.02, 1e-3, -1e-3];

    /// Given durations from which a minimum-time extremal is continued, as multiples of the
    /// duration of the initial path at the first of `LEVELS`. More values find more extremals and
    /// take longer.
    pub const DURATIONS: [f64; 5] = [0.5, 0.7, 1.0, 1.5, 2.2];

    /// A duration is long if it exceeds this multiple of `2 √θ` (scaled), the time that a sphere
    /// needs for a turn by θ about a limited axis. With a larger factor, smoothed inputs, which
    /// never rest, fail for some bodies; with a smaller one, a branch that is optimal for the long
    /// duration may be pruned at the shorter one.
    pub const LONG: f64 = 4.0;

    /// Fractions of a given duration in which maneuvers with one-sided thrusters are also planned;
    /// these plans are then slowed down to the duration. Each fraction takes about as much time as
    /// the plan itself. With fewer values a cheaper plan of a shorter duration is sometimes missed
    /// (`evidence -- stretches`).
    pub const QUICKER: [f64; 2] = [0.85, 0.6];
}

/// Constants of branches (`branches`). They decide how many extremals are distinguished and
/// followed.
pub(super) mod branches {
    use crate::Vector3;

    /// Sum of the initial and final rates (scaled) above which the body counts as fast, so that the
    /// long way may be the quicker one and ε decreases in smaller steps. A smaller value makes more
    /// searches take longer; a larger one loses branches.
    pub const FAST: f64 = 0.3;

    /// ε at which branches are distinguished and perturbed. At a larger value fewer branches exist
    /// yet; at a smaller one each initial extremal takes longer.
    pub const BRANCHING: f64 = 0.3;
    /// ε at which minimum-time branches are compared, for turns by 1 rad or more. A smaller value
    /// separates more branches and takes longer.
    pub const COMPARED: f64 = 0.008;
    /// ε at which minimum-fuel branches are compared. A smaller value separates more branches and
    /// takes longer.
    pub const COMPARED_FUEL: f64 = 0.02;
    /// ε, as a multiple of the comparison value, at which a perturbation is removed, because the
    /// branches have parted there. A larger multiple saves iterations, and removes the perturbation
    /// before some branches part.
    pub const PARTED: f64 = 7.0;

    /// Angle \[rad\] below which a turn is small, so that its branches hardly differ and ε
    /// decreases in smaller steps. A larger angle makes more searches take longer; a smaller one
    /// loses branches.
    pub const SMALL: f64 = 0.1;
    /// Angle \[rad\] below which the comparison ε no longer decreases in proportion to the angle. A
    /// smaller value takes longer for small turns.
    pub const SMALLEST_ANGLE: f64 = 0.03;

    /// Ratio to the lowest cost above which initial extremals are pruned. A larger factor keeps
    /// more branches and takes longer.
    pub const RIVAL_BASE: f64 = 1.15;

    /// Rotation vector from the body axes to the axes of the symmetry-breaking perturbations. A
    /// symmetric maneuver usually has its symmetry along body axes, and a perturbation along these
    /// axes has the symmetry too and does not break it.
    pub const ASKEW: Vector3 = Vector3::new(0.3, -0.5, 0.7);
    /// Rotation vector from the body axes to the axes of the second set of symmetry-breaking
    /// perturbations.
    pub const OTHERWISE: Vector3 = Vector3::new(-0.9, 0.4, 1.3);

    /// Ratio of the largest to the smallest control authority, or principal moment, above which
    /// further or larger sets of perturbations are tried. A smaller ratio takes longer; a larger
    /// one misses branches.
    pub const UNLIKE: f64 = 1.2;

    /// An axis counts as linearly dependent on the axes already chosen if the fraction of its
    /// length perpendicular to them is below this value. A smaller value accepts three nearly
    /// dependent axes.
    pub const ASIDE: f64 = 0.1;

    /// Relative differences of cost and of costates below which two minimum-time paths are the same
    /// extremal. Larger values merge different branches; smaller ones keep duplicates.
    pub const ALIKE: (f64, f64) = (1e-4, 1e-2);
    /// Relative differences of cost and of costates below which two minimum-fuel paths are the same
    /// extremal. They are larger than for time, because fuel is known less accurately.
    pub const ALIKE_FUEL: (f64, f64) = (2e-3, 2e-2);
}

/// Constants of smoothed extremals (`smooth`). They decide how fast and how far ε decreases, and on
/// which intervals.
pub(super) mod smooth {
    use crate::optimize::methods::continuation::Pace;

    /// Factor from one ε to the next in a continuation. A smaller factor needs fewer solves, and
    /// fails or changes the branch more often.
    pub const RATIO: f64 = 0.25;
    /// Factor from one ε to the next where a perturbation only has to separate branches. Smaller
    /// factors need fewer iterations and lose some branches.
    pub const STEEP: f64 = 0.185;
    /// Step sizes of the continuation in `ln ε`, in units of the logarithm of the factor. Larger
    /// steps need fewer solves and fail more often.
    pub const DESCENT: Pace = Pace { first: 1.0, least: 0.037, most: 1.0, longer: 1.4, shorter: 0.4 };

    /// Factor from one ε to the next for an extremal that is solved to round-off at each ε. A
    /// smaller factor needs fewer solves and fails more often.
    pub const SETTLING: f64 = 0.2;

    /// Tolerance of the residual in a continuation to smaller ε, as a fraction of ε. A smaller
    /// fraction takes more iterations; with a larger one the next solve starts from a worse guess.
    pub const ON_THE_WAY: f64 = 0.1;
    /// Smallest and largest tolerance of the residual in a continuation to smaller ε.
    pub const ON_THE_WAY_WITHIN: (f64, f64) = (1e-4, 1e-2);

    /// Largest Newton step of the duration and of the switching times, as a fraction of the
    /// duration. A larger step converges in fewer iterations, and leaves the region of convergence
    /// more often.
    pub const TIME_STEP: f64 = 0.4;

    /// Relative decrease of the residual, per unit of step length, that the line search requires. A
    /// larger value rejects more steps; a smaller one accepts steps of little use.
    pub const DECREASE: f64 = 0.1;
    /// Factor on the step length after a rejected trial of the line search. A smaller factor needs
    /// fewer trials and gives shorter steps.
    pub const SHORTENED: f64 = 0.4;
    /// Largest number of trials of one line search. A step that fails this often seldom succeeds
    /// with more trials.
    pub const MOST_TRIALS: usize = 6;

    /// Number of intervals of an initial path, at large ε, if one path per turn suffices. With half
    /// as many, Newton sometimes converges to other extremals. If a turn has several initial paths,
    /// some of which are poor guesses, each has `INTERVALS` intervals.
    pub const INTERVALS_NEAR: usize = 16;

    /// Number of intervals of a path at the start of a continuation. More intervals take longer;
    /// fewer may lead to other extremals.
    pub const INTERVALS: usize = 32;
    /// Number of intervals of a path that suffices where no input changes fast. More intervals take
    /// longer and resolve shorter pulses.
    pub const ENOUGH: usize = 128;
    /// Largest number of intervals of a path. It bounds the time of one solve; a larger value
    /// allows a smaller ε.
    pub const MOST_INTERVALS: usize = 3000;

    /// Largest change of an input over one interval, as a fraction of its range. On a uniform grid,
    /// this value divided by ε is a sufficient number of intervals. A smaller value resolves
    /// switches better and takes more intervals.
    pub const RESOLVED: f64 = 0.2;
    /// Largest number of bisections of one interval in one refinement. With fewer, more refinements
    /// and solves are needed.
    pub const DEEPEST: usize = 8;
}

/// Constants of bang-bang arcs (`arcs`, `certificate`, `least_gap`). They decide whether Newton on
/// switching times converges from the arcs of a smoothed path.
pub(super) mod arcs {
    /// Largest number of integration steps of one arc; it bounds only durations that are far too
    /// long.
    pub const MOST_STEPS: f64 = 1e3;

    /// Smallest number of switches that determine all costates. With fewer switches the Newton step
    /// of smallest norm is used.
    pub const DETERMINED: usize = 5;
    /// Largest number of switches of a plan. Singular arcs of minimum-fuel plans are long and need
    /// many; more switches take longer.
    pub const MOST_SWITCHES: usize = 40;

    /// Input level, as a fraction of its limit, below which the input is off. A smaller value
    /// merges pulses that are smoothed into one another; a larger one loses weak pulses.
    pub const IDLE: f64 = 0.02;
    /// Shortest pulse that is kept, as a fraction of the duration. A smaller value keeps pulses
    /// that are due to smoothing; a larger one loses real ones.
    pub const SHORTEST_PULSE: f64 = 1e-4;

    /// Mean level of an input over a run below which the run is a singular arc and is replaced by
    /// several pulses. A larger value divides more pulses; a smaller one misses singular arcs.
    pub const BETWEEN: f64 = 0.7;

    /// Runs of a wrong sign whose gap is at least this fraction of the largest gap are corrected
    /// together with the worst run. A smaller value corrects more runs at once.
    pub const TOGETHER: f64 = 0.2;

    /// First smoothing parameter μ of the absolute values in the smallest-gap problem. A larger
    /// value is easier for Newton and takes more reductions.
    pub const FIRST: f64 = 0.1;
    /// Factor from one μ to the next in the smallest-gap problem. A smaller factor needs fewer
    /// reductions, each with more Newton iterations.
    pub const REDUCED: f64 = 0.2;
    /// Largest addition of smoothing to the smallest gap, as a fraction of the gap, at which μ is
    /// small enough. A smaller value gives a tighter gap and takes longer.
    pub const ADDED: f64 = 0.05;

    /// Relative increase of the diagonal of the Hessian in the smallest-gap problem, because a
    /// maneuver with few inputs does not determine all costates. A larger value slows Newton; a
    /// smaller one leaves the Hessian singular.
    pub const OPEN: f64 = 1e-13;
}

/// Constants of the limits of branches as ε → 0 (`limit`, `search`, `fuel`). They decide how many
/// branches are converted to arcs, and with how much work.
pub(crate) mod limits {
    /// Gap, as a fraction of the cost, below which arcs are an exact extremal. A smaller value
    /// leads to further corrections of arcs that are exact; a larger one calls arcs with short
    /// wrong signs exact.
    pub const NO_GAP: f64 = 1e-7;
    /// Gap, as a fraction of the cost, below which arcs are accepted without further correction. A
    /// smaller value leads to more pulses and takes longer.
    pub const SMALL_GAP: f64 = 1e-4;

    /// Ratio to the lowest cost above which minimum-time branches are pruned. A larger factor
    /// follows more branches and takes longer.
    pub const RIVAL: f64 = 1.015;
    /// Ratio to the lowest cost above which branches are pruned for minimum fuel and for one-sided
    /// thrusters, where the smoothed cost can be far from the cost of the arcs.
    pub const FAR_RIVAL: f64 = 1.1;

    /// Largest number of reductions of ε for a minimum-time branch without exact arcs. More of them
    /// take a third longer in the slowest tenth of the public set.
    pub const MOST_DESCENTS: usize = 3;
    /// Largest number of reductions of ε for a minimum-fuel branch, whose short pulses appear only
    /// at small ε. More of them find more pulses and take longer.
    pub const MOST_DESCENTS_FUEL: usize = 12;

    /// ε at which the coarse continuation of a branch with a singular arc ends. A smaller value has
    /// a smaller gap and takes longer.
    pub const LAST: f64 = 5e-4;
    /// Smallest ε, to which a branch with a singular arc is then refined on intervals that resolve
    /// its inputs. A smaller value has a smaller gap and takes more intervals.
    pub const SMALLEST: f64 = 2e-5;

    /// Largest number of corrections of a switching sequence, separately for the signs of inputs,
    /// for arcs whose gap is not small and, on the grid, for the bounds of pulses and the order of
    /// switches. More corrections take longer and seldom help.
    pub const MOST_CORRECTIONS: usize = 12;

    /// Number of runs of a wrong sign, those with the largest gaps, each of which is corrected
    /// alone as a trial. More runs take longer.
    pub const WORST: usize = 3;
    /// Fractions of a run of a wrong sign over which its input is changed, tried in this order. A
    /// smaller fraction adds a shorter pulse; more fractions take longer.
    pub const PARTS: [f64; 4] = [1.0, 0.2, 0.04, 0.008];

    /// Relative amount by which arcs may cost more than their smoothed extremal and still be its
    /// limit, because smoothing changes the fuel. A larger value may accept arcs of a costlier
    /// branch; a smaller one rejects limits.
    pub const DEARER: f64 = 0.05;

    /// Numbers of pulses that replace a singular arc, tried in this order until the gap is small.
    /// More pulses leave a smaller gap and need a finer grid.
    pub const CELLS: [usize; 6] = [1, 2, 3, 4, 6, 8];

    /// Parts into which the angle of a turn about a fixed axis is divided. More parts give a more
    /// accurate duration and take longer.
    pub const EIGENAXIS_PARTS: usize = 4000;
}

/// Constants for long durations with nonzero boundary rates (`impulses`). They decide how many
/// coasts are searched for and given burns.
pub(super) mod impulses {
    /// Number of random initial momenta from which coasts are searched for. More of them find more
    /// coasts and take longer.
    pub const RANDOM: usize = 48;
    /// Number of cheapest two-impulse transfers that are converted to burns. More of them take
    /// longer, and find plans that are cheaper with burns than their impulsive transfers suggest.
    pub const TRIED: usize = 24;
    /// Number of cheapest transfers with burns to which further burns are added. More of them find
    /// more plans and take longer.
    pub const MENDED: usize = 4;
}

/// Constants of the grid (`discretize`, `on_grid`, `grid_step`). They decide whether arcs have a
/// discrete optimum.
pub(crate) mod grid {
    /// Smallest number of steps of an arc. A larger number makes the grid more accurate, and leaves
    /// room for fewer arcs.
    pub const LEAST_STEPS: usize = 2;

    /// Residual below which Newton on the grid may end, once it stops decreasing. A smaller value
    /// is below round-off for many plans; a larger one accepts less accurate plans.
    pub const CONVERGED: f64 = 2e-13;
    /// Ratio of two successive residuals above which the residual no longer decreases. A larger
    /// ratio takes more iterations for the last digits.
    pub const FALLING: f64 = 0.1;
    /// Largest number of Newton iterations on the grid. More of them seldom lead to convergence.
    pub const MOST_ITERATIONS: usize = 30;

    /// First ε of the smoothed problem on a grid, times the number of steps: about the smallest ε
    /// that the grid resolves. With a smaller value Newton fails more often; a larger one needs
    /// more reductions of ε.
    pub const FOLLOWED: f64 = 0.3;
}

/// Constants of pulses with a minimum pulse width (`pulses`). They decide which schedules are
/// tried, and when their times are optimal.
pub(super) mod pulses {
    /// Longest integration step of the motion under pulses, as a fraction of the duration. It is
    /// shorter than [`FINE`](super::FINE) because more derivatives are propagated.
    pub const FINE: f64 = 0.01;
    /// Longest integration step of the motion under pulses in intermediate iterations, as a
    /// fraction of the duration. A longer one is faster and less accurate.
    pub const COARSE: f64 = super::COARSER * FINE;

    /// Weight of the terminal conditions relative to the size of a step that restores them. A
    /// larger weight leaves a smaller residual and a worse conditioned program.
    pub const STIFF: f64 = 1e8;

    /// Largest change of a time in one step (trust region), as a fraction of the duration. A larger
    /// one needs fewer steps, of which more are rejected.
    pub const TRUST: f64 = 0.2;
    /// Trust region, as a fraction of the duration, below which the iteration ends. A smaller one
    /// takes more steps for a gain that hardly counts.
    pub const NO_TRUST: f64 = 1e-8;
    /// Factor on the trust region after a rejected step. A smaller factor leads to fewer rejections
    /// and to shorter steps.
    pub const LESS_TRUST: f64 = 0.3;

    /// Largest number of Gauss–Newton iterations after a step, and of successive iterations with a
    /// slow decrease of the terminal error. More iterations take longer and seldom converge.
    pub const ITERATIONS: usize = 6;
    /// Ratio of two successive terminal errors above which the decrease is slow. A smaller ratio
    /// gives up sooner.
    pub const LESS: f64 = 0.9;

    /// Largest number of steps of the minimisation of fuel. More steps take longer, for gains that
    /// become small.
    pub const MOST_STEPS: usize = 40;
    /// Predicted gain, as a fraction of the cost, below which the times are optimal. A smaller
    /// value takes more steps.
    pub const NO_GAIN: f64 = 1e-10;

    /// Ratio of the actual to the predicted gain above which the trust region grows. A smaller
    /// ratio leads to longer steps, of which more are rejected.
    pub const GOOD: f64 = 0.5;

    /// Slack of a bound, as a fraction of the duration, below which the bound is active. The
    /// thresholds are tried in this order. A larger threshold holds times at bounds that should be
    /// free; a smaller one misses active bounds.
    pub const NEAR: [f64; 3] = [super::NOTHING, 1e-8, 1e-10];

    /// Largest change of the times in the final Newton iteration, as a fraction of the duration. A
    /// larger one may accept another schedule.
    pub const NEARBY: f64 = 0.02;
    /// Largest difference between the times on the grid and those in continuous time, as a fraction
    /// of the duration. A larger one may accept another plan; a smaller one rejects plans on coarse
    /// grids.
    pub const NEARBY_ON_GRID: f64 = 0.05;

    /// Largest violation of a bound, as a fraction of the duration, that counts as round-off.
    pub const KEPT: f64 = 1e-13;

    /// Two pulses of one input are merged if the pause between them is below this multiple of the
    /// minimum pulse width. More multiples give more initial schedules.
    pub const JOINED: [f64; 3] = [0.0, 1.0, 4.0];
    /// Pulses shorter than this multiple of the minimum pulse width are dropped. More multiples
    /// give more initial schedules.
    pub const DROPPED: [f64; 4] = [0.5, 0.0, 0.9, 0.2];

    /// Largest number of extremals from which schedules are made. More of them find more schedules
    /// and take longer.
    pub const MOST_EXTREMALS: usize = 4;
    /// Largest number of initial schedules whose times are optimised. More of them find cheaper
    /// pulses and take longer.
    pub const MOST_STARTS: usize = 24;
    /// Factor on the number of trials in a thorough search. A larger one finds cheaper pulses and
    /// takes longer.
    pub const THOROUGH: usize = 4;

    /// Number of cheapest schedules that are changed by one pulse at a time. More of them find
    /// cheaper pulses and take longer.
    pub const CHANGED: usize = 3;
    /// Largest total number of changes of schedules that are tried. It bounds the time of the
    /// search.
    pub const MOST_CHANGES: usize = 60;

    /// Number of initial schedules with random changes. More of them find cheaper pulses and take
    /// longer.
    pub const RANDOM: usize = 12;
    /// Largest number of initial schedules with random changes if no schedule meets the terminal
    /// conditions. More of them find more plans and take longer.
    pub const MOST_RANDOM: usize = 40;

    /// Relative difference of costs below which two schedules are the same. A larger value merges
    /// different schedules; a smaller one keeps duplicates.
    pub const DISTINCT: f64 = 1e-7;
    /// Relative difference of times below which two initial schedules are the same. A larger value
    /// loses schedules; a smaller one repeats work.
    pub const ALIKE: f64 = 1e-3;

    /// Largest number of pulses of a schedule. It bounds the size of the quadratic programs.
    pub const MOST_PULSES: usize = 24;
    /// Number of inputs of the extremal, counted from the first, whose combinations of three are
    /// compared for an impulse; further inputs are not used. The time grows with the cube of this
    /// number.
    pub const MOST_COMBINED: usize = 12;
}
