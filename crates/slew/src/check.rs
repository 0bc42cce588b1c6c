//! `slew check`: checks the spec alone and reports all its errors together.

use super::{Console, Exit, Failure, Lines, ReportArgs, SpecArgs, Tone, memory, spec_file, summary};
use serde::Serialize;
use slewkit::maneuver::{Motion, Objective};
use slewkit::numerics::figures::{counted, significant};
use slewkit::plan::PeakMemory;
use slewkit::sequence::Ordering;
use slewkit_files::spec::{ClosedLoop, Diagnostic, Loaded, LoadedSequence, LoadedSimulation, Spec, escape};

/// Arguments of `slew check`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub spec: SpecArgs,
    #[command(flatten)]
    pub report: ReportArgs,
}

/// Runs `slew check` and returns its exit code.
pub fn run(args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    match spec_file::load(&args.spec.spec, &args.spec.reading, console)? {
        Spec::Maneuver(loaded) => maneuver(&loaded, args, console),
        Spec::Sequence(loaded) => sequence(&loaded, args, console),
        Spec::Simulation(loaded) => simulation(&loaded, args, console),
    }
}

/// Returns the verdict "valid" with the number of warnings, and its tone.
fn verdict(warnings: &[Diagnostic]) -> (String, Tone) {
    match warnings.len() {
        0 => ("valid".into(), Tone::Good),
        count => (format!("valid, {}", counted(count, "warning")), Tone::Note),
    }
}

#[derive(Serialize)]
struct BodyReport<'a> {
    name: &'a str,
    /// Mass of the body \[kg\]; `None` if the body only rotates.
    #[serde(skip_serializing_if = "Option::is_none")]
    mass_kg: Option<f64>,
    principal_moments_kg_m2: [f64; 3],
    /// Rows of the inertia matrix in body axes \[kg·m²\]. It refers to the center of mass or, under
    /// uniform gravity, to the pivot.
    inertia_kg_m2: [[f64; 3]; 3],
    #[serde(flatten)]
    solid: Option<SolidReport>,
}

/// Properties of a shape with faces; its vertices are relative to its center of mass.
#[derive(Serialize)]
struct SolidReport {
    faces: usize,
    volume_m3: f64,
    mass_center_m: [f64; 3],
}

fn simulation(loaded: &LoadedSimulation, args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let LoadedSimulation { simulation, warnings, solids, .. } = loaded;
    let (verdict, tone) = verdict(warnings);
    let bodies: Vec<BodyReport<'_>> = simulation
        .bodies
        .iter()
        .zip(simulation.system.bodies())
        .zip(solids)
        .map(|((name, body), solid)| BodyReport {
            name,
            mass_kg: body.mass,
            principal_moments_kg_m2: (*body.inertia.principal()).into(),
            // The matrix is symmetric, so its columns are its rows.
            inertia_kg_m2: (*body.inertia.j()).into(),
            solid: solid.map(|solid| SolidReport {
                faces: solid.faces,
                volume_m3: solid.volume,
                mass_center_m: solid.mass_center.into(),
            }),
        })
        .collect();
    let rows = simulation.steps.div_ceil(simulation.stride) + 1;
    let (duration, step) = (significant(simulation.duration, 4), significant(simulation.step(), 3));
    let steps = format!("{duration} s in {} steps of {step} s, {rows} rows", simulation.steps);
    let mut lines = vec![
        summary::headline(console, &simulation.name, &verdict, tone),
        summary::line("simulation", &steps),
        summary::line("integrator", simulation.kind.name()),
    ];
    for (index, body) in bodies.iter().enumerate().take(SHOWN) {
        let mass = body.mass_kg.map_or("only turns".into(), |mass| format!("{} kg", significant(mass, 6)));
        let moments = body.principal_moments_kg_m2.map(|moment| significant(moment, 6)).join(", ");
        let label = if index == 0 { "bodies" } else { "" };
        let text = format!("{}: {mass}, principal moments {moments} kg·m²", escape(body.name));
        lines.line(label, &text);
        lines.extend(body.solid.iter().flat_map(|solid| told(solid, &body.inertia_kg_m2)));
    }
    if bodies.len() > SHOWN {
        lines.line("", format!("… {} in all", bodies.len()));
    }
    console.say(&lines.join("\n"));
    let facts = simulation.kind.facts();
    args.report.print(&document! {
        status: "valid",
        exit_code: 0,
        name: &simulation.name,
        integrator: simulation.kind.name(),
        order: facts.order,
        symplectic: facts.symplectic,
        steps: simulation.steps,
        step_s: simulation.step(),
        duration_s: simulation.duration,
        rows: rows,
        bodies: &bodies,
        diagnostics: warnings,
    })?;
    Ok(Exit::Solved)
}

