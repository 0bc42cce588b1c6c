//! Compares gains, covariances and chances with simulated flights of the true motion.
//!
//! `cargo run --release -p evidence -- flies [COUNT [CASES]]`: COUNT (20 by default) random
//! maneuvers, CASES (20 000) flights each.
//!
//! The law: the bodies have moments in a ratio of up to 5 about random axes. Attitudes are uniform
//! on SO(3), and minimum-effort slews go from rest to rest in 60 s, on the default number of steps
//! and with neighbouring gains. Without the cone, the slew would carry one body axis 4° into it.
//! The errors are 0.3° and 0.005 deg/s at the start, 2 % of the moments of inertia and of the scale
//! of the torques, an actuator misalignment of 0.3°, and a sensor misalignment of 0.02° with a
//! noise of 0.003° and 1e-4 deg/s.
//!
//! It prints these figures:
//! - For a chance of 1e-2 at the worst instant of the cone: the proportion of flights inside the
//!   cone at that instant.
//! - For a fifth of the maneuvers, the same proportions for limits on each torque and on each
//!   component of the rate, and for a joint chance of 5e-2 at any time. These limits are a part of
//!   the peaks of the free slew.
//! - The ratio of sampled deviations to those of linear theory.
//! - The time of gains, covariances and a flight, compared with the time of the plan.
//! - A table of terminal deviations in open and closed loop for a published CubeSat, with an error
//!   of 2 % in its inertia: for its minimum-time slew and for a minimum-effort slew.

use evidence::Random;
use evidence::words::Words;
use slewkit::assured::{self, Beside, Kept, Over};
use slewkit::closed_loop::{Campaign, Flown, Moment, Plant, Proportion, Sampled};
use slewkit::feedback::{Gains, Kind};
use slewkit::maneuver::constraint::angle_between;
use slewkit::maneuver::{Rule, Side};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Limits};
use slewkit::optimize::discrete::linear_plan::{LinearPlan, Matrix6, Parameter, Vector6};
use slewkit::plan::{Silent, Status, plan};
use slewkit::uncertainty::chance::{Chance, Worst};
use slewkit::uncertainty::{Covariance, Uncertainty};
use slewkit::{
    Body, Constraint, Direction, Inertia, Matrix3, Pointing, Problem, Settings, State, Vector3, lie,
};
use std::error::Error;
use std::time::Instant;

const NEIGHBOURING: Kind = Kind::Neighbouring { freeze: Kind::FREEZE };
/// The requested chance.
const ASKED: f64 = 1e-2;
/// The factor by which the proportion of flights may differ from the requested chance.
const FACTOR: f64 = 1.5;

fn unit(axis: usize) -> Vector3 {
    Vector3::from_fn(|row, _| f64::from(u8::from(row == axis)))
}

/// Returns the covariance of attitude \[deg\] and rate [deg/s].
fn variances(attitude: f64, rate: f64) -> Matrix6 {
    let [attitude, rate] = [attitude, rate].map(|sigma| sigma.to_radians().powi(2));
    Matrix6::from_diagonal(&Vector6::new(attitude, attitude, attitude, rate, rate, rate))
}

/// Returns the three uncertain moments of inertia, with a relative standard deviation of `part`.
fn moments(problem: &Problem, part: f64) -> Vec<(String, Parameter, f64)> {
    let of = |axis: usize| {
        let delta = unit(axis) * unit(axis).transpose();
        let sigma = part * problem.body.inertia.j()[(axis, axis)];
        (format!("moment {axis}"), Parameter::Inertia(delta), sigma)
    };
    (0..3).map(of).collect()
}

fn uncertainty(problem: &Problem) -> Uncertainty {
    let mut parameters = moments(problem, 0.02);
    for axis in 0..3 {
        parameters.push((format!("scale {axis}"), Parameter::InputScale(axis), 0.02));
        parameters.push((format!("turn {axis}"), Parameter::ActuatorTurn(unit(axis)), 0.3_f64.to_radians()));
        parameters.push((format!("sensor {axis}"), Parameter::SensorTurn(unit(axis)), 0.02_f64.to_radians()));
    }
    Uncertainty {
        start: variances(0.3, 0.005),
        parameters,
        torque_noise: Matrix3::zeros(),
        sensor_noise: variances(0.003, 1e-4),
    }
}

