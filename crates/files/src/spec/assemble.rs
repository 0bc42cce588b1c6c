//! Second pass over the spec of a maneuver: builds the problem from the checked tree, with all
//! checks that involve more than one key.

use super::attitude::Rotation;
use super::attitude::from_file::Moment;
use super::boundary::{Boundary, TURN};
use super::{
    Expect, Report, Section, actuators, any_of, body, constraint, environment, escape, expect, maneuver,
    names, short, show, sky, stops,
};
use crate::identity::Identity;
use slewkit::lie::{exp, minus};
use slewkit::maneuver::{
    Constraint, Duration, EndCondition, Fuel, Method, Motion, Objective, Path, Problem, ProblemError, Rule,
    Settings, State, Stepping, Weights,
};
use slewkit::maneuver::{Reserve, Unsuited};
use slewkit::mechanics::{Body, Inertia};
use slewkit::numerics::figures::{rounded, told_apart};
use slewkit::sequence::{Ordering, Place, Sequence, Stop};
use slewkit::{Matrix3, Vector3};
use std::f64::consts::TAU;
use std::path::Path as FilePath;

/// Contents of the spec of a maneuver. They are valid only if the report has no error.
pub(crate) struct Assembled {
    pub problem: Problem,
    pub settings: Settings,
    pub expect: Option<Expect>,
    pub identity: Identity,
    pub heavens: Option<sky::Heavens>,
    /// Stops of a sequence and their order; `None` if the spec is a single maneuver.
    pub stops: Option<(Vec<Stop>, Ordering)>,
}