/// Returns two lines of the summary that describe a shape with faces.
fn told(solid: &SolidReport, inertia: &[[f64; 3]; 3]) -> [String; 2] {
    let list =
        |values: &[f64]| values.iter().map(|value| significant(*value, 6)).collect::<Vec<_>>().join(", ");
    let SolidReport { faces, volume_m3, mass_center_m } = solid;
    let (volume, center) = (significant(*volume_m3, 6), list(mass_center_m));
    let rows = inertia.map(|row| format!("[{}]", list(&row))).join(", ");
    [
        summary::line(
            "",
            &format!("  {faces} faces, {volume} m³, mass center [{center}] m as the vertices are given"),
        ),
        summary::line("", &format!("  inertia [{rows}] kg·m²")),
    ]
}

fn maneuver(loaded: &Loaded, args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let Loaded { problem, settings, warnings, .. } = loaded;
    problem.check().map_err(super::plan::invalid)?;
    let (verdict, tone) = verdict(warnings);
    let moves = match problem.motion {
        Motion::Attitude => "attitude",
        Motion::RigidBody => "position and attitude",
    };
    let moves =
        if problem.ends_in_any_attitude() { format!("{moves}, any at the end") } else { moves.into() };
    let grid = problem.duration.known().map(|duration| (duration, problem.step()));
    let duration = if let Some((duration, step)) = grid {
        let (duration, step) = (significant(duration, 4), significant(step, 3));
        format!("{duration} s in {} steps of {step} s", problem.steps)
    } else {
        let sought = if problem.objective == Objective::Time { "shortest" } else { "best" };
        let longest = problem.duration.at_most();
        let longest = longest.map(|longest| format!(" up to {} s", significant(longest, 4)));
        format!("{sought} duration{}, {} steps", longest.unwrap_or_default(), problem.steps)
    };
    let inputs = problem.actuation.count();
    let wheels = problem.actuation.wheels.as_ref().map_or(0, |wheels| wheels.momentum.len());
    let of_wheels = if wheels > 0 { ", each the torque of a reaction wheel" } else { "" };
    let mut lines = vec![
        summary::headline(console, &problem.name, &verdict, tone),
        summary::line("maneuver", &format!("{moves}, {duration}")),
        summary::line("inputs", &format!("{inputs}{of_wheels}")),
    ];
    let limits: Vec<_> = problem.actuation.limits().map(|limit| limit.name).collect();
    let constraints: Vec<&str> =
        problem.constraints.iter().map(|constraint| constraint.name.as_str()).collect();
    if !limits.is_empty() {
        lines.line("limits", limits.join(", "));
    }
    if !constraints.is_empty() {
        lines.line("constraints", escape(&listed(&constraints)));
    }
    for of in &problem.alternatives {
        let sets: Vec<String> = of.sets.iter().map(|set| set.join(" and ")).collect();
        lines.line("in turns", escape(&format!("{}: {}", of.name, sets.join(", or "))));
    }
    if let Some(text) = flight(&loaded.closed_loop) {
        lines.line("flight", text);
    }
    if let Some(dispersion) = &loaded.dispersion {
        let keys: Vec<&str> = dispersion.varied.iter().map(|varied| varied.key.as_str()).collect();
        let cases = counted(dispersion.cases as usize, "case");
        lines.line("dispersion", escape(&format!("{}, {cases}, for `slew monte-carlo`", listed(&keys))));
    }
    let memory = PeakMemory::of(problem, settings);
    lines.line("memory", memory::told(memory));
    console.say(&lines.join("\n"));
    memory::warn(problem, settings, console);
    args.report.print(&document! {
        status: "valid",
        exit_code: 0,
        name: &problem.name,
        steps: problem.steps,
        step_s: grid.map(|(_, step)| step),
        duration_s: grid.map(|(duration, _)| duration),
        inputs: inputs,
        wheels: wheels,
        limits: &limits,
        constraints: &constraints,
        flight: loaded.closed_loop.sections().map(|name| format!("[{name}]")).collect::<Vec<_>>(),
        dispersion: loaded.dispersion.as_ref().map(|dispersion| dispersion.varied.len()),
        memory_bytes: memory.likely,
        memory_bytes_at_most: memory.most,
        diagnostics: warnings,
    })?;
    Ok(Exit::Solved)
}

