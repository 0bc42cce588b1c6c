//! The cone of the columns of a matrix: their combinations with nonnegative weights.

use nalgebra::{DMatrix, DVector};

/// Singular value, relative to the largest one, below which columns do not span a direction.
const RANK_TOLERANCE: f64 = 1e-6;
/// The relative size below which a residual, or the gain of a weight, counts as zero.
const ROUND_OFF: f64 = 1e-10;

/// Returns whether every vector can be written as `A x` with `x ≥ 0`.
///
/// This holds if the columns have full rank and `−A 1` can be written in this form. Then `A (x + 1)
/// = 0` with positive weights, and a multiple of these weights can be added to the weights of any
/// vector.
pub(crate) fn is_whole_space(a: &DMatrix<f64>) -> bool {
    if a.ncols() <= a.nrows() {
        return false;
    }
    let sizes = a.singular_values();
    let target = -a.column_sum();
    let rest = &target - a * nonnegative_least_squares(a, &target);
    sizes.min() > RANK_TOLERANCE * sizes.max() && rest.norm() <= RANK_TOLERANCE * sizes.max()
}

/// Returns whether the set of vectors `A x`, `x ≥ 0`, contains the opposite of each of its vectors.
/// The set is then a subspace.
pub(crate) fn is_subspace(a: &DMatrix<f64>) -> bool {
    let svd = a.clone().svd(true, false);
    let least = RANK_TOLERANCE * svd.singular_values.max();
    let kept: Vec<usize> =
        (0..svd.singular_values.len()).filter(|index| svd.singular_values[*index] > least).collect();
    svd.u.is_some_and(|u| is_whole_space(&u.select_columns(&kept).tr_mul(a)))
}

/// Returns the `x ≥ 0` with the smallest `|A x − b|`, by the active-set method of Lawson and Hanson
/// (Solving Least Squares Problems, 1974, chapter 23).
fn nonnegative_least_squares(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let count = a.ncols();
    let least = ROUND_OFF * a.amax() * b.norm();
    let (mut x, mut free): (DVector<f64>, Vec<usize>) = (DVector::zeros(count), Vec::new());
    // Without round-off the iteration ends before this limit.
    for _ in 0..10 * count {
        let gain = a.tr_mul(&(b - a * &x));
        let bound = (0..count).filter(|column| !free.contains(column));
        let Some(next) =
            bound.max_by(|i, j| gain[*i].total_cmp(&gain[*j])).filter(|next| gain[*next] > least)
        else {
            break;
        };
        free.push(next);
        loop {
            let Ok(best) = a.select_columns(&free).svd(true, true).solve(b, ROUND_OFF) else { return x };
            // The step ends at the point at which a weight reaches zero; this weight stays zero.
            let part =
                |column: usize, to: f64| if x[column] > 0.0 { x[column] / (x[column] - to) } else { 0.0 };
            let ways = free.iter().zip(best.iter()).filter(|(_, to)| **to <= 0.0);
            let Some((way, last)) =
                ways.map(|(column, to)| (part(*column, *to), *column)).min_by(|a, b| a.0.total_cmp(&b.0))
            else {
                free.iter().zip(best.iter()).for_each(|(column, to)| x[*column] = *to);
                break;
            };
            free.iter().zip(best.iter()).for_each(|(column, to)| x[*column] += way * (to - x[*column]));
            x[last] = 0.0;
            free.retain(|column| *column != last);
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simplex_is_the_whole_space_and_what_lies_on_one_side_of_a_plane_is_not() {
        for rows in [3, 6] {
            // The columns are unit vectors and the opposite of their sum; a combination with all
            // weights 1 is zero.
            let simplex = DMatrix::from_fn(rows, rows + 1, |row, column| match column {
                column if column == rows => -1.0,
                column => f64::from(u8::from(row == column)),
            });
            assert!(is_whole_space(&simplex), "{rows}");
            for missing in 0..=rows {
                assert!(!is_whole_space(&simplex.clone().remove_column(missing)), "{rows} {missing}");
            }
            // If one column is reversed, the columns are on one side of a plane.
            for turned in 0..=rows {
                let mut half = simplex.clone();
                half.column_mut(turned).neg_mut();
                assert!(!is_whole_space(&half), "{rows} {turned}");
            }
        }
    }

    #[test]
    fn pairs_of_opposites_without_one_of_them_are_half_a_space() {
        let pairs = DMatrix::from_fn(6, 12, |row, column| match (row == column / 2, column % 2) {
            (true, 0) => 1.0,
            (true, _) => -0.3,
            (false, _) => 0.0,
        });
        assert!(is_whole_space(&pairs));
        for missing in 0..12 {
            assert!(!is_whole_space(&pairs.clone().remove_column(missing)), "{missing}");
        }
    }

    #[test]
    fn the_conditions_of_karush_kuhn_and_tucker_hold() {
        let mut seed = 1_u64;
        let mut draw = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / 2.0_f64.powi(52) - 1.0
        };
        for _ in 0..200 {
            let (a, b) = (DMatrix::from_fn(6, 9, |_, _| draw()), DVector::from_fn(6, |_, _| draw()));
            let x = nonnegative_least_squares(&a, &b);
            let gain = a.tr_mul(&(&b - &a * &x));
            for column in 0..9 {
                assert!(x[column] >= 0.0 && gain[column] < 1e-8 && (x[column] * gain[column]).abs() < 1e-8);
            }
        }
    }
}
