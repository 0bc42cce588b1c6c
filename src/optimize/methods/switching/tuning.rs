//! Every number of the methods of minimum time and fuel that the theory does not give, by what it
//! decides.
//!
//! An ε is in units of the switching functions, which are of the size of the price of time or fuel;
//! a residual is scaled. What the numbers trade is counted by
//!
//! | | command |
//! |---|---|
//! | how often the best known extremal of minimum time is found, and in what time | `cargo run --release -p evidence -- minimum_time plain` |
//! | the same of fuel | `cargo run --release -p evidence -- best_known` |
//! | fuel of pulses, and how often there is a plan | `cargo run --release -p evidence -- minimum_fuel` |
//! | whether plans of images of one maneuver cost the same | `cargo run --release -p evidence -- images` |

/// Numbers that differ by this part are one: costs, gaps, times and ε.
pub(super) const SAME: f64 = 1e-9;

/// Less than this part is nothing: of the duration for the grid, though Newton tells such times
/// apart; of a cost as a gain; of the largest switching function or curvature; and as a residual on
/// the way.
pub(super) const NOTHING: f64 = 1e-6;

/// Singular values below this part of the largest belong to what is not determined: lower,
/// round-off moves costates far; higher, what short arcs determine is lost.
pub(super) const UNDETERMINED: f64 = 1e-9;

/// Residual at which the end is met.
pub(super) const MET: f64 = 1e-11;

/// A switching function of this size is zero, and Newton on switching times ends: the flow along an
/// arc is as good as that.
pub(super) const ZERO: f64 = 1e-12;

/// Residual of times to all digits, and a part of the duration that is no length: two inputs switch
/// together.
pub(crate) const NO_LENGTH: f64 = 1e-14;

/// Iterations of Newton from a near solution of the same kind, and from farther away: what takes
/// more does not come as a rule.
pub(super) const NEAR_ITERATIONS: usize = 12;
pub(super) const FAR_ITERATIONS: usize = 20;

/// Longest part of the duration that one step of order 8 covers, where its error is round-off; and
/// how many times that on the way.
pub(super) const FINE: f64 = 0.03;
pub(super) const COARSER: f64 = 4.0;

/// Points of two such steps, or of the cubic over an interval, at which an integral looks: more see
/// shorter runs of wrong signs, and take longer.
pub(super) const POINTS: usize = 4;

/// ε over the one before where every one of them is of use: larger finds more, in more time.
pub(super) const SMALLER: f64 = 0.4;

/// First paths (`base`, `long`): whether there is an extremal at all, and which.
pub(super) mod paths {
    use crate::optimize::methods::continuation::Pace;

    /// Parts of the limits that the largest input of a first path has where the duration is sought:
    /// one after the other until a path is found or, where fuel counts and more time may cost less,
    /// all of them.
    pub const LEVELS: [f64; 3] = [0.7, 0.4, 0.9];
    pub const LEVELS_FUEL: [f64; 5] = [0.7, 0.4, 0.2, 0.1, 0.05];

    /// The least that a level leaves to the motion, where the inputs work without any.
    pub const ABOVE_IDLE: f64 = 0.25;

    /// ε of a first path where the duration is given: so large that fuel hardly counts.
    pub const EASY: [f64; 3] = [4.0, 12.0, 1.5];

    /// Under a limit of the norm the costate over ε that gives a torque is sought up to this size.
    pub const LARGEST_COSTATE: f64 = 32.0;

    /// How often a bracket is halved.
    pub const HALVINGS: usize = 40;

    /// Residual of a smoothed extremal that another one starts from.
    pub const RELAXED: f64 = 1e-3;

    /// How far the way from one problem to another, from 0 to 1, goes at once.
    pub const HOMOTOPY: Pace = Pace { first: 0.34, least: 0.02, most: 1.0, longer: 1.5, shorter: 0.4 };

    /// How the logarithm of a duration grows or falls, over that of the factor by which it does at
    /// most: of smoothed extremals longer or shorter, of arcs longer.
    pub const STRETCHING: Pace = Pace { first: 1.0, least: 0.03, most: 1.0, longer: 2.0, shorter: 0.5 };
    pub const STRETCH: f64 = 1.3;

