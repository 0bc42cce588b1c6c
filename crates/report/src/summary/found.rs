//! Results of the search: method, path, cost, arcs and optimality.

use super::lines::{Lines, line};
use slewkit::lie;
use slewkit::maneuver::{
    ChosenSteps, ContinuousGap, Landing, Method, Motion, Objective, Outcome, Path, Problem, Pulses, Rung,
    RungReport, Scheme, Sense, Solution, Structure, Switching, TerminalError,
};
use slewkit::numerics::figures::{counted, error, short, significant, time};
use slewkit_files::identity::Identity;
use slewkit_files::spec::escape;

/// Largest relative gap at which the bang-bang arcs that replace a singular arc count as
/// sufficiently many.
const SMALL_GAP: f64 = 1e-4;

/// Largest relative difference between two durations that count as equal.
const SAME_DURATION: f64 = 1e-12;

/// Returns the name of an integration scheme for use in sentences.
pub fn scheme(scheme: Scheme) -> &'static str {
    match scheme {
        Scheme::LieVerlet => "Lie–Verlet",
        Scheme::LieEuler => "Lie–Euler",
    }
}

pub(super) fn method(problem: &Problem, solution: &Solution) -> String {
    let scheme = scheme(solution.scheme);
    let how = match solution.method {
        Method::Scp => match &solution.convex {
            Some(work) => {
                format!("SCP: {}, then the interior point", counted(work.subproblems, "subproblem"))
            }
            None => "SCP".into(),
        },
        Method::InteriorPoint => "interior point".into(),
        Method::Shooting | Method::Auto if problem.switches() => {
            "shooting: smoothed extremals, then switching times".into()
        }
        Method::Shooting | Method::Auto => {
            let idle = problem.is_constrained() && solution.active.is_empty();
            let limits = if idle { ", no limit active" } else { "" };
            format!("shooting: Newton on {} costates{limits}", problem.dimension())
        }
    };
    let step = Some(solution.step).filter(|step| !step.is_nan());
    let step = step.map(|step| format!(" of {} s", significant(step, 3))).unwrap_or_default();
    format!("{how}, {} {scheme} steps{step}", solution.steps)
}

