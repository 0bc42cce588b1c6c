//! How fast a whole cold-start plan is against one bare propagation of the same steps, side by side.
use slewkit::body::{Body, Inertia};
use slewkit::dynamics::Dynamics;
use slewkit::plan::Silent;
use slewkit::planner::solve;
use slewkit::problem::{Path, Problem, State};
use slewkit::settings::Settings;
use slewkit::{Matrix3, Vector3, lie};
use std::hint::black_box;
use std::time::Instant;
fn main() {
    let j = Matrix3::new(2.0, 0.3, -0.2, 0.3, 1.6, 0.15, -0.2, 0.15, 1.1);
    let inertia = Inertia::new(j).unwrap();
    for n in [100, 1000, 10_000, 100_000] {
        let body = Body { inertia: inertia.clone(), mass: None };
        let axis = Vector3::new(1.0, 2.0, -0.5).normalize();
        let problem = Problem::attitude(
            body,
            State::at_rest(Matrix3::identity()),
            State::at_rest(lie::exp(&(axis * 2.0))),
            2.0,
        )
        .with_steps(n)
        .with_path(Path::Shortest);
        let dynamics = Dynamics::new(&problem, n);
        let (mut bare, mut plan) = (Vec::new(), Vec::new());
        let mut last = None;
        for _ in 0..20 {
            let t = Instant::now();
            black_box(dynamics.propagate(black_box(&problem)).ok());
            bare.push(t.elapsed().as_secs_f64());
            let s = solve(&problem, &Settings::default(), None, &mut Silent).unwrap();
            plan.push(s.solve_time);
            last = Some(s);
        }
        let ex = slewkit::extremal::Extremal::<6>::new(&problem, n);
        let c = nalgebra::SVector::<f64, 6>::repeat(0.3);
        let (mut sw, mut sl) = (Vec::new(), Vec::new());
        for _ in 0..20 {
            let t = Instant::now();
            black_box(ex.sweep(black_box(&c)).ok());
            sw.push(t.elapsed().as_secs_f64());
            let t = Instant::now();
            black_box(ex.sweep_linearized(black_box(&c)).ok());
            sl.push(t.elapsed().as_secs_f64());
        }
        let med = |v: &mut Vec<f64>| {
            v.sort_by(f64::total_cmp);
            v[v.len() / 2]
        };
        let (b, p) = (med(&mut bare), med(&mut plan));
        println!("sweep {:.1} ns lin {:.1} ns", med(&mut sw) * 1e9 / n as f64, med(&mut sl) * 1e9 / n as f64);
        println!(
            "N {n}: bare {:.1} us = {:.1} ns/step, plan {:.1} us, ratio {:.2}, err {:.1e}",
            b * 1e6,
            b * 1e9 / n as f64,
            p * 1e6,
            p / b,
            last.as_ref().unwrap().terminal.largest()
        );
        if n >= 1000 {
            for r in &last.unwrap().ladder {
                println!("   {} {} {:?} {} {:?}", r.rung, r.steps, r.outcome, r.iterations, r.residuals);
            }
        }
    }
}
