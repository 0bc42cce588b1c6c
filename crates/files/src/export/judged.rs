//! A plan file before the witnesses: the plan, and the figures that the file tells of it.

use super::{ExportError, PlanFile};
use crate::spec::{Difference, SpecDocument};
use serde_json::Value;
use slewkit::maneuver::{Problem, Settings};
use slewkit::verify::{self, Accuracy, Check, Verification};

/// What the witnesses found of a plan file.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// The maneuver that it was judged by, on the grid of the plan.
    pub problem: Problem,
    /// What they found, with a check of every figure that the file tells.
    pub verification: Verification,
    /// Where the spec that the file holds is not the one that it was judged by: the file's value first.
    pub differences: Vec<Difference>,
}

/// Relative error that a recorded figure may have: that of sums in another order.
const RECORDED: f64 = 1e-9;

/// By how much the record of a figure of the witnesses may differ from the figure: relative, and beside that.
const TOLD: f64 = 1e-6;
const ROUND_OFF: f64 = 1e-9;

impl PlanFile<'_> {
    /// Has the witnesses judge the plan: whether it fulfils `problem`, to the tolerances of `settings`, on its own
    /// grid. They stop when `stop` says so, which is asked every few steps.
    ///
    /// # Errors
    /// Arrays that do not fit the maneuver.
    pub fn judge(
        &self,
        problem: &Problem,
        settings: &Settings,
        stop: &dyn Fn() -> bool,
    ) -> Result<Judgement, ExportError> {
        // The grid is the plan's own matter.
        let problem = self.on_grid(problem)?;
        let held = self.spec.as_ref();
        let judged_by = SpecDocument::new(&problem, settings).ok();
        let differences = held.zip(judged_by).map_or(Vec::new(), |(held, other)| held.differences(&other));
        let (trajectory, tolerance) = (&self.trajectory.0, settings.tolerance);
        let continuous = settings.continuous_limit();
        let mut verification = verify::verify_until(&problem, trajectory, tolerance, continuous, stop);
        let own = held.is_some() && differences.is_empty();
        let told = self.verified.as_ref().filter(|told| {
            // What was cut off tells nothing.
            own && !told.was_stopped() && !verification.was_stopped()
        });
        let as_found = told.is_none_or(|told| self.tells(told, &verification, &problem, settings));
        let sense = if own { verify::sense(&problem, trajectory, stop) } else { None };
        // The tolerance that the plan was made to is its own matter, whatever another spec asks for.
        let cost = verify::cost(&problem, trajectory);
        let made_to = held.and_then(|held| held.read("the plan's spec", &[]).ok());
        let made_to = made_to.map(|own| (self.tolerance, own.settings.tolerance));
        // Where inputs switch the plan has its duration, and steps of which the mean is told.
        let switches = problem.switches();
        let last = trajectory.time.last().copied().unwrap_or(f64::NAN);
        let duration = if switches { last } else { problem.duration };
        let step = if switches { duration / problem.steps as f64 } else { problem.step() };
        let recorded = [
            ("recorded cost", Some((self.cost, cost))),
            ("recorded duration", Some((self.duration_s, duration))),
            ("recorded step", Some((self.step_s, step))),
            ("recorded turn", Some((self.turned_deg, verify::swept(trajectory).to_degrees()))),
            ("recorded tolerance", made_to),
        ];
        for (name, (told, found)) in recorded.into_iter().filter_map(|(name, pair)| Some((name, pair?))) {
            let value = (told - found).abs() / found.abs().max(f64::MIN_POSITIVE);
            let passed = told == found || value <= RECORDED;
            verification.checks.push(Check { name: name.into(), value, limit: RECORDED, passed });
        }
        let told = [
            ("recorded status", self.is_coherent()),
            ("recorded findings", as_found),
            ("recorded sense", sense.is_none_or(|sense| sense == self.sense)),
        ];
        for (name, passed) in told {
            verification.checks.push(Check {
                name: name.into(),
                value: f64::from(u8::from(!passed)),
                limit: 0.0,
                passed,
            });
        }
        Ok(Judgement { problem, verification, differences })
    }

    /// Whether what the file tells of how the plan ended goes together.
    fn is_coherent(&self) -> bool {
        self.status.agrees_with(self.outcome, self.verified.as_ref())
            && self.exit_code == self.status.exit_code()
            && self.second_order == self.optimality.second_order()
    }

    /// Whether what the witnesses are recorded to have found, and the planner before them, is what they find: every verdict and every
    /// figure, of the witnesses that ran, the margins, and what follows from them.
    fn tells(
        &self,
        told: &Verification,
        found: &Verification,
        problem: &Problem,
        settings: &Settings,
    ) -> bool {
        let (terminal, discrete) = (&self.terminal, found.discrete());
        let ends = [
            (Some(terminal.attitude_rad), Some(discrete.attitude_rad)),
            (Some(terminal.momentum_relative), Some(discrete.momentum_relative)),
            (terminal.position_relative, discrete.position_relative),
            (terminal.linear_momentum_relative, discrete.linear_momentum_relative),
        ];
        let ends = ends.into_iter().all(|(told, found)| match (told, found) {
            (Some(told), Some(found)) => near(told, found, TOLD),
            (told, found) => told.is_none() && found.is_none(),
        });
        let accuracy = Accuracy::of(found, problem, settings.continuous_limit());
        let accuracy = self.accuracy.as_ref().is_some_and(|told| {
            let steps = match (told.steps, accuracy.steps) {
                // They are told to two digits, and round-off may be at the edge of one.
                (Some(told), Some(found)) => near(told as f64, found as f64, STEPS),
                (told, found) => told.is_none() && found.is_none(),
            };
            steps
                && near(told.continuous_attitude_deg, accuracy.continuous_attitude_deg, TOLD)
                && near(told.wanted_deg, accuracy.wanted_deg, TOLD)
        });
        let tree = |of: &Verification| serde_json::to_value(of).unwrap_or_default();
        ends && accuracy && alike(&tree(told), &tree(found))
    }
}