/// Describes the result of a converged solve.
pub(super) fn found(problem: &Problem, solution: &Solution, identity: &Identity) -> Vec<String> {
    let unit = match problem.motion {
        Motion::Attitude => "  N²·m²·s",
        // The weights determine the unit of the sum of force effort and torque effort.
        Motion::RigidBody => "",
    };
    let of = rotation_beside_path(problem, solution).map(|rotation| format!(" of {rotation:.1} deg"));
    let (class, turned) = (way(problem, solution.sense), solution.turned_deg);
    let mut lines = vec![line("path", &format!("{class}{}, turned {turned:.1} deg", of.unwrap_or_default()))];
    match &solution.switching {
        Some(switching) => lines.extend(switched(problem, solution, switching, identity)),
        None if problem.objective == Objective::Time => {
            let duration = significant(solution.duration(problem), 9);
            lines.line("duration", format!("{duration} s, {MINIMAL}"));
        }
        None if problem.seeks_duration() => {
            let duration = significant(solution.duration(problem), 9);
            let priced = problem.objective.given_time_price().is_some();
            let why = match problem.duration.at_most() {
                Some(longest) if solution.duration(problem) >= longest * (1.0 - SAME_DURATION) => {
                    "the longest allowed"
                }
                Some(_) if !priced => "more time would cost more",
                _ => "where another second saves no more than its price",
            };
            let fuel = problem.objective.fuel().is_some();
            let unit = if fuel { "" } else { unit };
            let with_time = if priced { " with the price of time" } else { unit };
            lines.line("duration", format!("{duration} s, {why}"));
            let cost = significant(solution.cost, 9);
            lines.line(if fuel { "fuel" } else { "cost" }, format!("{cost}{with_time}"));
        }
        None if problem.objective.fuel().is_some() => {
            let fuel = significant(solution.cost, 9);
            lines.line("fuel", format!("{fuel}, {MINIMAL}"));
        }
        None => lines.line("cost", format!("{}{unit}", significant(solution.cost, 6))),
    }
    let work = solution.interior.as_ref().filter(|_| solution.switching.is_none());
    if let Some(continuous) = work.and_then(|work| work.continuous) {
        let (cost, error) = (significant(continuous.cost, 6), significant(continuous.error, 1));
        lines.line("continuous", format!("{cost} within about {error}, estimated from two grids"));
    }
    if let Some(gap) = work.and_then(|work| work.continuous_gap.as_ref()) {
        let unit = if problem.objective.fuel().is_some() { "" } else { " s" };
        let saves = "switches between the nodes save at most";
        lines.line("gap", format!("{saves} {}{unit}, to first order", error(gap.gap)));
        if !gap.undetermined.is_empty() {
            lines.line("not unique", undetermined(gap, identity));
        }
    }
    lines.extend(iterations(solution));
    lines.line("terminal", terminal(&solution.terminal));
    lines.extend(solution.landing.as_ref().map(|landing| line("landing", &landed(landing))));
    lines.extend(solution.chosen.as_ref().map(|chosen| line("steps", &steps(solution.steps, chosen))));
    let optimality = &solution.optimality;
    let second = match optimality.conjugate_points {
        Some(0) if solution.method.is_on_equal_steps() => "strict local minimum".into(),
        Some(count) if solution.method.is_on_equal_steps() => {
            format!("cost decreases in {}: not a minimum", counted(count, "direction"))
        }
        Some(0) => "no conjugate point".into(),
        Some(count) => {
            let given = matches!(problem.path, Path::AsGiven(_));
            let why =
                if given { "kept because the rotation is given" } else { "and no cheaper plan was found" };
            format!("{}: a saddle, {why}", counted(count, "conjugate point"))
        }
        None if optimality.tested => "not decided".into(),
        None => "not tested, as requested".into(),
    };
    let timed = solution.switching.is_some() || problem.is_shaped();
    // A single sweep of shooting computes both values. NaN means that the sweep was not requested
    // or was stopped.
    let known = Some(optimality.stationarity).filter(|stationarity| !stationarity.is_nan());
    let first = known.map(|stationarity| format!("stationarity {}", error(stationarity)));
    let second = if solution.switching.as_ref().is_some_and(|switching| switching.beside_optimum) {
        Some("no discrete optimum was found: the arcs meet the end near it".into())
    } else {
        (!timed).then(|| format!("second order: {second}"))
    };
    lines.line("optimality", first.into_iter().chain(second).collect::<Vec<_>>().join("   "));
    for rival in &solution.rivals {
        let points = match rival.conjugate_points {
            Some(0) => ", a local minimum".into(),
            Some(count) => format!(", {}", counted(count, "conjugate point")),
            None => String::new(),
        };
        let mut path = format!("{}, turned {:.1} deg", way(problem, rival.sense), rival.turned_deg);
        // Paths that pass a cone on different sides may belong to the same homotopy class.
        if solution.method.is_on_equal_steps() {
            path.push_str(&format!(", from {}", escape(&rival.start)));
        }
        if solution.switching.is_some() && !problem.is_shaped() {
            let unit = if problem.objective.fuel().is_some() { "" } else { " s" };
            lines.line("rival", format!("{}{unit}", significant(rival.cost, 9)));
            continue;
        }
        if problem.objective == Objective::Time {
            lines.line("rival", format!("{path}, {} s", significant(rival.cost, 6)));
            continue;
        }
        lines.line("rival", format!("{path}, cost {}{points}", significant(rival.cost, 6)));
    }
    lines
}

