//! The cost of a whole plan: cold start, default tolerance, verification included.

use divan::{Bencher, black_box};
use evidence::measured;
use slewkit::maneuver::problem::Problem;
use slewkit::maneuver::settings::Settings;
use slewkit::plan::{Silent, Status, plan};

const STEPS: [usize; 4] = [100, 1000, 10_000, 100_000];

fn main() {
    divan::main();
}

fn cold_start(bencher: Bencher, problem: &Problem) {
    let settings = Settings::default();
    bencher.bench(|| {
        let plan = plan(black_box(problem), &settings, None, &mut Silent).unwrap();
        assert_eq!(plan.status, Status::Solved);
        plan
    });
}

#[divan::bench(args = STEPS, max_time = 3)]
fn attitude(bencher: Bencher, steps: usize) {
    cold_start(bencher, &measured::attitude(steps));
}

#[divan::bench(args = STEPS, max_time = 3)]
fn rigid_body(bencher: Bencher, steps: usize) {
    cold_start(bencher, &measured::rigid_body(steps));
}
