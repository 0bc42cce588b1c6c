//! Tests of pulses: derivatives of the motion against finite differences, quadratic programs
//! against their optimality conditions, and ties.

use super::motion::Motion;
use super::on_grid::{Placed, placed};
use super::optimum::{best_arcs, best_times};
use super::schedule::{Pulse, PulseRequest, Schedule};
use crate::numerics::random::Stream;
use crate::optimize::methods::switching::extremal::{Extremal, TorqueLimit};
use crate::optimize::methods::switching::tuning::pulses::{COARSE, FINE};
use crate::optimize::methods::switching::work::StopRequest;
use crate::optimize::nlp::bounds::{Bound, Ties};
use crate::optimize::nlp::quadratic::Quadratic;
use crate::{Matrix3, Vector3, lie};
use nalgebra::{DMatrix, DVector, Vector6};

const DURATION: f64 = 5.0;

/// Returns an extremal with three two-sided torques that cost fuel, and a full inertia matrix.
fn extremal() -> Extremal {
    let j = Matrix3::new(1.1, 0.1, -0.05, 0.1, 0.9, 0.08, -0.05, 0.08, 1.3);
    let axes: Vec<Vector3> = [Vector3::x(), 1.2 * Vector3::y(), 0.8 * Vector3::z()]
        .into_iter()
        .flat_map(|axis| [0.5 * axis, -0.5 * axis])
        .collect();
    Extremal {
        j,
        j_inverse: j.try_inverse().unwrap(),
        costs: vec![0.5; axes.len()],
        law: TorqueLimit::Inputs(axes),
        time_price: 0.0,
        given_duration: Some(DURATION),
        middle: Vector3::zeros(),
        start_rate: Vector3::new(0.05, -0.1, 0.02),
        end_rate: Vector3::new(-0.02, 0.03, 0.06),
        end_attitude: lie::exp(&Vector3::new(0.9, -0.5, 0.7)),
        halt: StopRequest::default(),
    }
}

fn ask() -> PulseRequest {
    PulseRequest { shortest: 0.2, input_of: vec![0, 0, 1, 1, 2, 2], thorough: false, sought: false }
}

fn schedule() -> Schedule {
    let pulse = |level: usize, on: f64, off: f64| Pulse { level, on, off };
    let pulses = vec![
        // No arc is a whole number of integration steps long, so that a small change does not
        // change this number.
        pulse(0, 0.11, 0.52),
        pulse(1, 3.93, 4.45),
        pulse(3, 0.33, 0.74),
        pulse(2, 4.27, 4.91),
        pulse(4, 0.63, 1.45),
        pulse(5, 4.04, 4.68),
    ];
    Schedule { pulses, duration: DURATION, sought: false }
}

/// Returns the maneuver with a free duration and a price of time, with a schedule and its
/// requirements.
fn sought() -> (Extremal, Schedule, PulseRequest) {
    let extremal = extremal();
    let time_price = 0.3 + extremal.costs.iter().sum::<f64>();
    let extremal = Extremal { given_duration: None, time_price, ..extremal };
    (extremal, Schedule { sought: true, ..schedule() }, PulseRequest { sought: true, ..ask() })
}

/// Returns the central differences of a vector function of the times.
fn differences(times: &DVector<f64>, of: impl Fn(&DVector<f64>) -> DVector<f64>) -> DMatrix<f64> {
    const STEP: f64 = 2e-5;
    let columns: Vec<DVector<f64>> = (0..times.len())
        .map(|time| {
            let moved = |step: f64| {
                let mut times = times.clone();
                times[time] += step;
                of(&times)
            };
            (moved(STEP) - moved(-STEP)) / (2.0 * STEP)
        })
        .collect();
    DMatrix::from_columns(&columns)
}

#[test]
fn a_pulse_that_is_off_again_at_the_start_is_none() {
    let extremal = extremal();
    let mut schedule = schedule();
    let without = Motion::of(&extremal, &schedule, &Vector6::zeros(), FINE).unwrap().arcs;
    schedule.pulses.push(Pulse { level: 1, on: 0.0, off: 0.0 });
    let with = Motion::of(&extremal, &schedule, &Vector6::zeros(), FINE).unwrap().arcs;
    assert_eq!(with.signs, without.signs);
    assert_eq!(with.switches.len(), without.switches.len());
}

#[test]
fn the_end_answers_to_the_times_as_finite_differences_say() {
    let (sought, with_duration, _) = sought();
    for (extremal, schedule) in [(extremal(), schedule()), (sought, with_duration)] {
        let end = |times: &DVector<f64>| {
            Motion::of(&extremal, &schedule.at(times), &Vector6::zeros(), FINE)
                .unwrap()
                .kkt
                .constraints()
                .into_owned()
        };
        let found = Motion::of(&extremal, &schedule, &Vector6::zeros(), FINE).unwrap().kkt;
        let apart = (found.by_unknowns() - differences(&schedule.times(), end)).amax();
        // The error of the differences is the third derivative times 4e-10 / 6.
        assert!(apart < 1e-8, "{apart:e}");
    }
}

