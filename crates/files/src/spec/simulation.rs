//! Second pass over the spec of a simulation: builds a [`Simulation`] from the checked tree.

use super::boundary::Boundary;
use super::environment::Surroundings;
use super::keys::StepsOf;
use super::shape::{Budget, Shape, shape};
use super::{BodyShape, Section, SimulationExpect, Solid, body, cut, expect, grid, short, show};
use slewkit::Matrix3;
use slewkit::maneuver::{Motion, State};
use slewkit::mechanics::full_body::{
    Attractor, Dumbbell, Dumbbells, FullBodyError, GRAVITATIONAL_CONSTANT, MutualGravity, Potential,
};
use slewkit::mechanics::{Body, Inertia};
use slewkit::propagate::integrator::{ErrorControl, Kind, System};
use slewkit::propagate::simulate::Simulation;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Contents of the spec of a simulation. They are valid only if the report has no error.
pub(crate) struct Assembled {
    pub simulation: Simulation,
    pub shapes: Vec<Option<BodyShape>>,
    pub solids: Vec<Option<Solid>>,
    pub expect: Option<SimulationExpect>,
    pub files: Vec<PathBuf>,
}

/// Largest rotation per step `h|Ω|` for which the implicit attitude equation of the variational
/// integrators has a solution \[rad\]; h is the step and Ω the angular velocity.
const LONGEST_TURN: f64 = 1.0;

/// A body as defined in the spec.
struct Member<'a> {
    name: String,
    boundary: Boundary<'a>,
    shape: Option<Shape>,
    inertia: Option<Inertia>,
    mass: Option<f64>,
    moves: bool,
}

/// Builds the simulation; `None` if the report has an error. Relative paths refer to `folder`.
pub(crate) fn assemble(root: &Section, default_name: &str, folder: &Path) -> Option<Assembled> {
    let list = root.list("bodies");
    if list.is_empty() {
        if root.is_empty_list("bodies") {
            let reason = "a simulation needs at least one body";
            root.error("E0021", "bodies", reason, "add a table [[bodies]]");
        }
        return None;
    }
    let gravity = root.section("gravity");
    contradictions(root, gravity, list);
    let alone = list.len() == 1;
    let mut budget = Budget::new();
    let members: Vec<Member> = list
        .iter()
        .enumerate()
        .map(|(index, section)| member(section, index, gravity.is_some(), folder, &mut budget))
        .collect();
    names_differ(&members);
    let names: Vec<&str> = members.iter().map(|member| member.name.as_str()).collect();
    let expect = root.section("expect").map(|section| expect::of_simulation(section, &names));
    let surroundings = environment(root, &members);
    if let Some(surroundings) = &surroundings {
        surroundings.check_ends(&[&members[0].boundary]);
    }
    let section = root.section("simulation")?;
    let grid = section
        .number("duration_s")
        .and_then(|duration| Some((duration, grid::given(StepsOf::Simulation, section, duration)?)));
    if root.report.failed() {
        return None;
    }

    let bodies = members.iter().map(Member::body).collect::<Option<Vec<Body>>>()?;
    let system = match (&surroundings, &gravity) {
        (Some(surroundings), _) => {
            let environment = surroundings.read(members[0].inertia.as_ref())?;
            System::single(bodies.into_iter().next()?, environment)
        }
        (None, Some(gravity)) => System::new(bodies, Some(potential(gravity, &members)?)),
        (None, None) => {
            if !alone {
                let reason = "the bodies have no mutual gravity: [gravity] is missing";
                let remedy = "add [gravity], or simulate them one by one";
                root.warn("W0132", "bodies", reason, remedy);
            }
            System::new(bodies, None)
        }
    };
    let numbers = |_: &_| ("E0031", root.spot("bodies"), "check the numbers of the bodies");
    let system = root.report.accept(system, numbers)?;
    let states: Option<Vec<State>> = members.iter().map(Member::state).collect();
    let start = root.report.accept(system.state(&states?), numbers)?;
    let (duration, steps) = grid?;
    let integrator = section.word("integrator").unwrap_or("lie_verlet");
    let mut simulation = Simulation::new(system, start, integrator.parse().ok()?, duration, steps);
    simulation.name = root.word("name").unwrap_or(default_name).to_string();
    simulation.bodies = members.iter().map(|member| member.name.clone()).collect();
    simulation.stride = section.count("output_stride").unwrap_or(1) as u64;
    simulation.settings =
        ErrorControl { tolerance: section.number("tolerance").unwrap_or(ErrorControl::default().tolerance) };
    steps_are_short(&simulation, section, &members);
    simulation.reach =
        members.iter().map(|member| member.shape.as_ref().map_or(0.0, |shape| shape.reach)).collect();
    if gravity.is_some() {
        apart(&simulation, &members);
    }
    let shapes = members.iter().map(|member| member.shape.as_ref().map(shown)).collect();
    let solids = members.iter().map(|member| member.shape.as_ref().and_then(|shape| shape.solid)).collect();
    Some(Assembled { simulation, shapes, solids, expect: expect.flatten(), files: budget.files })
}

