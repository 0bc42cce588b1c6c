//! Minimum-time and minimum-fuel extremals: the flow of a free body and its costates, and the
//! variational equations of both.
//!
//! With the attitude costate fixed in space, `M = R m`, and the momentum costate `e` in body axes,
//!
//! ```text
//! R' = R S(Ω) ,   Π' = Π×Ω + τ ,   e' = −J⁻¹(m + e×Π) + e×Ω ,   m = RᵀM ,   Ω = J⁻¹Π
//! H  = p + Σ c_j v_j + m·Ω + e·(Π×Ω + τ) ,   0 where the duration is sought, p the price of time
//! ```
//!
//! A disturbance consists of `η` of the attitude in reference axes, `R⁺ = exp(S(η)) R`, of `δΠ`,
//! `δe` and `δM`:
//!
//! ```text
//! η'  = R J⁻¹ δΠ ,      δΠ' = (S(Π) J⁻¹ − S(Ω)) δΠ − G δe ,      G = −∂τ/∂e
//! δe' = −J⁻¹Rᵀ (δM + M×η) + (S(e) J⁻¹ − J⁻¹S(e)) δΠ + (J⁻¹S(Π) − S(Ω)) δe
//! ```
//!
//! The factor of `δe` is minus the transpose of that of `δΠ` in `δΠ'`, and `−J⁻¹S(e)` the transpose
//! of `S(e) J⁻¹`.

#![expect(
    clippy::needless_range_loop,
    reason = "iterators are calls of their own, and narrow in widened code"
)]

use super::extremal::{ArcLaw, Extremal, LawResponse};
use crate::numerics::eight::{Eight, Number};
use crate::numerics::tableau::{EIGHTH, FOURTH, Tableau};
use crate::numerics::three::{
    Matrix, Vector, apply, apply_transposed, cross, crossed, difference, dot, product, product_transposed,
    scaled, skew, splat, splat_matrix, sum, written,
};
use crate::{Matrix3, Vector3, lie};
use nalgebra::Vector6;

/// Attitude, momentum and momentum costate at one instant, scaled; with the number type `Eight`,
/// eight nodes at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node<T: Number = f64> {
    pub r: Matrix<T>,
    pub pi: Vector<T>,
    pub e: Vector<T>,
}

impl Node {
    /// Returns the initial node of a maneuver with the costate `e`.
    pub fn at_start(extremal: &Extremal, e: Vector3) -> Self {
        Self { r: Matrix3::identity(), pi: extremal.j * extremal.start_rate, e }
    }

    /// Converts a node of the time-reversed maneuver to one of `extremal`.
    pub fn reversed(&self, extremal: &Extremal) -> Self {
        Self { r: extremal.end_attitude * self.r, pi: -self.pi, e: self.e }
    }
}

/// Derivatives of a node with respect to L parameters; rows `η`, `δΠ`, `δe`. The first three
/// parameters are `M`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lanes<const L: usize>(pub [[f64; L]; 9]);

impl<const L: usize> Lanes<L> {
    pub fn zero() -> Self {
        Self([[0.0; L]; 9])
    }

    /// Returns the derivatives of the initial node, whose momentum costate `e` is the parameters 3,
    /// 4 and 5.
    pub fn of_costate() -> Self {
        let mut lanes = Self::zero();
        for axis in 0..3 {
            lanes.0[6 + axis][3 + axis] = 1.0;
        }
        lanes
    }

    /// Returns block 0, 1 or 2 (`η`, `δΠ` or `δe`) of one parameter.
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

    /// Returns these derivatives with `rate` added to one lane. Unlike `Self::add`, it makes no
    /// store to a single lane, which is faster if the lanes are then read as whole rows.
    #[inline(always)]
    pub fn with(&self, lane: usize, rate: &[Vector3; 3], units: &UnitRows<L>) -> Self {
        let mut sum = *self;
        for row in 0..9 {
            for l in 0..L {
                sum.0[row][l] += rate[row / 3][row % 3] * units.0[lane][l];
            }
        }
        sum
    }

    /// Returns the sum of these derivatives and `factor` times the derivatives `other`.
    #[inline(always)]
    fn plus(&self, other: &Self, factor: f64) -> Self {
        let mut sum = *self;
        for row in 0..9 {
            for lane in 0..L {
                sum.0[row][lane] += factor * other.0[row][lane];
            }
        }
        sum
    }
}

