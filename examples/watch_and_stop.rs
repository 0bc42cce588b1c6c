//! Watches a solve, and stops it: an `Observer` receives every strategy and decides whether to
//! continue.
//!
//! `cargo run --release --example watch_and_stop`

use slewkit::{
    Body, Control, Inertia, Matrix3, Observer, Problem, Progress, Rung, Settings, State, Status, Vector3,
    lie, plan,
};

/// Prints every change of strategy, start or grid, and stops when requested.
struct Watcher {
    seen: Vec<String>,
    stop_at: Option<Rung>,
}

impl Observer for Watcher {
    fn on_progress(&mut self, progress: &Progress) -> Control {
        let here = format!("{} from {}, {} steps", progress.rung, progress.start, progress.steps);
        if self.seen.last() != Some(&here) {
            println!("  {here}");
            self.seen.push(here);
        }
        if Some(progress.rung) == self.stop_at { Control::Stop } else { Control::Continue }
    }
}

fn main() {
    let inertia = Inertia::diagonal(Vector3::new(2.0, 1.6, 1.1)).expect("a physical inertia");
    let end = State::at_rest(lie::exp(&Vector3::new(1.0, 2.0, -0.5)));
    let start = State::at_rest(Matrix3::identity());
    let problem = Problem::attitude(Body { inertia, mass: None }, start, end, 2.0).with_steps(500);
    let solve = |stop_at| {
        let mut watcher = Watcher { seen: Vec::new(), stop_at };
        let plan = plan(&problem, &Settings::default(), None, &mut watcher).expect("a valid problem");
        println!("{}, {} tried\n", plan.status.name(), watcher.seen.len());
        (plan.status, watcher.seen.len())
    };
    let (whole, rungs) = solve(None);
    let (stopped, few) = solve(Some(Rung::Newton));

    assert_eq!((whole, stopped), (Status::Solved, Status::Interrupted));
    assert!(rungs > few);
}

#[test]
fn runs() {
    main();
}