#[test]
fn the_lagrangian_answers_to_the_times_as_finite_differences_say() {
    lagrangian_answers(&extremal(), &schedule());
    let (extremal, schedule, _) = sought();
    lagrangian_answers(&extremal, &schedule);
}

fn lagrangian_answers(extremal: &Extremal, schedule: &Schedule) {
    let costates = Vector6::new(0.3, -0.7, 0.4, -0.9, 0.5, 0.8);
    let at = |times: &DVector<f64>| Motion::of(extremal, &schedule.at(times), &costates, COARSE).unwrap().kkt;
    let times = schedule.times();
    let kkt = at(&times);
    let apart = (kkt.hessian() - differences(&times, |times| at(times).slope().into_owned())).amax();
    assert!(apart < 1e-8, "{apart:e}");
    // At zero costates the slope is the gradient of the cost; it is linear in the costates.
    let cost = differences(&times, |times| DVector::from_element(1, schedule.at(times).cost(extremal)));
    let pull = kkt.by_multipliers() * costates;
    assert!((kkt.slope() - pull - cost.transpose()).amax() < 1e-8);
    // In the null space of the terminal conditions the costates have no effect: both derivatives
    // have the same null space.
    let svd = kkt.by_unknowns().into_owned().svd(true, true);
    let rows = svd.v_t.unwrap();
    let count = rows.ncols();
    let along = DMatrix::identity(count, count) - rows.tr_mul(&rows);
    assert!((along.clone() * kkt.by_multipliers()).amax() < 1e-10);
    // The second derivative is symmetric in this null space, for any costates.
    let reduced = &along * kkt.hessian() * &along;
    assert!((&reduced - reduced.transpose()).amax() < 1e-10 * (1.0 + reduced.amax()));
}

#[test]
fn quadratic_programs_meet_the_conditions_of_karush_kuhn_and_tucker() {
    let mut random = Stream::new(5, 0, 0);
    for case in 0..40 {
        let n = 4 + case % 7;
        let mut number = || 2.0 * random.unit() - 1.0;
        let root = DMatrix::from_fn(n, n, |_, _| number());
        let hessian = root.tr_mul(&root) + 1e-3 * DMatrix::identity(n, n);
        let gradient = DVector::from_fn(n, |_, _| 3.0 * number());
        let equations = DMatrix::from_fn(2, n, |_, _| number());
        // The origin is within all bounds and satisfies the equations.
        let right = DVector::zeros(2);
        let mut bounds: Vec<Bound> =
            (1..n).map(|b| Bound { a: Some(b - 1), b: Some(b), least: -0.3 * number().abs() }).collect();
        bounds.extend((0..n).map(|b| Bound { a: None, b: Some(b), least: -0.5 }));
        bounds.extend((0..n).map(|a| Bound { a: Some(a), b: None, least: -0.5 }));
        let program = Quadratic {
            hessian: &hessian,
            gradient: &gradient,
            equations: Some((&equations, &right)),
            bounds: &bounds,
        };
        let found = program.solve(&vec![false; bounds.len()]).unwrap_or_else(|| panic!("case {case}"));
        assert!((&equations * &found.p).amax() < 1e-9, "case {case}");
        for (bound, acts) in bounds.iter().zip(&found.acting) {
            let slack = bound.slack(&found.p);
            assert!(slack > -1e-9 && (!acts || slack < 1e-7), "case {case}: {slack}");
        }
        // The multiplier term is a combination of the equations, and the remaining slope one of the
        // active bounds, with positive multipliers.
        let combined = |rows: DMatrix<f64>, slope: &DVector<f64>| {
            let shares = rows.clone().svd(true, true).solve(slope, 1e-12).unwrap();
            assert!((slope - rows * &shares).amax() < 1e-7, "case {case}");
            shares
        };
        combined(equations.transpose(), &found.pull);
        let mut met = DMatrix::zeros(n, 0);
        for bound in bounds.iter().zip(&found.acting).filter(|(_, acts)| **acts).map(|(bound, _)| bound) {
            let column = met.ncols();
            met = met.insert_column(column, 0.0);
            bound.write(1.0, |unknown, sign| met[(unknown, column)] += sign);
        }
        let left = &hessian * &found.p + &gradient - &found.pull;
        if met.ncols() > 0 {
            assert!(combined(met, &left).min() > -1e-7, "case {case}");
        } else {
            assert!(left.amax() < 1e-7, "case {case}");
        }
    }
}

