//! First derivatives of the rows of a stage, and their contributions to the second derivatives.

use super::super::program::{Derivatives, Duals};
use super::slopes::Here;
use super::space::{Space, bend_limit, both};
use super::{Bound, ChainProgram};
use crate::Vector3;
use crate::optimize::chain::rows::{Cone, What};

/// A row whose derivatives are being computed.
struct Bent<'a> {
    multiplier: f64,
    /// Exponent of the duration `s` in the limit of the row.
    power: f64,
    /// Duration `s` to the power `power`.
    grown: f64,
    /// Indices in `z` of the unknowns on which the row depends.
    places: &'a [u16],
    /// Index of the duration in `z`; `None` if the duration is not an unknown.
    duration: Option<usize>,
}

impl Bent<'_> {
    fn is_duration(&self, place: usize) -> bool {
        Some(place) == self.duration
    }

    /// Writes the derivatives of the row to `out`; `of` returns the derivative with respect to the
    /// unknown with a given index in `z`.
    fn slopes(&self, out: &mut [f64], of: impl Fn(usize) -> f64) {
        for (to, place) in out.iter_mut().zip(self.places) {
            *to = of(usize::from(*place));
        }
    }
}

/// Contribution of the rows of a stage to the gradient of the Lagrangian: the sums of multiplier
/// times derivative with respect to the physical rate at the node, the arc `log F`, and the
/// attitude and duration after the kick.
#[derive(Default)]
pub(super) struct Sums {
    pub node: Vector3,
    pub arc: Vector3,
    pub attitude: Vector3,
    pub duration: f64,
}

