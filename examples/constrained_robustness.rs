//! Random slews under a torque limit and keep-out cones on the unconstrained path: how many are solved?
//!
//! ```text
//! cargo run --release --example constrained_robustness [count] [folder for failures]
//! ```

use slewkit::actuation::{Actuation, AxisFrame, Channel, Limits};
use slewkit::body::{Body, Inertia};
use slewkit::constraint::{Constraint, Direction, Pointing, Rule, Side};
use slewkit::plan::{Silent, Status, plan};
use slewkit::problem::{Path, Problem, State};
use slewkit::settings::Settings;
use slewkit::{Matrix3, Vector3, lie};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count: u64 = std::env::args().nth(1).map_or(Ok(2000), |text| text.parse())?;
    let mut times = Vec::new();
    let mut work = (Vec::new(), Vec::new(), Vec::new());
    let mut share = 0.0;
    let mut tally = std::collections::BTreeMap::<&str, u64>::new();
    let only: Option<u64> = std::env::args().nth(2).and_then(|text| text.parse().ok());
    for seed in 0..count {
        if only.is_some_and(|only| only != seed) {
            continue;
        }
        let Some(problem) = case(seed) else { continue };
        let began = std::time::Instant::now();
        let plan = plan(&problem, &Settings::default(), None, &mut Silent)?;
        times.push(plan.solution.solve_time);
        if let Some(convex) = &plan.solution.convex {
            work.0.push(convex.subproblems);
            work.1.push(convex.all_subproblems);
            work.2.push(convex.cone_iterations as usize);
            share += convex.cone_seconds;
        }
        *tally.entry(plan.status.name()).or_default() += 1;
        if plan.status != Status::Solved || only.is_some() {
            let solution = &plan.solution;
            println!(
                "seed {seed}: {} {:?} terminal {:.1e} {} of {:.1} ms, {}",
                plan.status.name(),
                solution.outcome,
                solution.terminal.largest(),
                solution.start,
                1e3 * began.elapsed().as_secs_f64(),
                problem.name
            );
            for rung in solution.ladder.iter().filter(|rung| matches!(rung.rung.as_str(), "scp" | "polish")) {
                println!(
                    "     {} {} {} {:?} {} {:?}",
                    rung.rung,
                    rung.start,
                    rung.steps,
                    rung.outcome,
                    rung.iterations,
                    rung.residuals.last()
                );
            }
            if let Some(verification) = &plan.verification {
                for check in verification.checks.iter().filter(|check| !check.passed) {
                    println!("     {check:?}");
                }
            }
        }
    }
    for (name, list) in [
        ("subproblems of the winner", &mut work.0),
        ("of all seeds", &mut work.1),
        ("cone iterations", &mut work.2),
    ] {
        list.sort_unstable();
        if !list.is_empty() {
            println!(
                "{name}: median {}, 95 % {}, most {}",
                list[list.len() / 2],
                list[list.len() * 95 / 100],
                list[list.len() - 1]
            );
        }
    }
    times.sort_by(f64::total_cmp);
    let at = |share: f64| 1e3 * times[(share * (times.len() - 1) as f64) as usize];
    println!("{tally:?}");
    println!("inside the cone solver: {:.0} %", 100.0 * share / times.iter().sum::<f64>());
    println!("solve time: median {:.1} ms, 95 % {:.1} ms, worst {:.1} ms", at(0.5), at(0.95), at(1.0));
    Ok(())
}

/// The splitmix64 generator.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 * 2.0f64.powi(-53)
    }

    fn direction(&mut self) -> Vector3 {
        loop {
            let v = Vector3::from_fn(|_, _| 2.0 * self.unit() - 1.0);
            let size = v.norm();
            if size > 0.1 && size < 1.0 {
                return v / size;
            }
        }
    }
}

/// A random body, slew, limit and cones; `None` where the unconstrained slew was not found.
fn case(seed: u64) -> Option<Problem> {
    let mut random = Random(seed.wrapping_mul(0x1234_5677) + 99);
    let moments = loop {
        let m = Vector3::from_fn(|_, _| 0.3 + random.unit());
        if m.x + m.y > 1.05 * m.z && m.y + m.z > 1.05 * m.x && m.z + m.x > 1.05 * m.y {
            break m;
        }
    };
    let axes = lie::exp(&(random.direction() * 3.0));
    let j = axes * Matrix3::from_diagonal(&moments) * axes.transpose();
    let body = Body { inertia: Inertia::new(0.5 * (j + j.transpose())).ok()?, mass: None };
    let angle = 0.5 + 2.5 * random.unit();
    let start = lie::exp(&(random.direction() * (3.0 * random.unit())));
    let end = start * lie::exp(&(random.direction() * angle));
    let free = Problem::attitude(body, State::at_rest(start), State::at_rest(end), 1.0);
    let unconstrained =
        plan(&free.clone().with_path(Path::Shortest), &Settings::default(), None, &mut Silent).ok()?;
    let trajectory = &unconstrained.solution.trajectory;
    let peak = trajectory.torque.iter().map(|torque| torque.amax()).fold(0.0, f64::max);
    let share = 0.6 + 0.35 * random.unit();
    let axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
    let weight = nalgebra::DMatrix::identity(3, 3);
    let limits = Limits { size: Some(vec![share * peak; 3]), ..Limits::default() };
    let channel = Channel::new(axes, AxisFrame::Body, weight).ok()?.with_limits(limits).ok()?;
    let mut problem = free.with_actuation(Actuation::torques(channel));
    let cones = 1 + usize::from(random.unit() > 0.5);
    let mut text = format!("limit {share:.3}");
    for index in 0..cones {
        // A boresight, and a direction that it passes at a random moment of the unconstrained slew.
        for _ in 0..100 {
            let boresight = random.direction();
            let at = 0.25 + 0.5 * random.unit();
            let q = trajectory.quaternion[(at * (trajectory.quaternion.len() - 1) as f64) as usize];
            let half_angle = (3.0 + 9.0 * random.unit()).to_radians();
            // The path crosses the cone, as a rule off its axis.
            let aside = lie::exp(&(random.direction() * (half_angle * random.unit())));
            let direction = aside * lie::rotation_from_quaternion(&q) * boresight;
            let away =
                |r: &Matrix3| (r * boresight).dot(&direction).clamp(-1.0, 1.0).acos() > half_angle + 0.02;
            if away(&start) && away(&end) {
                text += &format!(", cone {:.1} deg at {at:.2}", half_angle.to_degrees());
                let pointing = Pointing {
                    side: Side::KeepOut,
                    boresights: vec![boresight],
                    directions: vec![Direction { vector: direction.normalize(), turns_with_frame: false }],
                    half_angle,
                    margin: 0.0,
                };
                problem = problem.with_constraint(Constraint {
                    name: format!("cone {index}"),
                    rule: Rule::Pointing(pointing),
                });
                break;
            }
        }
    }
    problem.name = text;
    Some(problem)
}
