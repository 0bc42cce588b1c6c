//! The shortest duration or the least fuel within limits and constraints, and the least fuel of forces and in fields: SCP with
//! the duration as an unknown where it is sought, and with the kinks of fuel in the cost (`methods/scp/model`,
//! `methods/scp/rows`).
//!
//! Time and fuel alone leave choices: where one input is at its limit throughout, others may do this or that. A little
//! effort in the cost decides them, and keeps every subproblem and Newton matrix regular. On the requested grid its share
//! is lowered until the cost does not feel it: with a share ε the optimum is dearer by `O(ε²)` where inputs are free on arcs,
//! and by nothing where each is at a limit, or off, but for as many as the terminal conditions ask for.
//!
//! Mostly nothing is lowered on that grid: a plan on few steps leads to arcs of continuous time, and these to the requested grid
//! (`search/by_arcs`).
//!
//! Where a share can be lowered no further, as where several limits act along arcs of a fine grid, the same share is counted from the
//! inputs of the plan itself, again and again (`search/goal`): the curvature stays, and the cost forgets the effort.
//!
//! A constraint that does not act does not choose the plan: where the cheapest plan of arcs without constraints, or one of its images,
//! keeps them all in its true motion, nothing that keeps them is cheaper, and it is the answer, with its arcs and its gap.
//!
//! Seeds are the paths of least effort without limits, that of minimum time or fuel under torque limits alone, straight and
//! bent, and their detours around the cones they cross; of fuel also what is of least effort within all limits. What is found
//! is a local minimum; how far the cheapest of them is the cheapest of all nobody knows.
//!
//! # How is the shortest maneuver found under cones, rate limits and wheels?
//!
//! By SCP with the duration as a state of the chain that every step leaves as it is (`optimize/methods/scp/model`). All else
//! is in the units that go with that duration: then a step of a free body does not know it, and what does are ends, fields
//! and limits, which grow as `s`, `s²` and `s³`. With fixed units every step is bilinear in duration and inputs; the same
//! iteration then creeps, because each step spoils what the one before has met. Subproblems, rows, Newton on the active set
//! and the way to a finer grid are those of least effort, and the plan is an effort plan of the duration found for whoever
//! reads it: equal steps, inputs at the nodes.
//!
//! Time alone leaves choices, and a Newton matrix without curvature: a share of the effort in the cost decides. It is a
//! hundredth while durations are compared, and is lowered to a millionth on the requested grid as far as that goes
//! (`search/cheapest`). The optimum is longer by the square of the share where inputs are free on arcs, and by nothing where
//! nearly all are at limits. Steps that end at switches would need arcs of three kinds (inputs, rates, cones) and their
//! order; opinion: `O(h²)` with the grid of all other plans is worth more. Switching times are those of continuous time, which
//! `search/limited` finds from the plan, where it does.
//!
//! # How does fuel go the same road?
//!
//! By its kinks. `c |u|` is the largest of `ν u` over the slopes `|ν| ≤ c`, so an input that costs fuel is one more row of
//! its stage, with a slope for a multiplier: in the cone program a variable above `±u`, in Newton on the active set an
//! equation `u = 0` where the slope is within its bounds, and a known slope elsewhere. Splitting inputs into two one-sided
//! ones would do the same with twice the inputs, and each pair would have a direction that costs nothing. A thruster is the
//! kink whose lower slope is any: the bound at 0 needs no row of its own. Under a limit of the norm alone the kink is that of
//! `|τ|`, three rows together, with its curvature where it burns; under limits of inputs and of the norm fuel is counted by
//! inputs. With the duration as a state the row is `u/s`, as `∫ c|u| dt` goes in the units of the chain, and its curvature
//! follows as that of every row does. On a grid the optimum is a vertex: nearly all inputs are off or at a limit, and so many
//! are between that the terminal conditions are met. A cost that is quadratic with a small share does not move a vertex; that
//! is why the shares of effort that decide what fuel leaves open need not vanish. Seeds are, beside those of minimum time,
//! the plans of least effort within all limits.
//!
//! # And forces, and fields?
//!
//! The same way, since the chain has them: a flight has force inputs beside those of the torques, each a kink of its own or,
//! under a limit of the norm alone, one for all of them; a field changes `A_k` and nothing else. Their inputs stand at the
//! nodes of equal steps. What they needed was a correction of second order. Where forces turn with the body, or a field with
//! the place, the dynamics bend along a move, the merit function sees defects that the subproblem does not, and the iteration
//! creeps with moves of a thousandth (Maratos). A move that gives less than half of what it promises is therefore solved once
//! more with the defects that it ended with; the better of both is taken. Of twelve transfers in central gravity six came to
//! a plan of fuel before and eleven do now; two of twelve pendulums and the flights of least time, which did not settle, do.
//! What was tried before it and is not here: curvature moved from stage to stage along the linearised dynamics, so that none
//! is lost where it is made convex, found four of the twelve transfers; a bound on how far positions move changed nothing.
//! Thrusters that push and turn are one row of inputs behind two sets of axes (`Actuation::split`): `B` of the chain has two
//! blocks in a column instead of one, and nothing else in the solver knows. The sets stay what they were, each with the
//! limits of the thrusters, so that proofs of infeasibility and the seeds without limits hold as for forces and torques that
//! do not know of each other, which can do more. Whether they push and turn every way is a question of six rows: full rank,
//! and `−B 1` within the cone of the columns, which least squares without negative weights decide (`numerics/cone`); the
//! three rows of torques alone ask the same. Where the duration is sought it is first guessed from all that helps along the
//! way: from the weakest thruster alone the guess may be far too long, and SCP does not come back. Where the frame turns the
//! duration says how far: `exp(−h s S(n))` on each step, whose derivative by `ln s` goes into the column of the duration, and
//! into the rows of cones about directions that stand in space. What a chain with an unknown duration has found is written in
//! the units of the duration found; where the body moves at an end the unit of length goes with it, and positions, momenta,
//! forces and their multipliers with that.

