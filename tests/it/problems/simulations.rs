//! Every shipped simulation run as a user would, against closed forms and other programs' numbers.

use slewkit::maneuver::problem::{Problem, State};
use slewkit::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::mechanics::environment::{GravityGradient, SecondOrderGravity};
use slewkit::propagate::integrator::{Kind, Quadrature};
use slewkit::propagate::simulate::{BodyState, Observer, Simulation, SimulationError, SimulationRow};
use slewkit::verify::propagation::{Propagation, Propagator, propagate};
use slewkit::{Matrix3, Vector3, lie};
use slewkit_files::spec::{self, Format, LoadedSimulation, Oscillation, Precession, SimulationExpect, Spec};
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

/// Returns the simulations among the files of `problems/`, in order of their names.
fn simulations() -> Vec<(String, LoadedSimulation)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap_or_else(|error| panic!("{folder}: {error}"))
        .map(|entry| entry.expect("an entry of the folder").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    files.sort();
    let loaded = files.into_iter().filter_map(|path| {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        match spec::load(&path, Format::Toml, &[]) {
            Ok(Spec::Simulation(loaded)) => Some((name, *loaded)),
            Ok(_) => None,
            Err(errors) => panic!("{errors}"),
        }
    });
    loaded.collect()
}

/// The results of a run, without its rows.
struct Seen {
    first: SimulationRow,
    last: SimulationRow,
    energy: f64,
    angular: f64,
    linear: f64,
    orthogonality: f64,
    /// Angle about the direction, unwound, and where it began.
    azimuth: Option<(f64, f64)>,
    /// Last component, and the upward passages through zero.
    swing: Option<(f64, f64, Vec<f64>)>,
}

fn attitude(body: &BodyState) -> Matrix3 {
    lie::rotation_from_quaternion(&body.quaternion)
}

/// Returns the angle of a body axis about a direction.
fn azimuth(precession: &Precession, row: &SimulationRow) -> f64 {
    let about = precession.about.normalize();
    let first = about.cross(&if about.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() }).normalize();
    let axis = attitude(&row.bodies[precession.body]) * precession.axis;
    axis.dot(&about.cross(&first)).atan2(axis.dot(&first))
}

fn component(oscillation: &Oscillation, row: &SimulationRow) -> f64 {
    oscillation.direction.normalize().dot(&(attitude(&row.bodies[oscillation.body]) * oscillation.axis))
}

fn run(simulation: &Simulation, expect: &SimulationExpect) -> Seen {
    let mut seen: Option<Seen> = None;
    let mut note = |row: &SimulationRow| {
        let seen = seen.get_or_insert_with(|| Seen {
            first: row.clone(),
            last: row.clone(),
            energy: 0.0,
            angular: 0.0,
            linear: 0.0,
            orthogonality: 0.0,
            azimuth: expect
                .precession
                .as_ref()
                .map(|wanted| azimuth(wanted, row))
                .map(|start| (start, start)),
            swing: expect.oscillation.as_ref().map(|wanted| (row.time, component(wanted, row), Vec::new())),
        });
        let (first, now) = (&seen.first.invariants, &row.invariants);
        // `max` would drop a NaN.
        let raise = |worst: &mut f64, value: f64| *worst = if value <= *worst { *worst } else { value };
        raise(&mut seen.energy, (now.energy - first.energy).abs());
        raise(&mut seen.angular, (now.angular_momentum - first.angular_momentum).norm());
        raise(&mut seen.linear, (now.linear_momentum - first.linear_momentum).norm());
        raise(&mut seen.orthogonality, now.orthogonality);
        if let (Some((_, angle)), Some(wanted)) = (&mut seen.azimuth, &expect.precession) {
            let step = (azimuth(wanted, row) - *angle).rem_euclid(TAU);
            *angle += if step > PI { step - TAU } else { step };
        }
        if let (Some((time, last, passages)), Some(wanted)) = (&mut seen.swing, &expect.oscillation) {
            let value = component(wanted, row);
            if *last < 0.0 && value >= 0.0 {
                passages.push(row.time - (row.time - *time) * value / (value - *last));
            }
            (*time, *last) = (row.time, value);
        }
        seen.last.clone_from(row);
        ControlFlow::Continue(())
    };
    let run = simulation.run(&mut note).unwrap_or_else(|error| panic!("{}: {error}", simulation.name));
    assert!(run.finished);
    seen.unwrap_or_else(|| panic!("{}: no row", simulation.name))
}

