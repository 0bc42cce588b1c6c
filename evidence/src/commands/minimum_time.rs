//! Plans a published set of minimum-time maneuvers: counts how many are solved and verified,
//! compares durations with the best published ones, and prints structures and computing times.
//!
//! `cargo run --release -p evidence -- minimum_time [COUNT [FILE]]`. A FILE has the columns of
//! `evidence/public_set/*.csv`. The inertia is diag(1, 2, 3) if the name of the file starts with
//! "asymmetric", and the identity otherwise.
//!
//! `cargo run --release -p evidence -- minimum_time plain [EVERY]`: the cases that users try first,
//! rest-to-rest turns of boxes about their axes by 60 to 180°, with equal and unequal limits. The
//! default plan is compared with the best plan of a thorough search, which plans the maneuver in
//! these body axes and in others.
//!
//! `cargo run --release -p evidence -- minimum_time random [COUNT [FIRST]]`: COUNT (2000 by
//! default) maneuvers of bodies whose principal moments are the sides of a random triangle with a
//! ratio of at most 10, about random axes. The limits are within a factor of 5, attitudes are
//! uniform, and rates at both ends are up to 1 in the unit of time. A plan counts only if it passed
//! the witnesses.

use evidence::Random;
use evidence::words::Words;
use slewkit::maneuver::{Problem, Settings, State, Structure, Thoroughness};
use slewkit::mechanics::{Actuation, ActuatorSet, AxisFrame, Body, Inertia, Limits};
use slewkit::plan::{Silent, Status, plan};
use slewkit::{Matrix3, Vector3, lie};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The rounding error of the published durations, which have three decimals.
const ROUNDING: f64 = 5e-4;

#[derive(Default)]
struct Tally {
    cases: usize,
    solved: usize,
    published: usize,
    longer: usize,
    shorter: usize,
    worst: f64,
    exact: usize,
    chattering: usize,
    singular: usize,
    /// The gaps of the plans with singular arcs [s].
    gaps: Vec<f64>,
    solve_ms: Vec<f64>,
    whole_ms: Vec<f64>,
}

pub fn run(words: &mut Words) -> Result<(), Box<dyn Error>> {
    if words.next_is("plain") {
        let every = words.number("number, of which every one is planned", 1)?;
        words.end()?;
        return plain(every);
    }
    if words.next_is("random") {
        let (count, first) =
            (words.number("number of cases", 2000)?, words.number("number of the first case", 0)?);
        words.end()?;
        return any(count, first);
    }
    let count = words.number("number of cases", usize::MAX)?;
    let folder = Path::new(evidence::ROOT).join("evidence/public_set");
    let shipped = ["rest.csv", "moving_ends.csv", "asymmetric.csv"].map(|name| folder.join(name));
    let files: Vec<PathBuf> = words.take().map_or(shipped.to_vec(), |file| vec![file.into()]);
    words.end()?;
    for file in files {
        let name = file.file_name().unwrap_or_default().to_string_lossy().to_string();
        let inertia = if name.starts_with("asymmetric") { [1.0, 2.0, 3.0] } else { [1.0; 3] };
        let mut tally = Tally::default();
        for (index, line) in std::fs::read_to_string(&file)?.lines().skip(1).take(count).enumerate() {
            case(index, line, inertia, &mut tally)
                .map_err(|error| format!("{name}, case {index}: {error}"))?;
        }
        report(&name, tally);
    }
    Ok(())
}

/// Returns the maneuver in a line of the published set.
pub(super) fn maneuver(line: &str, inertia: [f64; 3]) -> Result<Problem, Box<dyn Error>> {
    let cells = line.split(',');
    let numbers: Vec<f64> = cells.take(14).map(str::parse).collect::<Result<_, _>>()?;
    if numbers.len() < 14 {
        return Err(format!("{} numbers where 14 are needed", numbers.len()).into());
    }
    let [start, end] = [0, 7].map(|at| {
        let quaternion = [numbers[at], numbers[at + 1], numbers[at + 2], numbers[at + 3]];
        // The quaternion has six digits, so its matrix must be projected onto the rotations.
        let attitude = lie::project_to_rotation(&lie::rotation_from_quaternion(&quaternion));
        State::attitude(attitude, Vector3::from_row_slice(&numbers[at + 4..at + 7]))
    });
    let body = Body { inertia: Inertia::diagonal(inertia.into())?, mass: None };
    let limits = Limits { size: Some(vec![1.0; 3]), ..Limits::default() };
    let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits)?;
    Ok(Problem::minimum_time(body, start, end).with_actuation(Actuation::torques(torques)))
}