use super::advice;
use super::chains::{effort_paths, unlimited_paths};
use super::coarse::chain_steps;
use super::context::Context;
use super::duration;
use super::given_duration::{search_of, searched};
use super::goal::{SAME_COST, cheapest};
use super::ladder::Ask;
use super::paths::shortest_way;
use super::rungs::interior;
use super::shares::SHARE;
use super::switching;
use crate::Vector3;
use crate::flight::{Excess, Flight};
use crate::lie;
use crate::maneuver::constraint::Constraint;
use crate::maneuver::objective::{Fuel, Objective};
use crate::maneuver::problem::{Formulation, Motion, Problem, State, Stepping};
use crate::maneuver::settings::Method;
use crate::maneuver::shortfall::Shortfall;
use crate::maneuver::solution::{Outcome, Solution, Trajectory};
use crate::mechanics::actuators::{ActuatorSet, Limits};
use crate::mechanics::environment::{Free, Pose};
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::methods::scp::model::{Effort, Goal};
use crate::optimize::methods::scp::road::{Chain, path};
use std::f64::consts::PI;

/// How far the path of minimum time or fuel is bent to either side \[rad\]: a turn about one axis is often a saddle.
const BENT: f64 = 0.5;

/// Solves a maneuver of minimum time or fuel that more than torque limits shapes, or of least effort with a duration that is
/// sought.
pub(super) fn solve(problem: &Problem, context: &Context) -> Solution {
    let once = |problem: &Problem| match Formulation::of(problem) {
        Formulation::Extremal => {
            let ask = Ask { advise: true, lands: context.lands(), ..Ask::of_goal(None, context.settings) };
            searched(problem, context, ask)
        }
        _ if problem.objective.switches() => solve_once(problem, context),
        _ => effort_sought(problem, context),
    };
    match problem.duration.at_most() {
        Some(longest) => switching::up_to(longest, problem, context, &once),
        None => once(problem),
    }
}

/// Least effort in the best duration. The search for it is a local one, from that of a turn about a fixed axis without limits.
fn effort_sought(problem: &Problem, context: &Context) -> Solution {
    let longest = problem.duration.at_most().unwrap_or(f64::INFINITY);
    let free = duration::about_a_fixed_axis(problem, problem.objective.time_price());
    let stated = problem.clone().with_duration(free.min(longest));
    let stated = stated.with_objective(problem.objective.with_time_price(None));
    let unsolved = Solution::unsolved(problem, context.settings.tolerance);
    let mut solution = match stated.check() {
        Err(error) => Solution { shortfall: Some(Shortfall::Unusable(error)), ..unsolved },
        Ok(()) => of_stated(&stated, &problem.objective, context, &Trajectory::default()),
    };
    solution.ladder = context.ladder.take();
    solution.solve_time = context.began.elapsed().as_secs_f64();
    solution
}