fn shown(shape: &Shape) -> BodyShape {
    match shape.dumbbell {
        Some(dumbbell) => BodyShape::Dumbbell(dumbbell),
        None => BodyShape::Other(Box::new(shape.attractor.clone())),
    }
}

/// Checks that the gravity and the environment of the spec are compatible with the number of
/// bodies.
fn contradictions(root: &Section, gravity: Option<&Section>, bodies: &[Section]) {
    let environment = root.section("environment");
    if let (Some(environment), Some(_)) = (&environment, gravity) {
        let reason = "both [gravity] and [environment] are given";
        let remedy = "[gravity] is for several bodies, [environment] for one body: give only one of them";
        environment.error_here("E0028", reason, remedy);
    } else if let Some(environment) = environment.filter(|_| bodies.len() > 1) {
        let reason = format!("[environment] acts on one body, but the spec has {}", bodies.len());
        let remedy = "use [gravity], and add the attracting center as a body";
        environment.error_here("E0085", reason, remedy);
    }
    if let Some(gravity) = gravity.filter(|_| bodies.len() == 1) {
        let reason = "[gravity] acts between bodies, but the spec has only one";
        let remedy = "add another body, or use [environment] with kind = \"central_gravity\"";
        gravity.error_here("E0085", reason, remedy);
    }
}

fn member<'a>(
    section: &'a Section,
    index: usize,
    attracted: bool,
    folder: &Path,
    budget: &mut Budget,
) -> Member<'a> {
    let boundary = Boundary::read(section, "attitude", None);
    let section = &boundary.section;
    let moving = ["position_m", "velocity_m_s", "linear_momentum_n_s"];
    let moves = attracted || moving.iter().any(|name| section.has(name));
    if moves && !section.has("position_m") {
        let why = if attracted { "the bodies attract each other" } else { "the body translates" };
        let reason = format!("[{}] needs `position_m`: {why}", section.path);
        section.error_here("E0021", reason, "add position_m = [0, 0, 0]");
    }
    let given = section.number("mass_kg");
    let shape = shape(section, given, folder, budget);
    let inertia = match &shape {
        _ if section.has("inertia_kg_m2") => body::inertia(section),
        Some(shape) => inertia_of_shape(section, &shape.inertia),
        None => {
            if !section.has("shape") {
                let reason = format!("[{}] needs `inertia_kg_m2` or a shape", section.path);
                section.error_here("E0021", reason, "add inertia_kg_m2 = [1, 2, 2.5]");
            }
            None
        }
    };
    let mass = shape.as_ref().map(|shape| shape.mass).or(given);
    if !section.has("shape") {
        match (moves, section.has("mass_kg")) {
            (true, false) => {
                let reason = format!("[{}] needs `mass_kg`, because the body translates", section.path);
                section.error_here("E0021", reason, "add mass_kg = 100");
            }
            (false, true) => {
                let reason = "`mass_kg` has no effect: the body only rotates";
                let remedy = "remove it; or give the body a position";
                section.warn("W0021", "mass_kg", reason, remedy);
            }
            _ => {}
        }
    }
    if let (Some(inertia), Some(mass), true) = (&inertia, mass, section.has("inertia_kg_m2")) {
        body::warn_density(section, inertia, mass);
    }
    let name = section.word("name").map_or_else(|| format!("body {}", index + 1), str::to_string);
    Member { name, boundary, shape, inertia, mass, moves }
}