/// Describes the corrections of the discrete target with which the continuous motion meets the
/// target.
fn landed(landing: &Landing) -> String {
    let figure = |miss: Option<&f64>| miss.map_or("?".into(), |miss| error(*miss));
    let (first, last) = (figure(landing.misses.first()), figure(landing.misses.last()));
    let how = match landing.corrections {
        0 => format!("the true motion misses the end by {first}"),
        count => format!(
            "{} of the target took the true motion from {first} to {last} off",
            counted(count, "correction")
        ),
    };
    let how = format!("{how}, cost before {}", significant(landing.cost_before, 6));
    let named = |(name, by): &(String, f64)| format!("\"{}\" by {}", escape(name), error(*by));
    match &landing.drawn_in[..] {
        [] => how,
        tightened => {
            let names = tightened.iter().map(named).collect::<Vec<_>>().join(", ");
            format!("{how}; tightened for it: {names}")
        }
    }
}

/// Describes the choice of the number of steps.
fn steps(steps: usize, chosen: &ChosenSteps) -> String {
    let cost = match chosen.cost_error {
        Some(part) => format!("the cost is about {} above the cost of ever shorter steps", percent(part)),
        None => "the gain of shorter steps is unknown".into(),
    };
    let lands = if chosen.lands { "the true motion lands" } else { "the true motion does not land" };
    let from = if steps == chosen.began { String::new() } else { format!(", from {} upwards", chosen.began) };
    format!("{steps} chosen{from}: {lands}, {cost}")
}

fn percent(part: f64) -> String {
    format!("{} %", significant(100.0 * part, 2))
}

/// Returns the lines of a bang-bang plan: duration or fuel, arcs, and gap.
fn switched(
    problem: &Problem,
    solution: &Solution,
    switching: &Switching,
    identity: &Identity,
) -> Vec<String> {
    let figure = |value: f64| significant(value, 9);
    let mut lines = Vec::new();
    let fuel = problem.objective.fuel();
    if switching.structure == Structure::Rest {
        let none = if fuel.is_some() { "no fuel" } else { "0 s" };
        lines.line(problem.objective.name(), format!("{none}: the body is already in its end attitude"));
        return lines;
    }
    if problem.seeks_duration() {
        let (found, continuous) = (solution.duration(problem), switching.continuous_duration_s);
        let all = problem.duration.at_most().is_some_and(|longest| found >= longest * (1.0 - SAME_DURATION));
        let told = if all {
            format!("{} s, the longest allowed", figure(found))
        } else {
            format!("{} s on the grid, {} s in continuous time", figure(found), figure(continuous))
        };
        lines.line("duration", told);
    }
    if let Some(fuel) = fuel {
        let (found, continuous) = (solution.cost, switching.continuous_cost);
        let with_time = if fuel.time_price.is_some() { " with the price of time" } else { "" };
        let told =
            format!("{}{with_time} on the grid, {} in continuous time", figure(found), figure(continuous));
        lines.line("fuel", told);
    }
    let which = inputs_named(&switching.singular_inputs, identity);
    let arcs = match switching.structure {
        Structure::Norm => "the torque always has its full norm, and turns".into(),
        Structure::Singular if switching.arcs.is_empty() => {
            format!("singular: {which} within the limits; all inputs smoothed")
        }
        Structure::BangBang
        | Structure::BangOffBang
        | Structure::AlongLimits
        | Structure::TruncatedChattering
        | Structure::Singular
        | Structure::Pulses
        | Structure::Rest => {
            let lengths = switching.arcs.iter().map(|arc| arc.end_s - arc.start_s);
            let shortest = lengths.fold(f64::INFINITY, f64::min).max(0.0);
            let small = switching.gap <= SMALL_GAP * switching.continuous_cost;
            let chatters = if switching.structure == Structure::TruncatedChattering && !small {
                "; some signs are wrong".into()
            } else if switching.structure == Structure::TruncatedChattering {
                format!("; a singular arc of {which}, replaced by arcs")
            } else if switching.structure == Structure::Singular {
                format!("; {which} within the limits, stated by the mean")
            } else {
                String::new()
            };
            let chatters = if switching.smoothing.is_some() {
                format!("{chatters}; smoothed on this grid")
            } else {
                chatters
            };
            let (arcs, switches) = (counted(switching.arcs.len(), "arc"), switching.switches);
            let plural = if switches == 1 { "" } else { "es" };
            format!("{arcs}, {switches} switch{plural}, the shortest {} s{chatters}", error(shortest))
        }
    };
    lines.line("arcs", arcs);
    if let Some(pulses) = &switching.pulses {
        lines.line("pulses", pulsed(problem, switching, pulses));
        return lines;
    }
    let unit = if fuel.is_some() { "" } else { " s" };
    let gain = format!("neighbouring plans save at most {}{unit}, to first order", error(switching.gap));
    lines.line("gap", gain);
    if let Some(eigenaxis) = switching.eigenaxis_s {
        let more = 100.0 * (eigenaxis / switching.continuous_duration_s - 1.0);
        let told = match more {
            more if more.abs() < 0.05 => "as long".into(),
            more if more > 0.0 => format!("{more:.1} % longer"),
            more => format!("{:.1} % shorter: the plan is a local minimum", -more),
        };
        lines.line("eigenaxis", format!("{} s, {told}", significant(eigenaxis, 6)));
    }
    lines
}

