//! Plans passes over a ground station: from nadir to a station in view, which the boresight then
//! follows at its rate.
//!
//! `cargo run --release -p evidence -- passes [COUNT [FIRST]]`: COUNT (100 by default) random
//! passes, beginning with index FIRST (0). Each is planned with minimum effort in a given duration,
//! and in minimum time, on 100 steps. The law, with random numbers of `Random::of_case(43, index)`
//! in this order: circular orbits about a point mass, with the altitude uniform in 450 … 900 km,
//! node and argument of latitude uniform, and the cosine of the inclination uniform in −1 … 1, from
//! 2026-11-21T07:00 UTC. The body has moments in a ratio of up to 10 and of mean 100 kg·m², about
//! random axes. The duration is uniform in 60 … 150 s. The station is at 0 m on a sphere, in any
//! azimuth; its distance from the point below the satellite at the end of the duration is uniform,
//! up to the distance at which the satellite is 20° above its horizon. At the start, z points to
//! nadir and x along the track, and the body turns with the orbit. At the end, z points at the
//! station, and the roll is free. For minimum time, the limit of each torque about the body axes is
//! the one with which the largest moment turns by 90° from rest to rest in 40 s.
//!
//! The command prints how many passes are solved, the pointing error at the end relative to a model
//! of the sky that the planner does not use (full theories without fits, rates by differences), and
//! the time of a plan. It ends with 1 if a plan is not solved, or has a pointing error of more than
//! 1″.

use evidence::words::Words;
use evidence::{Random, median};
use slewkit::maneuver::Aim;
use slewkit::maneuver::constraint::angle_between;
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit::{
    Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits, Matrix3, Problem, Settings, State, Vector3, lie,
};
use slewkit_sky::{Clock, EARTH_RADIUS_M, EarthRotation, Elements, Model, Orbit, Sky, Target, earth_to_gcrs};
use std::error::Error;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::time::Instant;

/// The smallest elevation of the satellite above the horizon of the station, on a sphere \[deg\].
const LOWEST: f64 = 20.0;
/// The time for which targets are computed \[s\].
const AHEAD: f64 = 600.0;
/// The number of steps of a plan.
const STEPS: usize = 100;
/// The largest accepted pointing error \[″\].
const NEAR: f64 = 1.0;

/// A satellite, its station, and a body.
struct Pass {
    sky: Sky,
    station: Target,
    body: Body,
    duration: f64,
    torque: f64,
}

impl Pass {
    fn of_case(index: usize) -> Result<Self, Box<dyn Error>> {
        let mut random = Random::of_case(43, index);
        let altitude = random.within(450e3, 900e3);
        let mut circle = || random.within(0.0, 360.0);
        let (raan_deg, true_anomaly_deg) = (circle(), circle());
        let elements = Elements {
            semi_major_axis_m: EARTH_RADIUS_M + altitude,
            eccentricity: 0.0,
            inclination_deg: random.uniform().acos().to_degrees(),
            raan_deg,
            argument_of_perigee_deg: 0.0,
            true_anomaly_deg,
        };
        let clock = Clock::of_utc([2026, 11, 21], 7, 0, 0, 0).ok_or("no such moment")?;
        let orbit = Orbit::of_elements(&elements, Model::TwoBody, clock, clock)?;
        let moments = random.mean_moments(10.0) * 100.0;
        let inertia: Inertia = random.about_any_axes(&moments);
        let duration = random.within(60.0, 150.0);
        let rotation = EarthRotation::default();
        let below = earth_to_gcrs(&clock, duration, &rotation).tr_mul(&orbit.position(duration)?);
        // If the satellite has the elevation e at the station, the angle between both at the centre
        // of the Earth is acos(R/r cos e) − e.
        let least = LOWEST.to_radians();
        let farthest = (EARTH_RADIUS_M / below.norm() * least.cos()).acos() - least;
        let (apart, azimuth) = (farthest * random.unit(), random.within(0.0, TAU));
        let up = below.normalize();
        let east = Vector3::z().cross(&up).normalize();
        let aside = east * azimuth.sin() + up.cross(&east) * azimuth.cos();
        let there = up * apart.cos() + aside * apart.sin();
        let station = Target::Ground {
            latitude_deg: there.z.clamp(-1.0, 1.0).asin().to_degrees(),
            longitude_deg: there.y.atan2(there.x).to_degrees(),
            height_m: 0.0,
        };
        // A quarter turn from rest to rest in 40 s: θ = u T² / 4 J.
        let torque = 4.0 * FRAC_PI_2 * moments.max() / 40.0_f64.powi(2);
        let body = Body { inertia, mass: None };
        Ok(Self { sky: Sky::new(clock, Some(orbit), rotation), station, body, duration, torque })
    }

