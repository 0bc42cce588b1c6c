//! Extremals of minimum time and fuel: the motion of a free body and of its costates, and how both answer to a disturbance.
//!
//! With the attitude costate fixed in space, `M = R m`, and the momentum costate `e` in body axes,
//!
//! ```text
//! R' = R S(Ω) ,   Π' = Π×Ω + τ ,   e' = −J⁻¹(m + e×Π) + e×Ω ,   m = RᵀM ,   Ω = J⁻¹Π
//! H  = p + Σ c_j v_j + m·Ω + e·(Π×Ω + τ) ,   0 where the duration is sought, p the price of time
//! ```
//!
//! A disturbance is `η` of the attitude in reference axes, `R⁺ = exp(S(η)) R`, `δΠ`, `δe`, and `δM`:
//!
//! ```text
//! η'  = R J⁻¹ δΠ ,      δΠ' = (S(Π) J⁻¹ − S(Ω)) δΠ − G δe ,      G = −∂τ/∂e
//! δe' = −J⁻¹Rᵀ (δM + M×η) + (S(e) J⁻¹ − J⁻¹S(e)) δΠ + (J⁻¹S(Π) − S(Ω)) δe
//! ```
//!
//! The factor of `δe` is minus the transpose of that of `δΠ` in `δΠ'`, and `−J⁻¹S(e)` the transpose of `S(e) J⁻¹`.

use super::extremal::{Extremal, Response};
use crate::numerics::three::{apply, apply_transposed, cross, crossed, product, written};
use crate::{Matrix3, Vector3};

/// Attitude, momentum and momentum costate at one instant, scaled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    pub r: Matrix3,
    pub pi: Vector3,
    pub e: Vector3,
}

/// Derivatives of a node with respect to L parameters: rows `η`, `δΠ`, `δe`. The first three parameters are `M`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lanes<const L: usize>(pub [[f64; L]; 9]);

impl<const L: usize> Lanes<L> {
    pub fn zero() -> Self {
        Self([[0.0; L]; 9])
    }

    /// Of a first node whose costate `e` is the parameters 3, 4, 5.
    pub fn of_costate() -> Self {
        let mut lanes = Self::zero();
        for axis in 0..3 {
            lanes.0[6 + axis][3 + axis] = 1.0;
        }
        lanes
    }

    /// Block 0, 1, 2 (`η`, `δΠ`, `δe`) of one parameter.
    #[inline(always)]
    pub fn block(&self, block: usize, lane: usize) -> Vector3 {
        let row = |row: usize| self.0[3 * block + row][lane];
        Vector3::new(row(0), row(1), row(2))
    }

    #[inline(always)]
    pub fn add(&mut self, lane: usize, rate: &[Vector3; 3], factor: f64) {
        for row in 0..9 {
            self.0[row][lane] += factor * rate[row / 3][row % 3];
        }
    }

    /// The disturbance that a change of the parameters makes.
    pub fn times(&self, change: &[f64]) -> [Vector3; 3] {
        let row =
            |row: usize| self.0[row].iter().zip(change).map(|(lane, change)| lane * change).sum::<f64>();
        std::array::from_fn(|block| Vector3::from_fn(|axis, _| row(3 * block + axis)))
    }

    #[inline(always)]
    fn add_scaled(&mut self, other: &Self, factor: f64) {
        for row in 0..9 {
            for lane in 0..L {
                self.0[row][lane] += factor * other.0[row][lane];
            }
        }
    }
}

impl Node {
    /// `self ⊖ other`, in the blocks of a disturbance.
    #[inline(always)]
    pub fn minus(&self, other: &Self) -> [Vector3; 3] {
        let turn = product(&self.r, &other.r.transpose());
        [crate::lie::log(&turn), self.pi - other.pi, self.e - other.e]
    }

    /// After a change of the quaternion from this attitude, the momentum and its costate.
    #[inline(always)]
    fn displaced(&self, y: &[f64; 10]) -> Self {
        Self {
            r: product(&self.r, &turn(&[1.0 + y[0], y[1], y[2], y[3]])),
            pi: self.pi + Vector3::new(y[4], y[5], y[6]),
            e: self.e + Vector3::new(y[7], y[8], y[9]),
        }
    }

    /// Disturbed.
    pub fn plus(&self, change: &[Vector3; 3], factor: f64) -> Self {
        Self {
            r: crate::lie::exp(&(factor * change[0])) * self.r,
            pi: self.pi + factor * change[1],
            e: self.e + factor * change[2],
        }
    }
}

/// The linearised flow at one instant.
struct Linear {
    x: Matrix3,
    /// Of `δΠ` in `δΠ'`; its transpose is minus that of `δe` in `δe'`.
    a: Matrix3,
    g: Matrix3,
    y: Matrix3,
    c: Matrix3,
}

