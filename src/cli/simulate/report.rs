//! What a reader wants to know first: where it ended, what was conserved, and what it cost.

use super::record::Layout;
use crate::cli::console::{Console, Tone};
use crate::cli::number::{counted, error, significant, time};
use crate::cli::summary;
use serde::Serialize;
use slewkit::Vector3;
use slewkit::integrator::Facts;
use slewkit::simulate::{Row, Run};
use slewkit::spec::escape;

/// The largest errors over all rows.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Totals {
    /// `|E − E₀|` \[J\].
    energy_j: f64,
    /// `|ΔP|` [N·s].
    linear_momentum_n_s: f64,
    /// `|ΔL|` [N·m·s].
    angular_momentum_n_m_s: f64,
    /// `‖I − RᵀR‖`.
    orthogonality: f64,
}

/// What has been seen of the rows.
pub struct Seen {
    first: Row,
    last: Row,
    pub totals: Totals,
}

impl Seen {
    /// Bodies whose end is shown.
    const SHOWN: usize = 4;

    pub fn new(row: &Row) -> Self {
        Self { first: row.clone(), last: row.clone(), totals: Totals::default() }
    }

    pub fn note(&mut self, row: &Row) {
        self.last.clone_from(row);
        let (first, now) = (&self.first.invariants, &row.invariants);
        // Written so that a NaN stays.
        let raise = |worst: &mut f64, value: f64| *worst = if value <= *worst { *worst } else { value };
        raise(&mut self.totals.energy_j, (now.energy - first.energy).abs());
        let linear = now.linear_momentum - first.linear_momentum;
        raise(&mut self.totals.linear_momentum_n_s, linear.norm());
        let angular = now.angular_momentum - first.angular_momentum;
        raise(&mut self.totals.angular_momentum_n_m_s, angular.norm());
        raise(&mut self.totals.orthogonality, now.orthogonality);
    }

    /// The summary for people; `stopped`: after so many steps.
    pub fn summary(
        &self,
        console: &Console,
        layout: &Layout,
        run: Option<&Run>,
        stopped: Option<u64>,
    ) -> String {
        let duration = significant(layout.duration, 4);
        let (verdict, tone) = match stopped {
            None => (format!("{duration} s in {} steps", layout.steps), Tone::Good),
            Some(made) => {
                let reached = significant(self.last.time, 6);
                let steps = layout.steps;
                (format!("interrupted after {made} of {steps} steps, at t = {reached} s"), Tone::Note)
            }
        };
        let mut lines = vec![summary::headline(console, &layout.name, &verdict, tone)];
        let facts = run.map_or_else(String::new, |run| format!(": {}", in_words(&run.facts)));
        lines.push(summary::line("integrator", &format!("{}{facts}", layout.integrator)));
        let step = layout.duration / layout.steps as f64;
        lines.push(summary::line("step", &format!("{} s", significant(step, 4))));
        let several = layout.bodies.len() > 1;
        for (index, body) in self.last.bodies.iter().enumerate().take(Self::SHOWN) {
            let label = if index == 0 { "end" } else { "" };
            let of = if several { format!("{}: ", escape(&layout.bodies[index])) } else { String::new() };
            lines.push(summary::line(label, &format!("{of}quaternion_wxyz {}", list(&body.quaternion))));
            let rate: Vector3 = body.angular_velocity.map(f64::to_degrees);
            lines.push(summary::line("", &format!("angular_velocity_deg_s {}", list(rate.as_slice()))));
            if layout.moves[index] {
                lines.push(summary::line("", &format!("position_m {}", list(body.position.as_slice()))));
                lines.push(summary::line("", &format!("velocity_m_s {}", list(body.velocity.as_slice()))));
            }
        }
        if layout.bodies.len() > Self::SHOWN {
            lines.push(summary::line("", &format!("… {} bodies in all", layout.bodies.len())));
        }
        lines.extend(self.conserved(layout));
        if let Some(run) = run {
            let steps = run.work.steps.max(1);
            let (all, each) = (run.stepping.as_secs_f64(), run.stepping.as_secs_f64() / steps as f64);
            let each = if each < 1e-4 { format!("{} ns", significant(1e9 * each, 3)) } else { time(each) };
            let evaluations = counted(run.work.force_evaluations as usize, "force evaluation");
            lines.push(summary::line("work", &format!("{evaluations}; {}, {each} a step", time(all))));
        }
        lines.join("\n")
    }

    /// What is conserved, and how well.
    fn conserved(&self, layout: &Layout) -> Vec<String> {
        let start = &self.first.invariants;
        let Totals { energy_j, linear_momentum_n_s, angular_momentum_n_m_s, orthogonality } = self.totals;
        let changes = |value: f64, size: f64, unit: &str| {
            let relative =
                if size > 0.0 { format!(" ({} of it)", error(value / size)) } else { String::new() };
            format!("{unit} at the start, changes by at most {} {unit}{relative}", error(value))
        };
        let energy =
            format!("{} {}", significant(start.energy, 6), changes(energy_j, start.energy.abs(), "J"));
        let mut lines = vec![summary::line("energy", &energy)];
        if layout.moves.contains(&true) {
            let size = start.linear_momentum.norm();
            let linear = changes(linear_momentum_n_s, size, "N·s");
            lines.push(summary::line("momentum", &format!("linear {} {linear}", significant(size, 6))));
        }
        let size = start.angular_momentum.norm();
        let angular = changes(angular_momentum_n_m_s, size, "N·m·s");
        let label = if layout.moves.contains(&true) { "" } else { "momentum" };
        lines.push(summary::line(label, &format!("angular {} {angular}", significant(size, 6))));
        lines.push(summary::line("rotations", &format!("off by at most {}", error(orthogonality))));
        lines
    }
}

/// What theory says of a method.
fn in_words(facts: &Facts) -> String {
    let evaluations = match facts.force_evaluations {
        Some(count) => format!("{} a step", counted(count as usize, "force evaluation")),
        None => "as many force evaluations as it needs".into(),
    };
    let mut words = vec![format!("order {}", facts.order)];
    words.push(if facts.explicit { "explicit" } else { "implicit" }.into());
    let keeps = [
        (facts.symplectic, "symplectic"),
        (facts.preserves_momentum, "keeps momenta"),
        (facts.preserves_group, "keeps rotations"),
    ];
    words.extend(keeps.into_iter().filter(|(holds, _)| *holds).map(|(_, word)| word.to_string()));
    words.push(evaluations);
    words.join(", ")
}

fn list(values: &[f64]) -> String {
    let values: Vec<_> = values.iter().map(|value| significant(*value, 6)).collect();
    format!("[{}]", values.join(", "))
}