/// Describes the sections for simulated flights that the spec has, and the number of its chance
/// constraints. Returns `None` if the spec has neither.
fn flight(closed_loop: &ClosedLoop) -> Option<String> {
    let sections: Vec<String> = closed_loop.sections().map(|name| format!("[{name}]")).collect();
    let chances = match closed_loop.chances.len() {
        0 => String::new(),
        count => format!("; {} of limits", counted(count, "chance")),
    };
    (!sections.is_empty()).then(|| format!("{}, for `slew fly`{chances}", sections.join(", ")))
}

fn sequence(loaded: &LoadedSequence, args: &Args, console: &mut Console) -> Result<Exit, Failure> {
    let LoadedSequence { sequence, settings, warnings, .. } = loaded;
    let (verdict, tone) = verdict(warnings);
    let craft = &sequence.craft;
    let names: Vec<&str> = sequence.stops.iter().map(|stop| stop.name.as_str()).collect();
    let order = match sequence.order {
        Ordering::Given => "in the given order",
        Ordering::Free => "in the best order",
        Ordering::FreeBeforeLast => "in the best order before the last one",
    };
    let rests: f64 = sequence.stops.iter().map(|stop| stop.visit.rest()).sum();
    let duration = match craft.duration.known() {
        Some(duration) => format!("{} s in all", significant(duration, 4)),
        None => format!("{} duration", if craft.objective == Objective::Time { "shortest" } else { "best" }),
    };
    let mut lines = vec![
        summary::headline(console, &craft.name, &verdict, tone),
        summary::line("sequence", &format!("{}, {order}", counted(names.len(), "stop"))),
        summary::line("stops", &escape(&listed(&names))),
        summary::line("duration", &format!("{duration}, {} s at stops", significant(rests, 4))),
        summary::line("legs", &format!("{}, of {} steps each", craft.objective.name(), craft.steps)),
    ];
    if let Some(text) = flight(&loaded.closed_loop) {
        lines.line("flight", text);
    }
    let memory = PeakMemory::of(craft, settings);
    lines.line("memory", memory::told(memory));
    console.say(&lines.join("\n"));
    args.report.print(&document! {
        status: "valid",
        exit_code: 0,
        name: &craft.name,
        steps: craft.steps,
        duration_s: craft.duration.known(),
        stops: &names,
        rests_s: rests,
        diagnostics: warnings,
    })?;
    Ok(Exit::Solved)
}

/// Largest number of names that a line of the summary lists.
const SHOWN: usize = 6;

fn listed(names: &[&str]) -> String {
    let more = if names.len() > SHOWN { format!(", … {} in all", names.len()) } else { String::new() };
    format!("{}{more}", names[..names.len().min(SHOWN)].join(", "))
}
