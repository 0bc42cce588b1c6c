//! What is told of a plan in words: the summary of `slew plan` and `slew verify`, line by line.

use crate::files::identity::Identity;
use crate::files::spec::escape;
use crate::maneuver::{
    ActiveConstraint, Method, Motion, Objective, Outcome, Path, Problem, Pulses, Rung, RungReport, Scheme,
    SecondOrder, Sense, Settings, Solution, Structure, Switching, TerminalError, Trajectory,
};
use crate::numerics::figures::{counted, error, short, significant, time};
use crate::plan::{Plan, Status};
use crate::verify::{Accuracy, Margin, Testimony, Verification};

/// Width of the longest first line, name and verdict.
const WIDTH: usize = 76;

/// Characters before the text of a labelled line.
const LABELLED: usize = 13;

/// A gap of this part of the cost is that of a singular arc which is cut into enough arcs.
const SMALL_GAP: f64 = 1e-4;

/// Durations that differ by this part are one.
const SAME_DURATION: f64 = 1e-12;

/// A labelled line of a summary.
pub fn line(label: &str, text: &str) -> String {
    format!("  {label:<11} {text}")
}

/// Label and text of a labelled line.
pub fn parts(line: &str) -> (String, String) {
    let split = line.char_indices().nth(LABELLED).map_or(line.len(), |(at, _)| at);
    let (label, text) = line.split_at(split);
    (label.trim().into(), text.trim().into())
}

/// A summary, line by line.
pub trait Lines {
    /// Adds a labelled line.
    fn line(&mut self, label: &str, text: impl AsRef<str>);

    /// Adds lines of which the first has the label.
    fn lines<T: AsRef<str>>(&mut self, label: &str, texts: impl IntoIterator<Item = T>) {
        for (index, text) in texts.into_iter().enumerate() {
            self.line(if index == 0 { label } else { "" }, text);
        }
    }
}

impl Lines for Vec<String> {
    fn line(&mut self, label: &str, text: impl AsRef<str>) {
        self.push(line(label, text.as_ref()));
    }
}

/// What a text means, shown as colour and as a sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// It went well.
    Good,
    /// It did not.
    Bad,
    /// Something to know.
    Note,
}

/// `text` in the colour of its tone, for a terminal that has colours.
pub fn paint(colour: bool, tone: Tone, text: &str) -> String {
    let code = match tone {
        Tone::Good => "1;32",
        Tone::Bad => "1;31",
        Tone::Note => "1;33",
    };
    if colour { format!("\x1b[{code}m{text}\x1b[0m") } else { text.into() }
}

/// The first line: name to the left, verdict to the right.
pub fn headline(colour: bool, name: &str, verdict: &str, tone: Tone) -> String {
    let name = escape(name);
    let gap = WIDTH.saturating_sub(name.chars().count() + verdict.chars().count()).max(2);
    format!("{name}{}{}", " ".repeat(gap), paint(colour, tone, verdict))
}

/// The summary of a plan, solved or not: headline and lines.
pub fn plan(
    colour: bool,
    problem: &Problem,
    settings: &Settings,
    plan: &Plan,
    identity: &Identity,
) -> Vec<String> {
    let (verdict, tone) = verdict(plan);
    let mut lines = vec![headline(colour, &problem.name, verdict, tone)];
    lines.extend(told(colour, problem, settings, plan, identity));
    lines
}

/// What became of a plan in a few words.
pub fn verdict(plan: &Plan) -> (&'static str, Tone) {
    let solution = &plan.solution;
    let solved = solution.outcome == Outcome::Converged;
    match plan.status {
        Status::Solved if solution.optimality.second_order() == SecondOrder::Saddle => {
            ("saddle, solved and verified", Tone::Note)
        }
        Status::Solved => ("solved and verified", Tone::Good),
        Status::Infeasible => ("infeasible", Tone::Bad),
        Status::NotConverged => ("not converged", Tone::Bad),
        Status::LimitReached if solved => ("solved, not verified: limit reached", Tone::Bad),
        Status::LimitReached => ("limit reached", Tone::Bad),
        Status::VerificationFailed => ("solved, but verification failed", Tone::Bad),
        Status::Interrupted if solved => ("solved, not verified: interrupted", Tone::Note),
        Status::Interrupted => ("interrupted", Tone::Note),
    }
}