/// In a given duration, or in the best one of all.
fn solve_once(problem: &Problem, context: &Context) -> Solution {
    let unsolved = Solution::unsolved(problem, context.settings.tolerance);
    let mut bare = Problem {
        constraints: Vec::new(),
        actuation: problem.actuation.of_jumping_inputs(),
        stepping: Stepping::Formulated,
        ..problem.clone()
    };
    // Only a free body that turns has a plan of inputs that switch; in a frame that turns and in a field that is a path to begin from.
    let free = problem.is_free_turn();
    let open = problem.ends_in_any_attitude();
    if open {
        bare.end.attitude = bare.start.attitude;
    }
    // To any attitude there is none, unless the body has the rate that it should have.
    let arrived = problem.start.angular_velocity == problem.end.angular_velocity;
    let mut within = None;
    let interior = interior::plans(problem, context.settings);
    let quick = match problem.motion {
        // Paths about a fixed axis, bent and past cones, are enough.
        _ if interior => unsolved.clone(),
        Motion::Attitude if !open || arrived => {
            let bare = without_field(bare);
            let unconstrained = may_be_unconstrained(problem)
                .then(|| switching::solve_unconstrained(&bare, context, &|plan| keeps_all(problem, plan)));
            let cheapest = unconstrained.and_then(|found| {
                within = found.within;
                Some(found.cheapest).filter(|plan| plan.outcome == Outcome::Converged)
            });
            // Where a shorter duration is sought in vain it is all of the time.
            cheapest.unwrap_or_else(|| switching::solve_discrete(&bare, context))
        }
        _ => unsolved.clone(),
    };
    *context.ladder.borrow_mut() = if free { quick.ladder.clone() } else { Vec::new() };
    if free && quick.trajectory.time.len() == 1 {
        // The body is where it should be.
        let stored = problem.actuation.wheels.iter().flat_map(|wheels| wheels.momentum.clone()).collect();
        let trajectory = Trajectory { wheel_momentum: stored, ..quick.trajectory };
        return Solution { trajectory, ..quick };
    }
    // Nothing that keeps more is cheaper than the cheapest of all.
    let unconstrained = |plan: &Solution| {
        let cost = plan.landing.as_ref().map_or(plan.cost, |landing| landing.cost_before);
        cost <= quick.cost * (1.0 + SAME_COST) && !switching::is_dear(plan)
    };
    if let Some(answer) = within.take_if(|plan| unconstrained(plan)) {
        return answer;
    }
    let sought = problem.duration.known().is_none();
    let stated = quick.trajectory.time.last().copied().filter(|_| sought && free);
    let duration = stated.or(problem.duration.known()).unwrap_or_else(|| about(problem));
    let stated = Problem { objective: Objective::default(), ..problem.clone().with_duration(duration) };
    // Checked as what it is: effort takes less than time and fuel.
    let mut solution = match (problem.clone().lasting(duration).check(), context.interrupt()) {
        (_, Some(stopped)) => Solution { outcome: stopped, ..unsolved },
        (Err(error), _) => Solution { shortfall: Some(Shortfall::Unusable(error)), ..unsolved },
        (Ok(()), None) => of_stated(&stated, &problem.objective, context, &quick.trajectory),
    };
    if sought && let Some(cheaper) = by_its_duration(problem, context, &solution) {
        solution = cheaper;
    }
    if let Some(within) = within
        && !(solution.outcome == Outcome::Converged && solution.cost <= within.cost)
    {
        solution = within;
    }
    solution.ladder = context.ladder.take();
    solution.solve_time = context.began.elapsed().as_secs_f64();
    solution
}

/// Whether a maneuver without its constraints is one of arcs, so that these may be its plan.
fn may_be_unconstrained(problem: &Problem) -> bool {
    problem.stepping == Stepping::Formulated && problem.clone().planned_on_arcs().switches()
}

/// Whether a plan of arcs keeps all constraints of a maneuver: the discrete motion at its nodes, and the true motion all along.
fn keeps_all(problem: &Problem, plan: &Solution) -> bool {
    let planned = plan.on_grid(&problem.clone().planned_on_arcs());
    if plan.outcome != Outcome::Converged {
        return false;
    }
    let found = &plan.trajectory;
    let frame_rate = planned.environment.frame_rate();
    let at_nodes = found.quaternion.iter().zip(&found.angular_velocity).zip(&found.time);
    let keeps = |((quaternion, rate), time): ((&[f64; 4], &Vector3), &f64)| {
        let attitude = lie::rotation_from_quaternion(quaternion);
        let violated =
            |rule: &Constraint| rule.violation(&attitude, rate, Some(*time), &frame_rate).is_some();
        !planned.constraints.iter().any(violated)
    };
    let Some(mut excess) = Excess::of(&planned) else { return true };
    let steps = Flight::of_plan(&planned, found);
    let flown = Flight::new(&planned).fly(&steps, Some(&mut excess));
    at_nodes.into_iter().all(keeps) && flown.is_some() && excess.worst.iter().all(|worst| *worst <= 0.0)
}

