//! Detours around cones: initial paths for methods that converge locally.
//!
//! A path whose boresight crosses a keep-out cone is turned aside over the crossing, to either
//! side. A path that leaves a keep-in cone is pulled back into it node by node, and a path that
//! must stay on a cone is pulled onto it.

use crate::Vector3;
use crate::lie;
use crate::maneuver::constraint::{Direction, Pointing, Rule, Side, angle_between};
use crate::maneuver::problem::Problem;
use crate::mechanics::environment::Pose;
use crate::optimize::chain::path;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::Point;
use crate::optimize::search::starts::transfer::Interpolant;

/// Clearance of a detour from the edge of a cone \[rad\].
const CLEARANCE: f64 = 0.03;
/// Number of points per step at which crossings of a cone are tested.
const PARTS: usize = 8;
/// Largest number of paths that are kept. Each further cone doubles their number.
const MOST: usize = 8;

/// A pair of a boresight and the direction of a cone.
struct Cone<'a> {
    name: &'a str,
    pointing: &'a Pointing,
    half_angle: f64,
    boresight: Vector3,
    direction: &'a Direction,
    /// Duration of the path \[s\].
    seconds: f64,
    frame_rate: Vector3,
}

/// A boresight and a cone at a node.
struct Seen {
    boresight: Vector3,
    /// Direction of the cone's axis.
    direction: Vector3,
    /// Angle from the axis to the surface \[rad\].
    half_angle: f64,
    /// True if the cone is active at the time of the node.
    acts: bool,
}

/// Returns the detours of a path around every cone that it violates, to both sides of keep-out
/// cones; the path itself if it violates none or already leads around the cones.
pub(crate) fn detours(problem: &Problem, seed: Candidate) -> Vec<Candidate> {
    if seed.provenance.led_past { vec![seed] } else { turned(problem, seed, false) }
}

/// Returns the path with a detour on the nearer side of every cone that it violates, each cone
/// once.
pub(crate) fn past(problem: &Problem, seed: Candidate) -> Candidate {
    let mut past = turned(problem, seed.clone(), true).pop().unwrap_or(seed);
    past.provenance.led_past = true;
    past
}

/// Returns the detours of a path, to the nearer side only or to both sides.
fn turned(problem: &Problem, seed: Candidate, nearer: bool) -> Vec<Candidate> {
    let mut cones = Vec::new();
    for constraint in &problem.constraints {
        let Rule::Pointing(pointing) = &constraint.rule else { continue };
        for (boresight, direction) in pointing.pairs() {
            cones.push(Cone {
                name: &constraint.name,
                pointing,
                half_angle: pointing.effective_half_angle(),
                boresight: *boresight,
                direction,
                seconds: problem.seconds(),
                frame_rate: problem.environment.frame_rate(),
            });
        }
    }
    if cones.is_empty() {
        return vec![seed];
    }
    // A crossing may be between two nodes.
    let steps = seed.steps();
    let grid = seed.grid.clone();
    let between = Interpolant::of(seed.states.iter().map(Point::pose).collect());
    let mut seeds = vec![path(&seed.provenance.start, &seed.grid, between.on(PARTS * steps).into_iter())];
    for cone in &cones {
        let mut next = Vec::new();
        for seed in seeds {
            match cone.pointing.side {
                Side::KeepOut => around(cone, seed, nearer, &mut next),
                Side::KeepIn | Side::On { .. } => next.push(into(cone, seed)),
            }
        }
        next.truncate(MOST);
        seeds = next;
    }
    let at_nodes = |seed: Candidate| {
        let poses = seed.states.iter().step_by(PARTS).map(Point::pose);
        path(&seed.provenance.start, &grid, poses)
    };
    seeds.into_iter().map(at_nodes).collect()
}

impl Cone<'_> {
    /// Returns the boresight and the cone at a fraction of the path, in reference axes.
    fn seen(&self, part: f64, pose: &Pose) -> Seen {
        let time = part * self.seconds;
        Seen {
            boresight: pose.attitude * self.boresight,
            direction: self.direction.at(time, &self.frame_rate),
            half_angle: self.half_angle + self.direction.angular_radius(time),
            acts: self.pointing.during.contains(time),
        }
    }
}

