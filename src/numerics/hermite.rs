//! Cubic Hermite interpolation between two points, by values and derivatives at both.

/// Returns the value at the fraction `x` of an interval of the given length, between the values
/// `ends` with the derivatives `rates`. The error is proportional to the fourth power of the
/// length.
pub(crate) fn hermite<V>(x: f64, length: f64, ends: [&V; 2], rates: [&V; 2]) -> V
where
    V: Clone + std::ops::Add<V, Output = V> + std::ops::Mul<f64, Output = V>,
{
    let (x2, x3) = (x * x, x * x * x);
    ends[0].clone() * (2.0 * x3 - 3.0 * x2 + 1.0)
        + rates[0].clone() * (length * (x3 - 2.0 * x2 + x))
        + ends[1].clone() * (3.0 * x2 - 2.0 * x3)
        + rates[1].clone() * (length * (x3 - x2))
}