/// Returns the names of inputs, or their numbers if they have no names.
fn inputs_named(inputs: &[usize], identity: &Identity) -> String {
    let named: Vec<String> = inputs.iter().filter_map(|input| identity.input(*input)).map(escape).collect();
    let numbers: Vec<String> = inputs.iter().map(|input| input.saturating_add(1).to_string()).collect();
    match inputs.len() {
        0 => "an input".into(),
        count if named.len() == count => named.join(", "),
        1 => format!("input {}", numbers[0]),
        _ => format!("inputs {}", numbers.join(", ")),
    }
}

/// Describes the inputs, and the times, on which the cost does not depend to first order.
fn undetermined(gap: &ContinuousGap, identity: &Identity) -> String {
    let mut inputs: Vec<usize> = gap.undetermined.iter().map(|stretch| stretch.input).collect();
    inputs.dedup();
    let stretches = |input: &usize| {
        let own = gap.undetermined.iter().filter(|stretch| stretch.input == *input);
        let times = own.map(|own| format!("{}–{} s", significant(own.start_s, 4), significant(own.end_s, 4)));
        format!("{} ({})", inputs_named(&[*input], identity), times.collect::<Vec<_>>().join(", "))
    };
    let told: Vec<String> = inputs.iter().map(stretches).collect();
    format!("to first order the cost does not depend on {}", told.join(", "))
}

/// Describes the number of pulses, their durations, and the cost increase that they cause.
fn pulsed(problem: &Problem, switching: &Switching, pulses: &Pulses) -> String {
    let (without, cost) = (pulses.cost_without, switching.continuous_cost);
    let asked = problem.shortest_pulse().map_or(String::new(), |asked| {
        format!(
            "minimum pulse width {} s: {} {:.2} % above {}, the plan without it; ",
            short(asked),
            if problem.objective.given_time_price().is_some() { "cost" } else { "fuel" },
            100.0 * (cost / without - 1.0),
            significant(without, 9)
        )
    });
    let shortest = significant(pulses.shortest_s, 6);
    format!("{asked}{}, the shortest {shortest} s", counted(pulses.count, "pulse"))
}

fn way(problem: &Problem, sense: Sense) -> &'static str {
    match sense {
        _ if problem.ends_in_any_attitude() => "to an attitude chosen by the plan",
        _ if problem.aim().is_some_and(|aim| aim.has_roll()) => "to a roll chosen by the plan",
        Sense::Short => "short way round",
        Sense::Long => "long way round",
    }
}