/// Adds both detours around a keep-out cone, or the path itself if it does not enter the cone.
fn around(cone: &Cone, seed: Candidate, nearer: bool, out: &mut Vec<Candidate>) {
    let last = seed.states.len() - 1;
    let poses: Vec<Pose> = seed.states.iter().map(Point::pose).collect();
    let part = |index: usize| index as f64 / last as f64;
    let seen: Vec<Seen> =
        poses.iter().enumerate().map(|(index, pose)| cone.seen(part(index), pose)).collect();
    let angles: Vec<f64> = seen.iter().map(|seen| angle_between(&seen.boresight, &seen.direction)).collect();
    let inside = |index: &usize| seen[*index].acts && angles[*index] < seen[*index].half_angle;
    let (Some(first), Some(final_)) = ((0..=last).find(inside), (0..=last).rev().find(inside)) else {
        out.push(seed);
        return;
    };
    let beyond = |index: usize| angles[index] - seen[index].half_angle;
    let nearest = (first..=final_).min_by(|a, b| beyond(*a).total_cmp(&beyond(*b))).unwrap_or(first);
    let Seen { boresight: p, direction: w, half_angle, .. } = &seen[nearest];
    let motion = seen[(nearest + 1).min(last)].boresight - seen[nearest.saturating_sub(1)].boresight;
    let along = motion - p * p.dot(&motion);
    // A boresight at rest does not define a sideways direction, so any direction is used.
    let along = along.try_normalize(1e-9).unwrap_or_else(|| p.cross(&other(p)).normalize());
    let sideways = p.cross(&along);
    let lateral = sideways.dot(w).clamp(-1.0, 1.0).asin();
    // The rotation fades out over twice the crossing, within the ends of the path.
    let reach = 0.75 * (final_ - first + 2 * PARTS) as f64;
    let centre = 0.5 * (first + final_) as f64;
    let (low, high) = ((centre - 2.0 * reach).max(0.0), (centre + 2.0 * reach).min(last as f64));
    let near = if lateral > 0.0 { -1.0 } else { 1.0 };
    for side in [1.0, -1.0].into_iter().filter(|side| !nearer || *side == near) {
        let shift = lateral + side * (half_angle + CLEARANCE);
        let turned = poses.iter().enumerate().map(|(index, pose)| {
            let at = index as f64;
            let fade = if at <= centre {
                (at - low) / (centre - low).max(1.0)
            } else {
                (high - at) / (high - centre).max(1.0)
            };
            let weight = (fade.clamp(0.0, 1.0) * std::f64::consts::FRAC_PI_2).sin().powi(2);
            let turn = lie::exp(&(along * (-shift * weight)));
            Pose { position: pose.position, attitude: turn * pose.attitude }
        });
        let way = if side > 0.0 { "left" } else { "right" };
        let name = format!("{}, {way} of {}", seed.provenance.start, cone.name);
        out.push(path(&name, &seed.grid, turned));
    }
}

/// Returns a vector that is not parallel to `p`.
fn other(p: &Vector3) -> Vector3 {
    if p.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() }
}

/// Returns the path pulled into a keep-in cone, or onto a cone.
fn into(cone: &Cone, seed: Candidate) -> Candidate {
    let last = seed.states.len() - 1;
    let poses = seed.states.iter().map(Point::pose).enumerate().map(|(index, pose)| {
        let Seen { boresight: p, direction: w, half_angle, acts } =
            cone.seen(index as f64 / last as f64, &pose);
        let axis = p.cross(&w);
        let (surface, off) = match cone.pointing.side {
            Side::On { .. } => (half_angle, true),
            _ => (half_angle - CLEARANCE.min(0.1 * half_angle), false),
        };
        let excess = angle_between(&p, &w) - surface;
        let inner = index > 0 && index < last;
        match axis.try_normalize(1e-12) {
            Some(axis) if acts && (off || excess > 0.0) && inner => {
                Pose { position: pose.position, attitude: lie::exp(&(axis * excess)) * pose.attitude }
            }
            _ => pose,
        }
    });
    path(&seed.provenance.start, &seed.grid, poses)
}
