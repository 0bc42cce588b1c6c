//! The motion over a whole sequence as a single trajectory, along which gains and covariances are
//! computed and flights are simulated.

use super::joined::{Flown, Joined};
use super::{Sequence, SequencePlan};
use crate::feedback::RegulatorWeights;
use crate::flight::Flight;
use crate::maneuver::duration::Duration;
use crate::maneuver::problem::{EndCondition, Problem, State, Stepping};
use crate::maneuver::solution::Trajectory;
use crate::optimize::discrete::linear_plan::{MOST_STEPS, Unlinearised};
use crate::{Vector3, lie};

/// A trajectory with its maneuver. The time of the trajectory begins at zero.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// The maneuver, with the grid of the trajectory.
    pub problem: &'a Problem,
    /// The planned trajectory.
    pub path: &'a Trajectory,
}

/// A leg with the hold at its end.
#[derive(Clone, Copy, Debug)]
pub struct LegMotion<'a> {
    /// The motion of the leg.
    pub leg: Motion<'a>,
    /// The motion of the hold; `None` if the body rests.
    pub hold: Option<Motion<'a>>,
    /// Start time of the leg in the sequence \[s\].
    pub begins: f64,
    /// Start and end time of the hold in the sequence \[s\].
    pub holds: [f64; 2],
}

/// An instant at which the craft must be at a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    /// Index of the leg that leads to the stop, in the order of time.
    pub leg: usize,
    /// `true` if the hold at the stop ends at this instant. `false` if the hold begins, or if the
    /// craft passes without a hold.
    pub ends: bool,
    /// Index of the node of the trajectory at this instant.
    pub node: usize,
}

/// The motion over a whole sequence as a single trajectory.
#[derive(Clone, Debug)]
pub struct WholeMotion {
    /// The maneuver of the whole motion. Times in its constraints count from the start of the
    /// sequence. Alternative sets of cones are left out.
    pub problem: Problem,
    /// The true motion under the inputs of all legs and holds, with one row of inputs for each
    /// step.
    pub path: Trajectory,
    /// The instants at which the craft must be at a stop, in the order of time. The last instant
    /// may be at the last node.
    pub instants: Vec<Instant>,
    /// Duration of the shortest leg \[s\].
    pub shortest: f64,
}

impl WholeMotion {
    /// Joins legs and holds, and propagates the true motion of each under its inputs. While the
    /// body rests, the steps are at most as long as in the leg before.
    ///
    /// # Errors
    /// [`Unlinearised`] if the body moves in no leg, if a motion cannot be propagated, or if the
    /// sequence has more steps than can be linearised.
    pub fn of(sequence: &Sequence, legs: &[LegMotion<'_>]) -> Result<Self, Unlinearised> {
        let followed = |motion: &Motion<'_>| {
            let Motion { problem, path } = motion;
            let nodes = path.time.len();
            let fits = path.quaternion.len() == nodes
                && path.angular_velocity.len() == nodes
                && path.torque.len() <= nodes;
            if nodes == 0 || !fits {
                return Err(Unlinearised::Trajectory);
            }
            Flight::recorded(problem, path).ok_or(Unlinearised::Step)
        };
        let mut motions = Vec::with_capacity(legs.len());
        let (mut shortest, mut step) = (f64::INFINITY, f64::INFINITY);
        for LegMotion { leg, hold, begins, holds } in legs {
            let path = followed(leg)?;
            let lasting = path.time.last().copied().ok_or(Unlinearised::Trajectory)?;
            if lasting > 0.0 {
                shortest = shortest.min(lasting);
                step = lasting / (path.time.len() - 1) as f64;
            }
            let arrival = begins + lasting;
            // A hold at rest has a node where it begins, which its own grid may not have.
            let moves = |hold: &&Motion<'_>| hold.path.angular_velocity.iter().any(|rate| rate.amax() > 0.0);
            let hold = match hold.as_ref().filter(moves) {
                Some(hold) => Some(followed(hold)?),
                None => {
                    let inputs = leg.problem.actuation.count();
                    resting((&path, inputs), step, [holds[0] - arrival, holds[1] - arrival])?
                }
            };
            motions.push((path, hold));
        }
        let joined = Joined::of(motions.iter().zip(legs).map(|((path, hold), leg)| Flown {
            path,
            begins: leg.begins,
            hold: hold.as_ref(),
            until: leg.holds[1],
        }));
        let instants = instants(&joined, legs);
        let path = joined.path;
        let (Some(duration), Some(last), Some(rate), true) = (
            path.time.last().copied(),
            path.quaternion.last(),
            path.angular_velocity.last(),
            shortest.is_finite(),
        ) else {
            return Err(Unlinearised::Trajectory);
        };
        let end = State::attitude(lie::rotation_from_quaternion(last), *rate);
        let craft = &sequence.craft;
        let of_alternatives = |name: &String| {
            craft.alternatives.iter().any(|all| all.sets.iter().any(|set| set.contains(name)))
        };
        let problem = Problem {
            stepping: Stepping::Recorded,
            duration: Duration::Given(duration),
            chooses_steps: false,
            steps: path.time.len() - 1,
            end,
            end_condition: EndCondition::State,
            alternatives: Vec::new(),
            constraints: craft
                .constraints
                .iter()
                .filter(|constraint| !of_alternatives(&constraint.name))
                .cloned()
                .collect(),
            ..craft.clone()
        };
        Ok(Self { problem, path, instants, shortest })
    }

