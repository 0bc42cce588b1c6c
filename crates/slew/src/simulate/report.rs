//! Summary of a simulation: the final state, the conserved quantities, and the amount of
//! computation.

use super::layout::Layout;
use crate::{Console, Exit, Lines, Tone, headline};
use serde::Serialize;
use slewkit::Vector3;
use slewkit::mechanics::Symmetry;
use slewkit::numerics::figures::{counted, error, significant, time};
use slewkit::propagate::integrator::Facts;
use slewkit::propagate::simulate::{Run, SimulationRow};
use slewkit_files::spec::escape;

/// Largest errors of the conserved quantities over all rows. The errors between rows may be larger.
/// The value for a quantity that is not conserved is `None`.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Totals {
    /// Largest energy error `|E − E₀|` \[J\].
    #[serde(skip_serializing_if = "Option::is_none")]
    energy_j: Option<f64>,
    /// Largest error of the linear momentum, `|ΔP|` \[N·s\].
    #[serde(skip_serializing_if = "Option::is_none")]
    linear_momentum_n_s: Option<f64>,
    /// Largest error of the angular momentum, `|ΔL|` \[N·m·s\].
    #[serde(skip_serializing_if = "Option::is_none")]
    angular_momentum_n_m_s: Option<f64>,
    /// Largest error of the angular momentum about the axis d, `|Δ(d·L)|` \[N·m·s\]; `None` unless
    /// only this component is conserved.
    #[serde(skip_serializing_if = "Option::is_none")]
    angular_momentum_about_axis_n_m_s: Option<f64>,
    /// Unit vector along the axis d in the reference frame; `None` unless only the angular momentum
    /// about d is conserved.
    #[serde(skip_serializing_if = "Option::is_none")]
    axis: Option<[f64; 3]>,
    /// Largest orthogonality error `‖I − RᵀR‖` of the attitudes.
    orthogonality: f64,
}

impl Totals {
    fn new(layout: &Layout) -> Self {
        let zero = |conserved: bool| conserved.then_some(0.0);
        let axis = match layout.symmetry {
            Symmetry::About(axis) => Some(axis.into()),
            _ => None,
        };
        Self {
            energy_j: zero(layout.keeps_energy),
            linear_momentum_n_s: zero(layout.symmetry == Symmetry::All && layout.moves.contains(&true)),
            angular_momentum_n_m_s: zero(matches!(layout.symmetry, Symmetry::Turns | Symmetry::All)),
            angular_momentum_about_axis_n_m_s: zero(axis.is_some()),
            axis,
            orthogonality: 0.0,
        }
    }
}

/// First row, last row, and largest errors of the rows recorded so far.
pub struct Seen {
    first: SimulationRow,
    last: SimulationRow,
    pub totals: Totals,
}

impl Seen {
    /// Largest number of bodies whose final state the summary shows.
    const SHOWN: usize = 4;

    pub fn new(row: &SimulationRow, layout: &Layout) -> Self {
        Self { first: row.clone(), last: row.clone(), totals: Totals::new(layout) }
    }

    pub fn note(&mut self, row: &SimulationRow) {
        self.last.clone_from(row);
        let (first, now) = (&self.first.invariants, &row.invariants);
        let totals = &mut self.totals;
        // Unlike `f64::max`, the comparison preserves NaN.
        let raise = |worst: &mut f64, value: f64| *worst = if value <= *worst { *worst } else { value };
        let raise_if = |worst: &mut Option<f64>, value: f64| {
            if let Some(worst) = worst {
                raise(worst, value);
            }
        };
        raise_if(&mut totals.energy_j, (now.energy - first.energy).abs());
        let linear = now.linear_momentum - first.linear_momentum;
        raise_if(&mut totals.linear_momentum_n_s, linear.norm());
        let angular = now.angular_momentum - first.angular_momentum;
        raise_if(&mut totals.angular_momentum_n_m_s, angular.norm());
        let about = totals.axis.map_or(0.0, |axis| angular.dot(&Vector3::from(axis)).abs());
        raise_if(&mut totals.angular_momentum_about_axis_n_m_s, about);
        raise(&mut totals.orthogonality, now.orthogonality);
    }