impl Lanes<8> {
    /// Returns the disturbance that a change of the parameters causes. Both halves of a row are
    /// added in parallel.
    #[inline(always)]
    pub fn folded(&self, change: &[f64; 8]) -> [Vector3; 3] {
        let mut sums = [Vector3::zeros(); 3];
        for row in 0..9 {
            let mut products = self.0[row];
            for lane in 0..8 {
                products[lane] *= change[lane];
            }
            let mut halves = [0.0; 4];
            for lane in 0..4 {
                halves[lane] = products[lane] + products[lane + 4];
            }
            sums[row / 3][row % 3] = (halves[0] + halves[2]) + (halves[1] + halves[3]);
        }
        sums
    }
}

/// Rows of the identity: one in a lane, zero in the others.
///
/// An addition to a single lane is computed as a product with such a row, because a store to one
/// lane followed by a load of the whole row is slower. The positions of the zeros are hidden from
/// the compiler, which would otherwise split the rows.
pub(crate) struct UnitRows<const L: usize>([[f64; L]; L]);

impl<const L: usize> UnitRows<L> {
    pub fn new() -> Self {
        let mut rows = [[0.0; L]; L];
        for (lane, row) in rows.iter_mut().enumerate() {
            row[lane] = 1.0;
        }
        Self(std::hint::black_box(rows))
    }
}

/// Returns the sum of factor times row over `terms`.
#[inline(always)]
fn combined<const K: usize, const L: usize>(terms: [(f64, &[f64; L]); K]) -> [f64; L] {
    let (factor, row) = terms[0];
    let mut sum = *row;
    for l in 0..L {
        sum[l] *= factor;
    }
    for (factor, row) in &terms[1..] {
        for l in 0..L {
            sum[l] += factor * row[l];
        }
    }
    sum
}

impl<T: Number> Node<T> {
    /// Returns `self ⊖ other` in the blocks of a disturbance; the attitude block is `2 tan(θ/2)`
    /// along the axis.
    #[inline(always)]
    pub fn minus(&self, other: &Self) -> [Vector<T>; 3] {
        let turn = product_transposed(&self.r, &other.r);
        let factor = T::of(2.0) / (T::of(1.0) + (turn[(0, 0)] + turn[(1, 1)] + turn[(2, 2)]));
        let part = |i: usize, j: usize| factor * (turn[(i, j)] - turn[(j, i)]);
        let turned = Vector::new(part(2, 1), part(0, 2), part(1, 0));
        [turned, difference(&self.pi, &other.pi), difference(&self.e, &other.e)]
    }

    /// Returns the node with `factor` times the disturbance applied; the inverse of `Self::minus`.
    #[inline(always)]
    pub fn plus(&self, change: &[Vector<T>; 3], factor: T) -> Self {
        let [half, pi, e] =
            [scaled(T::of(0.5) * factor, &change[0]), scaled(factor, &change[1]), scaled(factor, &change[2])];
        Self {
            r: product(&turn(&[T::of(1.0), half.x, half.y, half.z]), &self.r),
            pi: sum(&self.pi, &pi),
            e: sum(&self.e, &e),
        }
    }

    /// Returns the node after a change of the relative quaternion, the momentum and its costate.
    #[inline(always)]
    fn displaced(&self, y: &[T; 10]) -> Self {
        Self {
            r: product(&self.r, &turn(&[T::of(1.0) + y[0], y[1], y[2], y[3]])),
            pi: sum(&self.pi, &Vector::new(y[4], y[5], y[6])),
            e: sum(&self.e, &Vector::new(y[7], y[8], y[9])),
        }
    }
}

impl Node<Eight> {
    /// Packs eight nodes, given by their index, into one.
    #[inline(always)]
    pub fn of<'a>(node: impl Fn(usize) -> &'a Node) -> Self {
        let lanes = |of: &dyn Fn(&Node) -> f64| Eight::from_fn(|lane| of(node(lane)));
        Self {
            r: written(|i, j| lanes(&|node| node.r[(i, j)])),
            pi: Vector::from_fn(|i, _| lanes(&|node| node.pi[i])),
            e: Vector::from_fn(|i, _| lanes(&|node| node.e[i])),
        }
    }
}

/// Coefficients of the variational equations at one instant.
#[derive(Clone, Copy)]
struct Linear<T: Number> {
    x: Matrix<T>,
    /// Derivative of `Π'` with respect to `Π`; minus its transpose is the derivative of `e'` with
    /// respect to `e`.
    a: Matrix<T>,
    g: Matrix<T>,
    y: Matrix<T>,
    c: Matrix<T>,
}

