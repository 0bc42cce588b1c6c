//! Plans the nodes of a table, one per orbit of the symmetry, and measures the errors of the table.

use super::mesh::Mesh;
use super::reference::Reference;
use super::{Errors, Nodes, Quantity, SlewTable, vectors};
use crate::maneuver::constraint::Rule;
use crate::maneuver::problem::{EndCondition, Motion, Path, Problem, ProblemError, State};
use crate::maneuver::settings::{Settings, Target};
use crate::maneuver::{Duration, Objective, Solution, fixed_axis_duration};
use crate::mechanics::actuators::AxisFrame;
use crate::numerics::random::Stream;
use crate::plan::{Control, Observer, PlanError, Progress, Status, plan};
use crate::sequence::leg_bound::LegBound;
use crate::sequence::symmetry::Symmetry;
use crate::{Matrix3, Vector3, lie};
use std::f64::consts::PI;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;
use thiserror::Error;

/// Stack size of a planning thread \[bytes\]. The main thread usually has a stack of this size.
const STACK: usize = 8 << 20;

/// Numbers of steps that are tried for a turn without a plan, relative to the requested number.
/// More entries find more plans: a turn by 40° of `evidence -- table wheels` has no plan on 50
/// steps, but one on 60. A thorough search on 50 steps finds a plan with four times the duration.
const GRIDS: [f64; 4] = [1.0, 1.2, 1.4, 1.7];

/// The options for computing a table.
#[derive(Clone, Debug, PartialEq)]
pub struct TableOptions {
    /// Number n of divisions of each edge of the octahedron: the table has `4n² + 2` directions,
    /// 90°/n apart. Doubling n takes four times as long and leaves about a quarter of the error.
    /// Default: 8, and up to 16 for symmetric spacecraft, which need fewer plans.
    pub divisions: Option<usize>,
    /// Angles of the turns \[deg\], ascending; the last one must be 180. Below the first angle the
    /// ratio to the closed form is constant. Default: 1, 3, 8, 20, and every 20 up to 180.
    pub angles_deg: Vec<f64>,
    /// Number of random turns that are planned to measure the errors; 0 for none. Default: 200.
    pub checks: usize,
    /// Settling time after a leg \[s\]. Default: 0.
    pub settling_s: f64,
    /// Number of threads. Default: all processors.
    pub threads: Option<usize>,
}

impl Default for TableOptions {
    fn default() -> Self {
        let rest = (1..=9).map(|step| 20.0 * f64::from(step));
        Self {
            divisions: None,
            angles_deg: [1.0, 3.0, 8.0].into_iter().chain(rest).collect(),
            checks: 200,
            settling_s: 0.0,
            threads: None,
        }
    }
}

/// The progress of a table: the number of planned maneuvers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Making {
    /// Number of maneuvers planned so far.
    pub done: usize,
    /// Total number of maneuvers to plan.
    pub total: usize,
}

/// A part of a problem that a table ignores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Left {
    /// Cones. The tabulated values are lower than the values with cones.
    Cones,
    /// Start and end. A table contains all turns from rest to rest.
    Ends,
}

/// The reason why a table could not be computed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TableError {
    /// The cost of a leg is not a function of the turn alone, or plans of this kind have no
    /// suitable value.
    #[error("no table: {reason}; {remedy}")]
    Refused {
        /// The property of the problem that prevents a table.
        reason: &'static str,
        /// A change of the problem that avoids the obstacle.
        remedy: &'static str,
    },
    /// The problem or the settings are invalid.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// No plan was found for a node.
    #[error(
        "no plan was found for the turn by {angle_deg:.1}° about [{:.4}, {:.4}, {:.4}] ({status}); {remedy}",
        axis[0], axis[1], axis[2]
    )]
    Unplanned {
        /// Angle of the turn \[deg\].
        angle_deg: f64,
        /// Rotation axis of the turn, body axes.
        axis: [f64; 3],
        /// Status of the failed plan.
        status: &'static str,
        /// A change that may help.
        remedy: &'static str,
    },
    /// An option is out of range.
    #[error("{what}")]
    Option {
        /// The option and its valid range, as a sentence.
        what: &'static str,
    },
    /// The nodes do not form a table.
    #[error("not a slew table: {what}")]
    Nodes {
        /// The invalid property of the nodes, as a phrase.
        what: &'static str,
    },
    /// The operating system granted no thread.
    #[error("the system cannot start a thread: allow more processes (`ulimit -u`), or more memory")]
    NoThread,
    /// The caller stopped the computation.
    #[error("stopped")]
    Stopped,
}

