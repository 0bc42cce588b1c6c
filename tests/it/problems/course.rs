//! The way of the witnesses, step by step, has the extremes that their verdict states.

use slewkit::maneuver::{Problem, Settings, Target};
use slewkit::plan::{Plan, Silent, plan};
use slewkit::verify::{WitnessError, course};
use slewkit_files::spec;
use std::path::Path;

fn planned(file: &str) -> (Problem, Plan) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../problems").join(file);
    let loaded = spec::read(&path, &[]).unwrap();
    // The plan has the discrete target, from which the continuous motion departs.
    let settings = Settings { target: Target::Discrete, ..loaded.settings };
    let plan = plan(&loaded.problem, &settings, None, &mut Silent).unwrap();
    (loaded.problem, plan)
}

#[test]
fn the_course_has_the_margins_and_the_end_of_the_verdict() {
    // A keep-out cone, a keep-in cone, and a field without any cone.
    for file in ["keep_out_medium.toml", "keep_in.toml", "limited_pendulum.toml"] {
        let (problem, plan) = planned(file);
        let (trajectory, found) = (&plan.solution.trajectory, plan.verification.unwrap());
        let course = course(&problem, trajectory).unwrap();
        assert_eq!(course.apart.len(), problem.steps + 1);
        let end = *course.apart.last().unwrap();
        // The discrete motion ends at the target, so both distances are equal.
        let wanted = found.continuous_attitude_rad;
        assert!((end - wanted).abs() < 1e-11, "{file}: {end} {wanted}");
        for clearance in &course.clearances {
            let margin = found.margins.iter().find(|margin| margin.name == clearance.name).unwrap();
            let least = |values: &[f64]| {
                assert_eq!(values.len(), problem.steps);
                values.iter().copied().fold(f64::INFINITY, f64::min).to_degrees()
            };
            let (discrete, continuous) = (least(&clearance.discrete), least(&clearance.continuous));
            assert!((discrete - margin.margin).abs() < 1e-9, "{file}: {discrete} {}", margin.margin);
            let wanted = margin.continuous_margin.unwrap();
            assert!((continuous - wanted).abs() < 1e-9, "{file}: {continuous} {wanted}");
        }
    }
}

#[test]
fn a_course_of_rows_that_do_not_fit_is_refused() {
    let (problem, plan) = planned("keep_out_medium.toml");
    let mut trajectory = plan.solution.trajectory;
    trajectory.input.pop();
    assert!(matches!(course(&problem, &trajectory), Err(WitnessError::Rows { .. })));
}
