//! Interpolation between two rows of attitudes and rates: a cubic in the rotation vector from the
//! first row.
//!
//! ```text
//! R(s) = R₀ exp(φ(s)),   φ(0) = 0,  φ'(0) = h Ω₀,  φ(1) = log(R₀ᵀ R₁),  φ'(1) = J_r⁻¹(φ(1)) h Ω₁
//! ```
//!
//! The interpolation error is measured on the rows themselves: every second row is omitted and
//! interpolated from its neighbours. The distance between rows is then twice as large, so that the
//! measured error is an upper bound for the full rows.

use crate::{Matrix3, Vector3, lie};

/// An attitude and its angular velocity.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Attitude, body → reference.
    pub attitude: Matrix3,
    /// Angular velocity, body axes [rad/s].
    pub rate: Vector3,
}

/// The rotation vector from the first of two rows to a point between them, as
/// `s (φ'(0) + s (c + s b))` with `s` from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Cubic {
    start: Vector3,
    curve: Vector3,
    bend: Vector3,
}

impl Cubic {
    /// Builds the cubic through two rows at the time difference `h` \[s\].
    pub fn between(first: &Row, second: &Row, h: f64) -> Self {
        let turn = lie::minus(&second.attitude, &first.attitude);
        let (start, end) = (h * first.rate, lie::right_jacobian_inverse(&turn) * (h * second.rate));
        Self { start, curve: 3.0 * turn - 2.0 * start - end, bend: start + end - 2.0 * turn }
    }

    /// Returns the rotation vector at the fraction `s` of the interval, and its derivative by `s`.
    pub fn at(&self, s: f64) -> (Vector3, Vector3) {
        let Self { start, curve, bend } = self;
        (s * (start + s * (curve + s * bend)), start + s * (2.0 * curve + 3.0 * s * bend))
    }

    /// Returns a bound on the derivative by `s`, from its Bernstein coefficients. The angular
    /// velocity times `h` does not exceed the bound, since `‖J_r‖ ≤ 1`.
    pub fn steepest(&self) -> f64 {
        let Self { start, curve, bend } = self;
        [*start, start + curve, start + 2.0 * curve + 3.0 * bend]
            .iter()
            .map(|slope| slope.norm())
            .fold(0.0, f64::max)
    }
}

/// Returns the row of the cubic at the fraction `s` of the time `h` \[s\] between two rows.
pub fn cubic(first: &Row, second: &Row, h: f64, s: f64) -> Row {
    let (vector, slope) = Cubic::between(first, second, h).at(s);
    Row { attitude: first.attitude * lie::exp(&vector), rate: lie::right_jacobian(&vector) * slope / h }
}

/// Returns the attitude at the fraction `s` of a rotation about a fixed axis at a constant rate.
pub fn linear(first: &Row, second: &Row, s: f64) -> Matrix3 {
    first.attitude * lie::exp(&(s * lie::minus(&second.attitude, &first.attitude)))
}

/// Returns bounds on the errors of two interpolations between rows \[rad\]: of the rotation at a
/// constant rate, and of the cubic.
pub fn missed(rows: &[Row], time: &[f64]) -> (f64, f64) {
    let mut worst = (0.0_f64, 0.0_f64);
    for k in 1..rows.len().saturating_sub(1) {
        let (first, middle, last) = (&rows[k - 1], &rows[k], &rows[k + 1]);
        let h = time[k + 1] - time[k - 1];
        let s = (time[k] - time[k - 1]) / h;
        let off = |attitude: &Matrix3| lie::minus(attitude, &middle.attitude).norm();
        worst.0 = worst.0.max(off(&linear(first, last, s)));
        worst.1 = worst.1.max(off(&cubic(first, last, h, s).attitude));
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::{Row, cubic, missed};
    use crate::{Matrix3, Vector3, lie};

    /// Returns the attitude and rate of a body that turns about a fixed axis by the angle sin t, in
    /// closed form.
    fn row(t: f64) -> Row {
        let axis = Vector3::new(1.0, -2.0, 2.0) / 3.0;
        Row { attitude: lie::exp(&(t.sin() * axis)), rate: t.cos() * axis }
    }

    #[test]
    fn the_cubic_is_of_fourth_order_and_its_bound_holds() {
        let off = |h: f64| {
            let found = cubic(&row(1.0), &row(1.0 + h), h, 0.5);
            let true_row = row(1.0 + 0.5 * h);
            assert!((found.rate - true_row.rate).norm() < h.powi(3), "the rate is its derivative");
            lie::minus(&found.attitude, &true_row.attitude).norm()
        };
        let order = (off(0.2) / off(0.1)).log2();
        assert!((order - 4.0).abs() < 0.1, "{order}");
        let time: Vec<f64> = (0..=30).map(|k| 0.1 * f64::from(k)).collect();
        let rows: Vec<Row> = time.iter().map(|t| row(*t)).collect();
        let (linear, bound) = missed(&rows, &time);
        assert!(off(0.1) < bound && bound < 20.0 * off(0.1), "{bound}");
        // The bound |θ''| h²/8 for the doubled distance 0.2, with |θ''| at most 1.
        assert!((linear - 0.005).abs() < 1e-4, "{linear}");
    }

    #[test]
    fn ends_are_met() {
        let (first, second) = (row(0.3), row(0.9));
        for (s, end) in [(0.0, &first), (1.0, &second)] {
            let found = cubic(&first, &second, 0.6, s);
            assert!((found.attitude - end.attitude).abs().max() < 4e-15);
            assert!((found.rate - end.rate).amax() < 1e-14);
        }
        assert!((first.attitude.tr_mul(&first.attitude) - Matrix3::identity()).amax() < 1e-15);
    }
}