fn maneuver(random: &mut Random) -> Problem {
    let moments = random.moments(5.0) * 100.0;
    let body = Body { inertia: random.about_any_axes(&moments), mass: None };
    let (start, end) = (random.uniform_rotation(), random.uniform_rotation());
    Problem::attitude(body, State::at_rest(start), State::at_rest(end), 60.0)
}

/// Returns the maneuver with a cone that the free slew enters by 4° in its middle; `None` if an end
/// would be within 8° of the cone.
fn past_a_cone(problem: Problem) -> Result<Option<Problem>, Box<dyn Error>> {
    let free = plan(&problem, &Settings::default(), None, &mut Silent)?;
    let path = &free.solution.trajectory;
    let attitude = |node: usize| lie::rotation_from_quaternion(&path.quaternion[node]);
    let last = path.quaternion.len() - 1;
    let boresight = Vector3::x();
    let seen = |node: usize| attitude(node) * boresight;
    let aside = seen(0).cross(&seen(last));
    if aside.norm() < 0.1 {
        return Ok(None);
    }
    let half_angle = 15.0_f64.to_radians();
    let off = 11.0_f64.to_radians();
    let middle = seen(last / 2);
    let across = (aside - middle * aside.dot(&middle)).normalize();
    let direction = lie::exp(&(middle.cross(&across) * off)) * middle;
    let clear = [0, last]
        .iter()
        .all(|node| angle_between(&seen(*node), &direction) > half_angle + 8.0_f64.to_radians());
    let cone = Pointing::new(Side::KeepOut, vec![boresight], vec![Direction::Fixed(direction)], half_angle);
    let constraint = Constraint { name: "cone".into(), rule: Rule::Pointing(cone) };
    Ok(clear.then(|| problem.with_constraint(constraint)))
}

/// Simulates flights. Returns the terminal deviations of all cases, and the proportion of cases
/// inside the cone at the node `node`.
fn flown(
    campaign: &Campaign<'_>,
    problem: &Problem,
    node: usize,
    cases: usize,
) -> (Vec<Vector6>, Proportion) {
    /// The number of cases whose steps are in memory at once.
    const CHUNK: usize = 8192;
    let Rule::Pointing(cone) = &problem.constraints[0].rule else { unreachable!("a cone") };
    let direction = cone.directions[0].at(0.0, &Vector3::zeros());
    let told = |flown: Flown, moments: Vec<Moment>| {
        let off = angle_between(&(moments[node].attitude * cone.boresights[0]), &direction);
        (flown.end, off < cone.half_angle)
    };
    let (mut ends, mut within) = (Vec::with_capacity(cases), 0);
    for first in (0..cases).step_by(CHUNK) {
        for (end, is_within) in
            campaign.trace_all(first as u64, CHUNK.min(cases - first), told).into_iter().flatten()
        {
            ends.push(end);
            within += u64::from(is_within);
        }
    }
    let count = ends.len() as u64;
    (ends, Proportion::new(within, count))
}

