//! The scale of proofs of optimality, which is one for plans of all methods.

use evidence::Random;
use evidence::switching::{Kind, maneuver};
use slewkit::maneuver::{Outcome, Path, Problem, Proved, Settings, Solution, State};
use slewkit::mechanics::{Body, Inertia};
use slewkit::optimize::search::solve;
use slewkit::plan::Silent;
use slewkit::{Matrix3, Vector3, lie};

fn answer(problem: &Problem, settings: &Settings) -> Solution {
    solve(problem, settings, None, &mut Silent).unwrap()
}

/// Returns the turn of a slab about the axis of its middle moment.
fn slab(angle: f64) -> Problem {
    let inertia = Inertia::diagonal(Vector3::new(1.0, 2.0, 2.9)).unwrap();
    let end = State::at_rest(lie::exp(&Vector3::new(0.0, angle, 0.0)));
    let body = Body { inertia, mass: None };
    Problem::attitude(body, State::at_rest(Matrix3::identity()), end, 4.0).with_steps(60)
}

#[test]
fn every_grade_has_its_plan() {
    let settings = Settings::discrete();
    let proved = |problem: &Problem| answer(problem, &settings).proved(problem);
    assert_eq!(proved(&slab(1.0)), Some(Proved::Minimum));
    let untested = Settings { test_second_order: false, ..settings.clone() };
    assert_eq!(answer(&slab(1.0), &untested).proved(&slab(1.0)), Some(Proved::Extremal));
    // A turn as given about a principal axis is a saddle for some boxes.
    let mut random = Random::new(20);
    let saddle = (0..40).any(|_| {
        let edges: [f64; 3] = std::array::from_fn(|_| random.within(0.2, 2.0).powi(2));
        let moments = Vector3::new(edges[1] + edges[2], edges[2] + edges[0], edges[0] + edges[1]);
        let body = Body { inertia: Inertia::diagonal(moments).unwrap(), mass: None };
        let given = Path::AsGiven(Vector3::new(0.0, 3.05, 0.0));
        proved(&Problem { body, ..slab(3.05) }.with_path(given)) == Some(Proved::Saddle)
    });
    assert!(saddle, "no box had a saddle");
    for kind in [Kind::Time, Kind::Fuel, Kind::Cones] {
        let problem = maneuver(kind, 1).unwrap();
        let found = answer(&problem, &settings);
        assert_eq!(found.proved(&problem), Some(Proved::FirstOrder), "{kind:?}");
        assert!(found.gap_part() < 0.01, "{kind:?}: {}", found.gap_part());
        if let Some(switching) = found.switching.clone() {
            let mut beside = found.clone();
            beside.switching = Some(switching);
            beside.switching.as_mut().unwrap().beside_optimum = true;
            assert_eq!(beside.proved(&problem), Some(Proved::Feasible));
        }
    }
    let time = maneuver(Kind::Time, 1).unwrap();
    let there = Problem { end: time.start, start: State::at_rest(time.start.attitude), ..time.clone() };
    let there = Problem { end: there.start, ..there };
    assert_eq!(proved(&there), Some(Proved::Global));
    let mut none = answer(&slab(1.0), &settings);
    none.outcome = Outcome::Stalled;
    assert_eq!(none.proved(&slab(1.0)), None);
    assert!(Proved::ALL.windows(2).all(|pair| pair[0] > pair[1]));
}
