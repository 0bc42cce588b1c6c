//! Butcher tableaux of the explicit Runge–Kutta methods.

/// The coefficients of a method `k_i = f(y + h Σ_{j<i} a_ij k_j)`, `y⁺ = y + h Σ b_i k_i`; row i of
/// `a` has i entries.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tableau {
    pub c: &'static [f64],
    pub a: &'static [&'static [f64]],
    pub b: &'static [f64],
    /// Weights `e_i` of the error estimate `h Σ e_i k_i` of an embedded pair; `None` without one.
    pub error: Option<&'static [f64]>,
    pub order: u32,
}

impl Tableau {
    /// Checks the shapes and the row sums of the coefficients.
    ///
    /// # Panics
    /// Panics if the coefficients are inconsistent, because one of them is misprinted.
    pub fn checked(self) -> Self {
        let near = |sum: f64, expected: f64| (sum - expected).abs() < 1e-14;
        assert_eq!((self.a.len(), self.b.len()), (self.c.len(), self.c.len()), "one row per stage");
        for (i, (row, c)) in self.a.iter().zip(self.c).enumerate() {
            assert_eq!(row.len(), i, "explicit");
            assert!(near(row.iter().sum(), *c), "row {i} adds up to its node");
        }
        assert!(near(self.b.iter().sum(), 1.0), "the weights add up to one");
        if let Some(error) = self.error {
            assert!(near(error.iter().sum(), 0.0), "an estimate of nothing is nothing");
        }
        self
    }
}

/// The explicit midpoint rule (Runge 1895).
pub(super) const MIDPOINT: Tableau =
    Tableau { c: &[0.0, 0.5], a: &[&[], &[0.5]], b: &[0.0, 1.0], error: None, order: 2 };

/// The classical fourth-order method (Kutta 1901).
pub(super) const KUTTA_4: Tableau = Tableau {
    c: &[0.0, 0.5, 0.5, 1.0],
    a: &[&[], &[0.5], &[0.0, 0.5], &[0.0, 0.0, 1.0]],
    b: &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
    error: None,
    order: 4,
};

/// A method of order 3 with products of exponentials (Crouch, Grossman, J. Nonlinear Sci. 3, 1993;
/// as in Hairer, Lubich, Wanner, Geometric Numerical Integration, IV.8).
pub(super) const CROUCH_GROSSMAN_3: Tableau = Tableau {
    c: &[0.0, 3.0 / 4.0, 17.0 / 24.0],
    a: &[&[], &[3.0 / 4.0], &[119.0 / 216.0, 17.0 / 108.0]],
    b: &[13.0 / 51.0, -2.0 / 3.0, 24.0 / 17.0],
    error: None,
    order: 3,
};

/// Fehlberg's pair of orders 7 and 8 with 13 stages (NASA TR R-287, 1968, table X). Integration
/// continues from the result of order 8.
#[rustfmt::skip]
pub(super) const FEHLBERG_78: Tableau = Tableau {
    c: &[
        0.0, 2.0 / 27.0, 1.0 / 9.0, 1.0 / 6.0, 5.0 / 12.0, 1.0 / 2.0, 5.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0,
        1.0 / 3.0, 1.0, 0.0, 1.0,
    ],
    a: &[
        &[],
        &[2.0 / 27.0],
        &[1.0 / 36.0, 1.0 / 12.0],
        &[1.0 / 24.0, 0.0, 1.0 / 8.0],
        &[5.0 / 12.0, 0.0, -25.0 / 16.0, 25.0 / 16.0],
        &[1.0 / 20.0, 0.0, 0.0, 1.0 / 4.0, 1.0 / 5.0],
        &[-25.0 / 108.0, 0.0, 0.0, 125.0 / 108.0, -65.0 / 27.0, 125.0 / 54.0],
        &[31.0 / 300.0, 0.0, 0.0, 0.0, 61.0 / 225.0, -2.0 / 9.0, 13.0 / 900.0],
        &[2.0, 0.0, 0.0, -53.0 / 6.0, 704.0 / 45.0, -107.0 / 9.0, 67.0 / 90.0, 3.0],
        &[
            -91.0 / 108.0, 0.0, 0.0, 23.0 / 108.0, -976.0 / 135.0, 311.0 / 54.0, -19.0 / 60.0, 17.0 / 6.0,
            -1.0 / 12.0,
        ],
        &[
            2383.0 / 4100.0, 0.0, 0.0, -341.0 / 164.0, 4496.0 / 1025.0, -301.0 / 82.0, 2133.0 / 4100.0,
            45.0 / 82.0, 45.0 / 164.0, 18.0 / 41.0,
        ],
        &[3.0 / 205.0, 0.0, 0.0, 0.0, 0.0, -6.0 / 41.0, -3.0 / 205.0, -3.0 / 41.0, 3.0 / 41.0, 6.0 / 41.0, 0.0],
        &[
            -1777.0 / 4100.0, 0.0, 0.0, -341.0 / 164.0, 4496.0 / 1025.0, -289.0 / 82.0, 2193.0 / 4100.0,
            51.0 / 82.0, 33.0 / 164.0, 12.0 / 41.0, 0.0, 1.0,
        ],
    ],
    b: &[
        0.0, 0.0, 0.0, 0.0, 0.0, 34.0 / 105.0, 9.0 / 35.0, 9.0 / 35.0, 9.0 / 280.0, 9.0 / 280.0, 0.0,
        41.0 / 840.0, 41.0 / 840.0,
    ],
    error: Some(&[
        41.0 / 840.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 41.0 / 840.0, -41.0 / 840.0, -41.0 / 840.0,
    ]),
    order: 8,
};