impl<T: Number> FlowStage<T> {
    /// Returns the time derivatives of the lanes of one case, which `case` extracts from each
    /// number. To the lane `stretched.0` the rate of the node is added, times the factor
    /// `stretched.1`.
    #[inline(always)]
    fn times<const L: usize>(
        &self,
        lanes: &Lanes<L>,
        stretched: Option<(usize, f64)>,
        units: &UnitRows<L>,
        case: impl Fn(&T) -> f64 + Copy,
    ) -> Lanes<L> {
        let (lane, per) = stretched.unwrap_or((0, 0.0));
        let Linear { x, a, g, y, c } = &self.linear;
        let own = |block: usize, row: usize| (per * case(&self.rate[block][row]), &units.0[lane]);
        let mut rates = Lanes::zero();
        for row in 0..3 {
            let by = |factor: f64, of: &Matrix<T>, at: (usize, usize)| factor * case(&of[at]);
            let of_x = |column: usize| (by(1.0, x, (row, column)), &lanes.0[3 + column]);
            rates.0[row] = combined([of_x(0), of_x(1), of_x(2), own(0, row)]);
            let of_pi = |column: usize| (by(1.0, a, (row, column)), &lanes.0[3 + column]);
            let of_e = |column: usize| (by(-1.0, g, (row, column)), &lanes.0[6 + column]);
            rates.0[3 + row] =
                combined([of_pi(0), of_pi(1), of_pi(2), of_e(0), of_e(1), of_e(2), own(1, row)]);
            let of_eta = |column: usize| (by(1.0, y, (row, column)), &lanes.0[column]);
            let of_pi = |column: usize| (by(1.0, c, (row, column)), &lanes.0[3 + column]);
            let of_e = |column: usize| (by(-1.0, a, (column, row)), &lanes.0[6 + column]);
            // −J⁻¹Rᵀ δM, where x = R J⁻¹.
            let of_m = |column: usize| (by(-1.0, x, (column, row)), &units.0[column]);
            rates.0[6 + row] = combined([
                of_eta(0),
                of_eta(1),
                of_eta(2),
                of_pi(0),
                of_pi(1),
                of_pi(2),
                of_e(0),
                of_e(1),
                of_e(2),
                of_m(0),
                of_m(1),
                of_m(2),
                own(2, row),
            ]);
        }
        rates
    }
}

impl Extremal {
    /// Returns the time derivative of a node, `[Ω in reference axes, Π', e']`, under a torque.
    #[inline(always)]
    pub fn rate(&self, m: &Vector3, node: &Node, torque: &Vector3) -> [Vector3; 3] {
        let (w, pi, e) = Course::of(self, m).body_rate(node, torque);
        [apply(&node.r, &w), pi, e]
    }

    /// Returns the Hamiltonian; `minimum` is the minimum of `e·τ + Σ c_j v_j` plus the smoothing
    /// term.
    #[inline(always)]
    pub fn hamiltonian(&self, m: &Vector3, node: &Node, minimum: f64) -> f64 {
        let w = apply(&self.j_inverse, &node.pi);
        self.time_price + apply_transposed(&node.r, m).dot(&w) + node.e.dot(&cross(&node.pi, &w)) + minimum
    }

    /// Returns the Hamiltonian at the start, and its derivative with respect to `M` and `e_0`.
    pub fn hamiltonian_at_start(&self, m: &Vector3, first: &Node, law: &ArcLaw) -> (f64, Vector6<f64>) {
        // The derivative of `e·τ` is `τ`, because a torque that turns with `e` minimises it.
        let torque = law.at(&first.e).torque;
        let (rate, push) = (self.start_rate, first.pi.cross(&self.start_rate) + torque);
        let value = self.hamiltonian(m, first, first.e.dot(&torque) + law.running());
        (value, Vector6::new(rate.x, rate.y, rate.z, push.x, push.y, push.z))
    }

    /// Returns the terminal error at the node `end`: the rotation vector of the attitude error,
    /// then the momentum error.
    pub fn miss(&self, end: &Node) -> Vector6<f64> {
        let turn = lie::log(&(end.r * self.end_attitude.transpose()));
        let momentum = end.pi - self.j * self.end_rate;
        Vector6::new(turn.x, turn.y, turn.z, momentum.x, momentum.y, momentum.z)
    }
}