/// Returns the angle of the shortest rotation from the start to the end \[deg\] if the path might
/// be mistaken for the long way. This is a rest-to-rest path that goes the short way but turns by
/// more than 180° in total. Returns `None` for all other paths.
pub(super) fn rotation_beside_path(problem: &Problem, solution: &Solution) -> Option<f64> {
    let (start, end) = (&problem.start, &problem.end);
    let known = problem.aim().is_none() && !problem.ends_in_any_attitude();
    let rests = [start, end].iter().all(|state| state.angular_velocity.norm() == 0.0);
    let astray = solution.sense == Sense::Short && solution.turned_deg > 180.0;
    (known && rests && astray).then(|| lie::minus(&end.attitude, &start.attitude).norm().to_degrees())
}

/// Phrase for the optimality of a minimum-time or minimum-fuel plan, for which no second-order test
/// exists.
const MINIMAL: &str = "minimal to first order on the grid";

/// Number of residuals that are shown before an ellipsis, and number that are shown after it.
const SHOWN: (usize, usize) = (3, 4);

/// Returns the lines about the iterations that led to the plan: their number on all grids, and
/// their residuals on the requested grid.
fn iterations(solution: &Solution) -> Vec<String> {
    let convex = solution.method.is_on_equal_steps();
    let won = |rung: &&RungReport| {
        let method = convex == [Rung::Scp, Rung::Polish, Rung::InteriorPoint].contains(&rung.rung);
        method && rung.start == solution.start && rung.outcome == Outcome::Converged
    };
    let won: Vec<&RungReport> = solution.ladder.iter().filter(won).collect();
    let mut grids: Vec<usize> = won.iter().map(|rung| rung.steps).collect();
    grids.sort_unstable();
    grids.dedup();
    let over = match &grids[..] {
        [] | [_] => String::new(),
        [coarse @ .., last] => {
            let coarse = coarse.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
            format!(" over grids of {coarse} and {last} steps")
        }
    };
    let subproblems = solution.convex.as_ref().filter(|_| convex).map_or(0, |work| work.subproblems);
    let count = match subproblems {
        0 => solution.iterations.to_string(),
        count => format!(
            "{}, {} of Newton",
            counted(count, "subproblem"),
            solution.iterations.saturating_sub(count)
        ),
    };
    let mut lines = vec![line("iterations", &format!("{count}{over}, {}", time(solution.solve_time)))];
    // The residual of a convex subproblem is the defect of the dynamics, but the residual of
    // Newton's method includes all conditions. The two are therefore not shown as one sequence.
    let last = won.iter().rfind(|rung| rung.steps == solution.steps && rung.rung != Rung::Scp);
    let mut residuals = last.map_or(Vec::new(), |rung| rung.residuals.clone());
    residuals.dedup();
    let shown = |errors: &[f64]| errors.iter().map(|value| error(*value)).collect::<Vec<_>>().join(" → ");
    let course = match &residuals[..] {
        // The solution on the coarser grid needed no further iterations on this grid.
        [] | [_] => return lines,
        short if short.len() <= SHOWN.0 + SHOWN.1 => shown(short),
        long => format!("{} → … → {}", shown(&long[..SHOWN.0]), shown(&long[long.len() - SHOWN.1..])),
    };
    let grid = if grids.len() > 1 { format!("   on {} steps", solution.steps) } else { String::new() };
    lines.line("residual", format!("{course}{grid}"));
    lines
}

pub(super) fn terminal(terminal: &TerminalError) -> String {
    let mut text = format!(
        "attitude {} rad   momentum {} (relative)",
        error(terminal.attitude_rad),
        error(terminal.momentum_relative)
    );
    if let (Some(position), Some(momentum)) = (terminal.position_relative, terminal.linear_momentum_relative)
    {
        text.push_str(&format!("   position {}   linear momentum {}", error(position), error(momentum)));
    }
    text
}