impl ChainProgram<'_> {
    /// Writes the derivatives of the rows of a stage and adds their curvature to the second
    /// derivatives; returns their contribution to the gradient of the Lagrangian.
    pub(super) fn rows(&self, here: &Here, duals: &Duals, space: &mut Space, out: &mut Derivatives) -> Sums {
        let (model, z) = (self.model, self.shape.z());
        let duration = model.duration.map(|duration| self.shape.m + duration);
        let block = here.k * z * z..(here.k + 1) * z * z;
        let (curvature, hessian) = (&mut out.curvatures[block.clone()], &mut out.hessians[block]);
        let mut sums = Sums::default();
        for index in self.shape.rows_of(here.k) {
            let row = &self.rows[index];
            let slopes = self.shape.slopes_of(index);
            if let (Bound::Roll(side), Some(family)) = (row.bound, self.family) {
                out.slopes[slopes].fill(side / family.within());
                continue;
            }
            let what = &self.limits.rows[row.row].what;
            let bent = Bent {
                multiplier: duals.rows[index],
                power: f64::from(what.growth()),
                grown: here.stage.stretch.powi(what.growth()),
                places: &self.shape.unknowns[slopes.clone()],
                duration,
            };
            let slopes = &mut out.slopes[slopes];
            match (row.bound, what) {
                (Bound::Side(_), _) => slopes[0] = -1.0,
                (Bound::Norm(norm), _) => self.burning(here, norm, &bent, space, (slopes, hessian)),
                (_, What::Cone(cone)) => {
                    // An inactive cone gets a value far from its bound.
                    let value = self.cone(here, cone, &bent, space, &mut sums, slopes);
                    let idle = if what.is_equation() { 0.0 } else { -1.0 };
                    out.values.rows[index] = value.unwrap_or(idle);
                }
                (_, What::RateAxis { .. } | What::RateNorm { .. }) => {
                    self.rate_limit(here, what, &bent, space, &mut sums, (slopes, curvature));
                }
                _ => self.input_limit(here, what, &bent, (slopes, curvature)),
            }
        }
        sums
    }

    /// Writes the derivatives of a limit of inputs or wheels, and adds its curvature.
    fn input_limit(&self, here: &Here, what: &What, row: &Bent, (out, curvature): (&mut [f64], &mut [f64])) {
        let (model, m, z) = (self.model, self.shape.m, self.shape.z());
        let (stage, multiplier, power) = (here.stage, row.multiplier, row.power);
        let of_limit = -power * row.grown;
        let factor = |place: usize| self.lanes[place].factor;
        match what {
            What::InputSize { sign, limit, .. } => {
                row.slopes(
                    out,
                    |place| {
                        if row.is_duration(place) { of_limit } else { sign / limit * factor(place) }
                    },
                )
            }
            What::InputRate { input, sign, limit } => row.slopes(out, |place| {
                if row.is_duration(place) {
                    of_limit
                } else if place < m {
                    sign / limit * factor(place)
                } else {
                    -sign / limit * self.units[*input]
                }
            }),
            What::Wheel { sign, limit, .. } => row.slopes(out, |place| {
                if row.is_duration(place) {
                    of_limit
                } else if place < m {
                    -stage.physical * sign / limit * factor(place)
                } else {
                    sign / limit
                }
            }),
            What::InputNorm { forces, limit } => {
                let size = limit * row.grown;
                let given = if *forces { stage.given.force } else { stage.given.moment } / size;
                let (axes, first) = model.channel(*forces);
                let turns = model.turning(*forces).is_some();
                let r = &stage.pose.attitude;
                let axis = |place: usize| -> Vector3 {
                    let lane = self.lanes[place];
                    let axis = lane.input.checked_sub(first).and_then(|index| axes.get(index));
                    let axis = axis.copied().unwrap_or_else(Vector3::zeros) * (lane.factor / size);
                    match (turns, *forces) {
                        (false, _) => axis,
                        (true, true) => r * axis,
                        (true, false) => r.tr_mul(&axis),
                    }
                };
                row.slopes(out, |place| {
                    if row.is_duration(place) {
                        -power * given.norm_squared()
                    } else if place < m {
                        given.dot(&axis(place))
                    } else {
                        0.0
                    }
                });
                for i in 0..self.lanes.len() {
                    for j in 0..=i {
                        both(curvature, z, i, j, multiplier * axis(i).dot(&axis(j)));
                    }
                    if let Some(d) = row.duration {
                        both(curvature, z, i, d, -2.0 * power * multiplier * given.dot(&axis(i)));
                    }
                }
                let bend = 2.0 * power * power * multiplier * given.norm_squared();
                bend_limit(curvature, z, row.duration, bend);
                return;
            }
            _ => return,
        }
        bend_limit(curvature, z, row.duration, multiplier * power * of_limit);
    }

    /// Writes the derivatives of the row that bounds the norm of a set of inputs. The row is
    /// convex, so its second derivatives are added to the part of the Hessian that Gauss–Newton
    /// keeps.
    fn burning(
        &self,
        here: &Here,
        norm: usize,
        row: &Bent,
        space: &Space,
        (out, hessian): (&mut [f64], &mut [f64]),
    ) {
        let (m, z) = (self.shape.m, self.shape.z());
        let norm = &self.norms[norm];
        let sigma = here.at.inputs[here.k * m + norm.place];
        let burnt = self.burnt(norm, &space.inputs) / sigma;
        let squared = burnt.norm_squared() + self.round.get() / (sigma * sigma);
        let (axes, first) = self.model.channel(norm.forces);
        let axis = |place: usize| {
            let lane = self.lanes[place];
            axes[lane.input - first] * (lane.factor / norm.limit)
        };
        let by = row.multiplier / sigma;
        row.slopes(
            out,
            |place| {
                if place == norm.place { -0.5 * (squared + 1.0) } else { burnt.dot(&axis(place)) }
            },
        );
        for (index, place) in row.places.iter().enumerate() {
            let place = usize::from(*place);
            if place == norm.place {
                both(hessian, z, place, place, by * squared);
                continue;
            }
            let own = axis(place);
            both(hessian, z, place, norm.place, -by * burnt.dot(&own));
            for other in &row.places[..=index] {
                let other = usize::from(*other);
                both(hessian, z, place, other, by * axis(other).dot(&own));
            }
        }
    }

    /// Writes the derivatives of a limit of the rate at a node or on an arc, and adds its
    /// curvature.
    fn rate_limit(
        &self,
        here: &Here,
        what: &What,
        row: &Bent,
        space: &mut Space,
        sums: &mut Sums,
        (out, curvature): (&mut [f64], &mut [f64]),
    ) {
        let (model, n, z) = (self.model, self.shape.n, self.shape.z());
        let Here { k, stage, .. } = *here;
        let (multiplier, grown, h) = (row.multiplier, row.grown, self.step_of(k));
        let moving = model.pi()..model.pi() + 3 + model.wheels;
        match what {
            What::RateAxis { arc, axis, sign, limit } => {
                let (slopes, by) =
                    if *arc { (&space.arc_by_z, sign / limit / h) } else { (&space.rate, sign / limit) };
                row.slopes(out, |place| {
                    by * slopes[place][*axis] - if row.is_duration(place) { grown } else { 0.0 }
                });
                bend_limit(curvature, z, row.duration, -multiplier * grown);
                if *arc {
                    sums.arc[*axis] += multiplier * by;
                    sums.duration -= multiplier * grown;
                } else {
                    sums.node[*axis] += multiplier * by;
                }
            }
            What::RateNorm { arc: false, limit } => {
                let size = limit * grown;
                let v = stage.rate / size;
                let slope = |place: usize| {
                    let of_limit = if row.is_duration(place) { v } else { Vector3::zeros() };
                    space.rate[place] / size - of_limit
                };
                row.slopes(out, |place| v.dot(&slope(place)));
                for (index, i) in row.places.iter().enumerate() {
                    for j in &row.places[..=index] {
                        let (i, j) = (usize::from(*i), usize::from(*j));
                        let mut value = slope(i).dot(&slope(j));
                        if row.is_duration(i) || row.is_duration(j) {
                            let other = if row.is_duration(i) { j } else { i };
                            value -= if row.is_duration(other) {
                                2.0 * v.dot(&space.rate[other]) / size - v.norm_squared()
                            } else {
                                v.dot(&space.rate[other]) / size
                            };
                        }
                        both(curvature, z, i, j, multiplier * value);
                    }
                }
                sums.node += v * (multiplier / size);
            }
            What::RateNorm { arc: true, limit } => {
                let size = limit * grown * h;
                let v = stage.arc / size;
                row.slopes(out, |place| {
                    let of_limit = if row.is_duration(place) { v.norm_squared() } else { 0.0 };
                    v.dot(&space.arc_by_z[place]) / size - of_limit
                });
                for i in moving.clone() {
                    for j in moving.start..=i {
                        let value = space.arc[i].dot(&space.arc[j]) / (size * size);
                        both(&mut space.phi, n, i, j, multiplier * value);
                    }
                }
                if let Some(duration) = model.duration {
                    for i in moving {
                        let value = -2.0 * multiplier * v.dot(&space.arc[i]) / size;
                        both(&mut space.phi, n, i, duration, value);
                    }
                    space.phi[duration * n + duration] += 2.0 * multiplier * v.norm_squared();
                }
                sums.arc += v * (multiplier / size);
                sums.duration -= multiplier * v.norm_squared();
            }
            _ => {}
        }
    }

    /// Writes the derivatives of a cone and returns its value; `None` if the cone is not active.
    fn cone(
        &self,
        here: &Here,
        cone: &Cone,
        row: &Bent,
        space: &mut Space,
        sums: &mut Sums,
        out: &mut [f64],
    ) -> Option<f64> {
        let (multiplier, first) = (row.multiplier, self.shape.m + self.model.zeta());
        out.fill(0.0);
        let felt = multiplier.abs() > self.tuning.felt;
        let (found, bend) = self.cone_bent(cone, here.k, here.stage, felt)?;
        row.slopes(out, |place| {
            let of_arc = if cone.is_of_arc() { found.by_arc.dot(&space.arc_by_z[place]) } else { 0.0 };
            let own = (first..first + 3).contains(&place);
            let of_attitude = if own { found.by_attitude[place - first] } else { 0.0 };
            of_arc + of_attitude + if row.is_duration(place) { found.by_duration } else { 0.0 }
        });
        sums.arc += found.by_arc * multiplier;
        sums.attitude += found.by_attitude * multiplier;
        sums.duration += found.by_duration * multiplier;
        if let Some(bend) = bend {
            self.bend_cone(cone, here.k, here.stage, (multiplier, &bend), space);
        }
        Some(found.c)
    }
}