#[cfg(test)]
mod tests {
    use super::*;

    /// A rooted tree, as the indices of its subtrees in a list of smaller trees, in non-increasing
    /// order.
    type Tree = Vec<usize>;

    /// Returns all rooted trees up to an order, smaller trees first, and their sizes.
    fn trees(order: usize) -> (Vec<Tree>, Vec<usize>) {
        let (mut trees, mut sizes): (Vec<Tree>, Vec<usize>) = (vec![vec![]], vec![1]);
        for size in 2..=order {
            let known = trees.len();
            // Partial trees whose subtrees are in non-increasing order: (subtrees, size so far).
            let mut open = vec![(Vec::new(), 1)];
            while let Some((tree, so_far)) = open.pop() {
                if so_far == size {
                    trees.push(tree);
                    sizes.push(size);
                    continue;
                }
                let limit = tree.last().map_or(known, |last| last + 1);
                for subtree in (0..limit).filter(|subtree| so_far + sizes[*subtree] <= size) {
                    let mut longer = tree.clone();
                    longer.push(subtree);
                    open.push((longer, so_far + sizes[subtree]));
                }
            }
        }
        (trees, sizes)
    }

    /// Returns the largest violation of the order conditions `Σ b_i φ_i(t) = 1/γ(t)` over all trees
    /// of each order.
    fn violations(tableau: &Tableau, weights: &[f64], order: usize) -> Vec<f64> {
        let (trees, sizes) = trees(order);
        let stages = tableau.c.len();
        let mut worst = vec![0.0; order + 1];
        // φ of the stage value and γ of every tree.
        let mut phis: Vec<Vec<f64>> = Vec::new();
        let mut gammas: Vec<f64> = Vec::new();
        for (tree, size) in trees.iter().zip(&sizes) {
            let mut phi = vec![1.0; stages];
            let mut gamma = *size as f64;
            for subtree in tree {
                gamma *= gammas[*subtree];
                for (i, phi) in phi.iter_mut().enumerate() {
                    *phi *= tableau.a[i].iter().zip(&phis[*subtree]).map(|(a, phi)| a * phi).sum::<f64>();
                }
            }
            let sum: f64 = weights.iter().zip(&phi).map(|(b, phi)| b * phi).sum();
            let error = (sum - 1.0 / gamma).abs();
            worst[*size] = if error > worst[*size] { error } else { worst[*size] };
            phis.push(phi);
            gammas.push(gamma);
        }
        worst
    }

    #[test]
    fn there_are_as_many_rooted_trees_as_cayley_counted() {
        let (_, sizes) = trees(8);
        let count = |order| sizes.iter().filter(|size| **size == order).count();
        assert_eq!((1..=8).map(count).collect::<Vec<_>>(), [1, 1, 2, 4, 9, 20, 48, 115]);
    }

    #[test]
    fn every_order_condition_holds_and_one_of_the_next_order_fails() {
        for tableau in [MIDPOINT, KUTTA_4, CROUCH_GROSSMAN_3, FEHLBERG_78] {
            let order = tableau.checked().order as usize;
            let worst = violations(&tableau, tableau.b, order + 1);
            assert!(worst[..=order].iter().all(|error| *error < 1e-14), "order {order}: {worst:?}");
            assert!(worst[order + 1] > 1e-8, "order {order}: {worst:?}");
        }
    }

    #[test]
    fn fehlbergs_estimate_is_the_difference_to_a_result_of_order_7() {
        let error = FEHLBERG_78.error.unwrap();
        let lower: Vec<f64> = FEHLBERG_78.b.iter().zip(error).map(|(b, e)| b + e).collect();
        let worst = violations(&FEHLBERG_78, &lower, 8);
        assert!(worst[..=7].iter().all(|error| *error < 1e-14) && worst[8] > 1e-8, "{worst:?}");
    }
}
