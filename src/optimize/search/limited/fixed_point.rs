//! Fixed points of the map from the event times of a grid to the event times of the optimum on that
//! grid.

use nalgebra::{DMatrix, DVector};

/// Anderson acceleration: the linear combination of the last changes that would vanish if the map
/// were linear.
///
/// Anderson, *Iterative procedures for nonlinear integral equations*, 1965.
#[derive(Default)]
pub(super) struct Anderson {
    /// Last changes, each with the values to which it led.
    tried: Vec<[DVector<f64>; 2]>,
}

impl Anderson {
    /// Returns the next values to try, after the map has taken `from` to `to`.
    pub fn next(&mut self, from: &[f64], to: &[f64]) -> Vec<f64> {
        let [from, to] = [from, to].map(DVector::from_column_slice);
        let moved = &to - &from;
        let differences = |now: &DVector<f64>, of: usize| {
            let column = |tried: &[DVector<f64>; 2]| now - &tried[of];
            DMatrix::from_columns(&self.tried.iter().map(column).collect::<Vec<_>>())
        };
        let mut next = to.clone();
        if !self.tried.is_empty() && !moved.is_empty() {
            let (moves, results) = (differences(&moved, 0), differences(&to, 1));
            if let Ok(shares) = moves.svd(true, true).solve(&moved, f64::EPSILON.sqrt() * moved.norm()) {
                next -= results * shares;
            }
        }
        self.tried.push([moved, to]);
        next.as_slice().to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::Anderson;

    /// Claim: a linear map of two unknowns is solved from three values, even if it does not
    /// contract.
    #[test]
    fn a_linear_map_is_solved_in_as_many_moves_as_it_has_unknowns() {
        let map = |x: &[f64]| vec![1.0 - 1.2 * x[0] + 0.3 * x[1], 2.0 + 0.5 * x[0] - 0.9 * x[1]];
        let (mut anderson, mut x) = (Anderson::default(), vec![0.0, 0.0]);
        for _ in 0..3 {
            x = anderson.next(&x, &map(&x));
        }
        for (value, led) in x.iter().zip(map(&x)) {
            assert!((value - led).abs() < 1e-10, "{x:?}");
        }
    }
}