/// The lines of a summary below its headline, but for what to try next.
pub fn told(
    colour: bool,
    problem: &Problem,
    settings: &Settings,
    plan: &Plan,
    identity: &Identity,
) -> Vec<String> {
    let solution = &plan.solution;
    let mut lines = Vec::new();
    // What is proved infeasible was not searched for.
    if plan.status != Status::Infeasible {
        lines.line("method", method(problem, solution));
    }
    if solution.outcome == Outcome::Converged {
        lines.extend(found(problem, solution, identity));
    } else {
        lines.line("stopped", stopped(solution));
        if let Some(proof) = &solution.infeasible {
            lines.line("because", escape(&proof.reason));
        } else {
            lines.extend(solution.shortfall.iter().map(|text| line("missing", &escape(text))));
            lines.line("best", best(&solution.terminal));
            lines.extend(ladder(&solution.ladder));
        }
    }
    if let Some(verification) = &plan.verification {
        let (trajectory, active) = (&solution.trajectory, Some(&solution.active[..]));
        let judged = Judged { problem, identity, trajectory, active };
        lines.extend(verified(colour, &judged, verification));
    }
    if let Some(verification) = plan.verification.as_ref().filter(|_| solution.outcome == Outcome::Converged)
    {
        lines.extend(accuracy(&Accuracy::of(verification, problem, settings.continuous_tolerance)));
    }
    lines
}

/// What the steps leave to be wished for, if they do.
fn accuracy(found: &Accuracy) -> Option<String> {
    let (missed, wanted) = (found.continuous_attitude_deg, short(found.wanted_deg));
    (missed > found.wanted_deg).then(|| {
        let missed = significant(missed, 3);
        let how = match found.steps {
            Some(steps) => format!("{steps} steps would bring that under {wanted} deg"),
            None => format!("no number of steps would bring that under {wanted} deg"),
        };
        line("accuracy", &format!("the motion under these torques ends {missed} deg off the target; {how}"))
    })
}

/// The name of a discretisation.
pub fn scheme(scheme: Scheme) -> &'static str {
    match scheme {
        Scheme::LieVerlet => "Lie–Verlet",
        Scheme::LieEuler => "Lie–Euler",
    }
}

