//! Measures how much is saved by planning stops with a free roll together instead of one by one.
//!
//! `cargo run --release -p evidence -- dwells [COUNT]`: COUNT (100 by default) random sequences of
//! three stops at rest, at each of which a boresight points at a direction and the roll is free.
//! The bodies have moments in a ratio of up to 3 about random axes; boresights and directions are
//! uniform on the sphere. The plans minimise effort in 12 s on 100 steps for each leg, and the
//! division of the time among the legs is free. One by one, each leg ends at the roll that
//! minimises its own cost, with the best division of the time.
//!
//! The command prints the smallest and largest saving, its quartiles, and the time of a plan. It
//! ends with 1 if a case costs more when planned together.

use evidence::words::Words;
use evidence::{Random, median};
use slewkit::maneuver::{Aim, Outcome, Settings};
use slewkit::optimize::search::solve;
use slewkit::plan::Silent;
use slewkit::sequence::{Ordering, Place, Sequence, Stop};
use slewkit::{Body, Direction, Matrix3, Problem, State, lie};
use std::error::Error;
use std::time::Instant;

/// The duration of a sequence [s].
const TOTAL: f64 = 12.0;
/// The relative difference below which two costs count as equal.
const NEAR: f64 = 1e-6;

fn sequence(index: usize) -> Sequence {
    let mut random = Random::of_case(72, index);
    let body = Body { inertia: random.inertia(3.0), mass: None };
    let (start, boresight) = (State::at_rest(random.uniform_rotation()), random.direction());
    let craft = Problem::attitude(body, start, State::at_rest(Matrix3::identity()), TOTAL).with_steps(100);
    let stop = |index: usize| {
        let aim = Aim::new(boresight, Direction::Fixed(random.direction())).at_rest();
        Stop::at(&index.to_string(), Place::Aim(aim))
    };
    Sequence { craft, stops: (1..=3).map(stop).collect(), order: Ordering::Given }
}

/// Returns the total cost of legs that are planned one by one, with the best division of the time.
fn one_by_one(sequence: &Sequence) -> Result<f64, Box<dyn Error>> {
    let (mut from, mut roots) = (sequence.craft.start, 0.0);
    for stop in &sequence.stops {
        let Place::Aim(aim) = &stop.place else { return Err("a stop without a target".into()) };
        let leg = Problem { start: from, ..sequence.craft.clone() }.with_aim_at_end(aim.clone());
        let found = solve(&leg, &Settings::discrete(), None, &mut Silent)?;
        let last = found.trajectory.quaternion.last().filter(|_| found.outcome == Outcome::Converged);
        let last = last.ok_or("no plan of a leg")?;
        from = State::at_rest(lie::project_to_rotation(&lie::rotation_from_quaternion(last)));
        roots += (found.cost * TOTAL.powi(3)).powf(0.25);
    }
    Ok(roots.powi(4) / TOTAL.powi(3))
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    let count: usize = words.number("number of sequences", 100)?;
    words.end()?;
    let (mut dearer, mut saved, mut seconds) = (0, Vec::new(), Vec::new());
    for index in 0..count {
        let sequence = sequence(index);
        let began = Instant::now();
        let cost = sequence.plan(&Settings::discrete(), &mut Silent)?.cost;
        seconds.push(began.elapsed().as_secs_f64());
        let apart = one_by_one(&sequence)?;
        saved.push(1.0 - cost / apart);
        if cost > apart * (1.0 + NEAR) {
            println!("sequence {index}: {cost:.6} together, {apart:.6} one by one");
            dearer += 1;
        }
    }
    saved.sort_by(f64::total_cmp);
    println!("part of the cost that is saved, by quarters of {count} sequences:");
    for quarter in 0..=4_usize {
        let place = (quarter * (count - 1)) / 4;
        println!("{:5} %  {:8.3} %", 25 * quarter, 100.0 * saved[place]);
    }
    println!("dearer together: {dearer}; seconds of a plan, median: {:.2}", median(&mut seconds));
    if dearer > 0 { Err("see above".into()) } else { Ok(()) }
}
