//! The polynomial through given values, or through values and derivatives, by divided differences.
//!
//! Its value is `c₀ + (x − x₀)(c₁ + (x − x₁)(c₂ + …))` with nodes `xₖ`. If derivatives are given,
//! each node occurs twice, and the divided difference of two equal nodes is the derivative.

/// Returns the value at `x` of the polynomial with `values` at distinct `nodes` and, if given, the
/// derivatives `slopes` at the nodes.
///
/// Returns `None` if the numbers of nodes, values and derivatives differ, or if no node is given.
pub fn through<const N: usize>(
    nodes: &[f64],
    values: &[[f64; N]],
    slopes: Option<&[[f64; N]]>,
    x: f64,
) -> Option<[f64; N]> {
    if nodes.is_empty() || nodes.len() != values.len() || slopes.is_some_and(|all| all.len() != nodes.len()) {
        return None;
    }
    let times = if slopes.is_some() { 2 } else { 1 };
    let count = times * nodes.len();
    let node = |k: usize| nodes[k / times];
    let mut differences: Vec<[f64; N]> = (0..count).map(|k| values[k / times]).collect();
    for order in 1..count {
        for k in (order..count).rev() {
            let width = node(k) - node(k - order);
            differences[k] = match slopes {
                Some(slopes) if order == 1 && k % 2 == 1 => slopes[k / 2],
                _ => std::array::from_fn(|i| (differences[k][i] - differences[k - 1][i]) / width),
            };
        }
    }
    let mut found = differences[count - 1];
    for k in (0..count - 1).rev() {
        let ahead = x - node(k);
        found = std::array::from_fn(|i| differences[k][i] + ahead * found[i]);
    }
    Some(found)
}

/// Returns the index of the first of `count` consecutive nodes around `x`. Equally many nodes are
/// before and after `x`, if they exist.
pub fn about(nodes: &[f64], count: usize, x: f64) -> usize {
    let after = nodes.partition_point(|node| *node <= x);
    after.saturating_sub(count.div_ceil(2)).min(nodes.len().saturating_sub(count))
}

#[cfg(test)]
mod tests {
    use super::{about, through};

    /// Checks that a polynomial of degree 5 is recovered from six values, and from three values and
    /// three derivatives, at nonuniform nodes.
    #[test]
    fn a_polynomial_is_found_again() {
        let value = |x: f64| [1.0 - 2.0 * x + 0.5 * x.powi(3) - 0.1 * x.powi(5), x * x];
        let slope = |x: f64| [-2.0 + 1.5 * x * x - 0.5 * x.powi(4), 2.0 * x];
        let nodes = [-1.3, -0.4, 0.1, 0.9, 1.6, 2.0];
        let values = nodes.map(value);
        let near = |found: [f64; 2], x: f64| (0..2).all(|i| (found[i] - value(x)[i]).abs() < 1e-13);
        for x in [-1.3, -1.0, 0.33, 1.9, 2.0] {
            assert!(near(through(&nodes, &values, None, x).unwrap(), x));
            let three = [0, 2, 4];
            let [values, slopes] = [three.map(|k| value(nodes[k])), three.map(|k| slope(nodes[k]))];
            assert!(near(through(&three.map(|k| nodes[k]), &values, Some(&slopes), x).unwrap(), x));
        }
        assert_eq!(through::<1>(&[], &[], None, 0.0), None);
        assert_eq!(through(&[0.0, 1.0], &[[0.0]], None, 0.0), None);
    }

    #[test]
    fn nodes_lie_about_a_place() {
        let nodes = [0.0, 1.0, 2.0, 3.0, 4.0];
        for (x, count, wanted) in
            [(2.5, 2, 2), (2.5, 4, 1), (0.2, 4, 0), (3.9, 4, 1), (4.0, 2, 3), (-1.0, 3, 0)]
        {
            assert_eq!(about(&nodes, count, x), wanted, "{x} {count}");
        }
    }
}