/// Returns the expectations of `[expect]` that the motion does not meet, in words, and the errors
/// that it has.
fn unmet(simulation: &Simulation, expect: &SimulationExpect, seen: &Seen) -> (Vec<String>, Vec<String>) {
    let (mut unmet, mut told) = (Vec::new(), Vec::new());
    let mut claim = |what: &str, error: f64, limit: f64| {
        told.push(format!("{what} {error:.1e}"));
        // A NaN does not meet it.
        let met = error <= limit;
        if !met {
            unmet.push(format!("{what}: off by {error:.3e}, limit {limit:.1e}"));
        }
    };
    let start = &seen.first.invariants;
    if let Some(energy) = expect.energy {
        claim("energy at the start", (start.energy - energy.value).abs(), energy.tolerance);
    }
    if let Some(limit) = expect.energy_error_at_most {
        claim("energy", seen.energy / start.energy.abs(), limit);
    }
    if let Some(limit) = expect.angular_momentum_error_at_most {
        claim("angular momentum", seen.angular / start.angular_momentum.norm(), limit);
    }
    if let Some(limit) = expect.linear_momentum_error_at_most {
        let momenta = simulation.start.momenta().iter();
        let size: f64 = momenta.map(|momentum| momentum.linear.norm()).sum();
        claim("linear momentum", seen.linear / size, limit);
    }
    if let Some(limit) = expect.orthogonality_at_most {
        claim("orthogonality", seen.orthogonality, limit);
    }
    for end in &expect.end {
        let (body, name) = (&seen.last.bodies[end.body], &simulation.bodies[end.body]);
        if let Some((expected, limit)) = end.attitude {
            let angle = lie::log(&expected.tr_mul(&attitude(body))).norm();
            claim(&format!("attitude of {name}"), angle, limit);
        }
        for (what, expected, found) in [
            ("angular velocity", end.angular_velocity, body.angular_velocity),
            ("position", end.position, body.position),
            ("velocity", end.velocity, body.velocity),
        ] {
            if let Some((expected, limit)) = expected {
                claim(&format!("{what} of {name}"), (found - expected).norm(), limit);
            }
        }
    }
    if let (Some(precession), Some((start, end))) = (&expect.precession, seen.azimuth) {
        let rate = (end - start) / simulation.duration;
        claim("precession", (rate - precession.rate.value).abs(), precession.rate.tolerance);
    }
    if let (Some(oscillation), Some((_, _, passages))) = (&expect.oscillation, &seen.swing) {
        let periods = passages.len().saturating_sub(1);
        let period = if periods > 0 { (passages[periods] - passages[0]) / periods as f64 } else { f64::NAN };
        claim("period", (period - oscillation.period.value).abs(), oscillation.period.tolerance);
    }
    (unmet, told)
}