fn chances(count: usize, cases: usize) -> Result<bool, Box<dyn Error>> {
    let (mut index, mut kept, mut near, mut done) = (0, 0, 0, 0);
    let mut factors = Vec::new();
    let (mut ratios, mut spent): (Vec<f64>, [f64; 4]) = (Vec::new(), [0.0; 4]);
    while done < count {
        let mut random = Random::of_case(57, index);
        index += 1;
        let Some(problem) = past_a_cone(maneuver(&mut random))? else { continue };
        let uncertainty = uncertainty(&problem);
        let asked = [Kept { limits: vec!["cone"], at_most: ASKED, over: Over::Instant }];
        let settings = Settings::default();
        let found =
            assured::plan(&problem, &settings, Some(NEIGHBOURING.into()), &uncertainty, &asked, &mut Silent);
        let Ok((with, found, margins)) = found else { continue };
        if found.status != Status::Solved || !margins.agreed {
            continue;
        }
        done += 1;
        let problem = found.solution.on_grid(&with);
        let trajectory = &found.solution.trajectory;
        spent[0] += found.solution.solve_time;
        let began = Instant::now();
        let linear = LinearPlan::flown(&problem, trajectory)?;
        let gains = Gains::along(&linear, NEIGHBOURING, false)?;
        spent[1] += began.elapsed().as_secs_f64();
        let began = Instant::now();
        let covariance = Covariance::along(&linear, Some(&gains), &uncertainty);
        spent[2] += began.elapsed().as_secs_f64();
        let beside = Beside::along(&problem, trajectory, Some(NEIGHBOURING.into()), Some(&uncertainty))?;
        let campaign = Campaign::new(&problem, &linear, Some(&gains), &uncertainty, Plant::default(), 3);
        let began = Instant::now();
        let (ends, flown) = flown(&campaign, &problem, beside.chances[0].worst().node, cases);
        spent[3] += began.elapsed().as_secs_f64() / cases as f64 / linear.count() as f64;
        let sampled = Sampled::of(&ends, &covariance.end);
        ratios.extend(sampled.sigma().component_div(&covariance.end_sigma()).iter());
        factors.push(flown.part() / beside.chances[0].largest());
        kept += usize::from(flown.high <= FACTOR * ASKED);
        near += usize::from(flown.part() >= ASKED / FACTOR && flown.part() <= FACTOR * ASKED);
    }
    factors.sort_by(f64::total_cmp);
    ratios.sort_by(f64::total_cmp);
    println!(
        "chance of {ASKED}: kept by {kept} of {count}, to {FACTOR} times it by the upper 95 % bound, and to \
            a factor of {FACTOR} met by {near}; flown over linear {:.2} to {:.2}, median {:.2}",
        factors[0],
        factors[count - 1],
        factors[count / 2]
    );
    println!(
        "deviations flown over linear: {:.3} to {:.3}, {} numbers",
        ratios[0],
        ratios[ratios.len() - 1],
        ratios.len()
    );
    println!(
        "gains {:.2} and covariance {:.2} of the solve; {:.2} us a step flown",
        spent[1] / spent[0],
        spent[2] / spent[0],
        1e6 * spent[3] / count as f64
    );
    Ok(kept == count)
}

/// Returns the maneuver with limits that equal the largest torques or rates of the free slew, so
/// that a reserve makes them active.
fn within_limits(problem: Problem, of_rates: bool) -> Result<Problem, Box<dyn Error>> {
    let free = plan(&problem, &Settings::default(), None, &mut Silent)?.solution.trajectory;
    let most = |of: &dyn Fn(usize) -> f64| (0..free.torque.len()).map(of).fold(0.0, f64::max);
    if of_rates {
        let rates = Vector3::from_fn(|axis, _| most(&|k| free.angular_velocity[k][axis].abs()));
        let constraint = Constraint { name: LIMITS[1].into(), rule: Rule::RateAxes(rates) };
        return Ok(problem.with_constraint(constraint));
    }
    let sizes: Vec<f64> = (0..3).map(|input| most(&|k| free.inputs(k)[input].abs())).collect();
    let limits = Limits { size: Some(sizes), ..Limits::default() };
    let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits)?;
    Ok(problem.with_actuation(Actuation::torques(torques)))
}

/// The names of the torque limit and of the rate limit.
const LIMITS: [&str; 2] = ["torque limit", "rates"];

/// Returns for each input or component of each limit whether a flight exceeds the limit at its
/// worst instant.
fn exceeded(craft: &Problem, beside: &Beside, moments: &[Moment]) -> Vec<bool> {
    let rates = craft.constraints.first().map(|constraint| &constraint.rule);
    let sizes = craft.actuation.torque.limits().size.as_deref();
    let of = |chance: &Chance| -> Vec<bool> {
        let part = |(part, worst): (usize, &Worst)| match (rates, sizes) {
            (Some(Rule::RateAxes(rates)), _) => {
                moments[worst.node].angular_velocity[part].abs() > rates[part]
            }
            (_, Some(sizes)) => moments[worst.node].commanded[part].abs() > sizes[part],
            _ => false,
        };
        chance.parts.iter().enumerate().map(part).collect()
    };
    beside.chances.iter().flat_map(of).collect()
}