fn case(index: usize, line: &str, inertia: [f64; 3], tally: &mut Tally) -> Result<(), Box<dyn Error>> {
    let cells: Vec<&str> = line.split(',').collect();
    let problem = maneuver(line, inertia)?;
    let began = Instant::now();
    let plan = plan(&problem, &Settings::default(), None, &mut Silent)?;
    tally.whole_ms.push(began.elapsed().as_secs_f64() * 1e3);
    tally.solve_ms.push(plan.solution.solve_time * 1e3);
    tally.cases += 1;
    if plan.status != Status::Solved {
        println!("  case {index}: {}", plan.status.name());
        return Ok(());
    }
    tally.solved += 1;
    // A plan on a uniform grid has no arcs.
    let arcs = plan.solution.switching.as_ref();
    match arcs.map(|switching| switching.structure) {
        Some(Structure::BangBang) => tally.exact += 1,
        Some(Structure::TruncatedChattering) => tally.chattering += 1,
        _ => tally.singular += 1,
    }
    tally.gaps.extend(arcs.filter(|arcs| arcs.structure != Structure::BangBang).map(|arcs| arcs.gap));
    let duration = arcs.map_or(plan.solution.cost, |switching| switching.continuous_duration_s);
    if let Some(published) = cells.get(14).and_then(|cell| cell.parse::<f64>().ok()) {
        tally.published += 1;
        let excess = duration - published;
        tally.worst = tally.worst.max(excess - ROUNDING);
        if excess > ROUNDING {
            tally.longer += 1;
            println!("  case {index}: {duration:.6}, published {published}");
        }
        tally.shorter += usize::from(excess < -2.0 * ROUNDING);
    }
    Ok(())
}

fn report(name: &str, tally: Tally) {
    let share = |count: usize| 100.0 * count as f64 / tally.solved.max(1) as f64;
    println!("{name}: {} of {} solved and verified", tally.solved, tally.cases);
    println!(
        "  {} published: longer than that and its rounding {}, at most by {:.1e}; shorter by more than 1e-3 {}",
        tally.published, tally.longer, tally.worst, tally.shorter
    );
    println!(
        "  bang-bang {:.1} %, truncated chattering {:.1} %, singular {:.1} %",
        share(tally.exact),
        share(tally.chattering),
        share(tally.singular)
    );
    let [median, most, nearly_all, worst] = parts(tally.gaps);
    println!(
        "  gap of what is not bang-bang, to first order: median {median:.1e}, 90 % {most:.1e}, 99 % \
            {nearly_all:.1e}, largest {worst:.1e} s"
    );
    for (what, times) in [("solve", tally.solve_ms), ("with witnesses", tally.whole_ms)] {
        let [median, most, nearly_all, _] = parts(times);
        println!("  {what}: median {median:.1} ms, 90 % {most:.1} ms, 99 % {nearly_all:.1} ms");
    }
}

/// Plans all combinations of simple boxes, limits, axes and angles. `every` = n selects every n-th
/// combination.
fn plain(every: usize) -> Result<(), Box<dyn Error>> {
    const BODIES: [[f64; 3]; 5] =
        [[1.0, 1.0, 1.0], [1.0, 2.0, 2.5], [5.0, 5.0, 2.0], [120.0, 100.0, 80.0], [1.0, 1.6, 2.3]];
    const LIMITS: [[f64; 3]; 5] =
        [[1.0, 1.0, 1.0], [1.0, 0.5, 2.0], [1.0, 2.0, 4.0], [0.5, 0.5, 1.0], [1.0, 1.0, 3.0]];
    const AXES: [[f64; 3]; 5] =
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]];
    const DEGREES: [f64; 4] = [60.0, 90.0, 120.0, 180.0];
    let other = lie::exp(&Vector3::new(0.3, -0.5, 0.7));
    let of = |at: usize, axes: &Matrix3| -> Result<Problem, Box<dyn Error>> {
        let (inertia, at) = (BODIES[at % 5], at / 5);
        let (limits, at) = (LIMITS[at % 5], at / 5);
        let (axis, degrees) = (Vector3::from(AXES[at % 5]).normalize(), DEGREES[at / 5]);
        let turned = |attitude: Matrix3| State::at_rest(axes * attitude * axes.transpose());
        let inertia = axes * Matrix3::from_diagonal(&inertia.into()) * axes.transpose();
        let body = Body { inertia: Inertia::new(0.5 * (inertia + inertia.transpose()))?, mass: None };
        let limits = Limits { size: Some(limits.to_vec()), ..Limits::default() };
        let inputs = (0..3).map(|input| axes.column(input).into_owned()).collect();
        let torques = ActuatorSet::new(inputs, AxisFrame::Body)?.with_limits(limits)?;
        let end = turned(lie::exp(&(axis * degrees.to_radians())));
        let problem = Problem::minimum_time(body, State::at_rest(Matrix3::identity()), end);
        Ok(problem.with_actuation(Actuation::torques(torques)))
    };
    let thorough = Settings { search: Thoroughness::Thorough, ..Settings::default() };
    let mut excesses = Vec::new();
    let (mut solve_ms, mut unsolved, mut slower) = (Vec::new(), 0, 0);
    for at in (0..500).step_by(every) {
        let (problem, same) = (of(at, &Matrix3::identity())?, of(at, &other)?);
        let duration = |problem: &Problem, settings: &Settings| -> Result<_, Box<dyn Error>> {
            let plan = plan(problem, settings, None, &mut Silent)?;
            let solved = plan.status == Status::Solved;
            Ok((solved.then_some(plan.solution.switching).flatten(), plan.solution.solve_time))
        };
        let (found, seconds) = duration(&problem, &Settings::default())?;
        solve_ms.push(seconds * 1e3);
        let Some(found) = found else {
            println!("  case {at}: not solved");
            unsolved += 1;
            continue;
        };
        let time = found.continuous_duration_s;
        let others = [
            duration(&problem, &thorough)?.0,
            duration(&same, &thorough)?.0,
            duration(&same, &Settings::default())?.0,
        ];
        let best = others.iter().flatten().map(|other| other.continuous_duration_s).fold(time, f64::min);
        slower += usize::from(found.eigenaxis_s.is_some_and(|eigenaxis| time > eigenaxis * (1.0 + 1e-9)));
        let excess = time / best - 1.0;
        if excess > 1e-3 {
            println!("  case {at}: {time:.6} s, known {best:.6} s, {:.2} % longer", 100.0 * excess);
        }
        excesses.push(excess);
    }
    let above = |part: f64| excesses.iter().filter(|excess| **excess > part).count();
    println!(
        "plain: {} cases, {unsolved} not solved, slower than about a fixed axis {slower}; longer than the \
            best known by more than 1e-4, 1e-3, 1 %, 3 %: {}, {}, {}, {}, at most {:.2} %",
        solve_ms.len(),
        above(1e-4),
        above(1e-3),
        above(1e-2),
        above(3e-2),
        100.0 * excesses.iter().copied().fold(0.0, f64::max)
    );
    let [median, most, nearly_all, _] = parts(solve_ms);
    println!("  solve: median {median:.1} ms, 90 % {most:.1} ms, 99 % {nearly_all:.1} ms");
    Ok(())
}