impl From<ProblemError> for TableError {
    fn from(error: ProblemError) -> Self {
        PlanError::from(error).into()
    }
}

impl SlewTable {
    /// Computes the table for the craft of a problem: its body, actuators, rate limits, objective,
    /// steps and search settings. `progress` is called about ten times per second; the computation
    /// stops when it returns false.
    ///
    /// # Errors
    /// [`TableError`] if the cost of a leg is not a function of the turn alone, a node has no plan,
    /// or the caller stops.
    pub fn make(
        problem: &Problem,
        settings: &Settings,
        options: &TableOptions,
        progress: &mut dyn FnMut(Making) -> bool,
    ) -> Result<Self, TableError> {
        let quantity = refuse(problem)?;
        check(options)?;
        let symmetry = Symmetry::of(problem);
        let reference = Reference::new(problem, quantity).ok_or(UNREACHED)?;
        let divisions = options.divisions.unwrap_or_else(|| usual_divisions(symmetry.maps.len()));
        let mesh = Mesh::new(divisions);
        let angles: Vec<f64> = options.angles_deg.iter().map(|angle| angle.to_radians().min(PI)).collect();
        let stands = mesh.representatives(&symmetry.maps);
        let own: Vec<usize> = (0..mesh.count()).filter(|node| stands[*node].0 == *node).collect();
        let all: Vec<Vector3> = vectors(&mesh, &symmetry.axes, &angles).collect();
        let at = |level: usize, node: usize| level * mesh.count() + node;
        let levels = 0..angles.len();
        let mut turns: Vec<Vector3> = levels
            .clone()
            .flat_map(|level| own.iter().map(move |node| (level, *node)))
            .map(|(level, node)| all[at(level, node)])
            .collect();
        let nodes = turns.len();
        turns.extend((0..options.checks).map(random_turn));
        let legs = Planner {
            problem: &of_leg(problem, quantity),
            settings: &of_table(settings, quantity),
            quantity,
        };
        let planned = legs.all(&turns, options.threads, progress)?;

        let bound = LegBound::new(problem);
        let mut values = vec![0.0; all.len()];
        let mut gradients = vec![Vector3::zeros(); all.len()];
        for level in levels {
            for (node, (from, map)) in stands.iter().enumerate() {
                let row = own.binary_search(from).unwrap_or_default();
                let leg = &planned[level * own.len() + row];
                let turned = symmetry.axes * map * symmetry.axes.transpose();
                values[at(level, node)] = leg.value;
                gradients[at(level, node)] = turned * leg.gradient;
            }
        }
        let bounded = |vector: &Vector3| match quantity {
            Quantity::Time => bound.time(&lie::exp(vector)),
            Quantity::Effort => bound.effort(&lie::exp(vector), problem.seconds()),
        };
        let mut leg = of_leg(problem, quantity);
        let fixed = |vector: &Vector3| {
            leg.end = State::at_rest(lie::exp(vector));
            (quantity == Quantity::Time).then(|| fixed_axis_duration(&leg))?
        };
        let mut table = Self::new(Nodes {
            quantity,
            divisions,
            axes: symmetry.axes,
            maps: symmetry.maps.clone(),
            bounds: all.iter().map(bounded).collect(),
            fixed_axis: all.iter().map(fixed).collect::<Option<_>>().unwrap_or_default(),
            angles,
            values,
            gradients,
            duration_s: if quantity == Quantity::Effort { problem.seconds() } else { 0.0 },
            scales: quantity == Quantity::Effort && !is_limited(problem),
            reference: [reference.torque, reference.rate],
            bound: bound.numbers(),
            settling_s: options.settling_s,
            planned: nodes,
            errors: Errors::default(),
        })?;
        let cases = turns[nodes..].iter().zip(&planned[nodes..]).map(|(turn, leg)| {
            let turn = lie::exp(turn);
            [table.value(&turn), leg.value, table.bound(&turn)]
        });
        table.nodes.errors = Errors::of(&cases.collect::<Vec<_>>());
        Ok(table)
    }

