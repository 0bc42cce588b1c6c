//! Makes and reads plans, and returns their contents as arrays.

use crate::failure::{self, detached};
use crate::maneuver::Maneuver;
use crate::watch::Watch;
use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use slewkit::assured::{self, Beside, NotKept};
use slewkit::maneuver::{Motion, Outcome, Problem, Settings, Trajectory};
use slewkit::plan::{self as planner, Guess, Plan};
use slewkit::uncertainty::Uncertainty;
use slewkit::{Vector3, lie};
use slewkit_files::exchange::Tables;
use slewkit_files::exchange::read_attitudes;
use slewkit_files::export::{ExportError, PlanFile, Target, TrajectoryDocument, read_guess};
use slewkit_files::flown::{FeedbackRecord, UncertaintyRecord, gains_alone, is_posed};
use slewkit_files::formats::Format;
use slewkit_files::identity::Identity;
use slewkit_files::spec::ClosedLoop;
use slewkit_report::draw::{Picture, panel};
use slewkit_report::{Shown, Subject, pictures, plan_page, summary};
use std::borrow::Cow;
use std::path::PathBuf;
use std::time::Instant;

/// A plan with its maneuver, on the grid of the plan.
#[pyclass(frozen, module = "slewkit._slewkit")]
pub struct Planned {
    pub problem: Problem,
    pub settings: Settings,
    pub identity: Identity,
    pub closed_loop: ClosedLoop,
    pub plan: Plan,
    /// Feedback gains along the plan; `None` if the spec does not request them.
    feedback: Option<FeedbackRecord>,
    /// Covariances along the plan; `None` if the spec states no uncertainty.
    uncertainty: Option<UncertaintyRecord>,
    /// Time spent in the library \[s\]; NaN for a plan that was read from a file.
    wall_time: f64,
}

/// Plans a maneuver. `guess` is a plan, the contents and the name of a plan file or an attitude
/// file, or costates. With `guess_alone`, no other start is tried if the guess leads to a plan.
/// `progress` is called with stage, start, steps and seconds. Also returns an exception that was
/// raised during the work.
#[pyfunction]
#[pyo3(signature = (maneuver, guess = None, guess_alone = false, progress = None))]
pub fn plan(
    py: Python<'_>,
    maneuver: &Bound<'_, Maneuver>,
    guess: Option<Suggestion<'_>>,
    guess_alone: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Planned, Option<PyErr>)> {
    let loaded = &maneuver.get().loaded;
    let (problem, settings, closed_loop) = (&loaded.problem, &loaded.settings, &loaded.closed_loop);
    let guess = guess.map(|guess| guess.taken(py, problem)).transpose()?;
    let guess = guess.map(|guess| if guess_alone { guess.alone() } else { guess });
    let mut watch = Watch::new(progress);
    let began = Instant::now();
    let found = detached(py, || {
        let found = match closed_loop.kept() {
            Some((uncertainty, kept)) => {
                let feedback = closed_loop.feedback;
                assured::plan(problem, settings, feedback, uncertainty, &kept, &mut watch)
                    .map(|(with, plan, margins)| (with, plan, Some(margins)))
            }
            None => planner::plan(problem, settings, guess.as_ref(), &mut watch)
                .map(|plan| (problem.clone(), plan, None))
                .map_err(NotKept::from),
        };
        (found, began.elapsed().as_secs_f64())
    });
    let (found, wall_time) = found?;
    let (with, plan, margins) = found.map_err(|error| failure::kept(py, &error))?;
    let problem = plan.solution.on_grid(&with);
    let (feedback, uncertainty) = detached(py, || {
        let gains = Some(&plan.solution.trajectory).filter(|_| plan.solution.outcome == Outcome::Converged);
        let gains = gains.and_then(|plan| gains_alone(&problem, plan, closed_loop)?.ok());
        let asked =
            closed_loop.is_asked() && !is_posed(&problem) && plan.solution.outcome == Outcome::Converged;
        let of = closed_loop.uncertainty.as_ref();
        let along = || Beside::along(&problem, &plan.solution.trajectory, closed_loop.feedback, of).ok();
        let beside = if asked { along() } else { None };
        let file = PlanFile::new(&problem, settings, &plan);
        let file = match &gains {
            Some(gains) => file.with_gains(&problem, gains, closed_loop),
            None => file.with_beside(&problem, beside.as_ref(), closed_loop, margins.as_ref()),
        };
        (file.feedback, file.uncertainty)
    })?;
    let (settings, identity) = (settings.clone(), loaded.identity.clone());
    let closed_loop = closed_loop.clone();
    let planned =
        Planned { problem, settings, identity, closed_loop, plan, feedback, uncertainty, wall_time };
    Ok((planned, watch.raised()))
}