#[test]
fn a_program_without_room_has_no_solution() {
    let (hessian, gradient) = (DMatrix::identity(2, 2), DVector::zeros(2));
    let bounds = [Bound { a: None, b: Some(0), least: 1.0 }, Bound { a: Some(0), b: None, least: 0.5 }];
    let (equations, bounds) = (None, &bounds);
    let program = Quadratic { hessian: &hessian, gradient: &gradient, equations, bounds };
    assert!(program.solve(&[false; 2]).is_none());
}

#[test]
fn times_hang_on_the_bounds_that_act() {
    let schedule = schedule();
    let bounds = schedule.bounds(&ask());
    // The first pulse starts with the maneuver and has the minimum pulse width; the second ends
    // with the maneuver.
    let of = |a: Option<usize>, b: Option<usize>| move |bound: &Bound| bound.a == a && bound.b == b;
    let first = of(None, Some(0));
    let short = of(Some(0), Some(1));
    let last = of(Some(3), None);
    let acting = bounds.iter().filter(|bound| first(bound) || short(bound) || last(bound));
    let mut ties = Ties::of(schedule.times().len(), acting);
    assert_eq!(ties.matrix().ncols(), 9);
    ties.add(&Bound { a: Some(4), b: Some(8), least: 0.0 });
    assert_eq!(ties.matrix().ncols(), 8);
    let times = ties.snapped(&schedule.times());
    assert_eq!((times[0], times[1], times[3]), (0.0, 0.2, DURATION));
    assert_eq!(times[4], times[8]);
    assert_eq!(times[2], 3.93);
}

#[test]
fn best_times_meet_the_end_and_their_grid_is_stationary() {
    let (extremal, ask) = (extremal(), ask());
    let placed = placed_well(&extremal, &ask);
    assert!((placed.grid.duration() / DURATION - 1.0).abs() < 1e-14);
}

fn placed_well(extremal: &Extremal, ask: &PulseRequest) -> Placed {
    let first = Schedule::kept(schedule().pulses, DURATION, ask).unwrap();
    let best = best_times(extremal, &first, ask).expect("a schedule that meets the end");
    assert!(best.cost < first.cost(extremal) * 2.0);
    let kkt = Motion::of(extremal, &best.schedule, &best.costates, COARSE).unwrap().kkt;
    assert!(kkt.constraints().norm() < 1e-9);
    let placed = placed(extremal, &best, ask, 200).expect("a grid");
    assert!(placed.grid.residual < 1e-12, "{}", placed.grid.residual);
    for pulse in &placed.schedule.pulses {
        assert!(pulse.length() >= ask.shortest - 1e-13);
    }
    placed
}

#[test]
fn a_sought_duration_is_the_best_of_those_that_are_given() {
    let (extremal, _, ask) = sought();
    let found = placed_well(&extremal, &ask);
    let (duration, cost) = (found.schedule.duration, found.schedule.cost(&extremal));
    assert!((duration / DURATION - 1.0).abs() > 0.01, "{duration}");
    // Optimises the pulses for a given duration; the cost includes the price of this duration.
    let given = |duration: f64| {
        let extremal = Extremal { given_duration: Some(duration), ..extremal.clone() };
        let ask = PulseRequest { sought: false, ..ask.clone() };
        let first = Schedule::kept(found.schedule.pulses.clone(), duration, &ask).unwrap();
        best_times(&extremal, &first, &ask).unwrap().cost + extremal.price_of_time() * duration
    };
    assert!((given(duration) / cost - 1.0).abs() < 1e-9);
    // If active bounds leave no time free, the cost increases in both directions.
    for part in [0.99, 0.999, 1.001, 1.01] {
        let other = given(part * duration);
        assert!(other > cost, "{part}: {other} {cost}");
    }
}

/// Claim: pulses that begin or end with the maneuver do so exactly, and the terminal conditions are
/// still met.
#[test]
fn arcs_of_the_best_times_meet_the_end_to_round_off() {
    let (sought, with_duration, _) = sought();
    for (extremal, schedule) in [(extremal(), schedule()), (sought, with_duration)] {
        let arcs = Motion::of(&extremal, &schedule, &Vector6::zeros(), FINE).unwrap().arcs;
        let best = best_arcs(&extremal, &arcs).expect("arcs that meet the end");
        assert!(best.signs.iter().any(|sign| *sign > 0.0), "{:?}", best.signs);
        let pulses = Schedule::of_arcs(&best);
        let again = Schedule { pulses, duration: best.duration, ..schedule };
        let miss = Motion::of(&extremal, &again, &Vector6::zeros(), FINE).unwrap().kkt.constraints().norm();
        assert!(miss < 1e-13, "{miss:e}");
    }
}
