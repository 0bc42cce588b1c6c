//! Maneuvers whose best plan a search from the start alone, or on the given grid alone, has missed.
//! Each plan costs as little as the best known one.

use evidence::metamorphic::images;
use evidence::switching::{Kind, cost_and_gap, maneuver};
use slewkit::maneuver::{Problem, Settings, Target};
use slewkit::plan::{Plan, Silent, Status, plan};
use slewkit_files::spec::{Format, from_str};
use std::path::Path;

/// Returns the plan of a file of `evidence/best_known`, in another duration where one is given
/// \[s\], and the best known cost, which stands in its first line with its source.
fn planned(name: &str, duration: Option<f64>) -> (Plan, f64) {
    let path = Path::new(evidence::ROOT).join("evidence/best_known").join(format!("{name}.toml"));
    let text = std::fs::read_to_string(path).unwrap();
    let best: f64 = text.split_whitespace().nth(3).unwrap().parse().unwrap();
    let loaded = from_str(&text, name, Format::Toml, &[]).unwrap();
    let settings = Settings { target: Target::Discrete, ..loaded.settings };
    let problem = match duration {
        Some(duration) => loaded.problem.with_duration(duration),
        None => loaded.problem,
    };
    let found = plan(&problem, &settings, None, &mut Silent).unwrap();
    assert_eq!(found.status, Status::Solved, "{name}");
    (found, best)
}

/// Returns the cost of a file over the best known.
fn over_the_best(name: &str) -> f64 {
    let (found, best) = planned(name, None);
    found.solution.cost / best
}

/// A maneuver planned backwards has another first path, other branches and an equal optimum.
#[test]
fn a_search_backwards_finds_what_one_forwards_misses() {
    let missed = [
        "time_given_300",
        "time_long_way",
        "time_long_way_3",
        "time_public_asymmetric_3410",
        "time_thrusters_reverse",
        "fuel_price_moving_start",
        "fuel_thrusters_plate",
    ];
    for name in missed {
        let over = over_the_best(name);
        assert!(over < 1.001, "{name}: {over}");
    }
}

/// The other way round is quicker about another axis: a turn about the axis of the rotation takes a
/// quarter longer.
#[test]
fn the_other_way_round_is_quicker_about_an_axis_of_its_own() {
    let over = over_the_best("time_other_axis");
    assert!(over < 1.001, "{over}");
}

/// The search does not stay at an extremal along whose arcs the cost falls, and it reaches long
/// durations from moderate ones.
#[test]
fn thrusters_forwards_find_what_they_find_backwards() {
    let over = over_the_best("fuel_thrusters_reverse");
    assert!(over < 1.001, "{over}");
}

/// Inputs that are singular have no arcs that the grid can hold.
#[test]
fn equal_steps_are_tried_where_arcs_do_not_fit() {
    for name in ["fuel_price_rod", "time_public_track_7813"] {
        let over = over_the_best(name);
        assert!(over < 1.001, "{name}: {over}");
    }
}

/// A plan of the coarse grid is not given up for a costlier one that is refined more easily.
#[test]
fn a_cheap_plan_of_the_coarse_grid_is_carried_with_more_effort_in_its_cost() {
    for name in ["fuel_keep_out", "time_torque_rate"] {
        let over = over_the_best(name);
        assert!(over < 1.001, "{name}: {over}");
    }
}

/// If no smaller effort weight leads to a plan on the grid, effort is counted from the plan itself.
#[test]
fn effort_that_stays_in_the_cost_is_counted_from_the_plan() {
    let over = over_the_best("time_rate_and_cone");
    assert!(over < 1.001, "{over}");
}

#[test]
fn long_durations_are_followed_from_moderate_ones() {
    let long = ["fuel_in_20_shortest", "fuel_in_50_shortest", "fuel_in_100_shortest", "fuel_in_300_shortest"];
    for name in long.into_iter().chain(["fuel_small_price"]) {
        let over = over_the_best(name);
        assert!(over < 1.001, "{name}: {over}");
    }
}

/// The products of ten thousand rotations on the grid are rounded more than the end may be missed
/// by.
#[test]
fn plans_that_switch_meet_their_end_on_ten_thousand_steps() {
    let over = over_the_best("time_xte");
    assert!(over < 1.001, "{over}");
}

/// A maneuver of long duration coasts for nearly all of it. There a small error of the costates
/// suggests a large gain.
#[test]
fn the_gap_of_a_slow_motion_is_as_small_as_that_of_a_quick_one_along_the_same_path() {
    let gap = |duration: f64| {
        let (found, _) = planned("fuel_in_1000_shortest", Some(duration));
        let cost = found.solution.cost;
        found.solution.switching.expect("arcs").gap / cost
    };
    let quick = gap(100.0);
    assert!((1e-5..1e-4).contains(&quick), "{quick:e}");
    for slow in [1000.0, 4000.0].map(gap) {
        assert!((slow / quick - 1.0).abs() < 0.1, "{quick:e} {slow:e}");
    }
}

/// A body that moves at an end of a long duration coasts for nearly all of it, with as many turns
/// as its motion makes.
#[test]
fn arcs_of_a_long_duration_between_rates_begin_from_impulses() {
    for name in ["fuel_long_between_rates", "fuel_thrusters_spin"] {
        let (found, best) = planned(name, None);
        let cost = found.solution.cost;
        assert!(found.solution.switching.is_some() && cost < 1.001 * best, "{name}: {cost} {best}");
    }
}

/// Random maneuvers that once had another answer backwards, or no answer. The causes: branches that
/// are visible from only one end of a maneuver, arcs that show late or whose grid is far from them,
/// and arcs of a costlier branch than the one from which they were read.
#[test]
fn a_maneuver_has_one_answer_forwards_and_backwards() {
    let settings = Settings { target: Target::Discrete, ..Settings::default() };
    let cost = |problem: &Problem| {
        let found = plan(problem, &settings, None, &mut Silent).unwrap();
        assert_eq!(found.status, Status::Solved);
        cost_and_gap(&found).0
    };
    let long = [107, 190, 242].map(|index| (Kind::Long, index));
    let given = [142, 326, 385].map(|index| (Kind::Given, index));
    for (kind, index) in long.into_iter().chain(given).chain([(Kind::Price, 210)]) {
        let problem = maneuver(kind, index).unwrap();
        let (name, backwards) = images(&problem).swap_remove(0);
        assert_eq!(name, "backwards");
        let (one, other) = (cost(&problem), cost(&backwards));
        assert!((one / other - 1.0).abs() < 1e-4, "{index}: {one} {other}");
    }
}

/// A motion that is slower by a factor takes torques that are smaller by its square, and fuel that
/// is smaller by the factor: first paths of thrusters lead elsewhere in the longer duration.
#[test]
fn least_fuel_of_thrusters_is_no_dearer_than_a_quicker_plan_slowed_down() {
    for name in ["fuel_thrusters_slowed", "fuel_thrusters_slowed_long", "fuel_thrusters_slowed_here"] {
        let over = over_the_best(name);
        assert!(over < 1.002, "{name}: {over}");
    }
}

/// Gyroscopic torques make many minima, of which paths from both ends, and with more turns about the
/// axis of the least moment, meet the cheapest.
#[test]
fn least_effort_of_unequal_moments_is_that_of_the_maneuver_backwards() {
    for name in ["box_8", "box_10", "rod_5", "rod_10", "rod_20", "rod_30", "rod_93"] {
        let over = over_the_best(&format!("effort_unequal_{name}"));
        assert!(over < 1.002, "{name}: {over}");
    }
}