/// How far a recorded order of convergence may be from the one that is found: it is read off errors that come near round-off.
const ORDER: f64 = 0.01;
/// Relative difference of two numbers of steps of two digits each, one unit apart.
const STEPS: f64 = 0.1;
/// A limit that acts is met at many times alike: which of them is the one is round-off.
const ACTS: f64 = 1e-6;

/// Of another machine figures may differ by the round-off of a long motion.
fn near(told: f64, found: f64, relative: f64) -> bool {
    told.is_nan() && found.is_nan() || (told - found).abs() <= ROUND_OFF + relative * found.abs()
}

/// Whether two trees of figures tell the same.
fn alike(told: &Value, found: &Value) -> bool {
    match (told, found) {
        (Value::Number(told), Value::Number(found)) => {
            let number = |number: &serde_json::Number| number.as_f64().unwrap_or(f64::NAN);
            near(number(told), number(found), TOLD)
        }
        (Value::Array(told), Value::Array(found)) => {
            told.len() == found.len() && told.iter().zip(found).all(|(told, found)| alike(told, found))
        }
        (Value::Object(told), Value::Object(found)) => {
            let word = |key: &str| found.get(key).and_then(Value::as_str);
            let figure = |key: &str| found.get(key).and_then(Value::as_f64);
            let acts = figure("scaled").is_some_and(|scaled| scaled.abs() <= ACTS);
            told.len() == found.len()
                && found.iter().all(|(key, found)| {
                    let Some(told) = told.get(key) else { return false };
                    let of_order = key == "order" || (key == "value" && word("name") == Some("order"));
                    match (told.as_f64(), found.as_f64()) {
                        (Some(told), Some(found)) if of_order => (told - found).abs() <= ORDER,
                        _ if acts && matches!(key.as_str(), "time_s" | "at") => true,
                        _ => alike(told, found),
                    }
                })
        }
        _ => told == found,
    }
}
