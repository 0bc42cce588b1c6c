//! The motion along arcs, in continuous time.
//!
//! ```text
//! q̇ = ½ q ∘ (0, Ω) ,   J Ω̇ = JΩ × Ω + A v ,   ḃ = Σ c_j |v_j|
//! ```
//!
//! with the inputs `v` as parts of their limits, and `b` what they have burnt. Inputs that hold limits are those for which the last
//! derivative of these vanishes, `N J⁻¹A_f v_f = −N Ω̇_0 − r`. The flow is that of [`EIGHTH`].

use super::constraint::Limit;
use super::state::{DISTURBANCE, Numbers, State};
use crate::maneuver::problem::Problem;
use crate::numerics::tableau::EIGHTH;
use crate::optimize::methods::switching::scaled::{Units, scaled};
use crate::{Matrix3, Vector3};
use nalgebra::{SMatrix, Vector6};

/// Longest step, in the unit of time and in turns by the present rate \[rad\]: halves of it lead to the same end within 1e-13
/// (`cargo test --lib -- limited::tests::steps`).
const LONGEST: f64 = 0.08;

/// Most inputs that hold something at once.
const MOST_FREE: usize = 3;

/// What an input does on an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Level {
    /// This part of its limit.
    At(f64),
    /// What holds the limits of the arc.
    Free,
}

/// What the inputs do on an arc, and what it holds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Law {
    pub levels: Vec<Level>,
    /// Limits of the state that it holds, as many as inputs are free.
    pub holds: Vec<usize>,
}

/// A law with what its inputs give, so that a step of the flow asks for no memory.
pub(crate) struct Driven<'a> {
    maneuver: &'a Maneuver,
    /// `J⁻¹` times what is given whatever the state.
    given: Vector3,
    /// What inputs at a level burn.
    burning: f64,
    free: usize,
    /// `J⁻¹ a` and price of free inputs.
    answers: [Vector3; MOST_FREE],
    prices: [f64; MOST_FREE],
    held: [Option<&'a Limit>; MOST_FREE],
}

/// A scaled maneuver.
pub(crate) struct Maneuver {
    j: Matrix3,
    j_inverse: Matrix3,
    /// `J⁻¹` times what each input gives at its limit.
    pub answers: Vec<Vector3>,
    /// What each costs at its limit.
    pub prices: Vec<f64>,
    /// What a unit of time costs.
    pub time_price: f64,
    pub given_duration: Option<f64>,
    pub one_sided: bool,
    pub limits: Vec<Limit>,
    pub start: State,
    pub end: State,
    pub units: Units,
}

impl Maneuver {
    /// That of a problem; `None` where arcs of this kind do not describe it.
    pub fn of(problem: &Problem) -> Option<Self> {
        let torque = problem.actuation.torque.limits();
        let only_size = torque.size.is_some() && torque.norm.is_none() && torque.rate.is_none();
        let taken = problem.objective.switches()
            && problem.is_free_turn()
            && !problem.ends_in_any_attitude()
            && only_size
            && problem.actuation.wheels.is_none()
            && !problem.constraints.is_empty()
            && problem.shortest_pulse().is_none();
        if !taken {
            return None;
        }
        let (extremal, units) = scaled(problem)?;
        let limits = Limit::all(problem, units.time)?;
        let sizes = torque.size.as_ref()?;
        let answers = problem.actuation.torque.axes().iter().zip(sizes);
        let answers = answers.map(|(axis, size)| extremal.j_inverse * axis * (size / units.torque)).collect();
        let price = |(input, size): (usize, &f64)| {
            problem.objective.fuel().map_or(0.0, |fuel| fuel.price(input) * size / units.rate)
        };
        Some(Self {
            answers,
            prices: sizes.iter().enumerate().map(price).collect(),
            time_price: problem.objective.time_price() / units.rate,
            given_duration: extremal.given_duration,
            one_sided: torque.one_sided,
            limits,
            start: State::of(&Matrix3::identity(), &extremal.start_rate),
            end: State::of(&extremal.end_attitude, &extremal.end_rate),
            j: extremal.j,
            j_inverse: extremal.j_inverse,
            units,
        })
    }

    pub fn counts_fuel(&self) -> bool {
        self.prices.iter().any(|price| *price != 0.0)
    }

    /// A law, ready to be followed; `None` where too many or too few inputs are free.
    pub fn driven<'a>(&'a self, law: &'a Law) -> Option<Driven<'a>> {
        let mut driven = Driven {
            maneuver: self,
            given: Vector3::zeros(),
            burning: 0.0,
            free: 0,
            answers: [Vector3::zeros(); MOST_FREE],
            prices: [0.0; MOST_FREE],
            held: [None; MOST_FREE],
        };
        for ((level, answer), price) in law.levels.iter().zip(&self.answers).zip(&self.prices) {
            match level {
                Level::At(level) => {
                    driven.given += *level * answer;
                    driven.burning += price * level.abs();
                }
                Level::Free => {
                    *driven.answers.get_mut(driven.free)? = *answer;
                    driven.prices[driven.free] = *price;
                    driven.free += 1;
                }
            }
        }
        for (held, limit) in driven.held.iter_mut().zip(&law.holds) {
            *held = Some(&self.limits[*limit]);
        }
        (driven.free == law.holds.len()).then_some(driven)
    }
}