impl Linear {
    #[inline(always)]
    fn times<const L: usize>(&self, lanes: &Lanes<L>) -> Lanes<L> {
        let v = &lanes.0;
        let mut out = Lanes::zero();
        for row in 0..3 {
            for column in 0..3 {
                let (x, a, g) = (self.x[(row, column)], self.a[(row, column)], self.g[(row, column)]);
                let (y, c, d) = (self.y[(row, column)], self.c[(row, column)], -self.a[(column, row)]);
                let (eta, pi, e) = (&v[column], &v[3 + column], &v[6 + column]);
                for l in 0..L {
                    out.0[row][l] += x * pi[l];
                    out.0[3 + row][l] += a * pi[l] - g * e[l];
                    out.0[6 + row][l] += y * eta[l] + c * pi[l] + d * e[l];
                }
            }
            // δe' has −J⁻¹Rᵀ δM, and x = R J⁻¹.
            for axis in 0..3 {
                out.0[6 + row][axis] -= self.x[(axis, row)];
            }
        }
        out
    }
}

impl Extremal {
    /// Time derivative of a node, `[Ω in reference axes, Π', e']`, under the torque `torque`.
    #[inline(always)]
    pub fn rate(&self, m: &Vector3, node: &Node, torque: &Vector3) -> [Vector3; 3] {
        let (w, pi, e) = self.body_rate(m, node, torque);
        [apply(&node.r, &w), pi, e]
    }

    #[inline(always)]
    fn body_rate(&self, m: &Vector3, node: &Node, torque: &Vector3) -> (Vector3, Vector3, Vector3) {
        let w = apply(&self.j_inverse, &node.pi);
        let m = apply_transposed(&node.r, m);
        let e = cross(&node.e, &w) - apply(&self.j_inverse, &(m + cross(&node.e, &node.pi)));
        (w, cross(&node.pi, &w) + torque, e)
    }

    #[inline(always)]
    fn linear(&self, m: &Vector3, node: &Node, w: &Vector3, stiffness: &Matrix3) -> Linear {
        let x = product(&node.r, &self.j_inverse);
        let (of_momentum, of_costate) =
            (crossed(&node.pi, &self.j_inverse), crossed(&node.e, &self.j_inverse));
        // −xᵀS(M): its rows are M × x of each column of x.
        let y = crossed(m, &x);
        Linear {
            x,
            a: of_momentum - crossed(w, &Matrix3::identity()),
            g: *stiffness,
            y: written(|row, column| y[(column, row)]),
            c: written(|row, column| of_costate[(row, column)] + of_costate[(column, row)]),
        }
    }

    /// The Hamiltonian; `minimum` is the least `e·τ + Σ c_j v_j` plus what smoothing adds.
    #[inline(always)]
    pub fn hamiltonian(&self, m: &Vector3, node: &Node, minimum: f64) -> f64 {
        let w = apply(&self.j_inverse, &node.pi);
        self.time_price + apply_transposed(&node.r, m).dot(&w) + node.e.dot(&cross(&node.pi, &w)) + minimum
    }
}

/// An explicit Runge–Kutta method; zero entries are skipped.
pub(crate) struct Tableau<const S: usize> {
    pub a: [[f64; S]; S],
    pub b: [f64; S],
    pub c: [f64; S],
}