/// The same maneuver of least fuel once more along what is cheaper in the duration that was found, where anything is: a search that
/// is local in the duration too misses more.
fn by_its_duration(problem: &Problem, context: &Context, found: &Solution) -> Option<Solution> {
    let converged = |solution: &Solution| solution.outcome == Outcome::Converged;
    let fuel = problem.objective.fuel().filter(|_| converged(found))?;
    let duration = *found.trajectory.time.last()?;
    let objective = Objective::Fuel(Fuel { time_price: None, ..fuel.clone() });
    let noted = context.ladder.borrow().clone();
    let given = solve_once(&problem.clone().with_objective(objective).with_duration(duration), context);
    *context.ladder.borrow_mut() = noted;
    let price = problem.objective.time_price();
    let dearer = found.cost * (1.0 - SAME_COST);
    if !converged(&given) || given.cost + price * duration >= dearer {
        return None;
    }
    let stated = Problem { objective: Objective::default(), ..problem.clone().with_duration(duration) };
    let again = of_stated(&stated, &problem.objective, context, &given.trajectory);
    (converged(&again) && again.cost < dearer).then_some(again)
}

/// The attitude alone of a body that nothing acts on, at the rates that it has in the reference frame.
fn without_field(problem: Problem) -> Problem {
    let rate = problem.environment.frame_rate();
    let relative = |state: &State| State {
        angular_velocity: state.angular_velocity - state.attitude.tr_mul(&rate),
        ..*state
    };
    let (start, end) = (relative(&problem.start), relative(&problem.end));
    Problem { start, end, ..problem }.with_environment(Free)
}

/// The solution of a maneuver of minimum time or fuel, with the duration of `stated` as the unit of time.
fn of_stated(stated: &Problem, objective: &Objective, context: &Context, quick: &Trajectory) -> Solution {
    match stated.motion {
        Motion::Attitude => of_dimension::<6>(stated, objective, context, quick),
        Motion::RigidBody => of_dimension::<12>(stated, objective, context, quick),
    }
}

/// The same in the tangent dimension of the motion.
fn of_dimension<const N: usize>(
    stated: &Problem,
    objective: &Objective,
    context: &Context,
    quick: &Trajectory,
) -> Solution {
    let interior = objective.switches()
        && interior::plans(&stated.clone().with_objective(objective.clone()), context.settings);
    // The interior point needs no effort that decides what time and fuel leave open.
    let share = if interior { 0.0 } else { SHARE };
    let goal = Goal { objective: objective.clone(), effort: Effort::of_share(share) };
    let advise = !objective.counts_time();
    let lands = context.lands() || stated.met().is_some();
    let ask = Ask { advise, lands, ..Ask::of_goal(Some(goal), context.settings) };
    let search = search_of::<N>(stated, context, ask.clone());
    let coarse = search.chain(chain_steps(stated));
    let mut paths = bent(resampled(&coarse, objective.name(), quick));
    if paths.is_empty() {
        // Without a plan of inputs that switch.
        paths.push(shortest_way(&coarse.model));
        if interior {
            paths = bent(paths);
        }
    }
    let unlimited = if interior { Vec::new() } else { unlimited_paths(&search, &coarse) };
    if objective.fuel().is_some() && !interior {
        paths.extend(effort_paths(&search, &unlimited));
    }
    paths.extend(unlimited);
    let search = search.of(stated, Ask { paths: &paths, ..ask });
    let (found, cheapest) = cheapest(&search);
    let Some(cheapest) = cheapest else {
        // The nearest miss may have a duration of its own, which is none of a plan.
        let missed = found.missed();
        let mut unsolved = Solution {
            method: if interior { Method::InteriorPoint } else { Method::Scp },
            outcome: context.interrupt().or(missed.map(|missed| missed.outcome)).unwrap_or(Outcome::Stalled),
            shortfall: missed.and_then(|missed| missed.shortfall.clone()),
            ..Solution::unsolved(stated, context.settings.tolerance)
        };
        if advise {
            advice::advise(&search, found.shortest, &mut unsolved);
        }
        return unsolved;
    };
    cheapest.written(&search, &found)
}