/// Returns the rotation matrix of a quaternion of any norm.
#[inline(always)]
fn turn<T: Number>(p: &[T; 4]) -> Matrix<T> {
    let [w, x, y, z] = *p;
    let one = T::of(1.0);
    let f = T::of(2.0) / (w * w + x * x + y * y + z * z);
    Matrix::new(
        one - f * (y * y + z * z),
        f * (x * y - w * z),
        f * (x * z + w * y),
        f * (x * y + w * z),
        one - f * (x * x + z * z),
        f * (y * z - w * x),
        f * (x * z - w * y),
        f * (y * z + w * x),
        one - f * (x * x + y * y),
    )
}

/// Constants of the flow of an extremal: the inverse inertia, and the attitude costate `M` in
/// reference axes.
#[derive(Clone, Copy)]
pub(crate) struct Course<T: Number = f64> {
    j_inverse: Matrix<T>,
    m: Vector<T>,
}

impl<T: Number> Course<T> {
    #[inline(always)]
    pub fn of(extremal: &Extremal, m: &Vector3) -> Self {
        Self { j_inverse: splat_matrix(&extremal.j_inverse), m: splat(m) }
    }

    /// Returns the time derivatives of a node, `[Ω, Π', e']`, with `Ω` in body axes.
    #[inline(always)]
    fn body_rate(&self, node: &Node<T>, torque: &Vector<T>) -> (Vector<T>, Vector<T>, Vector<T>) {
        let w = apply(&self.j_inverse, &node.pi);
        let m = apply_transposed(&node.r, &self.m);
        let of_momentum = apply(&self.j_inverse, &sum(&m, &cross(&node.e, &node.pi)));
        let e = difference(&cross(&node.e, &w), &of_momentum);
        (w, sum(&cross(&node.pi, &w), torque), e)
    }

    #[inline(always)]
    fn linear(&self, node: &Node<T>, w: &Vector<T>, stiffness: &Matrix<T>) -> Linear<T> {
        let x = product(&node.r, &self.j_inverse);
        let (of_momentum, of_costate) =
            (crossed(&node.pi, &self.j_inverse), crossed(&node.e, &self.j_inverse));
        let of_rate = skew(w);
        // −xᵀS(M): its rows are M × x of each column of x.
        let y = crossed(&self.m, &x);
        Linear {
            x,
            a: written(|row, column| of_momentum[(row, column)] - of_rate[(row, column)]),
            g: *stiffness,
            y: written(|row, column| y[(column, row)]),
            c: written(|row, column| of_costate[(row, column)] + of_costate[(column, row)]),
        }
    }

    /// Integrates the flow over one step of the given length and stores in `stages` what the
    /// derivatives need. `respond` returns the control law's response for a fraction of the step
    /// and a costate.
    #[inline(always)]
    pub fn step<const S: usize>(
        &self,
        tableau: &Tableau<S>,
        from: &Node<T>,
        length: T,
        respond: impl Fn(f64, &Vector<T>) -> LawResponse<T>,
        stages: &mut FlowStages<T, S>,
    ) -> Node<T> {
        let none = T::of(0.0);
        let mut rates = [[none; 10]; S];
        let mut total = [none; 10];
        for stage in 0..S {
            let mut y = [none; 10];
            for earlier in 0..stage {
                if tableau.a[stage][earlier] != 0.0 {
                    let factor = length * T::of(tableau.a[stage][earlier]);
                    for row in 0..10 {
                        y[row] = y[row] + factor * rates[earlier][row];
                    }
                }
            }
            let node = from.displaced(&y);
            let response = respond(tableau.c[stage], &node.e);
            let (w, pi, e) = self.body_rate(&node, &response.torque);
            let (half, q0, q) = (T::of(0.5), T::of(1.0) + y[0], Vector::new(y[1], y[2], y[3]));
            let q_dot = scaled(half, &sum(&scaled(q0, &w), &cross(&q, &w)));
            let q0_dot = -half * dot(&q, &w);
            rates[stage] = [q0_dot, q_dot.x, q_dot.y, q_dot.z, pi.x, pi.y, pi.z, e.x, e.y, e.z];
            if tableau.b[stage] != 0.0 {
                let factor = length * T::of(tableau.b[stage]);
                for row in 0..10 {
                    total[row] = total[row] + factor * rates[stage][row];
                }
            }
            stages.0[stage] = FlowStage {
                linear: self.linear(&node, &w, &response.stiffness),
                rate: [apply(&node.r, &w), pi, e],
            };
        }
        from.displaced(&total)
    }
}

/// Values of one Runge–Kutta stage that the propagation of derivatives needs.
#[derive(Clone, Copy)]
struct FlowStage<T: Number> {
    linear: Linear<T>,
    rate: [Vector<T>; 3],
}