/// An initial guess that the caller supplies for the search.
#[derive(FromPyObject)]
pub enum Suggestion<'py> {
    /// A plan, whose costates are the initial guess.
    Planned(Bound<'py, Planned>),
    /// Contents and name of a plan file or an attitude file.
    File(Vec<u8>, String),
    /// Costates at the start of the maneuver.
    Costates(Vec<f64>),
}

impl Suggestion<'_> {
    fn taken(self, py: Python<'_>, problem: &Problem) -> PyResult<Guess> {
        match self {
            Self::Planned(planned) => Ok(Guess::of(&planned.get().plan.solution, problem)),
            Self::Costates(costates) => Ok(Guess { costates, ..Guess::default() }),
            Self::File(bytes, name) => {
                if PlanFile::begins(&bytes) {
                    return read_guess(&bytes[..]).map_err(|error| failure::export(py, &error, &name));
                }
                let found = read_attitudes(&bytes[..], &name).map_err(|found| failure::spec(py, &found))?;
                Ok(Guess { quaternion: found.evenly(), ..Guess::default() })
            }
        }
    }
}

/// Reads a plan file from its bytes; `name` is its name in messages.
#[pyfunction]
pub fn read_plan(py: Python<'_>, bytes: &[u8], name: &str) -> PyResult<Planned> {
    let read = || -> Result<_, Failed> {
        let file = PlanFile::read(bytes)?;
        let held = file.spec.as_ref().ok_or(ExportError::NoSpec)?;
        let loaded = held.read(&format!("{name}, spec"), &[]).map_err(Failed::Spec)?;
        // A file whose contents were changed no longer counts as solved.
        let (file, _) = file.settled(&loaded);
        // A plan file without a trajectory states that the maneuver is infeasible.
        let has_rows = !file.trajectory.0.time.is_empty();
        let problem = if has_rows { file.on_grid(&loaded.problem)? } else { loaded.problem };
        let (settings, identity, closed_loop) = (loaded.settings, loaded.identity, loaded.closed_loop);
        let (feedback, uncertainty) = (file.feedback.clone(), file.uncertainty.clone());
        let plan = file.plan()?;
        let wall_time = f64::NAN;
        Ok(Planned { problem, settings, identity, closed_loop, plan, feedback, uncertainty, wall_time })
    };
    detached(py, read)?.map_err(|failed| match failed {
        Failed::Export(error) => failure::export(py, &error, name),
        Failed::Spec(found) => failure::spec(py, &found),
    })
}

/// Writes a page, completely or not at all, and replaces an existing file.
#[pyfunction]
pub fn write_page(py: Python<'_>, path: PathBuf, text: &str) -> PyResult<()> {
    let written = detached(py, || {
        let target = Target::new(&path, true)?;
        target.write(|output| Ok(output.write_all(text.as_bytes())?))
    })?;
    written.map_err(|error: ExportError| failure::export(py, &error, &path.to_string_lossy()))
}

/// Reason why a plan file cannot be used.
enum Failed {
    Export(ExportError),
    Spec(slewkit_files::spec::Diagnostics),
}

impl From<ExportError> for Failed {
    fn from(error: ExportError) -> Self {
        Self::Export(error)
    }
}