/// Kutta's method of order 4.
pub(crate) const RK4: Tableau<4> = Tableau {
    a: [[0.0; 4], [0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
    b: [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
    c: [0.0, 0.5, 0.5, 1.0],
};

/// Cooper and Verner, *Some explicit Runge–Kutta methods of high order*, 1972: order 8 in eleven stages, `s = √21`.
pub(crate) const COOPER_VERNER: Tableau<11> = {
    let s = 4.582_575_694_955_84;
    let z = 0.0;
    Tableau {
        a: [
            [z; 11],
            [0.5, z, z, z, z, z, z, z, z, z, z],
            [0.25, 0.25, z, z, z, z, z, z, z, z, z],
            [1.0 / 7.0, (-7.0 - 3.0 * s) / 98.0, (21.0 + 5.0 * s) / 49.0, z, z, z, z, z, z, z, z],
            [(11.0 + s) / 84.0, z, (18.0 + 4.0 * s) / 63.0, (21.0 - s) / 252.0, z, z, z, z, z, z, z],
            [
                (5.0 + s) / 48.0,
                z,
                (9.0 + s) / 36.0,
                (-231.0 + 14.0 * s) / 360.0,
                (63.0 - 7.0 * s) / 80.0,
                z,
                z,
                z,
                z,
                z,
                z,
            ],
            [
                (10.0 - s) / 42.0,
                z,
                (-432.0 + 92.0 * s) / 315.0,
                (633.0 - 145.0 * s) / 90.0,
                (-504.0 + 115.0 * s) / 70.0,
                (63.0 - 13.0 * s) / 35.0,
                z,
                z,
                z,
                z,
                z,
            ],
            [1.0 / 14.0, z, z, z, (14.0 - 3.0 * s) / 126.0, (13.0 - 3.0 * s) / 63.0, 1.0 / 9.0, z, z, z, z],
            [
                1.0 / 32.0,
                z,
                z,
                z,
                (91.0 - 21.0 * s) / 576.0,
                11.0 / 72.0,
                (-385.0 - 75.0 * s) / 1152.0,
                (63.0 + 13.0 * s) / 128.0,
                z,
                z,
                z,
            ],
            [
                1.0 / 14.0,
                z,
                z,
                z,
                1.0 / 9.0,
                (-733.0 - 147.0 * s) / 2205.0,
                (515.0 + 111.0 * s) / 504.0,
                (-51.0 - 11.0 * s) / 56.0,
                (132.0 + 28.0 * s) / 245.0,
                z,
                z,
            ],
            [
                z,
                z,
                z,
                z,
                (-42.0 + 7.0 * s) / 18.0,
                (-18.0 + 28.0 * s) / 45.0,
                (-273.0 - 53.0 * s) / 72.0,
                (301.0 + 53.0 * s) / 72.0,
                (28.0 - 28.0 * s) / 45.0,
                (49.0 - 7.0 * s) / 18.0,
                z,
            ],
        ],
        b: [1.0 / 20.0, z, z, z, z, z, z, 49.0 / 180.0, 16.0 / 45.0, 49.0 / 180.0, 1.0 / 20.0],
        c: [
            0.0,
            0.5,
            0.5,
            (7.0 + s) / 14.0,
            (7.0 + s) / 14.0,
            0.5,
            (7.0 - s) / 14.0,
            (7.0 - s) / 14.0,
            0.5,
            (7.0 + s) / 14.0,
            1.0,
        ],
    }
};

/// The rotation of a quaternion that need not have norm 1.
#[inline(always)]
fn turn(p: &[f64; 4]) -> Matrix3 {
    let [w, x, y, z] = *p;
    let f = 2.0 / (w * w + x * x + y * y + z * z);
    Matrix3::new(
        1.0 - f * (y * y + z * z),
        f * (x * y - w * z),
        f * (x * z + w * y),
        f * (x * y + w * z),
        1.0 - f * (x * x + z * z),
        f * (y * z - w * x),
        f * (x * z - w * y),
        f * (y * z + w * x),
        1.0 - f * (x * x + y * y),
    )
}

/// An extremal on its way: the maneuver, and the attitude costate `M` in reference axes.
#[derive(Clone, Copy)]
pub(crate) struct Course<'a> {
    pub extremal: &'a Extremal,
    pub m: &'a Vector3,
}

/// One step of the flow over `length`, and of its lanes. `respond` gives the torque at a fraction of the step and a
/// costate. To the lane `stretched` the rate of change over the duration is added, for a duration that is a parameter.
#[inline(always)]
pub(crate) fn advance<const S: usize, const L: usize>(
    course: &Course,
    tableau: &Tableau<S>,
    from: &Node,
    length: f64,
    lanes: &mut Lanes<L>,
    stretched: Option<(usize, f64)>,
    respond: impl Fn(f64, &Vector3) -> Response,
) -> Node {
    let Course { extremal, m } = *course;
    let mut rates = [[0.0; 10]; S];
    let mut lane_rates = [Lanes::<L>::zero(); S];
    let (mut sum, mut lane_sum) = ([0.0; 10], Lanes::<L>::zero());
    for stage in 0..S {
        let (mut y, mut v) = ([0.0; 10], *lanes);
        for earlier in 0..stage {
            let factor = length * tableau.a[stage][earlier];
            if factor != 0.0 {
                for row in 0..10 {
                    y[row] += factor * rates[earlier][row];
                }
                v.add_scaled(&lane_rates[earlier], factor);
            }
        }
        let node = from.displaced(&y);
        let response = respond(tableau.c[stage], &node.e);
        let (w, pi, e) = extremal.body_rate(m, &node, &response.torque);
        let (q0, q) = (1.0 + y[0], Vector3::new(y[1], y[2], y[3]));
        let q_dot = 0.5 * (q0 * w + cross(&q, &w));
        rates[stage] = [-0.5 * q.dot(&w), q_dot.x, q_dot.y, q_dot.z, pi.x, pi.y, pi.z, e.x, e.y, e.z];
        lane_rates[stage] = extremal.linear(m, &node, &w, &response.stiffness).times(&v);
        if let Some((lane, duration)) = stretched {
            lane_rates[stage].add(lane, &[apply(&node.r, &w), pi, e], 1.0 / duration);
        }
        let factor = length * tableau.b[stage];
        if factor != 0.0 {
            for row in 0..10 {
                sum[row] += factor * rates[stage][row];
            }
            lane_sum.add_scaled(&lane_rates[stage], factor);
        }
    }
    lanes.add_scaled(&lane_sum, 1.0);
    from.displaced(&sum)
}