/// Plans maneuvers with random bodies, limits, attitudes and rates. Cases before `first` are drawn
/// and skipped.
fn any(count: usize, first: usize) -> Result<(), Box<dyn Error>> {
    let mut random = Random::new(2026);
    let (mut solve_ms, mut solved) = (Vec::new(), 0);
    for _ in 0..first {
        drawn(&mut random)?;
    }
    for index in first..first + count {
        let problem = drawn(&mut random)?;
        let plan = plan(&problem, &Settings::default(), None, &mut Silent)?;
        solve_ms.push(plan.solution.solve_time * 1e3);
        solved += usize::from(plan.status == Status::Solved);
        if plan.status != Status::Solved {
            let shortfall = plan.solution.shortfall.map_or_else(String::new, |told| told.to_string());
            println!("  case {index}: {} {shortfall}", plan.status.name());
        }
    }
    let [median, most, nearly_all, _] = parts(solve_ms);
    println!("random: {solved} of {count} solved and verified");
    println!("  solve: median {median:.1} ms, 90 % {most:.1} ms, 99 % {nearly_all:.1} ms");
    Ok(())
}

fn drawn(random: &mut Random) -> Result<Problem, Box<dyn Error>> {
    // Draws a point uniform in the ball.
    let ball = |random: &mut Random| loop {
        let vector = Vector3::from_fn(|_, _| random.uniform());
        if vector.norm() < 1.0 {
            return vector;
        }
    };
    // Draws a uniform rotation: a quaternion of four uniform numbers within the unit ball,
    // normalised.
    let rotation = |random: &mut Random| loop {
        let q: [f64; 4] = std::array::from_fn(|_| random.uniform());
        let norm = q.iter().map(|part| part * part).sum::<f64>().sqrt();
        if (0.1..1.0).contains(&norm) {
            return lie::rotation_from_quaternion(&q.map(|part| part / norm));
        }
    };
    let (a, b) = (random.within(1.0, 10.0), random.within(1.0, 10.0));
    let c = random.within((a - b).abs().max(1.0), (a + b).min(10.0));
    let axes = rotation(random);
    let inertia = axes * Matrix3::from_diagonal(&Vector3::new(a, b, c)) * axes.transpose();
    let body = Body { inertia: Inertia::new(0.5 * (inertia + inertia.transpose()))?, mass: None };
    let limits: Vec<f64> = (0..3).map(|_| random.within(1.0, 5.0)).collect();
    let unit = ((a * b * c).cbrt() / limits.iter().product::<f64>().cbrt()).sqrt();
    let [start, end] = [0, 1].map(|_| State::attitude(rotation(random), ball(random) / unit));
    let limits = Limits { size: Some(limits), ..Limits::default() };
    let torques = ActuatorSet::three_axes(AxisFrame::Body).with_limits(limits)?;
    Ok(Problem::minimum_time(body, start, end).with_actuation(Actuation::torques(torques)))
}

/// Returns the median, the quantiles of 90 % and 99 %, and the largest value; NaN if there are no
/// values.
fn parts(mut values: Vec<f64>) -> [f64; 4] {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    let at = |part: f64| values.get(((part * values.len() as f64) as usize).min(last)).copied();
    [0.5, 0.9, 0.99, 1.0].map(|part| at(part).unwrap_or(f64::NAN))
}