/// Compares the chances of limits with flights: the chance of each limit at its worst instant, and
/// the joint chance of all limits over the motion. Returns whether they agree.
fn limits(count: usize, cases: usize) -> Result<bool, Box<dyn Error>> {
    /// The requested joint chance of all limits.
    const SHARED: f64 = 5e-2;
    /// The largest difference between an active margin and the required one, relative to the
    /// standard deviation.
    const ACTS: f64 = 0.02;
    let (mut index, mut done, mut parts, mut kept, mut refused) = (0, 0, 0, 0, 0);
    let (mut factors, mut shared, mut dearer) = (Vec::new(), Vec::new(), Vec::new());
    let kind = Some(Kind::Tvlqr(None).into());
    while done < count && index < 20 * count {
        let mut random = Random::of_case(59, index);
        index += 1;
        let of_rates = index % 2 == 0;
        let problem = within_limits(maneuver(&mut random), of_rates)?;
        let uncertainty = uncertainty(&problem);
        let keep = |at_most: f64, over: Over| {
            let asked = [Kept { limits: vec![LIMITS[usize::from(of_rates)]], at_most, over }];
            let found =
                assured::plan(&problem, &Settings::default(), kind, &uncertainty, &asked, &mut Silent);
            found.ok().filter(|(_, found, margins)| found.status == Status::Solved && margins.agreed)
        };
        let instant = keep(ASKED, Over::Instant);
        let motion = keep(SHARED, Over::Motion(Plant::default()));
        let (Some((with, found, margins)), Some(motion)) = (instant, motion) else {
            refused += 1;
            continue;
        };
        done += 1;
        dearer.push(found.solution.cost / margins.cost_without - 1.0);
        let on_grid = found.solution.on_grid(&with);
        let beside = Beside::along(&on_grid, &found.solution.trajectory, kind, Some(&uncertainty))?;
        // The authority is so large that no command saturates, so that the commands show what the
        // gains request.
        let plant = Plant { authority: 1e3, ..Plant::default() };
        let campaign = Campaign::new(&on_grid, &beside.linear, beside.gains.as_ref(), &uncertainty, plant, 3);
        let told = |_, moments: Vec<Moment>| exceeded(&problem, &beside, &moments);
        let flown: Vec<Vec<bool>> = campaign.trace_all(0, cases, told).into_iter().flatten().collect();
        let worst = beside.chances.iter().flat_map(|chance| &chance.parts);
        for (part, worst) in worst.enumerate().filter(|(_, worst)| worst.chance > (1.0 - ACTS) * ASKED) {
            let beyond = flown.iter().filter(|exceeded| exceeded[part]).count();
            let found = Proportion::new(beyond as u64, flown.len() as u64);
            parts += 1;
            kept += usize::from(found.high <= FACTOR * ASKED);
            factors.push(found.part() / worst.chance);
        }
        let (with, found, _) = motion;
        let on_grid = found.solution.on_grid(&with);
        let beside = Beside::along(&on_grid, &found.solution.trajectory, kind, Some(&uncertainty))?;
        let gains = beside.gains.as_ref();
        let campaign = Campaign::new(&on_grid, &beside.linear, gains, &uncertainty, Plant::default(), 3);
        let flown: Vec<Flown> = campaign.fly_all(0, cases).into_iter().flatten().collect();
        let any = |flown: &&Flown| flown.room.iter().chain(&flown.input_room).any(|room| *room < 0.0);
        shared.push(flown.iter().filter(any).count() as f64 / flown.len() as f64 / SHARED);
    }
    for of in [&mut factors, &mut shared, &mut dearer] {
        of.sort_by(f64::total_cmp);
    }
    let told = |of: &[f64]| match of {
        [] => "none".into(),
        of => format!("{:.3} to {:.3}, median {:.3}", of[0], of[of.len() - 1], of[of.len() / 2]),
    };
    println!(
        "limits of torque and rate of {done} maneuvers, {refused} refused: {parts} inputs and components \
            act; chance of {ASKED} kept by {kept} of them, to {FACTOR} times it by the upper 95 % bound; \
            flown over linear {}; cost beyond that without {}",
        told(&factors),
        told(&dearer)
    );
    println!("one chance of {SHARED} of all over the motion: flown over asked {}", told(&shared));
    Ok(kept == parts && done == count)
}

/// Prints the median time of gains, covariances and the plan, over 200 random slews without limits.
fn speed() -> Result<(), Box<dyn Error>> {
    let mut times: [Vec<f64>; 3] = Default::default();
    for index in 0..200 {
        let problem = maneuver(&mut Random::of_case(58, index));
        let found = plan(&problem, &Settings::default(), None, &mut Silent)?;
        let problem = found.solution.on_grid(&problem);
        let uncertainty = uncertainty(&problem);
        let linear = LinearPlan::flown(&problem, &found.solution.trajectory)?;
        let began = Instant::now();
        let gains = Gains::along(&linear, NEIGHBOURING, false)?;
        times[1].push(began.elapsed().as_secs_f64());
        let began = Instant::now();
        std::hint::black_box(Covariance::along(&linear, Some(&gains), &uncertainty));
        times[2].push(began.elapsed().as_secs_f64());
        times[0].push(found.solution.solve_time);
    }
    let [solve, gains, covariance] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        1e3 * times[times.len() / 2]
    });
    println!(
        "free slews: solve {solve:.2} ms, gains {gains:.2} ms, covariance with 12 parameters {covariance:.2} ms"
    );
    Ok(())
}

