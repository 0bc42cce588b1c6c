//! A plan file before the witnesses: the plan, and the figures that the file tells of it.

use super::{ExportError, PlanFile};
use crate::spec::{Difference, SpecDocument};
use slewkit::maneuver::{Problem, Settings};
use slewkit::verify::{self, Check, Verification};

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
        let as_found = told.is_none_or(|told| self.tells(told, &verification));
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

    /// Whether what the witnesses are recorded to have found, and the planner before them, is what they find: every verdict, and the
    /// figures of the plan as a whole.
    fn tells(&self, told: &Verification, found: &Verification) -> bool {
        // Of another machine they may differ by the round-off of a long motion.
        let near = |(told, found): (f64, f64)| {
            told.is_nan() && found.is_nan() || (told - found).abs() <= ROUND_OFF + TOLD * found.abs()
        };
        let verdicts = |of: &Verification| -> Vec<(String, bool)> {
            of.checks.iter().map(|check| (check.name.clone(), check.passed)).collect()
        };
        let (terminal, discrete) = (&self.terminal, found.discrete());
        let pairs = figures(told).into_iter().zip(figures(found));
        let margins =
            told.margins.iter().zip(&found.margins).map(|(told, found)| (told.scaled, found.scaled));
        let ends = [
            (terminal.attitude_rad, discrete.attitude_rad),
            (terminal.momentum_relative, discrete.momentum_relative),
        ];
        verdicts(told) == verdicts(found)
            && told.margins.len() == found.margins.len()
            && pairs.chain(margins).chain(ends).all(near)
    }
}

fn figures(of: &Verification) -> [f64; 10] {
    [
        of.discrete_attitude_rad,
        of.discrete_momentum_relative,
        of.continuous_attitude_rad,
        of.continuous_rate_rad_s,
        of.interpolated_attitude_rad,
        of.interpolated_rate_rad_s,
        of.continuous_position_m.unwrap_or(0.0),
        of.continuous_velocity_m_s.unwrap_or(0.0),
        of.peak_torque_n_m,
        of.peak_rate_rad_s,
    ]
}