    /// Returns the parts of a problem that a table ignores.
    pub fn left_out(problem: &Problem) -> Vec<Left> {
        let cones = problem.constraints.iter().any(|constraint| matches!(constraint.rule, Rule::Pointing(_)));
        let ends = problem.end_condition != EndCondition::State
            || [&problem.start, &problem.end].iter().any(|end| end.angular_velocity != Vector3::zeros());
        [(cones, Left::Cones), (ends, Left::Ends)]
            .into_iter()
            .filter(|(is, _)| *is)
            .map(|(_, left)| left)
            .collect()
    }

    /// Plans rest-to-rest legs with the settings of a table, and returns their values, for
    /// comparison with a table.
    ///
    /// # Errors
    /// [`TableError`], as [`SlewTable::make`] returns it.
    pub fn plan_legs(
        problem: &Problem,
        settings: &Settings,
        turns: &[Vector3],
        threads: Option<usize>,
        progress: &mut dyn FnMut(Making) -> bool,
    ) -> Result<Vec<f64>, TableError> {
        let quantity = refuse(problem)?;
        let legs = Planner {
            problem: &of_leg(problem, quantity),
            settings: &of_table(settings, quantity),
            quantity,
        };
        Ok(legs.all(turns, threads, progress)?.iter().map(|leg| leg.value).collect())
    }
}

/// Returns the rotation vector of random turn `number`; the turns are uniformly distributed on
/// SO(3).
pub(crate) fn random_turn(number: usize) -> Vector3 {
    const SEED: u64 = 71;
    let mut stream = Stream::new(SEED, number as u64, 0);
    let quaternion = [(); 4].map(|()| stream.normal());
    lie::log(&lie::rotation_from_quaternion(&quaternion))
}

const UNREACHED: TableError = TableError::Refused {
    reason: "the inputs have no limits, or do not reach every direction",
    remedy: "give `torque_limit_n_m`, and inputs about three axes",
};

/// Returns the quantity to tabulate, or an error if the cost of a leg is not a function of the
/// turn.
fn refuse(problem: &Problem) -> Result<Quantity, TableError> {
    let refused = |reason, remedy| Err(TableError::Refused { reason, remedy });
    let (torque, wheels) = (&problem.actuation.torque, problem.actuation.wheels.as_ref());
    let effort = matches!(problem.objective, Objective::Effort(_));
    if problem.motion != Motion::Attitude || problem.actuation.force.is_some() {
        return refused("the body translates too", "remove positions, mass and forces from the spec");
    }
    if !problem.environment.is_free() || problem.environment.frame_rate() != Vector3::zeros() {
        return refused(
            "in a field or a turning frame a leg depends on both attitudes and the time",
            "remove `[environment]`: `slew plan` plans single legs with it",
        );
    }
    if torque.frame() != AxisFrame::Body {
        return refused("inputs are fixed to the reference frame", "give their axes in body axes");
    }
    if wheels.is_some_and(|wheels| wheels.momentum.iter().any(|held| *held != 0.0)) {
        return refused(
            "with momentum stored in wheels a leg depends on both attitudes, not only on the turn",
            "set `momentum_n_m_s` to zero for a table of empty wheels, or plan the legs by `slew batch`",
        );
    }
    if problem.shortest_pulse().is_some() {
        return refused(
            "plans with a minimum pulse width have no gradient",
            "remove the minimum pulse width",
        );
    }
    if let Objective::Fuel(_) = problem.objective {
        return refused(
            "fuel cannot be scaled to other durations",
            "tabulate `minimize = \"time\"` or `\"effort\"`; `slew batch` plans minimum-fuel legs",
        );
    }
    if effort && problem.seeks_duration() {
        return refused("effort needs one duration for all turns", "give `duration_s`");
    }
    if !torque.reaches_every_direction() {
        return Err(UNREACHED);
    }
    Ok(if effort { Quantity::Effort } else { Quantity::Time })
}