    /// Returns the lines of the summary. `stopped` contains the exit code and the number of steps
    /// of a run that ended early.
    pub fn summary(
        &self,
        console: &Console,
        layout: &Layout,
        run: Option<&Run>,
        stopped: Option<(Exit, u64)>,
    ) -> String {
        let duration = significant(layout.duration, 4);
        let (verdict, tone) = match stopped {
            None => (format!("{duration} s in {} steps", layout.steps), Tone::Good),
            Some((exit, made)) => {
                let reached = significant(self.last.time, 6);
                let steps = layout.steps;
                let (why, tone) = match exit {
                    Exit::NotFinite => ("no longer finite", Tone::Bad),
                    _ => ("interrupted", Tone::Note),
                };
                (format!("{why} after {made} of {steps} steps, at t = {reached} s"), tone)
            }
        };
        let mut lines = vec![headline(console, &layout.name, &verdict, tone)];
        let facts =
            run.map_or_else(String::new, |run| format!(": {}", in_words(&run.facts, layout.symmetry)));
        lines.line("integrator", format!("{}{facts}", layout.integrator));
        let step = layout.duration / layout.steps as f64;
        lines.line("step", format!("{} s", significant(step, 4)));
        let several = layout.bodies.len() > 1;
        for (index, body) in self.last.bodies.iter().enumerate().take(Self::SHOWN) {
            let label = if index == 0 { "end" } else { "" };
            let of = if several { format!("{}: ", escape(&layout.bodies[index])) } else { String::new() };
            lines.line(label, format!("{of}quaternion_wxyz {}", list(&body.quaternion)));
            let rate: Vector3 = body.angular_velocity.map(f64::to_degrees);
            lines.line("", format!("angular_velocity_deg_s {}", list(rate.as_slice())));
            if layout.moves[index] {
                lines.line("", format!("position_m {}", list(body.position.as_slice())));
                lines.line("", format!("velocity_m_s {}", list(body.velocity.as_slice())));
            }
        }
        if layout.bodies.len() > Self::SHOWN {
            lines.line("", format!("… {} bodies in all", layout.bodies.len()));
        }
        lines.extend(self.conserved(layout));
        if let Some(run) = run {
            let steps = run.work.steps.max(1);
            let (all, each) = (run.stepping.as_secs_f64(), run.stepping.as_secs_f64() / steps as f64);
            let each = if each < 1e-4 { format!("{} ns", significant(1e9 * each, 3)) } else { time(each) };
            let evaluations = counted(run.work.force_evaluations as usize, "force evaluation");
            lines.line("work", format!("{evaluations}; {}, {each} a step", time(all)));
        }
        lines.join("\n")
    }

    /// Describes the conserved quantities and their largest errors in the rows.
    fn conserved(&self, layout: &Layout) -> Vec<String> {
        let (start, totals) = (&self.first.invariants, &self.totals);
        let value = |value: f64, size: f64, unit: &str, change: Option<f64>| {
            let start = format!("{} {unit} at the start", significant(value, 6));
            let relative = |change| {
                if size > 0.0 { format!(" ({} of it)", error(change / size)) } else { String::new() }
            };
            match change {
                Some(change) => {
                    format!(
                        "{start}; at the rows off by at most {} {unit}{}",
                        error(change),
                        relative(change)
                    )
                }
                None => format!("{start}; not conserved"),
            }
        };
        let energy = value(start.energy, start.energy.abs(), "J", totals.energy_j);
        let mut lines = Vec::new();
        lines.line("energy", energy);
        let moves = layout.moves.contains(&true);
        if moves {
            let size = start.linear_momentum.norm();
            let linear = value(size, size, "N·s", totals.linear_momentum_n_s);
            lines.line("momentum", format!("linear {linear}"));
        }
        let size = start.angular_momentum.norm();
        let angular = match totals.axis {
            Some(axis) => {
                let along = start.angular_momentum.dot(&Vector3::from(axis));
                let change = totals.angular_momentum_about_axis_n_m_s;
                format!("angular, about {}: {}", list(&axis), value(along, along.abs(), "N·m·s", change))
            }
            None => format!("angular {}", value(size, size, "N·m·s", totals.angular_momentum_n_m_s)),
        };
        lines.line(if moves { "" } else { "momentum" }, &angular);
        lines.line("rotations", format!("at the rows off by at most {}", error(totals.orthogonality)));
        lines
    }
}

/// Describes the theoretical properties of a method.
fn in_words(facts: &Facts, symmetry: Symmetry) -> String {
    let evaluations = match facts.force_evaluations {
        Some(count) => format!("{} a step", counted(count as usize, "force evaluation")),
        None => "a variable number of force evaluations".into(),
    };
    let mut words = vec![format!("order {}", facts.order)];
    words.push(if facts.explicit { "explicit" } else { "implicit" }.into());
    let keeps =
        if matches!(symmetry, Symmetry::All) { "keeps momenta" } else { "keeps the conserved momentum" };
    let keeps = [
        (facts.symplectic, "symplectic"),
        (facts.preserves_momentum && symmetry != Symmetry::None, keeps),
        (facts.preserves_group, "keeps rotations"),
    ];
    words.extend(keeps.into_iter().filter(|(holds, _)| *holds).map(|(_, word)| word.to_string()));
    words.push(evaluations);
    words.join(", ")
}

fn list(values: &[f64]) -> String {
    // Adding 0 avoids the text "-0".
    let values: Vec<_> = values.iter().map(|value| significant(value + 0.0, 6)).collect();
    format!("[{}]", values.join(", "))
}
