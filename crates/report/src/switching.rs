//! Switching functions and arcs of plans of minimum time and fuel.
//!
//! The Hamiltonian is least where an input is at the limit opposite to its switching function, or
//! off:
//!
//! ```text
//! time            σ_j = ū_j b_j·λ^Π        u_j = −ū_j sign σ_j ,   a thruster ū_j where σ_j < 0
//! fuel            σ_j = b_j·λ^Π / c_j      u_j = −ū_j sign σ_j where |σ_j| > 1 ,   a thruster where σ_j < −1
//! norm, time      σ   = U |λ^Π|            τ = −U λ^Π/|λ^Π|
//! norm, fuel      σ   = |λ^Π| / c          the same where σ > 1 , else 0
//! ```
//!
//! with axes b, limits ū and U, and prices c. The first and the third are the value of a second
//! of the input \[s/s\].

use super::arcs::arcs;
use super::charts::{shown, time_axis};
use super::{Shown, Subject, line};
use crate::draw::{Axis, Chart, Level};
use slewkit::Vector3;

/// Returns the chart; `None` if the inputs of the plan do not switch.
pub(super) fn chart(subject: &Subject) -> Option<Shown> {
    let (problem, trajectory) = (subject.problem, subject.trajectory());
    subject.plan.solution.switching.as_ref()?;
    // The inputs along constraints do not depend on these functions alone.
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
        (Some(_), _, false) => {
            ("|λΠ| / price", vec![(1.0, "on above")], "at the full norm where above 1, against λΠ")
        }
        (Some(_), false, _) => {
            ("Bᵀ λΠ / price", vec![(1.0, "on beyond"), (-1.0, "")], "on where beyond 1, against its sign")
        }
        (Some(_), true, _) => ("Bᵀ λΠ / price", vec![(-1.0, "on below")], "on where below −1"),
        (None, false, true) => {
            ("limit × Bᵀ λΠ, s/s", vec![(0.0, "changes sides")], "at the limit against its sign")
        }
        (None, true, _) => ("limit × Bᵀ λΠ, s/s", vec![(0.0, "on below")], "on where below 0"),
        (None, false, false) => {
            ("limit × |λΠ|, s/s", vec![(0.0, "")], "the torque has its full norm, against λΠ")
        }
    };
    let pulses = problem.shortest_pulse().is_some();
    let remark =
        if pulses { "a pulse longer than the shortest begins and ends at the level" } else { remark };
    let mut chart = Chart::new("Switching functions", time_axis(), Axis::linear(label), curves);
    // A pulse that is as short as it may be is on below the level too, and none stands everywhere
    // beyond it.
    let level = |(value, label): (f64, &str)| Level { value, label: if pulses { "" } else { label }.into() };
    chart.levels = levels.into_iter().map(level).collect();
    chart.spans = arcs(subject);
    Some(shown("switching", chart, remark))
}
