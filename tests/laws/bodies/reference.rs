//! Two dumbbells of `full_body.json`, computed by another program: forces, energy, five steps.

use super::verlet::step;
use crate::evidence::{list, matrix3, number, reference, vector};
use serde_json::Value;
use slewkit::mechanics::body::{Body, Inertia};
use slewkit::mechanics::environment::{Pose, Wrench};
use slewkit::mechanics::full_body::invariants::Momentum;
use slewkit::mechanics::full_body::*;
use slewkit::propagate::integrator::{System, SystemState};
use std::sync::Arc;

const TOLERANCE: f64 = 1e-13;

fn dumbbells(file: &Value) -> Vec<Dumbbell> {
    (0..2)
        .map(|body| Dumbbell {
            mass: file["masses"][body].as_array().unwrap().iter().map(number).sum(),
            length: 2.0 * number(&file["rho"][body][0][0]),
            sphere_radius: 0.4 * number(&file["rho"][body][0][0]),
        })
        .collect()
}

fn clouds(file: &Value) -> Vec<Attractor> {
    let point =
        |(mass, position): (&Value, &Value)| MassPoint { mass: number(mass), position: vector(position) };
    let of = |(masses, rho): (&Value, &Value)| {
        let points = list(masses).iter().zip(list(rho)).map(point).collect();
        Attractor::Cloud(PointCloud::new(points).unwrap())
    };
    list(&file["masses"]).iter().zip(list(&file["rho"])).map(of).collect()
}

fn poses(state: &Value) -> Vec<Pose> {
    let of = |(x, r): (&Value, &Value)| Pose { position: vector(x), attitude: matrix3(r) };
    list(&state["x"]).iter().zip(list(&state["R"])).map(of).collect()
}

fn momenta(state: &Value) -> Vec<Momentum> {
    let of = |(gamma, pi): (&Value, &Value)| Momentum { linear: vector(gamma), angular: vector(pi) };
    list(&state["gamma"]).iter().zip(list(&state["Pi"])).map(of).collect()
}

fn close(name: &str, found: f64, expected: f64) {
    assert!((found - expected).abs() <= TOLERANCE, "{name}: {found} {expected}");
}

#[test]
fn two_dumbbells_follow_the_reference() {
    let file = reference("full_body");
    let g = number(&file["G"]);
    let potentials: [Arc<dyn Potential>; 3] = [
        Arc::new(Dumbbells::new(g, &dumbbells(&file)).unwrap()),
        Arc::new(MutualGravity::new(g, clouds(&file)).unwrap()),
        Arc::new(MutualGravity::new(g, clouds(&file)).unwrap().with_threads(Threads::Many)),
    ];
    let of = |(j, masses): (&Value, &Value)| Body {
        inertia: Inertia::new(matrix3(j)).unwrap(),
        mass: Some(list(masses).iter().map(number).sum()),
    };
    let bodies: Vec<_> = list(&file["J"]).iter().zip(list(&file["masses"])).map(of).collect();
    for (body, dumbbell) in bodies.iter().zip(dumbbells(&file)) {
        assert!((body.inertia.j() - dumbbell.inertia()).amax() < 1e-16);
    }
    for potential in potentials {
        let system = System::new(bodies.clone(), Some(potential.clone())).unwrap();
        let states = list(&file["states"]);
        let (mut at, mut moving) = (poses(&states[0]), momenta(&states[0]));
        let mut wrenches = vec![Wrench::zero(); 2];
        potential.wrenches(&at, &mut wrenches);
        for (body, wrench) in wrenches.iter().enumerate() {
            assert!((wrench.force - vector(&file["f0"][body])).amax() < TOLERANCE);
            assert!((wrench.moment - vector(&file["M0"][body])).amax() < TOLERANCE);
        }
        close("U", potential.energy(&at), number(&file["U0"]));
        let expected = vector(&file["angular_momentum0"]);
        for (state, total) in states.iter().zip(list(&file["energies"])) {
            let now = system.invariants(&SystemState::new(at.clone(), moving.clone()));
            close("energy", now.energy, number(total));
            assert!((now.angular_momentum - expected).amax() < TOLERANCE);
            assert!(now.linear_momentum.amax() < TOLERANCE);
            for ((pose, momentum), (there, then)) in
                at.iter().zip(&moving).zip(poses(state).iter().zip(momenta(state)))
            {
                assert!((pose.position - there.position).amax() < TOLERANCE);
                assert!((pose.attitude - there.attitude).amax() < TOLERANCE);
                assert!((momentum.linear - then.linear).amax() < TOLERANCE);
                assert!((momentum.angular - then.angular).amax() < TOLERANCE);
            }
            step(&bodies, potential.as_ref(), number(&file["h"]), &mut at, &mut moving, &mut wrenches);
        }
    }
}
