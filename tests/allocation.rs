//! The inner loops do not allocate: the allocator itself counts.

// The crate forbids unsafe code. This test is a separate crate, because a counting allocator is an
// `unsafe impl`: both methods pass their arguments to the system's allocator unchanged.

use slewkit::maneuver::constraint::{Constraint, Direction, Pointing, Rule, Side};
use slewkit::maneuver::objective::Objective;
use slewkit::maneuver::problem::{Problem, Scheme, State};
use slewkit::mechanics::actuators::{Actuation, ActuatorSet, AxisFrame, Limits, Wheels};
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::mechanics::environment::{
    CentralGravity, GravityGradient, PointMass, Pose, UniformGravity, Wrench,
};
use slewkit::mechanics::full_body::{
    Attractor, Dumbbell, Dumbbells, HomogeneousPolyhedron, MassPoint, MutualGravity, PointCloud, Polyhedron,
    Potential, Threads,
};
use slewkit::optimize::discrete::step::Dynamics;
use slewkit::optimize::discrete::sweep::BoundaryValueProblem;
use slewkit::optimize::with_cold_solve;
use slewkit::propagate::integrator::{self, EulerPoincare, Input, Kind, Quadrature};
use slewkit::{Matrix3, Vector3, lie};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // During thread shutdown the counter may be gone: nobody looks any more.
        let _ = COUNT.try_with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Allocations that `work` makes on this thread.
fn allocations<T>(work: impl FnOnce() -> T) -> usize {
    let before = COUNT.get();
    let result = std::hint::black_box(work());
    let count = COUNT.get() - before;
    drop(result);
    count
}

fn state(seed: f64) -> State {
    State {
        position: Vector3::new(1.0, 0.2 * seed, -0.1),
        velocity: Vector3::new(0.1, 0.8, 0.2 * seed),
        attitude: lie::exp(&Vector3::new(0.3 * seed, -0.2, 0.5)),
        angular_velocity: Vector3::new(0.1, -0.3, 0.2 * seed),
    }
}

fn check<const N: usize>(problem: &Problem) {
    let bvp = BoundaryValueProblem::<N>::new(problem, problem.steps);
    let costate = nalgebra::SVector::<f64, N>::from_fn(|row, _| 0.02 * row as f64 - 0.05);
    let dynamics = Dynamics::new(problem, problem.steps);
    assert!(bvp.sweep_linearized(&costate).is_ok());
    let (scheme, field) = (problem.scheme, &problem.environment);
    assert_eq!(allocations(|| bvp.sweep(&costate)), 0, "{scheme:?} {field:?}");
    assert_eq!(allocations(|| bvp.sweep_linearized(&costate)), 0, "{scheme:?} {field:?}");
    assert_eq!(allocations(|| dynamics.linearize::<N>(&problem.start, &costate)), 0, "{scheme:?} {field:?}");
    assert_eq!(allocations(|| dynamics.propagate(problem)), 0, "{scheme:?} {field:?}");
}

#[test]
fn sweeps_allocate_nothing() {
    assert_eq!(allocations(|| vec![1, 2, 3]), 1, "the counter counts");
    let inertia = Inertia::new(Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1)).unwrap();
    let body = Body { inertia, mass: Some(1.3) };
    let pendulum = UniformGravity::new(1.0, 1.7, Vector3::z(), Vector3::new(0.1, -0.2, 0.9)).unwrap();
    let points = [0.1, -0.1].map(|x| PointMass { parameter: 0.5, position: Vector3::new(x, 0.0, 0.0) });
    for scheme in [Scheme::LieEuler, Scheme::LieVerlet] {
        let attitude = Problem::attitude(body.clone(), state(1.0), state(-1.0), 2.0).with_scheme(scheme);
        check::<6>(&attitude);
        check::<6>(&attitude.with_environment(pendulum.clone()));
        let moving = Problem::rigid_body(body.clone(), state(1.0), state(-1.0), 2.0).with_scheme(scheme);
        check::<12>(&moving);
        check::<12>(&moving.with_environment(CentralGravity::new(points.to_vec()).unwrap()));
    }
}

#[test]
fn forces_allocate_nothing() {
    let dumbbell = Dumbbell { mass: 1.0, length: 0.5, sphere_radius: 0.1 };
    let point = |k: usize| MassPoint {
        mass: 1.0,
        position: Vector3::new((k as f64).sin(), (1.3 * k as f64).sin(), (1.7 * k as f64).sin()),
    };
    let cloud = || PointCloud::centered((0..300).map(point).collect()).unwrap().0;
    let gravity =
        MutualGravity::new(1.0, vec![Attractor::Cloud(cloud()), Attractor::Cloud(cloud())]).unwrap();
    let potentials: [Box<dyn Potential>; 3] = [
        Box::new(Dumbbells::new(1.0, &[dumbbell; 2]).unwrap()),
        Box::new(gravity.clone().with_threads(Threads::One)),
        Box::new(gravity.with_threads(Threads::Many)),
    ];
    let at =
        |x: f64| Pose { position: Vector3::new(x, 0.0, 0.0), attitude: lie::exp(&Vector3::new(x, 0.2, 0.3)) };
    let (poses, mut wrenches) = ([at(0.0), at(4.0)], [Wrench::zero(); 2]);
    let count = || {
        for potential in potentials {
            potential.wrenches(&poses, &mut wrenches);
            let count = allocations(|| (0..100).for_each(|_| potential.wrenches(&poses, &mut wrenches)));
            assert_eq!(count, 0, "{potential:?}");
        }
    };
    // Inside a pool of threads: a call from outside hands over a job, which now and then allocates.
    #[cfg(feature = "threads")]
    rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap().install(count);
    #[cfg(not(feature = "threads"))]
    count();
}