/// Builds the problem; `None` if the report has an error. Relative paths refer to `folder`.
pub(crate) fn assemble(root: &Section, default_name: &str, folder: &FilePath) -> Option<Assembled> {
    let body_section = root.section("body");
    let inertia = body_section.as_ref().and_then(|section| body::inertia(section));
    let mass = body_section.as_ref().and_then(|section| section.number("mass_kg"));
    let lasting = root.section("maneuver").filter(|section| section.has("duration_s"));
    let moment = |seconds| Moment::of(root, seconds, folder);
    let at_start = moment(Some(0.0));
    let mut start = root.section("start").map(|section| Boundary::read(section, "attitude", Some(&at_start)));
    let at_end = moment(lasting.and_then(|section| section.number("duration_s")));
    let mut end = root.section("end").map(|section| {
        let relative = section.has("rotation_from_start") && !section.has("attitude");
        Boundary::read(section, if relative { "rotation_from_start" } else { "attitude" }, Some(&at_end))
    });
    let motion = motion(start.as_ref(), end.as_ref());
    if let Some(section) = &body_section {
        mass_and_motion(section, inertia.as_ref(), mass, motion);
    }
    let actuated = actuators::actuated(root.section("actuators"), motion);
    let identity = names::identity(root, actuated.as_ref().map(|actuated| &actuated.actuation));
    let section = root.section("maneuver")?;
    let duration = maneuver::duration(section);
    let known = duration.and_then(|duration| duration.known().or(duration.at_most()));
    let has_stops = stops::has_stops(root);
    let known = known.or_else(|| has_stops.then(|| sky::ahead_of(stops::lasting(root, identity.epoch))));
    let mut sky = sky::Reading::new(root, identity.epoch, known, folder);
    let constraints = constraint::constraints(root, &mut sky);
    for boundary in [&start, &end].into_iter().flatten() {
        sky::Reading::check_boundary(boundary.section);
    }
    if let Some(start) = &mut start {
        start.aimed(&mut sky);
    }
    let aim = match &end {
        Some(end) if end.section.has("point") => {
            Some(sky.aim(end.section, duration.and_then(|duration| duration.known()))?)
        }
        _ => None,
    };
    if let (Some(end), Some(_), Some(start)) = (&mut end, &aim, &start) {
        end.rotation.clone_from(&start.rotation);
        // The angular velocity at the end is computed from the target.
        end.rate = Some(Vector3::zeros());
    }
    let stops = if has_stops { stops::read(root, &mut sky) } else { Some(Vec::new()) };
    if let (None, true, Some(start)) = (&end, has_stops, &start) {
        // A sequence ends at its last stop, so this end is not used.
        end = Some(Boundary { rate: Some(Vector3::zeros()), ..start.clone() });
    }
    let solver = root.section("solver");
    let (scheme, settings) = maneuver::solver(solver);
    let expect = root.section("expect").map(expect::of_maneuver);
    let place = "[start] and [end]";
    let surroundings =
        environment::Surroundings { section: root.section("environment"), motion, mass, place };
    let environment = surroundings.read(inertia.as_ref());
    if let Some((start, end)) = start.as_ref().zip(end.as_ref()) {
        let ends: &[&Boundary<'_>] = if has_stops && !root.has("end") { &[start] } else { &[start, end] };
        surroundings.check_ends(ends);
    }

    let (start, end) = (start?, end?);
    let path = path(section, &end);
    let start_rotation = start.rotation.as_ref()?;
    // If the end attitude is free, the start attitude is used in the initial guess.
    let end_rotation = if end.is_open() { start_rotation } else { end.rotation.as_ref()? };
    let end_condition = match aim {
        Some(aim) => EndCondition::Aim(aim),
        None if end.is_open() => EndCondition::AnyAttitude,
        None => EndCondition::State,
    };
    let aims = matches!(end_condition, EndCondition::Aim(_));
    warn_quaternion_order(start_rotation, end_rotation, &root.report);
    let end_attitude =
        if end.relative() { start_rotation.matrix * end_rotation.matrix } else { end_rotation.matrix };
    // Attitudes relative to other orbital axes are converted to the orbital axes of this program.
    // The rotation from the start to the end is not affected.
    let to_nadir = root.section("environment").and_then(|section| section.word("lvlh_axes"))
        == Some("velocity_antinormal_nadir");
    let axes =
        if to_nadir { Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)) } else { Matrix3::identity() };
    let constraints = constraints.map(|all| all.into_iter().map(|one| turned(one, &axes)).collect());
    wrong_turn(&end, &start_rotation.matrix.tr_mul(&end_attitude));
    let (start_state, end_state) =
        (start.state(axes * start_rotation.matrix)?, end.state(axes * end_attitude)?);
    let (duration, path, environment) = (duration?, path?, environment?);

    let turning = |end: &Boundary, state: State| {
        if !end.rests_in_orbit() {
            return state;
        }
        if root.section("environment").and_then(|section| section.word("kind")) != Some("gravity_gradient") {
            let reason = "rest in LVLH needs an orbit: LVLH is the frame of kind = \"gravity_gradient\"";
            let remedy = "add that [environment], or write angular_velocity_deg_s";
            end.section.error("E0028", super::keys::REST_IN_ORBIT, reason, remedy);
        }
        let angular_velocity = state.attitude.tr_mul(&environment.frame_rate());
        State { angular_velocity, ..state }
    };
    let (start_state, end_state) = (turning(&start, start_state), turning(&end, end_state));
    let still = environment.is_free() && environment.frame_rate().amax() == 0.0;
    if still && !aims && !has_stops && is_same(&start_state, &end_state, &path) {
        let reason = "the body is already at rest in its end attitude: the plan is zero torque";
        let remedy =
            if end.is_open() { "give [end] an attitude, or a rate" } else { "give [end] another attitude" };
        end.section.warn_here("W0059", reason, remedy);
    }
    let shortest = minus(&end_state.attitude, &start_state.attitude).norm();
    let angle = match path {
        Path::Shortest => shortest,
        // The value `best` tries both directions of rotation. The larger rotation is the one along
        // the long way.
        Path::Long | Path::Best => TAU - shortest,
        Path::AsGiven(vector) => vector.norm(),
    };
    let spin = if let EndCondition::Aim(aim) = &end_condition { aim.roll_rate.abs() } else { 0.0 };
    let rate = start_state.angular_velocity.norm().max(end_state.angular_velocity.norm() + spin);
    let stored = actuated.as_ref().map_or_else(Vector3::zeros, |all| all.actuation.stored_momentum());
    let nutation = inertia.as_ref().map_or(0.0, |inertia| inertia.nutation(&stored));
    let rate = rate + environment.frame_rate().norm() + nutation;
    let legs = stops.as_ref().map_or(1, |stops| stops.len().max(1));
    let steps = match duration.known().map(|duration| duration / legs as f64) {
        Some(duration) => maneuver::steps(section, duration, angle, rate)?,
        None => maneuver::steps_of_sought_duration(section, angle)?,
    };

    let body = Body { inertia: inertia?, mass: mass.filter(|_| motion == Motion::RigidBody) };
    let name = root.word("name").unwrap_or(default_name).to_string();
    let actuators::Actuated { actuation, weights, prices, force_prices } = actuated?;
    let weights = weights.simplified();
    let objective = match section.word("minimize") {
        Some("time") => Objective::Time,
        Some("fuel") => {
            Objective::Fuel(Fuel { prices, force_prices, time_price: section.number("time_price_per_s") })
        }
        _ => Weights { time_price: section.number("time_price_per_s"), ..weights.clone() }.into(),
    };
    let (switches, sought) = (objective.switches(), duration.known().is_none());
    if switches && weights != Weights::default() {
        let reason = format!("weights of the effort have no effect if the objective is {}", objective.name());
        section.error("E0029", "minimize", reason, "remove effort_weight; or write minimize = \"effort\"");
    }
    let constraints: Vec<Constraint> = constraints?;
    let alternatives = any_of::alternatives(root, &constraints)?;
    let problem = Problem {
        name,
        motion,
        body,
        environment,
        actuation,
        objective,
        start: start_state,
        end: end_state,
        end_condition,
        duration,
        steps,
        chooses_steps: !section.has("steps") && !section.has("step_s"),
        scheme,
        stepping: if settings.method.is_on_equal_steps() { Stepping::Equal } else { Stepping::Formulated },
        path,
        constraints,
        alternatives,
        reserve: Reserve::default(),
    };
    if (switches || sought)
        && let Some(solver) = &solver
    {
        maneuver::refuse_scheme(solver);
    }
    if let (Method::Shooting, Some(solver)) = (settings.method, &solver) {
        constraint::refuse_shooting(&problem, solver);
    }
    if let (Method::Scp, Some(solver)) = (settings.method, &solver) {
        constraint::refuse_scp(&problem, solver);
    }
    match problem.check() {
        Ok(()) => {}
        // All violated constraints are reported at once.
        Err(ProblemError::Violated { .. }) => {
            for error in problem.violations() {
                refuse(&error, &problem, root, section, [&start, &end]);
            }
            return None;
        }
        Err(error) => {
            refuse(&error, &problem, root, section, [&start, &end]);
            return None;
        }
    }
    let stops = match stops? {
        _ if !has_stops => stops::refuse_order(section).map(|()| None)?,
        stops => Some(sequence(root, section, &problem, stops, (&end, root.has("end")))?),
    };
    let scenery = sky.scenery(root);
    let identity = Identity { scenery, ..identity };
    Some(Assembled { problem, settings, expect, identity, heavens: sky.heavens(), stops })
}