/// Simulates flights of a published CubeSat (Miller, Akella: inertia, MRP, torque norm), for the
/// minimum-time plan with nine tenths of its torque and for a minimum-effort plan.
fn cubesats() -> Result<(), Box<dyn Error>> {
    println!(
        "2 % of error in each moment of the inertia, 2000 flights: deviation of the attitude about its worst \
            axis at the end, deg"
    );
    println!("{:<34} {:>10} {:>10} {:>10}", "", "open loop", "gains", "linear");
    let first = Matrix3::new(0.0145, 0.0, -0.0015, 0.0, 0.022, 0.0, -0.0015, 0.0, 0.0142);
    let second = Matrix3::from_diagonal(&Vector3::new(0.0416, 0.0083, 0.0416));
    for (name, j, sigma, rate) in [
        ("2U+1U CubeSat, 30 deg", first, 0.076, Vector3::zeros()),
        ("3U CubeSat, 90 deg, from a rate", second, 0.2391, Vector3::new(-0.05, 0.05, -0.05)),
    ] {
        let body = Body { inertia: Inertia::new(j)?, mass: None };
        let mrp = Vector3::repeat(sigma);
        let turn = mrp.normalize() * (4.0 * mrp.norm().atan());
        let start = State::attitude(lie::exp(&turn), rate);
        let limits = Limits { norm: Some(0.9 * 0.0032), ..Limits::default() };
        let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits)?;
        let end = State::at_rest(Matrix3::identity());
        let fastest = Problem::minimum_time(body.clone(), start, end)
            .with_actuation(Actuation::torques(torques.clone()));
        let found = plan(&fastest, &Settings::default(), None, &mut Silent)?;
        let duration = 1.5 * found.solution.duration(&fastest);
        let gentle =
            Problem::attitude(body, start, end, duration).with_actuation(Actuation::torques(torques));
        for (how, problem, kind) in [
            ("least time", fastest, Kind::Tvlqr(None)),
            ("least effort in 1.5 times that", gentle, NEIGHBOURING),
        ] {
            let found = plan(&problem, &Settings::default(), None, &mut Silent)?;
            let problem = found.solution.on_grid(&problem);
            let parameters = moments(&problem, 0.02);
            let sensor_noise = variances(0.003, 1e-4);
            let uncertainty = Uncertainty { parameters, sensor_noise, ..Uncertainty::default() };
            let beside =
                Beside::along(&problem, &found.solution.trajectory, Some(kind.into()), Some(&uncertainty))?;
            let plant = Plant { authority: 1.0 / 0.9, ..Plant::default() };
            let worst = |sigma: Vector6| sigma.fixed_rows::<3>(0).amax().to_degrees();
            let flown = |gains: Option<&Gains>, linear: &Covariance| {
                let campaign = Campaign::new(&problem, &beside.linear, gains, &uncertainty, plant, 3);
                let ends: Vec<Vector6> =
                    campaign.fly_all(0, 2000).into_iter().flatten().map(|flown| flown.end).collect();
                worst(Sampled::of(&ends, &linear.end).sigma())
            };
            let (Some(open), Some(closed)) = (&beside.open, &beside.closed) else { continue };
            println!(
                "{:<34} {:>10.3} {:>10.4} {:>10.4}",
                name,
                flown(None, open),
                flown(beside.gains.as_ref(), closed),
                worst(closed.end_sigma())
            );
            println!("  {how}");
        }
    }
    Ok(())
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let (count, cases) =
        (words.number("number of maneuvers", 20)?, words.number("number of flights", 20_000)?);
    words.end()?;
    let kept = chances(count, cases)? & limits(count.div_ceil(5), cases)?;
    speed()?;
    cubesats()?;
    if !kept {
        std::process::exit(1);
    }
    Ok(())
}