fn inertia_of_shape(section: &Section, inertia: &Matrix3) -> Option<Inertia> {
    if let Err(slewkit::mechanics::body::InertiaError::NotPositive { .. }) = Inertia::new(*inertia) {
        let reason = "the points lie on a line, about which the body has no moment of inertia";
        let remedy = "add `inertia_kg_m2` to the body; or use a dumbbell, whose spheres have a radius";
        return section.refuse("E0041", "shape", reason, remedy);
    }
    body::checked(*inertia, section, "shape")
}

impl Member<'_> {
    fn body(&self) -> Option<Body> {
        Some(Body { inertia: self.inertia.clone()?, mass: self.mass.filter(|_| self.moves) })
    }

    /// Returns the state of the body at the start, computed from velocities or momenta.
    fn state(&self) -> Option<State> {
        let section = &self.boundary.section;
        let mut state = self.boundary.state(self.boundary.rotation.as_ref()?.matrix)?;
        if section.has("angular_momentum_body_n_m_s") {
            let momentum = section.vector("angular_momentum_body_n_m_s")?;
            state.angular_velocity = self.inertia.as_ref()?.j_inverse() * momentum;
        }
        if section.has("linear_momentum_n_s") {
            state.velocity = section.vector("linear_momentum_n_s")? / self.mass?;
        }
        Some(state)
    }
}