    /// Parts of the duration of the first level that are given on the way to one that is sought.
    pub const DURATIONS: [f64; 5] = [0.5, 0.7, 1.0, 1.5, 2.2];

    /// A duration is long from so many times that of a turn of a sphere with limits about the axis:
    /// `2 √θ` in the units of an extremal. Higher, smoothed inputs, which never rest, lead nowhere
    /// for some bodies; lower, a branch of the long duration may be no rival yet.
    pub const LONG: f64 = 4.0;

    /// Parts of a given duration in which one-sided thrusters are planned too, to be slowed down:
    /// each takes about as long as the plan itself. With fewer a cheaper plan of less time is
    /// missed now and then (`evidence -- stretches`).
    pub const QUICKER: [f64; 2] = [0.85, 0.6];
}

/// Branches (`branches`): how many extremals are told apart, and followed.
pub(super) mod branches {
    use crate::Vector3;

    /// Boundary rates in the unit of time beyond which either way round may be the short one.
    pub const FAST: f64 = 0.3;

    /// ε at which branches are told apart; at which they are compared, for an angle of a radian and
    /// more, and where fuel counts; and, over that, at which a bias has done its work: branches
    /// have parted, and Newton goes on without it.
    pub const BRANCHING: f64 = 0.3;
    pub const COMPARED: f64 = 0.008;
    pub const COMPARED_FUEL: f64 = 0.02;
    pub const PARTED: f64 = 7.0;

    /// Turns below this are small \[rad\]: their branches hardly differ. And the angle below which
    /// ε falls no further with it.
    pub const SMALL: f64 = 0.1;
    pub const SMALLEST_ANGLE: f64 = 0.03;

    /// A base that costs more than the best by this is no rival.
    pub const RIVAL_BASE: f64 = 1.15;

    /// Rotation vectors from the axes of the body to those that biases lie along: a maneuver with a
    /// symmetry has that along axes of the body as a rule, and what lies along them as well tips
    /// nothing.
    pub const ASKEW: Vector3 = Vector3::new(0.3, -0.5, 0.7);
    pub const OTHERWISE: Vector3 = Vector3::new(-0.9, 0.4, 1.3);

    /// Inputs that differ by more than this in what they give have branches that one set of biases
    /// misses; and so far is a body from a sphere that small ones miss some.
    pub const UNLIKE: f64 = 1.2;

    /// An axis with less of it beside others is no third one.
    pub const ASIDE: f64 = 0.1;

    /// Paths are one extremal whose costs and costates differ by less than these parts: of time,
    /// and of fuel, which is known less well.
    pub const ALIKE: (f64, f64) = (1e-4, 1e-2);
    pub const ALIKE_FUEL: (f64, f64) = (2e-3, 2e-2);
}

/// Smoothed extremals (`smooth`): how fast and how far ε falls, and on what intervals.
pub(super) mod smooth {
    use crate::optimize::methods::continuation::Pace;

    /// ε over the one before, and where a bias is only to tell branches apart; how the logarithm of
    /// ε falls, over that of the ratio.
    pub const RATIO: f64 = 0.25;
    pub const STEEP: f64 = 0.185;
    pub const DESCENT: Pace = Pace { first: 1.0, least: 0.037, most: 1.0, longer: 1.4, shorter: 0.4 };

    /// ε over the one before of an extremal that is known to all digits.
    pub const SETTLING: f64 = 0.2;

    /// Residual over ε of an extremal on the way to a smaller ε, and within what bounds.
    pub const ON_THE_WAY: f64 = 0.1;
    pub const ON_THE_WAY_WITHIN: (f64, f64) = (1e-4, 1e-2);

    /// Longest step of the duration and of switching times, relative to the duration.
    pub const TIME_STEP: f64 = 0.4;

    /// A step of Newton leaves out so much of the residual times its length, or is made shorter by
    /// this factor, so often: what does not come then rarely does with more.
    pub const DECREASE: f64 = 0.1;
    pub const SHORTENED: f64 = 0.4;
    pub const MOST_TRIALS: usize = 6;

