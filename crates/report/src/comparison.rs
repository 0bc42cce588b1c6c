//! Page of a comparison of methods or objectives for one maneuver, or of integrators for one
//! motion.
//!
//! The page is created from the JSON document of `slew compare --format json`. The document
//! contains neither motions nor errors over time; the page shows them only if the caller supplies
//! them.

use super::charts::{components, shown, time_axis};
use super::page::{Content, Words, written};
use super::summary::Tone;
use super::words::Table;
use super::{INPUT_KEYS, Shown, line};
use crate::draw::{Axis, Chart, Curve};
use crate::studies::clock::THREAD_TIME;
use crate::studies::integrators::figures::charts;
use crate::studies::integrators::{
    EQUAL, EqualError, History, IntegratorRun, Path, RUNS, Study, WorkPrecision, equal_row, run_row,
};
use serde::Deserialize;
use serde_json::Value;
use slewkit::lie;
use slewkit::maneuver::{TerminalError, Trajectory};
use slewkit::numerics::figures::{error, short, significant, time};
use slewkit::propagate::integrator::{ErrorControl, Kind};
use slewkit_files::export::ExportError;
use std::io::{BufReader, Read};

/// Data of a comparison that its page uses: the JSON document, and data that only the caller has.
#[derive(Clone, Debug, Deserialize)]
pub struct ComparisonFile {
    name: String,
    status: String,
    #[serde(flatten)]
    compared: Compared,
    /// Motion of each compared method that found a plan.
    #[serde(skip)]
    pub motions: Vec<Motion>,
    /// Names of the inputs, in the order of the rows of a motion. If the list is empty, pictures
    /// number the inputs.
    #[serde(skip)]
    pub inputs: Vec<String>,
    /// Errors of each integrator over time, all with the same step.
    #[serde(skip)]
    pub histories: Vec<History>,
}

/// Motion that one of the compared methods planned.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Name of the method.
    pub name: String,
    /// Trajectory of the plan.
    pub trajectory: Trajectory,
    /// True if the inputs are held constant over each step.
    pub held: bool,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "compares", rename_all = "snake_case")]
enum Compared {
    Methods {
        scheme: String,
        steps: usize,
        step_s: f64,
        methods: Vec<MethodRow>,
        agreement: AgreementRow,
    },
    Objectives {
        objectives: Vec<ObjectiveRow>,
    },
    Integrators {
        integrators: Vec<String>,
        steps_s: Vec<f64>,
        horizons_s: Vec<f64>,
        energy_scale_j: f64,
        levels: Vec<f64>,
        runs: Vec<IntegratorRun>,
        equal_error: Vec<EqualError>,
    },
}

#[derive(Clone, Debug, Deserialize)]
struct MethodRow {
    method: String,
    status: String,
    reason: Option<String>,
    cost: Option<f64>,
    terminal: Option<TerminalError>,
    stationarity: Option<f64>,
    conjugate_points: Option<usize>,
    turned_deg: Option<f64>,
    subproblems: Option<usize>,
    newton_iterations: usize,
    solve_time_s: f64,
}

#[derive(Clone, Debug, Deserialize)]
struct AgreementRow {
    cost: Option<f64>,
    duals_before_polish: Option<f64>,
    duals_after_polish: Option<f64>,
}

#[derive(Clone, Debug, Deserialize)]
struct ObjectiveRow {
    minimises: String,
    status: Option<String>,
    reason: Option<String>,
    duration_s: Option<f64>,
    effort: Option<f64>,
    fuel: Option<f64>,
    switches: Option<usize>,
    gap: Option<f64>,
    solve_time_s: f64,
}

impl ComparisonFile {
    /// Reads the JSON document of a comparison.
    ///
    /// # Errors
    /// Returns an error of the stream, or of a text that is not a comparison.
    pub fn read(input: impl Read) -> Result<Self, ExportError> {
        Ok(serde_json::from_reader(BufReader::new(input))?)
    }

    /// Builds the data of the page from a parsed JSON document.
    ///
    /// # Errors
    /// Returns an error for a document that is not a comparison.
    pub fn of(document: Value) -> Result<Self, ExportError> {
        Ok(serde_json::from_value(document)?)
    }
}

/// Returns the page of a comparison.
pub fn comparison_page(file: &ComparisonFile) -> String {
    let shown = comparison_pictures(file);
    let nodes = file.motions.iter().map(|motion| motion.trajectory.time.len()).max().unwrap_or(0);
    let missing = shown.is_empty().then(|| {
        let reason =
            "The document of a comparison has no motion: `slew compare SPEC --report FILE.html` shows it.";
        ("compared", reason.to_string())
    });
    written(&Content {
        name: &file.name,
        words: &words(file),
        tiles: Vec::new(),
        proved: vec![proved(file).into()],
        shown,
        missing: missing.into_iter().collect(),
        grouped: None,
        tables: tables(file),
        body: Value::Null,
        nodes,
    })
}