    /// Returns the motion over the whole sequence for a plan.
    ///
    /// # Errors
    /// The errors of [`WholeMotion::of`].
    pub fn of_plan(sequence: &Sequence, plan: &SequencePlan) -> Result<Self, Unlinearised> {
        let grids: Vec<_> = plan
            .legs
            .iter()
            .map(|leg| {
                let hold = leg.hold.as_ref().map(|hold| hold.plan.solution.on_grid(&hold.problem));
                (leg.plan.solution.on_grid(&leg.problem), hold)
            })
            .collect();
        let legs: Vec<_> = plan
            .legs
            .iter()
            .zip(&grids)
            .map(|(leg, (problem, hold))| LegMotion {
                leg: Motion { problem, path: &leg.plan.solution.trajectory },
                hold: leg
                    .hold
                    .as_ref()
                    .zip(hold.as_ref())
                    .map(|(hold, problem)| Motion { problem, path: &hold.plan.solution.trajectory }),
                begins: leg.begins,
                holds: leg.holds,
            })
            .collect();
        Self::of(sequence, &legs)
    }

    /// Returns the indices of the nodes at which the craft must be at a stop, without the last
    /// node.
    pub fn stops(&self) -> Vec<usize> {
        let last = self.path.time.len() - 1;
        self.instants.iter().map(|instant| instant.node).filter(|node| *node < last).collect()
    }

    /// Returns the default weights of a regulator, which are based on the duration of the shortest
    /// leg.
    pub fn weights(&self) -> RegulatorWeights {
        let whole = self.path.time.last().copied().unwrap_or(self.shortest);
        RegulatorWeights::of_legs(&self.problem, self.shortest, whole)
    }
}

/// Returns the trajectory of the rest after a leg, with steps of at most `step` \[s\]. The hold
/// begins and ends at the given times \[s\] from the end of the leg, and each of these times is a
/// node. Returns `None` if the rest takes no time.
fn resting(
    (leg, inputs): (&Trajectory, usize),
    step: f64,
    [begins, ends]: [f64; 2],
) -> Result<Option<Trajectory>, Unlinearised> {
    let mut time = vec![0.0];
    for until in [begins, ends] {
        let from = time[time.len() - 1];
        if until > from {
            let steps = ((until - from) / step).ceil().max(1.0);
            if steps > MOST_STEPS as f64 {
                return Err(Unlinearised::Fine);
            }
            time.extend((1..=steps as usize).map(|index| from + (until - from) * index as f64 / steps));
        }
    }
    let (nodes, wheels) = (time.len(), leg.wheel_momentum.len() / leg.time.len());
    let held = leg.wheel_momentum[leg.wheel_momentum.len() - wheels..].to_vec();
    Ok((nodes > 1).then(|| Trajectory {
        quaternion: vec![leg.quaternion[leg.quaternion.len() - 1]; nodes],
        angular_velocity: vec![Vector3::zeros(); nodes],
        input: vec![0.0; (nodes - 1) * inputs],
        input_count: inputs,
        torque: vec![Vector3::zeros(); nodes - 1],
        wheel_momentum: held.repeat(nodes),
        time,
        ..Trajectory::default()
    }))
}

/// Returns the instants at which the craft must be at a stop, in the order of time.
fn instants(joined: &Joined, legs: &[LegMotion<'_>]) -> Vec<Instant> {
    let time = &joined.path.time;
    let mut instants: Vec<Instant> = Vec::with_capacity(2 * legs.len());
    for (index, leg) in legs.iter().enumerate() {
        let mut parts = joined.parts.iter().filter(|part| part.leg == index);
        let (Some(flown), rest) = (parts.next(), parts.next()) else { continue };
        let [first, last] = rest.map_or([flown.nodes[1]; 2], |rest| rest.nodes);
        let begins = (first..=last).min_by(|a, b| {
            let apart = |node: usize| (time[node] - leg.holds[0]).abs();
            apart(*a).total_cmp(&apart(*b))
        });
        let begins = begins.unwrap_or(first);
        instants.push(Instant { leg: index, ends: false, node: begins });
        if last > begins {
            instants.push(Instant { leg: index, ends: true, node: last });
        }
    }
    instants
}

#[cfg(test)]
mod tests;