fn check(options: &TableOptions) -> Result<(), TableError> {
    let option = |what| Err(TableError::Option { what });
    if options.divisions.is_some_and(|divisions| !(1..=SlewTable::MAX_DIVISIONS).contains(&divisions)) {
        return option("the divisions must be from 1 to 64");
    }
    let angles = &options.angles_deg;
    let ascend = angles.windows(2).all(|pair| pair[0] < pair[1]);
    let ends = angles.first().is_some_and(|first| *first > 0.0)
        && angles.last().is_some_and(|last| (last - 180.0).abs() < 1e-9);
    if !(2..=SlewTable::MAX_ANGLES).contains(&angles.len()) || !ascend || !ends {
        return option("the angles must ascend from above 0° to 180°");
    }
    if !(options.settling_s >= 0.0 && options.settling_s.is_finite()) {
        return option("the settling time must not be negative");
    }
    Ok(())
}

/// Returns the default number of divisions for a symmetry group of this order. It keeps the number
/// of plans at about 130 directions, until the file would become large.
fn usual_divisions(order: usize) -> usize {
    (8.0 * (order as f64 / 2.0).sqrt()).round().clamp(8.0, 16.0) as usize
}

fn is_limited(problem: &Problem) -> bool {
    problem.actuation.is_limited()
        || problem.constraints.iter().any(|constraint| !matches!(constraint.rule, Rule::Pointing(_)))
}

/// Returns the problem of a leg; the caller sets its end.
fn of_leg(problem: &Problem, quantity: Quantity) -> Problem {
    let mut leg = problem.clone();
    let still = State::at_rest(Matrix3::identity());
    (leg.start, leg.end, leg.end_condition, leg.path) = (still, still, EndCondition::State, Path::Best);
    leg.constraints.retain(|constraint| !matches!(constraint.rule, Rule::Pointing(_)));
    leg.alternatives.clear();
    if quantity == Quantity::Time {
        leg.duration = Duration::SOUGHT;
    }
    leg
}

/// Returns the settings for the plans of a table, without the second-order test. Minimum-time plans
/// use the discrete motion, whose duration converges faster than the duration of a landed plan. The
/// effort of a discrete plan may be below the optimum in continuous time, and thus below the lower
/// bound, so minimum-effort plans keep the requested target.
fn of_table(settings: &Settings, quantity: Quantity) -> Settings {
    Settings {
        target: if quantity == Quantity::Time { Target::Discrete } else { settings.target },
        continuous_tolerance: None,
        test_second_order: false,
        ..settings.clone()
    }
}

/// The value of a planned leg, and its gradient by the rotation vector.
#[derive(Clone, Copy, Debug)]
struct Leg {
    value: f64,
    gradient: Vector3,
}

/// The planner of the legs of a table.
struct Planner<'a> {
    problem: &'a Problem,
    settings: &'a Settings,
    quantity: Quantity,
}

/// An observer that stops planning when the flag is set.
struct Stoppable<'a>(&'a AtomicBool);

impl Observer for Stoppable<'_> {
    fn on_progress(&mut self, _: &Progress) -> Control {
        if self.0.load(Ordering::Relaxed) { Control::Stop } else { Control::Continue }
    }
}