fn method(problem: &Problem, solution: &Solution) -> String {
    let scheme = scheme(solution.scheme);
    let how = match solution.method {
        Method::Scp => match &solution.convex {
            Some(work) => {
                format!("SCP: {}, then Newton on the active set", counted(work.subproblems, "subproblem"))
            }
            None => "SCP".into(),
        },
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

/// What a converged solve found.
fn found(problem: &Problem, solution: &Solution, identity: &Identity) -> Vec<String> {
    let unit = match problem.motion {
        Motion::Attitude => "  N²·m²·s",
        // Forces and torques add up in the unit that the user's weights give them.
        Motion::RigidBody => "",
    };
    let mut lines =
        vec![line("path", &format!("{}, turned {:.1} deg", way(solution.sense), solution.turned_deg))];
    match &solution.switching {
        Some(switching) => lines.extend(switched(problem, solution, switching, identity)),
        None if problem.objective == Objective::Time => {
            let duration = significant(solution.duration(problem), 9);
            lines.line("duration", format!("{duration} s, {}", minimal(solution)));
        }
        None if problem.seeks_duration() => {
            let duration = significant(solution.duration(problem), 9);
            let priced = problem.objective.given_time_price().is_some();
            let why = match problem.duration_at_most {
                _ if solution.shortest.is_some() => {
                    "the shortest found: less time would cost less, and has no plan"
                }
                Some(longest) if solution.duration(problem) >= longest * (1.0 - SAME_DURATION) => {
                    "the longest allowed"
                }
                Some(_) if !priced => "more time would cost more",
                _ => "where a second is worth its price",
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
            lines.line("fuel", format!("{fuel}, {}", minimal(solution)));
        }
        None => lines.line("cost", format!("{}{unit}", significant(solution.cost, 6))),
    }
    lines.extend(iterations(solution));
    lines.line("terminal", terminal(&solution.terminal));
    let optimality = &solution.optimality;
    let second = match optimality.conjugate_points {
        Some(0) if solution.method == Method::Scp => "strict local minimum".into(),
        Some(count) if solution.method == Method::Scp => {
            format!("cost decreases in {}: not a minimum", counted(count, "direction"))
        }
        Some(0) => "no conjugate point".into(),
        Some(count) => {
            let given = matches!(problem.path, Path::AsGiven(_));
            let why =
                if given { "kept because the rotation is given" } else { "and nothing cheaper was found" };
            format!("{}: a saddle, {why}", counted(count, "conjugate point"))
        }
        None if optimality.tested => "not decided".into(),
        None => "not tested, as asked".into(),
    };
    let timed = solution.switching.is_some() || problem.is_shaped();
    // The shooting tests both in one sweep, which may not have been asked for, or have been stopped.
    let known = Some(optimality.stationarity).filter(|stationarity| !stationarity.is_nan());
    let first = known.map(|stationarity| format!("stationarity {}", error(stationarity)));
    let second = (!timed).then(|| format!("second order: {second}"));
    lines.line("optimality", first.into_iter().chain(second).collect::<Vec<_>>().join("   "));
    for rival in &solution.rivals {
        let points = match rival.conjugate_points {
            Some(0) => ", a local minimum".into(),
            Some(count) => format!(", {}", counted(count, "conjugate point")),
            None => String::new(),
        };
        let mut path = format!("{}, turned {:.1} deg", way(rival.sense), rival.turned_deg);
        // What passes cones on different sides may turn the same way.
        if solution.method == Method::Scp {
            path.push_str(&format!(", from {}", escape(&rival.start)));
        }
        if solution.switching.is_some() {
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

/// Duration or fuel, arcs and certificate of a plan whose inputs switch.
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
        lines.line(problem.objective.name(), format!("{none}: the body is where it should be"));
        return lines;
    }
    if problem.seeks_duration() {
        let (found, continuous) = (solution.duration(problem), switching.continuous_duration_s);
        let all = problem.duration_at_most.is_some_and(|longest| found >= longest * (1.0 - SAME_DURATION));
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
    let inputs = &switching.singular_inputs;
    let named: Vec<String> = inputs.iter().filter_map(|input| identity.input(*input)).map(escape).collect();
    let numbers: Vec<String> = inputs.iter().map(|input| (input + 1).to_string()).collect();
    let which = match inputs.len() {
        0 => "an input".into(),
        count if named.len() == count => named.join(", "),
        1 => format!("input {}", numbers[0]),
        _ => format!("inputs {}", numbers.join(", ")),
    };
    let arcs = match switching.structure {
        Structure::Norm => "the torque has its full norm all the time, and turns".into(),
        Structure::Singular => format!("singular: {which} within the limits; all inputs smoothed"),
        Structure::BangBang
        | Structure::BangOffBang
        | Structure::TruncatedChattering
        | Structure::Pulses
        | Structure::Rest => {
            let lengths = switching.arcs.iter().map(|arc| arc.end_s - arc.start_s);
            let shortest = lengths.fold(f64::INFINITY, f64::min).max(0.0);
            let small = switching.gap <= SMALL_GAP * switching.continuous_cost;
            let chatters = if switching.structure == Structure::TruncatedChattering && !small {
                "; not every sign is right".into()
            } else if switching.structure == Structure::TruncatedChattering {
                format!("; a singular arc of {which}, cut into arcs")
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
    lines.line("gap", format!("{}{unit} to be gained at most, to first order", error(switching.gap)));
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

/// How many pulses, how long they are, and what that costs.
fn pulsed(problem: &Problem, switching: &Switching, pulses: &Pulses) -> String {
    let (without, cost) = (pulses.cost_without, switching.continuous_cost);
    let asked = problem.shortest_pulse().map_or(String::new(), |asked| {
        format!(
            "shortest pulse {} s: fuel {:.2} % above {}, the plan without it; ",
            short(asked),
            100.0 * (cost / without - 1.0),
            significant(without, 9)
        )
    });
    let shortest = significant(pulses.shortest_s, 6);
    format!("{asked}{}, the shortest {shortest} s", counted(pulses.count, "pulse"))
}

fn way(sense: Sense) -> &'static str {
    match sense {
        Sense::Short => "short way round",
        Sense::Long => "long way round",
    }
}

/// How many residuals are shown before and after an ellipsis.
const SHOWN: (usize, usize) = (3, 4);

/// What is said of a plan of time or fuel on the convex road, whose second order is not tested.
fn minimal(solution: &Solution) -> String {
    // Below this what a share of the effort adds to the cost is out of sight.
    const SEEN: f64 = 1e-6;
    let minimal = "minimal to first order on the grid";
    match solution.convex.map_or(0.0, |work| work.effort_share) {
        share if share > SEEN => {
            let share = significant(share, 2);
            format!("{minimal} with {share} of the effort in the cost: a little less is possible")
        }
        _ => minimal.into(),
    }
}

/// Iterations of the winning start over all grids, and the residuals of those on the requested grid.
fn iterations(solution: &Solution) -> Vec<String> {
    let convex = solution.method == Method::Scp;
    let won = |rung: &&RungReport| {
        let method = convex == [Rung::Scp, Rung::Polish].contains(&rung.rung);
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
    // A subproblem's residual is a defect, Newton's one of all conditions: they make no one sequence.
    let last = won.iter().rfind(|rung| rung.steps == solution.steps && rung.rung != Rung::Scp);
    let mut residuals = last.map_or(Vec::new(), |rung| rung.residuals.clone());
    residuals.dedup();
    let shown = |errors: &[f64]| errors.iter().map(|value| error(*value)).collect::<Vec<_>>().join(" → ");
    let course = match &residuals[..] {
        // Where the grid before left nothing to do.
        [] | [_] => return lines,
        short if short.len() <= SHOWN.0 + SHOWN.1 => shown(short),
        long => format!("{} → … → {}", shown(&long[..SHOWN.0]), shown(&long[long.len() - SHOWN.1..])),
    };
    let grid = if grids.len() > 1 { format!("   on {} steps", solution.steps) } else { String::new() };
    lines.line("residual", format!("{course}{grid}"));
    lines
}

fn terminal(terminal: &TerminalError) -> String {
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

/// What the witnesses judged.
pub struct Judged<'a> {
    /// The maneuver.
    pub problem: &'a Problem,
    /// What its inputs are called.
    pub identity: &'a Identity,
    /// The plan.
    pub trajectory: &'a Trajectory,
    /// What the solver says acts, where it may speak.
    pub active: Option<&'a [ActiveConstraint]>,
}

/// Limits and verdicts of the witnesses, and every check that fails.
pub fn verified(colour: bool, judged: &Judged, verification: &Verification) -> Vec<String> {
    if verification.was_stopped() {
        // Their numbers are NaN.
        return verification.failure.iter().map(|failure| line("witness", &escape(failure))).collect();
    }
    let mut peaks = format!(
        "peak torque (norm) {} N·m   peak rate {} deg/s",
        significant(verification.peak_torque_n_m, 3),
        significant(verification.peak_rate_rad_s.to_degrees(), 3)
    );
    if judged.problem.actuation.wheels.is_some() {
        let momenta = judged.trajectory.wheel_momentum.iter().map(|momentum| momentum.abs());
        let peak = momenta.fold(0.0, f64::max);
        peaks.push_str(&format!("   peak wheel momentum {} N·m·s", significant(peak, 3)));
    }
    let mut lines = vec![line("limits", &peaks)];
    let name = |margin: &Margin| escape(&margin.name);
    let width = verification.margins.iter().map(|margin| name(margin).chars().count()).max().unwrap_or(0);
    for margin in &verification.margins {
        let text = format!("{:<width$}  {}", name(margin), self::margin(colour, judged, margin));
        lines.line("", &text);
    }
    let missed = verification.continuous_attitude_rad;
    // A plan of no time has no motion to follow.
    if let Some(ran) = ran(verification, "continuous, held torque") {
        let mut continuous = format!(
            "continuous witness, {}, torque held over each step: attitude {} rad ({} deg)",
            ran.method,
            error(missed),
            significant(missed.to_degrees(), 2)
        );
        if let Some(position) = verification.continuous_position_m {
            continuous.push_str(&format!(", position {} m", error(position)));
        }
        lines.line("verified", &continuous);
    }
    if let Some(symplectic) = ran(verification, "symplectic") {
        let text = match verification.symplectic_to_continuous {
            Some(apart) => format!("{}, {} from the continuous one", symplectic.method, error(apart)),
            None => symplectic.method.clone(),
        };
        lines.line("", format!("symplectic witness{}: {text}", over(symplectic, judged)));
    }
    if let Some(order) = ran(verification, "order") {
        let found = verification.order.map_or("round-off".into(), |order| significant(order, 3));
        let text = format!("order of convergence{}: {found}, {}", over(order, judged), order.method);
        lines.line("", &text);
    }
    if let Some(failure) = &verification.failure {
        lines.line("witness", escape(failure));
    }
    for check in verification.checks.iter().filter(|check| !check.passed) {
        let label = paint(colour, Tone::Bad, &escape(&check.name));
        let figure = |value: f64| match check.name.as_str() {
            "continuous terminal" | "continuous pointing" => {
                format!("{} deg", significant(value.to_degrees(), 3))
            }
            _ => significant(value, 3),
        };
        lines.line("failed", format!("{label}: {}, limit {}", figure(check.value), figure(check.limit)));
        if check.name == "continuous terminal" && check.value > check.limit {
            lines.line(
                "",
                "the steps are too coarse: the motion under this torque ends elsewhere; take more steps",
            );
        }
    }
    lines
}

/// What is on record of a witness that ran, or that could not judge.
fn ran<'a>(verification: &'a Verification, witness: &str) -> Option<&'a Testimony> {
    verification.witnesses.iter().find(|ran| ran.witness == witness)
}

/// Over what part of the plan it ran, where that is not the whole.
fn over(ran: &Testimony, judged: &Judged) -> String {
    if ran.windows <= 1 {
        return String::new();
    }
    format!(" over {} of {} steps in {} windows", ran.steps, judged.problem.steps, ran.windows)
}

/// How near the plan comes to one limit, when, and whether that is between two nodes.
fn margin(colour: bool, judged: &Judged, margin: &Margin) -> String {
    let active = judged.active.and_then(|all| all.iter().find(|active| active.name == margin.name));
    let touched = judged.active.is_none() && margin.scaled.abs() <= Margin::ROUND_OFF;
    let state = match active {
        _ if !margin.holds() => paint(colour, Tone::Bad, "violated, "),
        Some(active) => format!("active at {}, ", counted(moments(active), "node")),
        None if touched => "active, ".into(),
        None => String::new(),
    };
    // What acts touches its limit up to round-off, of either sign.
    let value = if margin.scaled.abs() <= Margin::ROUND_OFF { 0.0 } else { margin.margin };
    let steps = margin.time_s / judged.problem.step();
    let between = if (steps - steps.round()).abs() > 1e-6 { ", between nodes" } else { "" };
    let name = margin.input(judged.problem).and_then(|input| judged.identity.input(input));
    let at = name.unwrap_or(&margin.at);
    let at = if at.is_empty() { String::new() } else { format!(", {}", escape(at)) };
    let (value, time) = (significant(value, 3), significant(margin.time_s, 4));
    // Where the limit acts the continuous motion oversteps it by the error of the discretisation.
    let noticed = -Margin::ROUND_OFF.to_degrees();
    let continuous = margin.continuous_margin.filter(|continuous| *continuous < noticed);
    let overstepped = continuous.map_or(String::new(), |continuous| {
        format!("; the continuous motion is {} {} beyond", significant(-continuous, 2), margin.unit)
    });
    format!("{state}margin {value} {} at {time} s{between}{at}{overstepped}", margin.unit)
}

/// How many moments a constraint acts at; several inputs may at one.
fn moments(active: &ActiveConstraint) -> usize {
    let mut times: Vec<u64> = active.time_s.iter().map(|time| time.to_bits()).collect();
    times.sort_unstable();
    times.dedup();
    times.len()
}

fn stopped(solution: &Solution) -> &'static str {
    match solution.outcome {
        Outcome::Converged => "the terminal conditions are met",
        Outcome::IterationLimit => "the iteration limit was reached",
        Outcome::Stalled if solution.method == Method::Scp => {
            "no plan was found within the limits and constraints"
        }
        Outcome::Stalled => "no step reduces the terminal error any more",
        Outcome::StepTooLong => "the body turns too far in one step: the implicit equation has no solution",
        Outcome::NotFinite => "a number became NaN or infinite",
        Outcome::Singular => "the sensitivity matrix is singular: the costates do not steer the end state",
        Outcome::Infeasible => "proved infeasible: no plan exists",
        Outcome::TimeLimit => "the time limit was reached",
        Outcome::Interrupted => "interrupted; this is the best iterate",
    }
}

/// The terminal error of the best iterate, if one reached the end at all.
fn best(error: &TerminalError) -> String {
    if error.largest().is_finite() { terminal(error) } else { "no iterate reached the end".into() }
}

fn ended(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Converged => "converged",
        Outcome::IterationLimit => "iteration limit",
        Outcome::Stalled => "stalled",
        Outcome::StepTooLong => "step too long",
        Outcome::NotFinite => "not finite",
        Outcome::Singular => "singular",
        Outcome::Infeasible => "infeasible",
        Outcome::TimeLimit => "time limit",
        Outcome::Interrupted => "interrupted",
    }
}

/// Runs of one rung, one after the other, beyond which they share a line; a file has them all.
const CROWD: usize = 8;

/// Everything tried, one line a run, a crowd of equal ones in one.
fn ladder(rungs: &[RungReport]) -> Vec<String> {
    let texts = rungs
        .chunk_by(|a, b| a.rung == b.rung)
        .flat_map(|runs| if runs.len() > CROWD { vec![crowd(runs)] } else { runs.iter().map(run).collect() });
    let mut lines = Vec::new();
    lines.lines("ladder", texts.map(|text| text.trim_end().to_string()));
    lines
}

fn run(rung: &RungReport) -> String {
    let course = match (rung.residuals.first(), rung.residuals.last()) {
        (Some(first), Some(last)) => format!("{} → {}", error(*first), error(*last)),
        _ => String::new(),
    };
    let (name, start) = (rung.rung, escape(&rung.start));
    let (outcome, iterations) = (ended(rung.outcome), counted(rung.iterations, "iteration"));
    format!("{name:<15} {start:<9} {:>7} steps  {outcome:<15}  {iterations:>14}  {course}", rung.steps)
}

fn crowd(runs: &[RungReport]) -> String {
    let mut outcomes: Vec<(&str, usize)> = Vec::new();
    for rung in runs {
        match outcomes.iter_mut().find(|(name, _)| *name == ended(rung.outcome)) {
            Some((_, count)) => *count += 1,
            None => outcomes.push((ended(rung.outcome), 1)),
        }
    }
    let outcomes: Vec<_> = outcomes.iter().map(|(name, count)| format!("{count} {name}")).collect();
    let last = runs.iter().filter_map(|rung| rung.residuals.last());
    let best =
        last.copied().min_by(f64::total_cmp).map_or(String::new(), |best| format!(", best {}", error(best)));
    format!("{:<15} {} runs: {}{best}", runs[0].rung, runs.len(), outcomes.join(", "))
}
