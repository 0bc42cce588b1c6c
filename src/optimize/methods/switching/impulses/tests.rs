//! Test of two impulses with free motion between them, against an integration in short steps.

use super::*;
use crate::optimize::methods::method::Watch;
use crate::optimize::methods::switching::extremal::TorqueLimit;
use crate::optimize::methods::switching::flow::Course;
use crate::optimize::methods::switching::work::StopRequest;
use crate::testing::full_inertia;

fn moving() -> Extremal {
    let units = [Vector3::x(), Vector3::y(), Vector3::z()];
    let inertia = full_inertia();
    Extremal {
        j: *inertia.j(),
        j_inverse: *inertia.j_inverse(),
        law: TorqueLimit::Inputs(units.into_iter().flat_map(|axis| [0.5 * axis, -0.5 * axis]).collect()),
        costs: vec![1.0; 6],
        time_price: 6.0,
        given_duration: Some(60.0),
        middle: Vector3::zeros(),
        start_rate: Vector3::new(0.2, -0.1, 0.15),
        end_rate: Vector3::new(-0.05, 0.1, 0.02),
        end_attitude: lie::exp(&Vector3::new(0.9, -0.5, 0.7)),
        halt: StopRequest::default(),
    }
}

#[test]
fn two_impulses_turn_a_free_body_to_the_end_with_the_momentum_that_it_should_have() {
    let given = moving();
    let work = Work::of(Watch::NONE);
    let momenta = first_momenta(&given, 60.0);
    let all: Vec<Transfer> =
        momenta.into_iter().filter_map(|momentum| transfer(&given, momentum, 60.0, &work)).collect();
    assert!(all.len() > 10, "{}", all.len());
    let (none, still) = (Vector3::zeros(), Extremal::holding(&Vector3::zeros(), 0.0));
    for Transfer { momentum, burns, cost } in all {
        let course = Course::of(&given, &none);
        let mut node = Node { r: Matrix3::identity(), pi: momentum, e: none };
        for _ in 0..4000 {
            node = course.reached(&node, 60.0 / 4000.0, |_, e| still.at(e));
        }
        assert!(lie::log(&given.end_attitude.tr_mul(&node.r)).norm() < 2.0 * NOTHING);
        let pushed = burns.map(|burn| {
            burn.iter().fold(none, |sum, (level, length)| sum + 2.0 * *length * given.axes()[*level])
        });
        let start = momentum - given.j * given.start_rate;
        let stop = given.j * given.end_rate - node.pi;
        assert!((pushed[0] - start).norm() < 1e-9 && (pushed[1] - stop).norm() < 1e-6);
        // Each axis costs two for a unit of impulse.
        assert!((cost - 2.0 * (start.lp_norm(1) + stop.lp_norm(1))).abs() < 1e-5, "{cost}");
    }
}

#[test]
fn impulses_are_of_use_between_rates_for_long_alone() {
    let work = Work::of(Watch::NONE);
    let long = moving();
    let short = long.lasting(Some(4.0));
    let rests = Extremal { start_rate: Vector3::zeros(), end_rate: Vector3::zeros(), ..moving() };
    assert!([&long, &short, &rests].map(is_long) == [true, false, false]);
    assert!(are_of_use(&long, None, &work) && !are_of_use(&long.lasting(None), None, &work));
}