#[test]
fn every_shipped_simulation_comes_to_what_it_expects() {
    let only = std::env::var("SLEW_PROBLEM").ok();
    let mut failures = Vec::new();
    for (name, loaded) in simulations() {
        if only.as_ref().is_some_and(|only| !name.contains(only)) {
            continue;
        }
        let expect = loaded.expect.unwrap_or_else(|| panic!("{name}: no [expect]"));
        let began = Instant::now();
        let seen = run(&loaded.simulation, &expect);
        let (unmet, told) = unmet(&loaded.simulation, &expect, &seen);
        println!("{name:24} {:.2} s  {}", began.elapsed().as_secs_f64(), told.join(", "));
        failures.extend(unmet.into_iter().map(|what| format!("{name}: {what}")));
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

#[test]
fn every_shipped_simulation_says_what_it_is_for_and_where_its_numbers_come_from() {
    for (name, loaded) in simulations() {
        let path = format!("{}/../../problems/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
        let comment = text.lines().take_while(|line| line.starts_with("# ")).count();
        assert!(comment >= 2, "{name}: no opening comment");
        assert!(loaded.warnings.is_empty(), "{name}: {:?}", loaded.warnings);
        let expect = loaded.expect.unwrap_or_else(|| panic!("{name}: no [expect]"));
        let source = expect.source.unwrap_or_else(|| panic!("{name}: no source"));
        assert!(source.len() > 20, "{name}: {source:?} is no source");
        let invariants = [expect.energy_error_at_most, expect.orthogonality_at_most];
        assert!(invariants.iter().all(Option::is_some), "{name}: no bounds on energy and orthogonality");
        let known = !expect.end.is_empty() || expect.precession.is_some() || expect.oscillation.is_some();
        assert!(known || name == "dumbbells_long", "{name}: the motion is not checked");
    }
}

/// Returns a maneuver's body with actuators fixed in the body or in the reference frame, in a field
/// that turns its moment.
fn maneuver(frame: AxisFrame, moves: bool) -> Problem {
    let inertia = Inertia::new(Matrix3::new(2.0, 0.1, 0.0, 0.1, 3.0, -0.2, 0.0, -0.2, 4.0)).unwrap();
    let body = Body { inertia, mass: moves.then_some(2.0) };
    let axes = vec![Vector3::x(), Vector3::new(0.0, 1.0, 0.5)];
    let channel = || ActuatorSet::new(axes.clone(), frame).unwrap();
    let start = State {
        position: Vector3::new(1.0, 0.2, 0.0) * f64::from(u8::from(moves)),
        velocity: Vector3::new(0.0, 0.9, 0.1) * f64::from(u8::from(moves)),
        attitude: lie::exp(&Vector3::new(0.3, -0.2, 0.5)),
        angular_velocity: Vector3::new(0.2, -0.4, 0.6),
    };
    let actuation = Actuation { force: moves.then(channel), ..Actuation::torques(channel()) };
    let mut problem = if moves {
        Problem::rigid_body(body, start, start, 1.5).with_environment(
            SecondOrderGravity::new(1.0, 2.0, &Inertia::diagonal(Vector3::new(0.02, 0.03, 0.04)).unwrap())
                .unwrap(),
        )
    } else {
        Problem::attitude(body.clone(), start, start, 3.0)
            .with_environment(GravityGradient::new(0.7, &body.inertia).unwrap())
    };
    problem.actuation = actuation;
    problem
}

/// Constant inputs reach every integrator as they reach the witnesses, whatever frame their axes
/// are fixed in.
#[test]
fn a_maneuver_moves_as_its_witness_says() {
    for (frame, moves) in [
        (AxisFrame::Body, false),
        (AxisFrame::Reference, false),
        (AxisFrame::Body, true),
        (AxisFrame::Reference, true),
    ] {
        let problem = maneuver(frame, moves);
        let inputs: Vec<f64> = [0.3, -0.5, 0.7, 0.2][..problem.actuation.count()].to_vec();
        for (inputs, what) in [(None, "free"), (Some(inputs.as_slice()), "pushed")] {
            let witness = |propagator, steps| {
                let mut last = None;
                let settings = Propagation { propagator, steps, stride: steps, inputs };
                propagate(&problem, &settings, &mut |row: &SimulationRow| {
                    last = Some(row.clone());
                    ControlFlow::Continue(())
                })
                .unwrap();
                last.unwrap()
            };
            let exact = witness(Propagator::Verner98, 30);
            for (kind, limit) in [
                (Kind::LieVerlet, 0.0),
                (Kind::Verner98, 1e-11),
                (Kind::Dop853, 1e-11),
                (Kind::Galerkin { degree: 4, quadrature: Quadrature::Gauss }, 1e-11),
                (Kind::Fehlberg78, 1e-9),
                (Kind::MuntheKaas4, 1e-4),
            ] {
                let mut simulation = Simulation::of(&problem, inputs).unwrap();
                (simulation.kind, simulation.steps, simulation.stride) = (kind, 60, 60);
                let mut last = None;
                simulation
                    .run(&mut |row: &SimulationRow| {
                        last = Some(row.clone());
                        ControlFlow::Continue(())
                    })
                    .unwrap();
                let last = last.unwrap();
                // The discrete witness is the same map in other arithmetic.
                let (expected, limit) = if limit == 0.0 {
                    (witness(Propagator::LieVerlet, 60), 1e-13)
                } else {
                    (exact.clone(), limit)
                };
                let error = (attitude(&last.bodies[0]) - attitude(&expected.bodies[0])).amax();
                assert!(error < limit, "{kind} {frame:?} {moves} {what}: {error:e}");
                let off = (last.bodies[0].position - expected.bodies[0].position).norm();
                assert!(off < limit, "{kind} {frame:?} {moves} {what}: {off:e}");
                let energy = (last.invariants.energy - expected.invariants.energy).abs();
                assert!(energy < 10.0 * limit, "{kind} {frame:?} {moves} {what}: {energy:e}");
                let momentum = last.invariants.angular_momentum - expected.invariants.angular_momentum;
                assert!(momentum.norm() < 10.0 * limit, "{kind} {frame:?} {moves} {what}: {momentum}");
            }
        }
    }
}

/// The output has rows at the stride, at the start and at the end; both stops work; faults are
/// reported before the first step.
#[test]
fn a_run_hands_out_the_rows_asked_for_and_stops_when_told() {
    let mut simulation = Simulation::of(&maneuver(AxisFrame::Body, false), None).unwrap();
    (simulation.steps, simulation.stride, simulation.duration) = (10, 4, 2.0);
    let mut times = Vec::new();
    let run = simulation.run(&mut |row: &SimulationRow| {
        times.push(row.time);
        ControlFlow::Continue(())
    });
    assert_eq!(times, [0.0, 0.8, 1.6, 2.0]);
    assert!(run.unwrap().finished);
    let mut rows = 0;
    let run = simulation.run(&mut |_: &SimulationRow| {
        rows += 1;
        if rows < 2 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    assert_eq!((rows, run.unwrap().finished), (2, false));

    struct Until(u64, u64);
    impl Observer for Until {
        fn on_row(&mut self, _: &SimulationRow) -> ControlFlow<()> {
            ControlFlow::Continue(())
        }
        fn on_step(&mut self, steps: u64) -> ControlFlow<()> {
            self.1 = steps;
            if steps < self.0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        }
    }
    let mut until = Until(3, 0);
    let run = simulation.run(&mut until).unwrap();
    assert_eq!((until.1, run.finished, run.work.steps), (3, false, 3));

    let ignore = |_: &SimulationRow| ControlFlow::Continue(());
    let wrong = Simulation { steps: 0, ..simulation.clone() };
    assert_eq!(wrong.run(&mut { ignore }), Err(SimulationError::Grid));
    let wrong = Simulation { duration: f64::NAN, ..simulation.clone() };
    assert_eq!(wrong.run(&mut { ignore }), Err(SimulationError::Grid));
    let long = Simulation { steps: 1, duration: 1e3, ..simulation };
    assert!(matches!(long.run(&mut { ignore }), Err(SimulationError::Step { .. })));
    let problem = maneuver(AxisFrame::Body, true);
    let refused = |inputs: &[f64]| Simulation::of(&problem, Some(inputs)).unwrap_err();
    assert_eq!(refused(&[1.0]), SimulationError::Inputs { found: 1, expected: 4 });
    assert_eq!(refused(&[1.0, f64::NAN, 0.0, 0.0]), SimulationError::Inputs { found: 4, expected: 4 });
}