impl Planned {
    /// Builds the Python object of a plan, without gains and uncertainty.
    pub fn of(
        problem: Problem,
        settings: Settings,
        identity: Identity,
        closed_loop: ClosedLoop,
        plan: Plan,
    ) -> Self {
        let (feedback, uncertainty, wall_time) = (None, None, f64::NAN);
        Self { problem, settings, identity, closed_loop, plan, feedback, uncertainty, wall_time }
    }

    pub fn file(&self) -> PlanFile<'_> {
        let file = PlanFile::new(&self.problem, &self.settings, &self.plan).with_identity(&self.identity);
        file.with_records(self.feedback.clone(), self.uncertainty.clone(), &self.closed_loop)
    }

    /// Returns the numbers that `of` extracts from the uncertainty; an empty list if the spec
    /// states no uncertainty.
    fn assumed(&self, of: impl Fn(&Uncertainty) -> Vec<f64>) -> Vec<f64> {
        self.closed_loop.uncertainty.as_ref().map(of).unwrap_or_default()
    }

    fn trajectory(&self) -> &Trajectory {
        &self.plan.solution.trajectory
    }
}

fn flat(vectors: &[Vector3]) -> Vec<f64> {
    vectors.iter().flatten().copied().collect()
}

#[pymethods]
impl Planned {
    /// Returns the status, such as `"solved"`.
    #[getter]
    fn status(&self) -> &'static str {
        self.plan.status.name()
    }

    /// Returns the exit code of the status.
    #[getter]
    fn exit_code(&self) -> u8 {
        self.plan.status.exit_code()
    }

    /// Returns the name of the maneuver.
    #[getter]
    fn name(&self) -> &str {
        &self.problem.name
    }

    /// Returns the cost: the effort, the fuel, or the duration in seconds, according to the
    /// objective. NaN without a plan.
    #[getter]
    fn cost(&self) -> f64 {
        self.plan.solution.cost
    }

    /// Returns the duration in seconds; NaN if time is minimised and no plan was found.
    #[getter]
    fn duration(&self) -> f64 {
        self.plan.solution.duration(&self.problem)
    }

    /// Returns the number of steps of the plan.
    #[getter]
    fn steps(&self) -> usize {
        self.plan.solution.steps
    }

    /// Returns the elapsed time of the search alone, in seconds.
    #[getter]
    fn solve_time(&self) -> f64 {
        self.plan.solution.solve_time
    }

    /// Returns the elapsed time within the library, in seconds; NaN for a plan that was read from a
    /// file.
    #[getter]
    fn wall_time(&self) -> f64 {
        self.wall_time
    }

    /// Returns the index of the node of the first row of inputs, and whether a row acts over the
    /// step that begins at its node.
    #[getter]
    fn first_input(&self) -> (usize, bool) {
        let held = self.problem.switches();
        (if held { 0 } else { self.problem.scheme.first_input() }, held)
    }

    /// Returns whether the body translates in addition to its rotation.
    #[getter]
    fn moves(&self) -> bool {
        self.problem.motion == Motion::RigidBody
    }

    /// Returns the number of values in a row of inputs.
    #[getter]
    fn input_count(&self) -> usize {
        self.trajectory().input_count
    }

    /// Returns the number of inputs and of states of the gain matrix of a step; `None` without
    /// gains.
    #[getter]
    fn gain_shape(&self) -> Option<(usize, usize)> {
        let step = self.feedback.as_ref()?.gains.first()?;
        Some((step.len(), step.first()?.len()))
    }

    /// Returns the rows of the inertia matrix in body axes [kg·m²].
    #[getter]
    fn inertia(&self) -> [[f64; 3]; 3] {
        // The matrix is symmetric, so its columns are its rows.
        (*self.problem.body.inertia.j()).into()
    }

    /// Returns a quantity of the trajectory as a one-dimensional array, row after row. The array
    /// owns its numbers. Returns `None` for an unknown name.
    fn column<'py>(&self, py: Python<'py>, name: &str) -> Option<Bound<'py, PyArray1<f64>>> {
        let of = self.trajectory();
        let quaternions = |order: fn(&[f64; 4]) -> [f64; 4]| {
            of.quaternion.iter().map(order).collect::<Vec<_>>().into_flattened()
        };
        let numbers = match name {
            "time" => of.time.clone(),
            "quaternion_wxyz" => quaternions(|q| *q),
            "quaternion_xyzw" => quaternions(|[w, x, y, z]| [*x, *y, *z, *w]),
            "rotation_matrix" => {
                let rows = |q| <[[f64; 3]; 3]>::from(lie::rotation_from_quaternion(q).transpose());
                of.quaternion.iter().map(rows).collect::<Vec<_>>().into_flattened().into_flattened()
            }
            "angular_velocity" => flat(&of.angular_velocity),
            "position" => flat(&of.position),
            "velocity" => flat(&of.velocity),
            "input" => of.input.clone(),
            "torque" => flat(&of.torque),
            "force" => flat(&of.force),
            "wheel_momentum" => of.wheel_momentum.clone(),
            "costates" => of.costates.clone(),
            "gains" => {
                let gains = self.feedback.iter().flat_map(|feedback| &feedback.gains);
                gains.flatten().flatten().copied().collect()
            }
            "arc_gains" => {
                let arcs = self.feedback.iter().flat_map(|feedback| &feedback.arcs);
                arcs.flat_map(|arc| arc.gain).collect()
            }
            "arc_lengths" => {
                let arcs = self.feedback.iter().flat_map(|feedback| &feedback.arcs);
                arcs.map(|arc| arc.length_s).collect()
            }
            "covariance" => {
                let of = self.uncertainty.as_ref();
                let of = of.map(|all| all.closed_loop.as_ref().unwrap_or(&all.open_loop));
                of.iter().flat_map(|of| &of.covariance).flatten().copied().collect()
            }
            "start_covariance" => self.assumed(|of| of.start.iter().copied().collect()),
            "torque_noise" => self.assumed(|of| of.torque_noise.iter().copied().collect()),
            "sensor_noise" => self.assumed(|of| of.sensor_noise.iter().copied().collect()),
            _ => return None,
        };
        Some(PyArray1::from_vec(py, numbers))
    }

    /// Returns the names and standard deviations of the uncertain parameters; `None` if the spec
    /// states no uncertainty.
    #[getter]
    fn uncertain_parameters(&self) -> Option<Vec<(String, f64)>> {
        let of = self.closed_loop.uncertainty.as_ref()?;
        Some(of.parameters.iter().map(|(name, _, sigma)| (name.clone(), *sigma)).collect())
    }

    /// Returns the plan file without its trajectory, as JSON.
    fn head_json(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            let mut file = self.file();
            file.trajectory = TrajectoryDocument(Cow::Owned(Trajectory::default()));
            serde_json::to_string(&file)
        })?
        .map_err(|error| failure::export(py, &error.into(), "plan"))
    }

    /// Returns the plan as text in a format.
    #[pyo3(signature = (format = "json", margins = false))]
    fn text(&self, py: Python<'_>, format: &str, margins: bool) -> PyResult<Vec<u8>> {
        let format = self.format(py, Some(format), "")?;
        let tables = Tables { margins, ..Tables::default() };
        let mut text = Vec::new();
        let written =
            detached(py, || format.write(&self.file(), &self.problem, &self.identity, tables, &mut text))?;
        written.map_err(|error| failure::export(py, &error, "plan"))?;
        Ok(text)
    }

    /// Writes the plan to a file, completely or not at all. Without `format`, the ending of the
    /// file selects the format.
    #[pyo3(signature = (path, format = None, tick = None, margins = false, overwrite = false))]
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        format: Option<&str>,
        tick: Option<f64>,
        margins: bool,
        overwrite: bool,
    ) -> PyResult<()> {
        let tables = Tables { tick, margins };
        let ending = path.extension().map_or(String::new(), |ending| ending.to_string_lossy().into_owned());
        let format = self.format(py, format, &ending)?;
        let name = path.to_string_lossy().into_owned();
        let written = detached(py, || {
            Target::new(&path, overwrite).map_err(ExportError::from).and_then(|target| {
                target
                    .write(|output| format.write(&self.file(), &self.problem, &self.identity, tables, output))
            })
        })?;
        written.map_err(|error| failure::export(py, &error, &name))
    }

    /// Returns the HTML page of the plan.
    fn page(&self, py: Python<'_>, euler: &str) -> PyResult<String> {
        let euler = failure::sequence(euler)?;
        let Self { problem, settings, plan, identity, closed_loop, .. } = self;
        let margins = self.uncertainty.as_ref().and_then(|uncertainty| uncertainty.margins.as_ref());
        detached(py, || plan_page(problem, settings, plan, identity, (closed_loop, margins), euler))
    }

    /// Returns the name and the SVG text of every picture of `slew plot` that the plan has.
    fn pictures(&self, py: Python<'_>, euler: &str) -> PyResult<Vec<(&'static str, String)>> {
        let euler = failure::sequence(euler)?;
        let drawn = || self.shown(euler).iter().map(|shown| (shown.key, shown.picture.svg())).collect();
        detached(py, drawn)
    }

    /// Returns the named pictures in two columns as one SVG text. For an unknown name, the error
    /// lists the names that exist.
    fn panel(&self, py: Python<'_>, names: Vec<String>, euler: &str) -> PyResult<String> {
        let euler = failure::sequence(euler)?;
        let drawn = || {
            let shown = self.shown(euler);
            let find = |name: &String| {
                let found = shown.iter().find(|shown| shown.key == *name);
                found.map(|shown| &shown.picture).ok_or_else(|| {
                    let known: Vec<&str> = shown.iter().map(|shown| shown.key).collect();
                    format!("the plan has no picture {name:?}; its pictures are {}", known.join(", "))
                })
            };
            let chosen: Vec<&Picture> = names.iter().map(find).collect::<Result<_, _>>()?;
            Ok(panel(&chosen, 2))
        };
        detached(py, drawn)?.map_err(|reason: String| PyValueError::new_err(reason))
    }

    /// Returns the name of each input; an input without a name in the spec has its number.
    #[getter]
    fn input_names(&self) -> Vec<String> {
        let name = |index| self.identity.input(index).map_or((index + 1).to_string(), str::to_owned);
        (0..self.trajectory().input_count).map(name).collect()
    }

    /// Returns the summary that `slew plan` prints.
    fn summary(&self) -> String {
        summary::plan(false, &self.problem, &self.settings, &self.plan, &self.identity).join("\n")
    }
}

impl Planned {
    fn shown(&self, euler: &str) -> Vec<Shown> {
        let subject = Subject::new(&self.problem, &self.plan, &self.identity, euler);
        pictures(&subject.flown_with(&self.closed_loop))
    }

    fn format(&self, py: Python<'_>, named: Option<&str>, ending: &str) -> PyResult<Format> {
        let found = match named {
            Some(name) => Format::named(name),
            None => Format::of_ending(ending),
        };
        let known = || {
            let each = Format::ALL
                .iter()
                .map(|format| format!("{} (.{})", format.name(), format.endings().join(", .")));
            each.collect::<Vec<_>>().join(", ")
        };
        let format = found.ok_or_else(|| {
            let reason = match named {
                Some(name) => format!("no format is called {name:?}"),
                None => format!("no format has the ending {ending:?}"),
            };
            failure::coded(py, "FileError", "E0105", &reason, &format!("the formats are {}", known()))
        })?;
        if matches!(format, Format::Exchange(_)) && self.trajectory().time.is_empty() {
            let reason = format!("the format {} holds a trajectory, and the plan has none", format.name());
            return Err(failure::coded(py, "FileError", "E0108", &reason, "save it as .json"));
        }
        Ok(format)
    }
}