/// A step of every method, for one body and for two, with and without inputs. The references of
/// another crate allocate, and the counter shows it.
#[test]
fn steps_of_the_integrators_allocate_nothing() {
    let inertia = Inertia::new(Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1)).unwrap();
    let body = Body { inertia, mass: None };
    let field = UniformGravity::new(1.0, 1.7, Vector3::z(), Vector3::new(0.1, -0.2, 0.9)).unwrap();
    let orbit = GravityGradient::new(0.5, &body.inertia).unwrap();
    let pair = [(1.0, 0.5), (2.0, 1.0)];
    let pair = pair.map(|(mass, length)| Dumbbell { mass, length, sphere_radius: 0.2 * length });
    let bodies = pair.iter().map(|dumbbell| dumbbell.body().unwrap()).collect();
    let mut systems = vec![
        integrator::System::new(vec![body.clone()], None).unwrap(),
        integrator::System::single(body.clone(), Arc::new(field)).unwrap(),
        integrator::System::single(body, Arc::new(orbit)).unwrap(),
        integrator::System::new(bodies, Some(Arc::new(Dumbbells::new(1.0, &pair).unwrap()))).unwrap(),
    ];
    let point = |k: usize| MassPoint {
        mass: 0.1,
        position: 0.3 * Vector3::new((k as f64).sin(), (1.3 * k as f64).sin(), (1.7 * k as f64).sin()),
    };
    let cloud = || PointCloud::centered((0..20).map(point).collect()).unwrap().0;
    let solid = Polyhedron::octahedron(&Vector3::new(0.5, 0.4, 0.3)).unwrap();
    let solid = || Attractor::Polyhedron(HomogeneousPolyhedron::with_mass(solid.clone(), 2.0, 2).unwrap());
    for attractors in [vec![Attractor::Cloud(cloud()), Attractor::Cloud(cloud())], vec![solid(), solid()]] {
        let bodies = attractors.iter().map(|attractor| attractor.body().unwrap()).collect();
        let gravity = MutualGravity::new(1.0, attractors).unwrap().with_threads(Threads::One);
        systems.push(integrator::System::new(bodies, Some(Arc::new(gravity))).unwrap());
    }
    for system in &systems {
        let n = system.bodies().len();
        let start = system.state(&[state(1.0), state(-6.0)][..n]).unwrap();
        let input = Wrench { force: Vector3::zeros(), moment: Vector3::new(1e-4, 0.0, -1e-4) };
        let inputs = vec![Input::held(input); n];
        for kind in Kind::all().filter(|kind| !matches!(kind, Kind::Dop853 | Kind::Verner98)) {
            let mut method = kind.start(system, &start, 0.01, &integrator::ErrorControl::default()).unwrap();
            for inputs in [&[][..], &inputs] {
                let count = allocations(|| (0..3).map(|_| method.step(inputs)).all(|step| step.is_ok()));
                assert_eq!(count, 0, "{kind} {system:?}");
            }
        }
    }
    let mut reduced = EulerPoincare::new(&systems[0].bodies()[0].inertia, 3, Quadrature::Gauss, 0.1).unwrap();
    assert_eq!(allocations(|| reduced.step(&Vector3::new(0.3, 0.5, 1.0)).unwrap()), 0);
}

/// An interior point solves again in the space of its first solution: least time and effort with
/// wheels, rate limits and a cone.
#[test]
fn an_interior_point_allocates_nothing() {
    let body = Body { inertia: Inertia::diagonal(Vector3::new(1.0, 0.8, 1.2)).unwrap(), mass: None };
    let at_rest = |turn: Vector3| State::at_rest(lie::exp(&turn));
    let problem =
        Problem::attitude(body, at_rest(Vector3::zeros()), at_rest(Vector3::new(0.2, 1.0, 0.6)), 4.0);
    let axes = [[0.8, 0.0, 0.6], [-0.8, 0.0, 0.6], [0.0, 0.8, 0.6], [0.0, -0.8, 0.6]].map(Vector3::from);
    let limits = Limits { size: Some(vec![1.0; 4]), ..Limits::default() };
    let set = ActuatorSet::new(axes.to_vec(), AxisFrame::Body).unwrap().with_limits(limits).unwrap();
    let mut actuation = Actuation::torques(set);
    actuation.wheels = Some(Wheels { momentum: vec![0.0; 4], momentum_limit: vec![2.0; 4] });
    let directions = vec![Direction::Fixed(Vector3::new(0.8, 0.36, -0.48))];
    let cone = Pointing::new(Side::KeepOut, vec![Vector3::x()], directions, 0.2);
    let named = |name: &str, rule: Rule| Constraint { name: name.into(), rule };
    let problem = problem
        .with_actuation(actuation)
        .with_steps(20)
        .with_constraint(named("rate", Rule::RateAxes(Vector3::repeat(0.7))))
        .with_constraint(named("cone", Rule::Pointing(cone)));
    for problem in [problem.clone().with_objective(Objective::Time), problem] {
        with_cold_solve(&problem, |solve| {
            let first = solve();
            assert!(first > 5, "{first}");
            let mut again = 0;
            assert_eq!(allocations(|| again = solve()), 0);
            assert_eq!(first, again);
        });
    }
}