/// The path of a plan without constraints on the grid of a chain; none where there is no plan.
fn resampled(chain: &Chain, objective: &str, quick: &Trajectory) -> Vec<Candidate> {
    let Some(duration) = quick.time.last() else { return Vec::new() };
    let grid = &chain.model.dynamics.grid;
    let pose = |node: usize| {
        let time = duration * grid.time(node);
        let after = quick.time.partition_point(|at| *at <= time).clamp(1, quick.time.len() - 1);
        let [from, to] = [after - 1, after].map(|row| lie::rotation_from_quaternion(&quick.quaternion[row]));
        let part = (time - quick.time[after - 1]) / (quick.time[after] - quick.time[after - 1]);
        let part = part.clamp(0.0, 1.0);
        let turn = lie::minus(&to, &from) * part;
        let position = match &quick.position[..] {
            [] => chain.model.start.position,
            places => places[after - 1].lerp(&places[after], part) / chain.model.dynamics.units.length,
        };
        Pose { position, attitude: from * lie::exp(&turn) }
    };
    vec![path(&format!("minimum {objective}"), grid, (0..=grid.steps()).map(pose))]
}

/// Paths, and the same bent to either side about each reference axis.
fn bent(paths: Vec<Candidate>) -> Vec<Candidate> {
    let sides = [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().flat_map(|axis| [axis, -axis]);
    let bends: Vec<Vector3> = sides.map(|side| side * BENT).collect();
    let bend = |straight: &Candidate, turn: &Vector3| {
        let poses = straight.states.iter().enumerate().map(|(node, point)| {
            let part = (PI * node as f64 / straight.steps() as f64).sin();
            Pose { attitude: lie::exp(&(turn * part)) * point.attitude.value, ..point.pose() }
        });
        let name = format!("{}, bent", straight.provenance.start);
        path(&name, &straight.grid, poses)
    };
    let turned =
        paths.iter().flat_map(|path| bends.iter().map(move |turn| bend(path, turn))).collect::<Vec<_>>();
    paths.into_iter().chain(turned).collect()
}

/// About how long a turn about a fixed axis takes, or a flight along a line where that is longer \[s\].
fn about(problem: &Problem) -> f64 {
    let lasting = |way: &Vector3, least: f64, speeds: &Vector3, inertia: f64, set: &ActuatorSet| {
        let way_there = 2.0 * (way.norm().max(least) * inertia / given(set, way)).sqrt();
        way_there + speeds.norm() * inertia / given(set, speeds)
    };
    let (start, end, torque) = (&problem.start, &problem.end, &problem.actuation.torque);
    let of_body = |vector: &Vector3| torque.frame().of_body(&start.attitude, vector);
    let turn = of_body(&lie::minus(&end.attitude, &start.attitude));
    let rates = of_body(&(end.angular_velocity - start.angular_velocity));
    let turning = if problem.ends_in_any_attitude() {
        // By a torque along the change of the momentum, whichever way the body turns meanwhile.
        let change = problem.body.inertia.j() * (end.angular_velocity - start.angular_velocity);
        change.norm() / given(torque, &of_body(&change))
    } else {
        lasting(&turn, 0.1, &rates, problem.body.inertia.j().norm(), torque)
    };
    let mass = problem.body.mass.filter(|_| problem.motion == Motion::RigidBody);
    let flying = mass.zip(problem.actuation.force.as_ref()).map_or(0.0, |(mass, force)| {
        let of_reference = |vector: &Vector3| force.frame().of_reference(&start.attitude, vector);
        let way = of_reference(&(end.position - start.position));
        lasting(&way, 0.0, &of_reference(&(end.velocity - start.velocity)), mass, force)
    });
    turning.max(flying)
}

/// About what a set gives along and against a direction: that of its weakest input or, where all that helps is much more, a part
/// of that.
fn given(set: &ActuatorSet, direction: &Vector3) -> f64 {
    let Limits { size, norm, one_sided, .. } = set.limits();
    let inputs = || set.axes().iter().zip(size.iter().flatten());
    // A thruster through the mass center turns nothing.
    let each = inputs().map(|(axis, bound)| axis.norm() * bound).chain(*norm);
    let weakest = each.filter(|bound| *bound > 0.0).fold(f64::INFINITY, f64::min);
    let along = |direction: &Vector3| -> f64 {
        let helps = |axis: &Vector3| {
            if *one_sided { axis.dot(direction).max(0.0) } else { axis.dot(direction).abs() }
        };
        inputs().map(|(axis, bound)| helps(axis) * bound).sum()
    };
    let unit = direction.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    let together = along(&unit).min(along(&-unit)) / 3.0_f64.sqrt();
    weakest.max(together.min(norm.unwrap_or(f64::INFINITY)))
}