impl Planner<'_> {
    /// Plans all turns on several threads. The results do not depend on the number of threads.
    fn all(
        &self,
        turns: &[Vector3],
        threads: Option<usize>,
        progress: &mut dyn FnMut(Making) -> bool,
    ) -> Result<Vec<Leg>, TableError> {
        let (next, over) = (AtomicUsize::new(0), AtomicBool::new(false));
        let available = || thread::available_parallelism().map_or(1, |count| count.get());
        let count = threads.unwrap_or_else(available).clamp(1, turns.len().max(1));
        let mut found: Vec<Option<Leg>> = vec![None; turns.len()];
        let mut first_error: Option<(usize, TableError)> = None;
        let mut stopped = false;
        thread::scope(|scope| {
            let (sender, results) = mpsc::channel();
            for number in 0..count {
                let (sender, next, over) = (sender.clone(), &next, &over);
                let work = move || {
                    loop {
                        let index = next.fetch_add(1, Ordering::Relaxed);
                        if index >= turns.len() || over.load(Ordering::Relaxed) {
                            break;
                        }
                        if sender.send((index, self.leg(&turns[index], over))).is_err() {
                            break;
                        }
                    }
                };
                let started = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work);
                if started.is_err() && number == 0 {
                    first_error = Some((0, TableError::NoThread));
                }
            }
            drop(sender);
            let mut done = 0;
            loop {
                match results.recv_timeout(std::time::Duration::from_millis(100)) {
                    Ok((index, Ok(leg))) => {
                        found[index] = Some(leg);
                        done += 1;
                    }
                    Ok((index, Err(error))) => {
                        // The error of the first failed turn in the list is reported, whichever
                        // thread finishes first.
                        if first_error.as_ref().is_none_or(|(known, _)| index < *known) && !stopped {
                            first_error = Some((index, error));
                        }
                        over.store(true, Ordering::Relaxed);
                    }
                    Err(mpsc::RecvTimeoutError::Disconnected) => break,
                    Err(mpsc::RecvTimeoutError::Timeout) => {}
                }
                if !progress(Making { done, total: turns.len() }) {
                    stopped = true;
                    over.store(true, Ordering::Relaxed);
                }
            }
        });
        if stopped {
            return Err(TableError::Stopped);
        }
        match first_error {
            Some((_, error)) => Err(error),
            None => found.into_iter().collect::<Option<Vec<_>>>().ok_or(TableError::NoThread),
        }
    }

    /// Plans one turn. If no plan is found, plans the inverse turn, which has the same value, and
    /// then both turns on other grids.
    fn leg(&self, turn: &Vector3, over: &AtomicBool) -> Result<Leg, TableError> {
        let mut status = Status::NotConverged;
        let tries = GRIDS.iter().flat_map(|share| [(*share, *turn), (*share, -turn)]);
        for (share, vector) in tries {
            let mut problem = self.problem.clone();
            problem.end = State::at_rest(lie::exp(&vector));
            problem.steps = ((problem.steps as f64 * share).ceil() as usize).min(Problem::MAX_STEPS);
            let found = plan(&problem, self.settings, None, &mut Stoppable(over))?;
            if found.status == Status::Solved
                && let Some(leg) = self.value(&found.solution, &vector)
            {
                let gradient = if vector == *turn { leg.gradient } else { -leg.gradient };
                return Ok(Leg { gradient, ..leg });
            }
            status = found.status;
            if status == Status::Interrupted {
                return Err(TableError::Stopped);
            }
        }
        let angle = turn.norm();
        let remedy = match self.quantity {
            Quantity::Time => "give another number of `steps`",
            Quantity::Effort => {
                "give a longer `duration_s`: it must suffice for half a turn about every axis"
            }
        };
        let axis = turn / angle;
        Err(TableError::Unplanned {
            angle_deg: angle.to_degrees(),
            axis: axis.into(),
            status: status.name(),
            remedy,
        })
    }

    /// Returns value and gradient of a plan; `None` if a number is not finite.
    fn value(&self, solution: &Solution, vector: &Vector3) -> Option<Leg> {
        let continuous = solution.switching.as_ref().map(|switching| switching.continuous_duration_s);
        let value = match self.quantity {
            Quantity::Time => continuous.unwrap_or(solution.cost),
            Quantity::Effort => solution.cost,
        };
        // The terminal costate of the attitude is the negative gradient by a turn in body axes.
        let costates = &solution.trajectory.costates;
        let last = costates.get(costates.len().checked_sub(6)?..)?;
        let mut gradient = -lie::right_jacobian(vector).transpose() * Vector3::new(last[0], last[1], last[2]);
        let angle = vector.norm();
        let outward = gradient.dot(vector) / angle;
        if angle > PI * (1.0 - 1e-9) && outward < 0.0 {
            // The plan turned the long way. By symmetry the value increases equally on the short
            // way.
            gradient -= vector * (2.0 * outward / angle);
        }
        let finite = value > 0.0 && value.is_finite() && gradient.iter().all(|part| part.is_finite());
        finite.then_some(Leg { value, gradient })
    }
}