fn names_differ(members: &[Member<'_>]) {
    for (index, member) in members.iter().enumerate() {
        if let Some(first) = members[..index].iter().position(|other| other.name == member.name) {
            let (first, second, name) = (first + 1, index + 1, cut(&member.name, 40));
            let reason = format!("bodies {first} and {second} are both called \"{name}\"");
            member.boundary.section.error("E0011", "name", reason, "give each body another name");
        }
    }
}

/// Returns the table `[environment]` with the data that its checks need; `None` unless the
/// simulation has a single body.
fn environment<'a>(root: &'a Section, members: &[Member<'_>]) -> Option<Surroundings<'a>> {
    let section = root.section("environment")?;
    let [member] = members else { return None };
    if section.word("kind") == Some("central_gravity")
        && member.moves
        && !member.boundary.section.has("velocity_m_s")
        && !member.boundary.section.has("linear_momentum_n_s")
    {
        let reason = "the body starts at rest in a central field: it falls into the center";
        let remedy = "no action is needed if this is intended; else add `velocity_m_s`";
        member.boundary.section.warn_here("W0133", reason, remedy);
    }
    let motion = if member.moves { Motion::RigidBody } else { Motion::Attitude };
    Some(Surroundings { section: Some(section), motion, mass: member.mass, place: "[[bodies]]" })
}

/// Builds the mutual gravity of the bodies. The closed form is used only if the bodies are
/// dumbbells.
fn potential(gravity: &Section, members: &[Member<'_>]) -> Option<Arc<dyn Potential>> {
    let constant = match gravity.number("gravitational_constant_m3_kg_s2") {
        Some(constant) => constant,
        None if gravity.has("gravitational_constant_m3_kg_s2") => return None,
        None => GRAVITATIONAL_CONSTANT,
    };
    let second_order = gravity.word("potential") == Some("second_order");
    let dumbbells: Option<Vec<Dumbbell>> =
        members.iter().map(|member| member.shape.as_ref()?.dumbbell).collect();
    let built: Result<Arc<dyn Potential>, FullBodyError> = match dumbbells.filter(|_| !second_order) {
        Some(dumbbells) => Dumbbells::new(constant, &dumbbells).map(|potential| Arc::new(potential) as _),
        None => {
            let attractor = |member: &Member<'_>| match &member.shape {
                Some(shape) if !second_order => Some(shape.attractor.clone()),
                _ => Some(Attractor::SecondOrder { mass: member.mass?, inertia: member.inertia.clone()? }),
            };
            let attractors: Option<Vec<_>> = members.iter().map(attractor).collect();
            MutualGravity::new(constant, attractors?).map(|potential| {
                long_steps(&potential, gravity, members);
                Arc::new(potential) as _
            })
        }
    };
    let remedy = |error: &FullBodyError| match error {
        FullBodyError::Count { .. } => "use coarser shapes, fewer bodies, or potential = \"second_order\"",
        _ => "check masses and the constant of gravitation",
    };
    gravity.report.accept(built, |error| ("E0086", gravity.here(), remedy(error)))
}

/// Number of point interactions per evaluation of the forces above which a step takes a noticeable
/// part of a second.
const LONG: f64 = 1e8;

/// Warns if a step takes long, because progress is reported only between steps.
fn long_steps(gravity: &MutualGravity, section: &Section, members: &[Member<'_>]) {
    let interactions = gravity.interactions();
    if interactions < LONG {
        return;
    }
    let faces = members.iter().filter_map(|member| {
        let faces = member.shape.as_ref()?.solid?.faces;
        Some(format!("{} {faces}", cut(&member.name, 40)))
    });
    let faces: Vec<_> = faces.take(3).collect();
    let of = if faces.is_empty() { String::new() } else { format!(" (faces: {})", faces.join(", ")) };
    let (count, time) = (short(interactions), short((10.0 * interactions / PER_SECOND).round() / 10.0));
    let reason = format!(
        "each evaluation of the gravity needs {count} point-to-point interactions{of}, about \
        {time} s; a step makes one or more"
    );
    let remedy = "use shapes with fewer faces, a lower gauss_order, points for one shape, or potential = \
     \"second_order\"";
    section.warn_here("W0137", reason, remedy);
}

/// Approximate number of point interactions that one processor evaluates per second.
/// `cargo bench -p benches --bench bodies` prints the time for 10⁸ interactions.
const PER_SECOND: f64 = 2e8;

/// Checks that the steps are so short that the implicit attitude equation has a solution at the
/// start.
fn steps_are_short(simulation: &Simulation, section: &Section, members: &[Member<'_>]) {
    let limited = matches!(
        simulation.kind,
        Kind::LieEuler | Kind::LieEulerAdjoint | Kind::LieVerlet | Kind::LieVerletLagrangian
    );
    for (member, momentum) in members.iter().zip(simulation.start.momenta()).filter(|_| limited) {
        let Some(inertia) = &member.inertia else { continue };
        let turn = (inertia.j_inverse() * momentum.angular).norm() * simulation.step();
        if turn >= LONGEST_TURN {
            let (name, shown) = (cut(&member.name, 40), short(turn));
            let reason = format!(
                "{name} turns {shown} rad in one step, but the implicit equation needs less than \
                {LONGEST_TURN}"
            );
            let steps = (simulation.steps as f64 * turn / 0.3).ceil();
            let remedy = if section.has("steps") {
                format!("increase `steps` to about {}, or check the rate", show(steps))
            } else {
                let step = short(0.3 * simulation.step() / turn);
                format!("shorten `step_s` to about {step} s, or check the rate")
            };
            section.report.error("E0120", member.boundary.rate_spot(), reason, remedy);
        }
    }
}

/// Checks that no two bodies overlap at the start.
fn apart(simulation: &Simulation, members: &[Member<'_>]) {
    let poses = simulation.start.poses();
    let reach = |index: usize| members[index].shape.as_ref().map_or(0.0, |shape| shape.reach);
    let mut warned = 0;
    for second in 0..members.len() {
        for first in 0..second {
            let distance = (poses[second].position - poses[first].position).norm();
            let (a, b) = (cut(&members[first].name, 40), cut(&members[second].name, 40));
            let section = members[second].boundary.section;
            if distance == 0.0 {
                let reason = format!("{a} and {b} are in the same place");
                section.error("E0083", "position_m", reason, "move one of them");
                return;
            }
            if distance < reach(first) + reach(second) && warned < 3 {
                warned += 1;
                let [distance, first, second] = [distance, reach(first), reach(second)].map(short);
                let reason = format!(
                    "{a} and {b} are {distance} m apart, and their radii are {first} m and {second} m: \
                    they may touch"
                );
                let remedy = "no action is needed if their shapes are apart; gravity is exact for bodies that \
                    do not touch";
                section.warn("W0131", "position_m", reason, remedy);
            }
        }
    }
    if !simulation.system.invariants(&simulation.start).energy.is_finite() {
        let reason = "the energy at the start is infinite: points of two bodies coincide";
        let remedy = "move the bodies apart";
        members[0].boundary.section.error("E0083", "position_m", reason, remedy);
    }
}
