//! The equations of a path whose nodes are unknowns, condensed to its few parameters.
//!
//! Every piece of a path starts from its own stored node. Of a path that Newton goes on from, lanes carry from node to node how the
//! motion answers to the parameters and to the gaps between the pieces; with them the nodes drop out of the Newton step, and follow
//! it afterwards: nothing grows along the maneuver but derivatives (Bock's condensing of multiple shooting).

use super::extremal::Extremal;
use super::flow::{Lanes, Node};
use crate::{Vector3, lie};
use nalgebra::{DMatrix, DVector};

/// Equations in the parameters, the gaps carried to them.
pub(super) struct Condensed {
    /// With what the gaps carry to it, once [`closed`](Self::closed).
    pub residual: DVector<f64>,
    /// One more column than there are parameters, for the gaps, until it is closed.
    pub jacobian: DMatrix<f64>,
    /// Sum of the squares of the gaps.
    pub gaps: f64,
    /// Norm of residual and gaps.
    pub merit: f64,
    /// How nodes answer to a step of the parameters, and to 1.
    updates: Vec<DMatrix<f64>>,
}

impl Condensed {
    /// So many equations in as many parameters.
    pub fn new(parameters: usize) -> Self {
        Self {
            residual: DVector::zeros(parameters),
            jacobian: DMatrix::zeros(parameters, parameters + 1),
            gaps: 0.0,
            merit: f64::NAN,
            updates: Vec::new(),
        }
    }

    /// The gap between where a piece leads and the node that the next one starts from.
    pub fn gap<const L: usize>(&mut self, reached: &Node, node: &Node, lanes: &mut Lanes<L>) {
        let difference = reached.minus(node);
        self.gaps += difference.iter().map(|part| part.norm_squared()).sum::<f64>();
        lanes.add(self.residual.len(), &difference, 1.0);
    }

    /// Keeps how a node answers.
    pub fn keep<const L: usize>(&mut self, lanes: &Lanes<L>) {
        self.updates.push(DMatrix::from_fn(9, self.jacobian.ncols(), |row, lane| lanes.0[row][lane]));
    }

    /// The slope of an equation along each lane.
    pub fn slope(&mut self, row: usize, of: impl Fn(usize) -> f64) {
        for lane in 0..self.jacobian.ncols() {
            self.jacobian[(row, lane)] = of(lane);
        }
    }

    /// The six terminal conditions, the first equations.
    pub fn end<const L: usize>(&mut self, extremal: &Extremal, end: &Node, lanes: &Lanes<L>) {
        let miss = extremal.miss(end);
        let of_log = lie::left_jacobian_inverse(&miss.fixed_rows::<3>(0).into_owned());
        for lane in 0..self.jacobian.ncols() {
            let (eta, pi) = (of_log * lanes.block(0, lane), lanes.block(1, lane));
            self.jacobian.view_mut((0, lane), (3, 1)).copy_from(&eta);
            self.jacobian.view_mut((3, lane), (3, 1)).copy_from(&pi);
        }
        self.residual.rows_mut(0, 6).copy_from(&miss);
    }

    /// Complete; `None` where a number is not finite.
    pub fn closed(mut self) -> Option<Self> {
        self.merit = (self.residual.norm_squared() + self.gaps).sqrt();
        let carried = self.jacobian.ncols() - 1;
        self.residual += self.jacobian.column(carried);
        self.jacobian = self.jacobian.remove_column(carried);
        self.merit.is_finite().then_some(self)
    }

    /// The disturbances of the kept nodes that go with a step of the parameters.
    pub fn disturbances(&self, step: &DVector<f64>) -> impl Iterator<Item = [Vector3; 3]> {
        let change = step.clone().insert_row(step.len(), 1.0);
        self.updates.iter().map(move |update| {
            let moved = update * &change;
            [0, 3, 6].map(|row| Vector3::new(moved[row], moved[row + 1], moved[row + 2]))
        })
    }
}