    /// Returns the minimum-effort maneuver in the given duration, and the minimum-time maneuver.
    fn maneuvers(&self) -> Result<[Problem; 2], Box<dyn Error>> {
        let direction = |target: &Target| self.sky.direction(target, 0.0, AHEAD);
        let nadir = Aim::new(Vector3::z(), direction(&Target::Nadir)?);
        let start = nadir.with_roll_towards(Vector3::x(), direction(&Target::AlongTrack)?, 0.0);
        let ends = start.ends(0.0, &Matrix3::identity(), &Vector3::zeros())?;
        let (attitude, rate) = ends.at(0.0);
        let start = State::attitude(attitude, rate);
        let aim = Aim::new(Vector3::z(), direction(&self.station)?);
        let limits = Limits { size: Some(vec![self.torque; 3]), ..Limits::default() };
        let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits)?;
        let effort = Problem::attitude(self.body.clone(), start, start, self.duration);
        let time = Problem::minimum_time(self.body.clone(), start, start)
            .with_actuation(Actuation::torques(torques));
        Ok([effort, time].map(|problem| problem.with_aim_at_end(aim.clone()).with_steps(STEPS)))
    }

    /// Returns the angle between boresight and station \[rad\], and the difference of their
    /// transverse rates [rad/s].
    fn off(&self, found: &Plan) -> Result<[f64; 2], Box<dyn Error>> {
        const H: f64 = 0.5;
        let rows = &found.solution.trajectory;
        let time = *rows.time.last().ok_or("no end")?;
        let attitude = lie::rotation_from_quaternion(rows.quaternion.last().ok_or("no end")?);
        let rate = attitude * rows.angular_velocity.last().ok_or("no end")?;
        let boresight = attitude * Vector3::z();
        let seen = |time: f64| self.sky.seen(&self.station, time);
        let near = seen(time + H)? - seen(time - H)?;
        let far = seen(time + 2.0 * H)? - seen(time - 2.0 * H)?;
        let moves = (near * 8.0 - far) / (12.0 * H);
        Ok([angle_between(&boresight, &seen(time)?), (rate.cross(&boresight) - moves).norm()])
    }
}

/// Describes the checks of the witnesses that fail, each with its value and its limit.
fn failed(found: &Plan) -> String {
    let checks = found.verification.iter().flat_map(|verification| &verification.checks);
    let failed = checks.filter(|check| !check.passed);
    failed.map(|check| format!("; {} {:.1e}, at most {:.1e}", check.name, check.value, check.limit)).collect()
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count: usize = words.number("number of passes", 100)?;
    let first = words.number("number of the first pass", 0)?;
    words.end()?;
    let mut bad = false;
    let mut found: [Vec<[f64; 4]>; 2] = Default::default();
    for index in first..first + count {
        let pass = Pass::of_case(index)?;
        for (kind, problem) in pass.maneuvers()?.iter().enumerate() {
            let began = Instant::now();
            let planned = plan(problem, &Settings::default(), None, &mut Silent)?;
            let took = began.elapsed().as_secs_f64();
            if planned.status != Status::Solved {
                println!("  pass {index}, {}: {}{}", KINDS[kind], planned.status.name(), failed(&planned));
                continue;
            }
            let [angle, rate] = pass.off(&planned)?;
            let duration = planned.solution.trajectory.time.last().copied().unwrap_or(f64::NAN);
            found[kind].push([angle.to_degrees() * 3600.0, rate.to_degrees(), took, duration]);
        }
    }
    for (kind, found) in KINDS.iter().zip(&found) {
        let column = |column: usize| found.iter().map(|row| row[column]).collect::<Vec<f64>>();
        let most = |values: Vec<f64>| values.into_iter().fold(0.0, f64::max);
        println!(
            "{kind:<12} {} of {count} solved; off the station by {:.3}″ at most, {:.3}″ in the median; its \
                rate by {:.1e} deg/s at most; median {:.3} s a plan, {:.1} s a maneuver",
            found.len(),
            most(column(0)),
            median(&mut column(0)),
            most(column(1)),
            median(&mut column(2)),
            median(&mut column(3)),
        );
        bad |= found.len() < count || most(column(0)) > NEAR;
    }
    if bad { Err("see above".into()) } else { Ok(()) }
}

const KINDS: [&str; 2] = ["least effort", "least time"];