/// Returns the pictures of a comparison.
pub fn comparison_pictures(file: &ComparisonFile) -> Vec<Shown> {
    let mut all = Vec::new();
    for (key, motion) in INPUT_KEYS.into_iter().zip(&file.motions) {
        all.push(inputs(key, motion, &file.inputs));
    }
    if !file.motions.is_empty() {
        all.push(turning(&file.motions));
        all.extend(difference(file));
    }
    if let Some((study, found)) = study(file) {
        let charts = charts(&file.name, &study, &found);
        all.extend(charts.into_iter().map(|(key, chart)| shown(key, chart, "")));
    }
    all
}

/// Returns the chart of the inputs of one motion.
fn inputs(key: &'static str, motion: &Motion, names: &[String]) -> Shown {
    let trajectory = &motion.trajectory;
    let count = trajectory.input_count;
    let rows = trajectory.torque.len();
    let node = trajectory.time.len() - rows;
    let curve = |input: usize| {
        let values = (0..rows).map(|row| trajectory.inputs(row)[input]);
        let name = names.get(input).cloned().unwrap_or_else(|| format!("input {}", input + 1));
        if motion.held {
            let time: Vec<f64> = trajectory.time.windows(2).flatten().copied().collect();
            line(name, input, &time, values.flat_map(|value| [value, value]))
        } else {
            line(name, input, &trajectory.time[node..], values)
        }
    };
    let title = format!("Inputs: {}", motion.name);
    shown(key, Chart::new(title, time_axis(), Axis::linear("input, SI"), (0..count).map(curve).collect()), "")
}

/// Returns the chart of the angular rate in each motion.
fn turning(motions: &[Motion]) -> Shown {
    let degrees = 1.0_f64.to_degrees();
    let curve = |(style, motion): (usize, &Motion)| {
        let rates = &motion.trajectory.angular_velocity;
        let norm = components(&motion.trajectory.time, rates, "Ω", degrees, true).pop();
        norm.map(|curve| Curve { name: motion.name.clone(), style, ..curve })
    };
    let curves = motions.iter().enumerate().filter_map(curve).collect();
    let chart = Chart::new("Angular velocity, norm", time_axis(), Axis::linear("|Ω|, deg/s"), curves);
    shown("turning", chart, "")
}

/// Returns the chart of the angle between the attitude of each method and the attitude of the first
/// method; `None` if the comparison does not concern methods.
fn difference(file: &ComparisonFile) -> Option<Shown> {
    let (first, others) = file.motions.split_first()?;
    if !matches!(file.compared, Compared::Methods { .. }) || others.is_empty() {
        return None;
    }
    let attitudes = |motion: &Motion| -> Vec<_> {
        motion.trajectory.quaternion.iter().map(lie::rotation_from_quaternion).collect()
    };
    let of_first = attitudes(first);
    let curve = |(style, motion): (usize, &Motion)| {
        let apart: Vec<f64> = attitudes(motion)
            .iter()
            .zip(&of_first)
            .map(|(attitude, first)| lie::minus(attitude, first).norm().to_degrees())
            .collect();
        line(motion.name.clone(), style + 1, &motion.trajectory.time, apart.into_iter())
    };
    let curves = others.iter().enumerate().map(curve).collect();
    let axis = Axis::logarithmic("angle, deg");
    let chart = Chart::new(format!("Attitude differences from {}", first.name), time_axis(), axis, curves);
    Some(shown("difference", chart, ""))
}

/// Rebuilds the study of integrators from the JSON document; `None` if the comparison does not
/// concern integrators.
fn study(file: &ComparisonFile) -> Option<(Study, WorkPrecision)> {
    let Compared::Integrators { integrators, steps_s, horizons_s, energy_scale_j, levels, runs, equal_error } =
        &file.compared
    else {
        return None;
    };
    let kinds: Vec<Kind> = integrators.iter().filter_map(|name| name.parse().ok()).collect();
    let shown_step = file.histories.first().map_or(f64::NAN, |history| history.step);
    let study = Study {
        kinds,
        steps: steps_s.clone(),
        horizons: horizons_s.clone(),
        levels: levels.clone(),
        shown_step,
        settings: ErrorControl::default(),
        repeats: 1,
    };
    let found = WorkPrecision {
        energy_scale_j: *energy_scale_j,
        levels: levels.clone(),
        runs: runs.clone(),
        equal_error: equal_error.clone(),
        histories: file.histories.clone(),
        path: Path::default(),
        interrupted: false,
    };
    Some((study, found))
}

fn proved(file: &ComparisonFile) -> &'static str {
    match file.compared {
        Compared::Methods { .. } => {
            "No global minimum is proved: methods that agree reached one extremal by different methods."
        }
        Compared::Objectives { .. } => {
            "Each plan is an extremal of its own objective. The values of the other objectives are \
            measured, not bounded."
        }
        Compared::Integrators { .. } => {
            "The true motion is not computed: conserved quantities are compared with their initial values."
        }
    }
}

