//! Initial paths for maneuvers within limits: turns about a fixed axis and coasts, bent to several
//! sides.
//!
//! The interior-point method converges to an optimum near its initial path, so that the paths need
//! variety: a turn about a fixed axis is often a saddle, with several optima about it.
//! `cargo run --release -p evidence -- guard` counts the plans that the paths lead to.

use crate::Vector3;
use crate::maneuver::constraint::Rule;
use crate::maneuver::grid::Grid;
use crate::maneuver::problem::Path;
use crate::maneuver::settings::Thoroughness;
use crate::mechanics::environment::Pose;
use crate::optimize::chain::path;
use crate::optimize::discrete::candidate::Candidate;
use crate::optimize::discrete::step::Point;
use crate::optimize::discrete::sweep::BoundaryValueProblem;
use crate::optimize::search::ladder::Search;
use crate::optimize::search::starts::detour::past;
use crate::optimize::search::starts::{self, paths};
use std::f64::consts::{PI, TAU};

/// Number of sides to which a path is bent, evenly spaced about its axis.
const SIDES: usize = 6;

/// Returns initial paths on a grid of `steps` steps, the most promising first. Their number depends
/// on the thoroughness.
pub fn of<const N: usize>(search: &Search<N>, steps: usize, thoroughness: Thoroughness) -> Vec<Candidate> {
    let bvp = BoundaryValueProblem::<N>::new(search.problem, steps);
    let rests =
        [&search.problem.start, &search.problem.end].map(|end| end.angular_velocity == Vector3::zeros());
    let moves = rests != [true; 2];
    let ends = [&search.problem.start, &search.problem.end];
    let fastest = ends.map(|end| end.angular_velocity.norm()).into_iter().fold(0.0, f64::max);
    let spins = fastest * search.problem.seconds() > search.context.tuning.carried_on;
    let nearly_half = paths::rotation(&bvp, 0).norm() > search.context.tuning.nearly_half;
    let turns = turns(search, spins, nearly_half);
    let mut found = Vec::new();
    if moves && let Ok(coasts) = paths::coasting(&bvp, &turns) {
        found.extend(coasts.into_iter().map(|coast| (false, coast)));
    }
    if spins && search.problem.is_free_turn() {
        found.extend(turns.iter().flat_map(|turn| natural(search, steps, *turn)).map(|way| (false, way)));
    }
    let thorough = thoroughness == Thoroughness::Thorough;
    for (index, turn) in turns.iter().enumerate() {
        let rotation = paths::rotation(&bvp, *turn);
        let name = starts::name_of(*turn);
        found.push((false, paths::smooth(&bvp, name.clone(), &rotation, paths::straight)));
        // If both homotopy classes turn by about half a turn, paths in both are bent; in a thorough
        // search all are.
        let is_bent = index == 0 || thorough || index == 1 && nearly_half;
        let bends = if is_bent && thoroughness != Thoroughness::Quick { SIDES } else { 0 };
        for (side, bend) in sides(&rotation, search.context.tuning.bend).into_iter().enumerate().take(bends) {
            let name = format!("{name}, bent {}", side + 1);
            found.push((true, paths::smooth(&bvp, name, &rotation, |t| bend * (PI * t).sin().powi(2))));
        }
    }
    let grid = &bvp.dynamics.grid;
    let poses = |seed: &Candidate| seed.states.iter().map(Point::pose).collect::<Vec<Pose>>();
    let written = found.into_iter().map(|(is_bent, seed)| {
        let grid = if seed.grid.duration() == bvp.dynamics.grid.duration() { grid } else { &seed.grid };
        let seed = path(&seed.provenance.start, grid, poses(&seed).into_iter());
        // Paths past either side of every cone are derived from the straight path.
        if is_bent { past(search.problem, seed) } else { seed }
    });
    written.collect()
}

/// Returns the paths of a body without inputs (see `paths::natural`) with `turns` additional turns:
/// one for a given duration, or one for each of several durations if the duration is free, because
/// the body makes more turns in a longer time.
fn natural<const N: usize>(search: &Search<N>, steps: usize, turns: i32) -> Vec<Candidate> {
    let sought = search.ask.goal.as_ref().is_some_and(|goal| goal.objective.counts_time());
    let parts = if sought { &search.context.tuning.durations[..] } else { &[1.0] };
    let way = |part: &f64| {
        let problem = search.problem.clone().with_duration(part * search.problem.seconds());
        let way = paths::natural(&BoundaryValueProblem::<N>::new(&problem, steps), turns).ok()?;
        Some(Candidate { grid: Grid::uniform(search.problem.scheme, *part, steps), ..way })
    };
    parts.iter().filter_map(way).collect()
}

/// Returns the numbers of turns to add to the shortest rotation, the most promising first.
fn turns<const N: usize>(search: &Search<N>, spins: bool, nearly_half: bool) -> Vec<i32> {
    let asked = starts::wanted_turns(search.problem);
    if search.problem.path != Path::Best {
        return asked;
    }
    // Cones may leave only the long way, or lengthen the short one.
    let aside = search.problem.constraints.iter().any(|one| matches!(one.rule, Rule::Pointing(_)));
    match (spins, nearly_half || aside) {
        (true, _) => vec![0, -1, 1],
        (false, true) => vec![0, -1],
        (false, false) if search.context.settings.search == Thoroughness::Thorough => asked,
        (false, false) => vec![0],
    }
}

/// Returns bends by an angle perpendicular to a rotation, evenly spaced about its axis.
fn sides(rotation: &Vector3, bend: f64) -> [Vector3; SIDES] {
    let axis = rotation.try_normalize(1e-9).unwrap_or_else(Vector3::x);
    let least = axis.iamin();
    let first = axis.cross(&Vector3::ith(least, 1.0)).normalize();
    let second = axis.cross(&first);
    std::array::from_fn(|side| {
        let (sine, cosine) = (TAU * side as f64 / SIDES as f64).sin_cos();
        (first * cosine + second * sine) * bend
    })
}