/// Values of one integration step that the propagation of derivatives needs, for each Runge–Kutta
/// stage.
pub(crate) struct FlowStages<T: Number, const S: usize>([FlowStage<T>; S]);

impl<T: Number, const S: usize> FlowStages<T, S> {
    /// Creates stages for [`Course::step`] to fill.
    #[inline(always)]
    pub fn empty() -> Self {
        let (matrix, vector) = (splat_matrix(&Matrix3::zeros()), splat(&Vector3::zeros()));
        let linear = Linear { x: matrix, a: matrix, g: matrix, y: matrix, c: matrix };
        Self([FlowStage { linear, rate: [vector; 3] }; S])
    }

    /// Carries derivatives over the step of the case that `case` extracts from each number. If the
    /// duration is a parameter, `stretched` holds its lane and value, and the rate of change with
    /// the duration is added to this lane.
    #[inline(always)]
    pub fn carry<const L: usize>(
        &self,
        tableau: &Tableau<S>,
        length: f64,
        lanes: &Lanes<L>,
        stretched: Option<(usize, f64)>,
        units: &UnitRows<L>,
        case: impl Fn(&T) -> f64 + Copy,
    ) -> Lanes<L> {
        let stretched = stretched.map(|(lane, duration)| (lane, 1.0 / duration));
        let mut rates = [Lanes::<L>::zero(); S];
        let mut end = *lanes;
        for stage in 0..S {
            let mut v = *lanes;
            for earlier in 0..stage {
                if tableau.a[stage][earlier] != 0.0 {
                    v = v.plus(&rates[earlier], length * tableau.a[stage][earlier]);
                }
            }
            rates[stage] = self.0[stage].times(&v, stretched, units, case);
            if tableau.b[stage] != 0.0 {
                end = end.plus(&rates[stage], length * tableau.b[stage]);
            }
        }
        end
    }
}

impl<T: Number> FlowStages<T, 4> {
    /// Carries derivatives over a step of [`FOURTH`], in which each stage depends only on the
    /// previous one.
    #[inline(always)]
    pub fn carry_on<const L: usize>(
        &self,
        length: f64,
        lanes: &Lanes<L>,
        stretched: Option<(usize, f64)>,
        units: &UnitRows<L>,
        case: impl Fn(&T) -> f64 + Copy,
    ) -> Lanes<L> {
        let stretched = stretched.map(|(lane, duration)| (lane, 1.0 / duration));
        let [first, second, third, fourth] = &self.0;
        let rate = first.times(lanes, stretched, units, case);
        let mut end = lanes.plus(&rate, FOURTH.b[0] * length);
        let rate = second.times(&lanes.plus(&rate, FOURTH.a[1][0] * length), stretched, units, case);
        end = end.plus(&rate, FOURTH.b[1] * length);
        let rate = third.times(&lanes.plus(&rate, FOURTH.a[2][1] * length), stretched, units, case);
        end = end.plus(&rate, FOURTH.b[2] * length);
        let rate = fourth.times(&lanes.plus(&rate, FOURTH.a[3][2] * length), stretched, units, case);
        end.plus(&rate, FOURTH.b[3] * length)
    }
}

/// Returns the blocks for one case, which `case` extracts from each number.
#[inline(always)]
pub(crate) fn taken<T: Number>(blocks: &[Vector<T>; 3], case: impl Fn(&T) -> f64) -> [Vector3; 3] {
    let mut taken = [Vector3::zeros(); 3];
    for (block, taken) in blocks.iter().zip(&mut taken) {
        *taken = Vector3::new(case(&block.x), case(&block.y), case(&block.z));
    }
    taken
}

impl Course {
    /// Returns the node after one step of the eighth-order method.
    #[inline(always)]
    pub fn reached(&self, from: &Node, length: f64, respond: impl Fn(f64, &Vector3) -> LawResponse) -> Node {
        self.step(&EIGHTH, from, length, respond, &mut FlowStages::empty())
    }

    /// Returns the node after one step of the eighth-order method, and carries its derivatives.
    #[inline(always)]
    pub fn carried<const L: usize>(
        &self,
        from: &Node,
        length: f64,
        lanes: &mut Lanes<L>,
        respond: impl Fn(f64, &Vector3) -> LawResponse,
    ) -> Node {
        let (mut stages, units) = (FlowStages::empty(), UnitRows::new());
        let end = self.step(&EIGHTH, from, length, respond, &mut stages);
        *lanes = stages.carry(&EIGHTH, length, lanes, None, &units, |number| *number);
        end
    }
}