    /// Intervals of the one first path of a turn, where ε is large: on half of them other extremals
    /// are found now and then. Where there are several such paths, some of them far, they have as
    /// many as what is continued.
    pub const INTERVALS_NEAR: usize = 16;

    /// Intervals of a path at the start of a continuation, those that are enough where no input
    /// changes fast, and at most.
    pub const INTERVALS: usize = 32;
    pub const ENOUGH: usize = 128;
    pub const MOST_INTERVALS: usize = 3000;

    /// What an input may change by on one interval, as a part of its range: of equal ones this over
    /// ε are enough; and how often one is halved for it at once.
    pub const RESOLVED: f64 = 0.2;
    pub const DEEPEST: usize = 8;
}

/// Arcs at the limits (`arcs`, `certificate`, `least_gap`): whether Newton on switching times comes
/// from a reading of a path to its arcs.
pub(super) mod arcs {
    /// Most steps of one arc: no bound but for durations that are out of all proportion.
    pub const MOST_STEPS: f64 = 1e3;

    /// Fewest switches that determine all costates; and most that are looked for, as singular arcs
    /// of fuel are long.
    pub const DETERMINED: usize = 5;
    pub const MOST_SWITCHES: usize = 40;

    /// An input below this part of its limit is off, and a pulse shorter than this part of the
    /// duration is none.
    pub const IDLE: f64 = 0.02;
    pub const SHORTEST_PULSE: f64 = 1e-4;

    /// An input that is on for less than this part of a run is between its limits.
    pub const BETWEEN: f64 = 0.7;

    /// Runs of wrong signs whose gap is this part of the largest are put right with it.
    pub const TOGETHER: f64 = 0.2;

    /// Of the least gap: first μ, by what factor it is made smaller, and what it may add to the gap
    /// in the end, as a part of that.
    pub const FIRST: f64 = 0.1;
    pub const REDUCED: f64 = 0.2;
    pub const ADDED: f64 = 0.05;

    /// What is added to the diagonal of its matrix, as a part of that: a maneuver of few inputs
    /// leaves costates open.
    pub const OPEN: f64 = 1e-13;
}

/// Limits of branches (`limit`, `search`, `fuel`): how many are brought to arcs, and how hard that
/// is tried.
pub(crate) mod limits {
    /// A gap below this part of the cost is none, and one below that can stay.
    pub const NO_GAP: f64 = 1e-7;
    pub const SMALL_GAP: f64 = 1e-4;

    /// A branch that costs more than the best by this is no rival: of time; and of fuel, or by
    /// one-sided thrusters, as the cost of what is smoothed can be far from that of arcs.
    pub const RIVAL: f64 = 1.015;
    pub const FAR_RIVAL: f64 = 1.1;

    /// How often a branch without arcs is followed to a smaller ε: of time, where more of them
    /// would take a third longer in the slowest tenth of the public set; and of fuel, as short
    /// pulses show late.
    pub const MOST_DESCENTS: usize = 3;
    pub const MOST_DESCENTS_FUEL: usize = 12;

    /// ε at which a branch with a singular arc ends on equal intervals, and that to which it is
    /// then carried.
    pub const LAST: f64 = 5e-4;
    pub const SMALLEST: f64 = 2e-5;

    /// Most corrections of the sequence of switches, of times that are laid out anew, and of arcs
    /// with a gap that is not small; and on the grid, where pulses are held at another bound and
    /// switches exchanged or joined.
    pub const MOST_CORRECTIONS: usize = 12;

    /// The last are of so many of the worst signs, on these parts of their time.
    pub const WORST: usize = 3;
    pub const PARTS: [f64; 4] = [1.0, 0.2, 0.04, 0.008];

    /// Arcs may cost more than their smoothed extremal by this part: what smoothing lets through of
    /// fuel.
    pub const DEARER: f64 = 0.05;

    /// How many pulses stand for a singular arc, one after the other until the gap is small.
    pub const CELLS: [usize; 6] = [1, 2, 3, 4, 6, 8];