/// Returns the stops of a sequence and their order. If the spec has `[end]`, it is the last stop.
fn sequence(
    root: &Section,
    maneuver: &Section,
    craft: &Problem,
    mut stops: Vec<Stop>,
    (end, has_end): (&Boundary<'_>, bool),
) -> Option<(Vec<Stop>, Ordering)> {
    if has_end {
        let place = match &craft.end_condition {
            EndCondition::Aim(aim) => Place::Aim(aim.clone()),
            EndCondition::State if !end.relative() && craft.end.angular_velocity == Vector3::zeros() => {
                Place::Attitude(craft.end.attitude)
            }
            _ => {
                let reason = "a sequence must end at rest in an attitude, or on a target";
                return end.section.refuse_here(
                    "E0190",
                    reason,
                    "give [end] an attitude or `point`, and no rate",
                );
            }
        };
        stops.push(Stop::at("end", place));
    }
    for key in ["step_s", "path"] {
        if maneuver.has(key) {
            let reason = format!("`{key}` applies to a single maneuver, and this spec has stops");
            maneuver.error("E0029", key, reason, "remove the key");
        }
    }
    let order = stops::order(maneuver, &mut stops, has_end)?;
    let sequence = Sequence { craft: craft.clone(), stops, order };
    stops::check(root, &sequence).then_some((sequence.stops, order))
}

/// Returns the kind of motion. The body translates if any boundary has a position or a velocity;
/// then every boundary must have both.
fn motion(start: Option<&Boundary<'_>>, end: Option<&Boundary<'_>>) -> Motion {
    let ends = [start, end];
    if !ends.iter().flatten().any(|end| end.moves()) {
        return Motion::Attitude;
    }
    for end in ends.into_iter().flatten() {
        for (name, sample) in [("position_m", "[1, 0, 0]"), ("velocity_m_s", "[0, 0, 0]")] {
            if !end.section.has(name) {
                let reason =
                    format!("[{}] needs `{name}`: the maneuver also moves the body", end.section.path);
                let remedy = format!("add {name} = {sample}, or remove positions and velocities everywhere");
                end.section.error_here("E0021", reason, remedy);
            }
        }
    }
    Motion::RigidBody
}

fn mass_and_motion(section: &Section, inertia: Option<&Inertia>, mass: Option<f64>, motion: Motion) {
    match (motion, section.has("mass_kg")) {
        (Motion::RigidBody, false) => {
            let reason = "[body] needs `mass_kg`: the maneuver also moves the body";
            section.error_here("E0021", reason, "add mass_kg = 100");
        }
        (Motion::Attitude, true) => {
            let reason = "`mass_kg` is not used: the maneuver moves the attitude only";
            let remedy = "remove it; or give positions in [start] and [end]";
            section.warn("W0021", "mass_kg", reason, remedy);
        }
        _ => {}
    }
    if let (Some(inertia), Some(mass)) = (inertia, mass) {
        body::warn_density(section, inertia, mass);
    }
}

fn path(section: &Section, end: &Boundary<'_>) -> Option<Path> {
    let says_turn = end.relative() || end.section.has(TURN);
    let as_given = || {
        let turn = if end.relative() { end.rotation.as_ref()?.vector } else { end.turn? };
        Some(Path::AsGiven(turn))
    };
    if !section.has("path") {
        return if says_turn { as_given() } else { Some(Path::Best) };
    }
    match section.word("path")? {
        "shortest" => Some(Path::Shortest),
        "long" => Some(Path::Long),
        "as_given" if says_turn => as_given(),
        "as_given" => {
            let reason = "path = \"as_given\" needs `rotation_from_start` in [end]: an attitude does not \
             determine the path";
            let remedy =
                "write rotation_from_start = { axis = [1, 0, 0], angle_deg = 480 } instead of attitude";
            section.refuse("E0021", "path", reason, remedy)
        }
        _ => Some(Path::Best),
    }
}

/// Reports that the end attitude is not the start attitude followed by the rotation that the spec
/// gives.
fn wrong_turn(end: &Boundary<'_>, from_start: &Matrix3) {
    const ROUNDING: f64 = 1e-6;
    let Some(turn) = end.turn else { return };
    if end.is_open() {
        let reason = "rotation_from_start_rad needs an attitude, and [end] has none".to_string();
        let remedy = "write it as rotation_from_start, which also gives the attitude; or remove it";
        end.section.error("E0029", TURN, reason, remedy);
        return;
    }
    let off = minus(from_start, &exp(&turn)).norm();
    if off > ROUNDING {
        let reason = format!(
            "the rotation leads {} rad past the attitude, and at most {ROUNDING:e} is accepted as rounding",
            short(off)
        );
        let remedy =
            "write the rotation vector with all digits; or give only one of the two, as rotation_from_start";
        end.section.error("E0058", TURN, reason, remedy);
    }
}

/// Returns the constraint with its directions rotated by the matrix `axes`.
fn turned(mut constraint: Constraint, axes: &Matrix3) -> Constraint {
    if let Rule::Pointing(pointing) = &mut constraint.rule {
        for direction in &mut pointing.directions {
            *direction = direction.turned(axes);
        }
    }
    constraint
}

/// Returns true if the body is at rest in the same attitude at both ends and makes no whole turns.
fn is_same(start: &State, end: &State, path: &Path) -> bool {
    const SAME: f64 = 1e-14;
    let turned = match path {
        Path::AsGiven(vector) => vector.norm(),
        Path::Long => TAU,
        _ => minus(&end.attitude, &start.attitude).norm(),
    };
    let moving = [start.angular_velocity, end.angular_velocity, start.velocity, end.velocity];
    let moved = (end.position - start.position).amax() > SAME * start.position.amax();
    turned < SAME && !moved && moving.iter().all(|velocity| velocity.amax() == 0.0)
}

fn warn_quaternion_order(start: &Rotation, end: &Rotation, report: &Report) {
    let identity = |rotation: &Rotation| rotation.vector.amax() < 1e-9;
    let suspects = [(start, true), (end, identity(start) || start.maybe_identity.is_some())];
    for (rotation, suspect) in suspects {
        if let (Some(other), true) = (rotation.maybe_identity, suspect) {
            let axis = if other == "quaternion_xyzw" { "z" } else { "x" };
            let reason =
                format!("this quaternion is a 180° turn about {axis}; in the other order it is the identity");
            report.warn("W0053", rotation.spot.clone(), reason, format!("meant {other}?"));
        }
    }
}

/// Reports an error of [`Problem::check`] at the position in the spec that caused it.
fn refuse(
    error: &ProblemError,
    problem: &Problem,
    root: &Section,
    maneuver: &Section,
    ends: [&Boundary<'_>; 2],
) {
    let at = |name: &str| ends[usize::from(name == "end")];
    match error {
        ProblemError::StepTooLong { end, angle, limit, steps } => {
            let reason = format!(
                "the {end} rate turns {} rad in one step, and the implicit equation needs less than {}",
                short(*angle),
                show(*limit)
            );
            let remedy = if *steps <= Problem::MAX_STEPS {
                let raise = if maneuver.has("step_s") {
                    "replace `step_s` by `steps` ="
                } else {
                    "increase `steps` to"
                };
                format!("{raise} {steps} or more, or remove the key")
            } else {
                format!("even {} steps are too few: check the rate and `duration_s`", Problem::MAX_STEPS)
            };
            maneuver.report.error("E0120", at(end).rate_spot(), reason, remedy);
        }
        ProblemError::NotRotation { end, .. } => {
            let end = at(end);
            end.section.error("E0055", end.key, error.to_string(), "write all digits");
        }
        ProblemError::Violated { end, name, .. } => {
            let (code, remedy) = constraint::violated(problem, name, end);
            let at = at(end);
            let key = if at.section.has("point") { "point" } else { at.key };
            let spot = if code == "E0060" { at.rate_spot() } else { at.section.spot(key) };
            maneuver.report.error(code, spot, escape(&error.to_string()), remedy);
        }
        ProblemError::Aim(error) => {
            let reason = error.to_string();
            at("end").section.error("E0078", "point", reason, "check the axes and the directions");
        }
        ProblemError::Unsuited(cause) => unsuited(*cause, root, maneuver, problem),
        ProblemError::Value { what: "shortest pulse", value, reason } => {
            let (told, remedy) = match problem.duration {
                Duration::Given(longest) => (Some(longest), "shorten the pulse, or lengthen `duration_s`"),
                Duration::Sought { at_most } | Duration::Found { at_most, .. } => {
                    (at_most, "shorten the pulse, or lengthen `duration_at_most_s`")
                }
            };
            let reason = match told {
                Some(longest) => {
                    let [value, longest] = told_apart([*value, longest], 4, rounded);
                    format!("the shortest pulse is {value} s: it {reason}, of {longest} s")
                }
                None => error.to_string(),
            };
            if let Some(section) = root.section("actuators") {
                section.error("E0031", actuators::SHORTEST_PULSE, reason, remedy);
            }
        }
        ProblemError::Value { .. }
        | ProblemError::Missing(_)
        | ProblemError::Constraint { .. }
        | ProblemError::Alternatives { .. }
        | ProblemError::Wheels(_)
        | ProblemError::Weight { .. } => {
            maneuver.error_here("E0031", error.to_string(), "check the numbers");
        }
    }
}

/// Reports that the settings of the solver do not suit the maneuver, with a remedy.
fn unsuited(cause: Unsuited, root: &Section, maneuver: &Section, problem: &Problem) {
    let reason = cause.to_string();
    let remedy = match cause {
        // The error has already been reported at the key concerned.
        Unsuited::SchemeOfSoughtDuration | Unsuited::SchemeOfSwitching => return,
        // A rotation without an attitude is reported at the key of the rotation.
        Unsuited::WayToAnyAttitude => {
            if maneuver.has("path") {
                let reason = format!("{reason}: only path = \"best\" is possible");
                maneuver.error("E0029", "path", reason, "remove path, or give [end] an attitude");
            }
            return;
        }
        Unsuited::WayToTarget => {
            maneuver.error("E0029", "path", reason, "remove path, or give [end] an attitude");
            return;
        }
        Unsuited::PulsesToAnyAttitude
        | Unsuited::PulsesOfMotion
        | Unsuited::PulsesInField
        | Unsuited::PulsesWithoutFuel
        | Unsuited::PulsesOfWheels
        | Unsuited::PulsesUnderNorm
        | Unsuited::PulsesOfLimitedRate
        | Unsuited::PulsesUnderConstraints
        | Unsuited::PulsesOnEqualSteps => {
            let remedy = "remove it, or write minimize = \"fuel\" and give only limits on the inputs";
            if let Some(section) = root.section("actuators") {
                section.error("E0029", actuators::SHORTEST_PULSE, reason, remedy);
            }
            return;
        }
        Unsuited::UnlimitedTorque => "add torque_limit_n_m to [actuators]: one number, or one for each axis",
        Unsuited::UnlimitedForce => "add force_limit_n to [actuators]: one number, or one for each axis",
        Unsuited::TorqueDirections if problem.actuation.torque.limits().one_sided => {
            "add thrusters that turn the body about this axis"
        }
        Unsuited::TorqueDirections => "add inputs until they reach every direction, or minimise effort",
        Unsuited::ThrusterDirections => "add thrusters until they push and turn in every direction",
        Unsuited::TorquePricesOfThrusters | Unsuited::TorquePricesUnderNorm => {
            "give fuel_price as one number"
        }
        Unsuited::ForcePricesUnderNorm => "give force_fuel_price as one number",
        Unsuited::ThrustersOfEffort
        | Unsuited::ThrusterLimits
        | Unsuited::ThrustersOfAttitude
        | Unsuited::ThrustersWithWheels
        | Unsuited::ThrusterAxes => "write minimize = \"fuel\", or describe the inputs by torque axes",
        Unsuited::FuelToMovingTarget | Unsuited::LimitsToMovingTarget => {
            "give `duration_s`, or aim at a fixed target"
        }
        _ => "remove it, or minimise effort with a given `duration_s`",
    };
    let of_thrusters = matches!(
        cause,
        Unsuited::ThrustersOfEffort
            | Unsuited::ThrusterLimits
            | Unsuited::ThrustersOfAttitude
            | Unsuited::ThrustersWithWheels
            | Unsuited::ThrusterAxes
    );
    let of_directions = matches!(cause, Unsuited::TorqueDirections | Unsuited::ThrusterDirections);
    let moves = problem.motion == Motion::RigidBody;
    let lacking =
        (of_thrusters || of_directions).then(|| actuators::reach::lacking(&problem.actuation, moves));
    let (reason, remedy) = match lacking.flatten() {
        // The remedy for thrusters proposes minimum fuel. It must also state that minimum fuel
        // needs torques in all directions; otherwise the next error would propose minimum effort
        // again.
        Some(way) if of_thrusters => (
            format!("{reason}; and {way}"),
            format!("{remedy}; fuel needs thrusters that reach every direction"),
        ),
        Some(way) => (format!("{reason}; {way}"), remedy.to_string()),
        None => (reason, remedy.to_string()),
    };
    maneuver.error("E0029", "minimize", reason, remedy);
}
