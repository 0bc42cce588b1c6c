//! Every short example, compiled and run: each prints its result and asserts what it claims.

#[path = "../../../examples/guess_and_sweep.rs"]
mod guess_and_sweep;
#[path = "../../../examples/integrators_compared.rs"]
mod integrators_compared;
#[path = "../../../examples/own_environment.rs"]
mod own_environment;
#[path = "../../../examples/plan_a_slew.rs"]
mod plan_a_slew;
#[path = "../../../examples/watch_and_stop.rs"]
mod watch_and_stop;

#[test]
fn plan_a_slew_runs() {
    plan_a_slew::main();
}

#[test]
fn own_environment_runs() {
    own_environment::main();
}

#[test]
fn watch_and_stop_runs() {
    watch_and_stop::main();
}

#[test]
fn guess_and_sweep_runs() {
    guess_and_sweep::main();
}

#[test]
fn integrators_compared_runs() {
    integrators_compared::main().unwrap();
}