fn words(file: &ComparisonFile) -> Words {
    let label = |label: &str, text: String| (label.to_string(), text);
    let mut summary = Vec::new();
    let what = match &file.compared {
        Compared::Methods { scheme, steps, step_s, methods, agreement } => {
            summary.push(label("problem", format!("{steps} {scheme} steps of {} s", short(*step_s))));
            let parts = [
                ("costs", agreement.cost, "apart, relative"),
                (
                    "duals",
                    agreement.duals_before_polish,
                    "difference from the shooting's costates, of the largest",
                ),
                ("", agreement.duals_after_polish, "after polish"),
            ];
            let parts = parts.into_iter().filter_map(|(name, value, of)| Some((name, value?, of)));
            summary.extend(parts.map(|(name, value, of)| label(name, format!("{} {of}", error(value)))));
            let reasons = methods.iter().filter_map(|run| Some((run.method.as_str(), run.reason.clone()?)));
            summary.extend(reasons.map(|(method, reason)| label(method, reason)));
            "methods"
        }
        Compared::Objectives { objectives } => {
            let measures = "duration in s; effort ∫ ½ uᵀWu dt; fuel ∫ Σ c |u| dt, or c ∫ |τ| dt under a \
                limit of the norm; SI, up to weights and prices";
            summary.push(label("measures", measures.into()));
            let reasons =
                objectives.iter().filter_map(|run| Some((run.minimises.as_str(), run.reason.clone()?)));
            summary.extend(reasons.map(|(name, reason)| label(name, reason)));
            "objectives"
        }
        Compared::Integrators { energy_scale_j, horizons_s, .. } => {
            let horizon = horizons_s.last().copied().unwrap_or(f64::NAN);
            summary.push(label("horizon", format!("{} s", short(horizon))));
            summary.push(label(
                "energy",
                format!("errors are relative to T₀ + |U₀| = {} J", short(*energy_scale_j)),
            ));
            summary.push(label("time", format!("{THREAD_TIME} of one thread, the least of several runs")));
            "integrators"
        }
    };
    let (verdict, tone) = match file.status.as_str() {
        "solved" | "compared" => (format!("{what} compared"), Tone::Good),
        other => (other.replace('_', " "), Tone::Note),
    };
    Words { verdict, tone, summary, details: Vec::new() }
}

fn tables(file: &ComparisonFile) -> Vec<Table> {
    let none = || "–".to_string();
    let figures = |value: Option<f64>, digits| value.map_or_else(none, |value| significant(value, digits));
    let small = |value: Option<f64>| value.map_or_else(none, error);
    let count = |value: Option<usize>| value.map_or_else(none, |value| value.to_string());
    match &file.compared {
        Compared::Methods { methods, .. } => {
            let row = |run: &MethodRow| {
                vec![
                    run.method.replace('_', " + "),
                    run.status.replace('_', " "),
                    figures(run.cost, 12),
                    small(run.terminal.map(|terminal| terminal.largest())),
                    small(run.stationarity),
                    count(run.conjugate_points),
                    figures(run.turned_deg, 5),
                    count(run.subproblems),
                    run.newton_iterations.to_string(),
                    time(run.solve_time_s),
                ]
            };
            vec![Table {
                title: "Methods",
                head: vec![
                    "method",
                    "",
                    "cost",
                    "terminal",
                    "stationarity",
                    "ways down",
                    "turned, deg",
                    "subproblems",
                    "Newton",
                    "time",
                ],
                rows: methods.iter().map(row).collect(),
                remark: "Each method solves one discrete problem. The time is the time of the solve, without \
                 the witnesses.",
            }]
        }
        Compared::Objectives { objectives } => {
            let row = |run: &ObjectiveRow| {
                vec![
                    run.minimises.clone(),
                    run.status.clone().unwrap_or("does not apply".into()).replace('_', " "),
                    figures(run.duration_s, 8),
                    figures(run.effort, 8),
                    figures(run.fuel, 8),
                    count(run.switches),
                    small(run.gap),
                    time(run.solve_time_s),
                ]
            };
            vec![Table {
                title: "Objectives",
                head: vec!["least", "", "duration, s", "effort", "fuel", "switches", "gap", "time"],
                rows: objectives.iter().map(row).collect(),
                remark: "Each plan measured by every objective: the value of each objective for each plan.",
            }]
        }
        Compared::Integrators { runs, equal_error, .. } => vec![
            Table {
                title: "Work at equal error",
                head: EQUAL.to_vec(),
                rows: equal_error.iter().map(equal_row).collect(),
                remark: "At one mean energy error, interpolated between steps; ratios are to the first \
                 method. ≤ and ≥: beyond the longest or the shortest step.",
            },
            Table {
                title: "Runs",
                head: std::iter::once("horizon, s").chain(RUNS.iter().copied()).collect(),
                rows: runs
                    .iter()
                    .map(|run| std::iter::once(short(run.horizon_s)).chain(run_row(run)).collect())
                    .collect(),
                remark: "Energy: mean and largest |E − E₀| relative to T₀ + |U₀|; RᵀR: mean ‖I − RᵀR‖.",
            },
        ],
    }
}
