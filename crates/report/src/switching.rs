//! The chart of the switching functions and the arcs of minimum-time and minimum-fuel plans.
//!
//! The maximum principle minimises the Hamiltonian over the inputs. Each input is therefore at the
//! limit opposite in sign to its switching function σ, or off:
//!
//! ```text
//! time            σ_j = ū_j b_j·λ^Π        u_j = −ū_j sign σ_j ,   a thruster ū_j where σ_j < 0
//! fuel            σ_j = b_j·λ^Π / c_j      u_j = −ū_j sign σ_j where |σ_j| > 1 ,   a thruster where σ_j < −1
//! norm, time      σ   = U |λ^Π|            τ = −U λ^Π/|λ^Π|
//! norm, fuel      σ   = |λ^Π| / c          the same where σ > 1 , else 0
//! ```
//!
//! with input axes b, limits ū of each input and U of the norm, prices c, and the costate λ^Π of
//! the angular momentum. The switching functions of minimum-time plans (first and third line) are
//! the reduction of the duration per second of the input \[s/s\].

use super::arcs::arcs;
use super::charts::{shown, time_axis};
use super::{Shown, Subject, line};
use crate::draw::{Axis, Chart, Level};
use slewkit::Vector3;

/// Returns the chart of the switching functions; `None` if the plan is not bang-bang, or has
/// constraints.
pub(super) fn chart(subject: &Subject) -> Option<Shown> {
    let (problem, trajectory) = (subject.problem, subject.trajectory());
    subject.plan.solution.switching.as_ref()?;
    // Along active constraints, the switching functions alone do not determine the inputs.
    if trajectory.costates.is_empty() || problem.is_shaped() {
        return None;
    }
    let set = &problem.actuation.torque;
    let (limits, fuel) = (set.limits(), problem.objective.fuel());
    let rows = trajectory.costates.chunks(problem.dimension());
    let costates: Vec<Vector3> = rows.map(|row| Vector3::from_column_slice(&row[3..6])).collect();
    let curve = |name: String, style: usize, values: &mut dyn Iterator<Item = f64>| {
        line(name, style, subject.input_times(), values)
    };
    let curves = match (&limits.size, limits.norm) {
        (Some(sizes), _) => (0..set.count())
            .map(|input| {
                let factor = fuel.map_or(sizes[input], |fuel| 1.0 / fuel.price(input));
                let axis = factor * set.axes()[input];
                curve(subject.input_name(input), input, &mut costates.iter().map(|costate| axis.dot(costate)))
            })
            .collect(),
        (None, norm) => {
            let norm = norm?;
            let factor = fuel.map_or(norm, |fuel| 1.0 / fuel.price(0));
            vec![curve("norm".into(), 0, &mut costates.iter().map(|costate| factor * costate.norm()))]
        }
    };
    let (label, levels, remark) = match (fuel, limits.one_sided, limits.size.is_some()) {
        (Some(_), _, false) => (
            "|λΠ| / price",
            vec![(1.0, "on above")],
            "full norm, opposite to λΠ, where the function is above 1",
        ),
        (Some(_), false, _) => (
            "Bᵀ λΠ / price",
            vec![(1.0, "on beyond"), (-1.0, "")],
            "on, with the opposite sign, where the magnitude exceeds 1",
        ),
        (Some(_), true, _) => {
            ("Bᵀ λΠ / price", vec![(-1.0, "on below")], "on where the function is below −1")
        }
        (None, false, true) => {
            ("limit × Bᵀ λΠ, s/s", vec![(0.0, "changes sides")], "at the limit of the opposite sign")
        }
        (None, true, _) => {
            ("limit × Bᵀ λΠ, s/s", vec![(0.0, "on below")], "on where the function is below 0")
        }
        (None, false, false) => {
            ("limit × |λΠ|, s/s", vec![(0.0, "")], "the torque has its full norm, opposite to λΠ")
        }
    };
    let pulses = problem.shortest_pulse().is_some();
    let remark =
        if pulses { "a pulse longer than the minimum width begins and ends at the level" } else { remark };
    let mut chart = Chart::new("Switching functions", time_axis(), Axis::linear(label), curves);
    // With a minimum pulse width, a pulse is also on where the function is below the level, so the
    // label "on" would be wrong.
    let level = |(value, label): (f64, &str)| Level { value, label: if pulses { "" } else { label }.into() };
    chart.levels = levels.into_iter().map(level).collect();
    chart.spans = arcs(subject);
    Some(shown("switching", chart, remark))
}