    /// Parts into which the angle of a turn about a fixed axis is cut.
    pub const EIGENAXIS_PARTS: usize = 4000;
}

/// Long durations between rates (`impulses`): how many coasts are known, and laid out.
pub(super) mod impulses {
    /// Momenta at random that coasts are sought from; how many of the cheapest transfers are given
    /// burns, and how many of the cheapest of these more of them.
    pub const RANDOM: usize = 48;
    pub const TRIED: usize = 24;
    pub const MENDED: usize = 4;
}

/// The grid (`discretize`, `on_grid`, `grid_step`): whether arcs have a discrete optimum.
pub(crate) mod grid {
    /// Fewest steps of an arc.
    pub const LEAST_STEPS: usize = 2;

    /// Residual at which Newton ends if it falls no further, to less than this part; its
    /// iterations.
    pub const CONVERGED: f64 = 2e-13;
    pub const FALLING: f64 = 0.1;
    pub const MOST_ITERATIONS: usize = 30;

    /// ε that a step of the grid can follow, times the number of steps.
    pub const FOLLOWED: f64 = 0.3;
}

/// Pulses of a shortest length (`pulses`): which schedules are tried, and when their times are
/// best.
pub(super) mod pulses {
    /// As [`FINE`](super::FINE), with more lanes to carry; and on the way.
    pub const FINE: f64 = 0.01;
    pub const COARSE: f64 = super::COARSER * FINE;

    /// Weight of the terminal conditions against the size of a step that brings a motion back to
    /// them.
    pub const STIFF: f64 = 1e8;

    /// Longest change of a time at once, as a part of the duration; the shortest below which
    /// nothing is gained any more; and that after a step that was of no use, over what it was.
    pub const TRUST: f64 = 0.2;
    pub const NO_TRUST: f64 = 1e-8;
    pub const LESS_TRUST: f64 = 0.3;

    /// Iterations of Gauss and Newton after a step; and most that do not leave less than a part of
    /// the miss.
    pub const ITERATIONS: usize = 6;
    pub const LESS: f64 = 0.9;

    /// Steps of least fuel; what is still to be gained, as a part of it, when the best times are
    /// found.
    pub const MOST_STEPS: usize = 40;
    pub const NO_GAIN: f64 = 1e-10;

    /// Part of the predicted gain at which the next step may be longer.
    pub const GOOD: f64 = 0.5;

    /// A bound this near, as a part of the duration, is met exactly; the same for another attempt.
    pub const NEAR: [f64; 3] = [super::NOTHING, 1e-8, 1e-10];

    /// Newton stays this near to where it began, as a part of the duration; and on the grid to the
    /// equations of motion.
    pub const NEARBY: f64 = 0.02;
    pub const NEARBY_ON_GRID: f64 = 0.05;

    /// A bound that is violated by less than this part of the duration is kept.
    pub const KEPT: f64 = 1e-13;

    /// Pulses of one input with a gap below this many of the shortest are joined, and those below
    /// this part of it dropped.
    pub const JOINED: [f64; 3] = [0.0, 1.0, 4.0];
    pub const DROPPED: [f64; 4] = [0.5, 0.0, 0.9, 0.2];

    /// Extremals that schedules are made of; schedules whose best times are looked for; how many
    /// times as much a thorough search tries.
    pub const MOST_EXTREMALS: usize = 4;
    pub const MOST_STARTS: usize = 24;
    pub const THOROUGH: usize = 4;

    /// Schedules that are changed by a pulse at a time, and changes that are tried in all.
    pub const CHANGED: usize = 3;
    pub const MOST_CHANGES: usize = 60;

    /// Random schedules, and how many are tried at most where none has met the end.
    pub const RANDOM: usize = 12;
    pub const MOST_RANDOM: usize = 40;

    /// Costs that differ by this part are those of two schedules; schedules whose times differ by
    /// less than this are one to start from.
    pub const DISTINCT: f64 = 1e-7;
    pub const ALIKE: f64 = 1e-3;

    /// Most pulses; pulses of so many levels at most are combined for a burn.
    pub const MOST_PULSES: usize = 24;
    pub const MOST_COMBINED: usize = 12;
}