impl Driven<'_> {
    /// `Ω̇` without the free inputs.
    fn unheld(&self, rate: &Vector3) -> Vector3 {
        let Maneuver { j, j_inverse, .. } = self.maneuver;
        j_inverse * (j * rate).cross(rate) + self.given
    }

    /// The free inputs, in their order, that make up for a change of `Ω̇` and for so much of `r`; NaN where they cannot.
    fn making_up_for(&self, state: &State, change: &Vector3, rests: f64) -> [f64; MOST_FREE] {
        if self.free == 0 {
            return [0.0; MOST_FREE];
        }
        let mut matrix = Matrix3::identity();
        let mut wanted = Vector3::zeros();
        for (row, limit) in self.held.iter().flatten().enumerate() {
            let (normal, rest) = limit.held(state);
            for column in 0..self.free {
                matrix[(row, column)] = normal.dot(&self.answers[column]);
            }
            wanted[row] = -(normal.dot(change) + rests * rest);
        }
        matrix.try_inverse().map_or([f64::NAN; MOST_FREE], |inverse| (inverse * wanted).into())
    }

    /// The free inputs, in their order; NaN where they cannot hold what they should.
    pub fn free_levels(&self, state: &State) -> [f64; MOST_FREE] {
        self.making_up_for(state, &self.unheld(&state.rate()), 1.0)
    }

    /// How the free inputs answer to a change of `Ω̇`, so that what is held stays held.
    pub fn compensation(&self, state: &State, change: &Vector3) -> [f64; MOST_FREE] {
        self.making_up_for(state, change, 0.0)
    }

    /// What burns and `Ω̇`.
    pub fn rates(&self, state: &State) -> (f64, Vector3) {
        let mut change = self.unheld(&state.rate());
        let mut burning = self.burning;
        if self.free > 0 {
            let levels = self.free_levels(state);
            for (column, level) in levels.iter().enumerate().take(self.free) {
                change += *level * self.answers[column];
                burning += self.prices[column] * level.abs();
            }
        }
        (burning, change)
    }

    /// How the state changes, by turn and rate: what one more unit of time does to it.
    pub fn velocity(&self, state: &State) -> Vector6<f64> {
        let (rate, (_, change)) = (state.rate(), self.rates(state));
        Vector6::new(rate.x, rate.y, rate.z, change.x, change.y, change.z)
    }

    fn derivative(&self, numbers: &Numbers) -> Numbers {
        let state = State(*numbers);
        let (rate, (burning, change)) = (state.rate(), self.rates(&state));
        let v = Vector3::new(numbers[1], numbers[2], numbers[3]);
        let turned = 0.5 * (numbers[0] * rate + v.cross(&rate));
        let scalar = -0.5 * v.dot(&rate);
        Numbers::from([scalar, turned.x, turned.y, turned.z, change.x, change.y, change.z, burning])
    }

    /// One step of the flow.
    fn step(&self, from: &Numbers, length: f64) -> Numbers {
        let mut slopes = [Numbers::zeros(); EIGHTH.b.len()];
        let weighted = |weights: &[f64], slopes: &[Numbers]| {
            let sum = weights.iter().zip(slopes).filter(|(weight, _)| **weight != 0.0);
            sum.fold(*from, |at, (weight, slope)| at + length * *weight * slope)
        };
        for stage in 0..slopes.len() {
            slopes[stage] = self.derivative(&weighted(&EIGHTH.a[stage][..stage], &slopes));
        }
        weighted(&EIGHTH.b, &slopes)
    }

    /// How many steps an arc takes from a state.
    pub fn steps(&self, from: &State, length: f64) -> usize {
        (length * (1.0 + from.rate().norm()) / LONGEST).ceil().clamp(1.0, 1000.0) as usize
    }

    /// Where a state comes to in `length`, in so many steps.
    pub fn flow(&self, from: &State, length: f64, steps: usize) -> State {
        let mut numbers = from.0;
        for _ in 0..steps {
            numbers = self.step(&numbers, length / steps as f64);
        }
        let size = numbers.fixed_rows::<4>(0).norm();
        numbers.fixed_rows_mut::<4>(0).scale_mut(1.0 / size);
        State(numbers)
    }

    /// The same with the derivative of where it comes to, and of what is burnt in the last row, by the state it comes from.
    pub fn linearised(&self, from: &State, length: f64, steps: usize) -> (State, SMatrix<f64, 7, 6>) {
        let to = self.flow(from, length, steps);
        let mut slope = SMatrix::<f64, 7, 6>::zeros();
        for column in 0..6 {
            let [ahead, behind] = [DISTURBANCE, -DISTURBANCE]
                .map(|size| self.flow(&from.plus(&Vector6::ith(column, size)), length, steps));
            let change = (ahead.minus(&to) - behind.minus(&to)) / (2.0 * DISTURBANCE);
            slope.fixed_view_mut::<6, 1>(0, column).copy_from(&change);
            slope[(6, column)] = (ahead.burnt() - behind.burnt()) / (2.0 * DISTURBANCE);
        }
        (to, slope)
    }
}
