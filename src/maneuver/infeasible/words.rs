//! Figures in messages: four digits, rounded to the side that keeps a claim true.

use crate::Vector3;

/// Far more than the slack that proofs allow for, far less than what four digits show.
const SLACK: f64 = 3e-6;

/// Rounded down to four significant digits: "no plan under …".
pub(super) fn at_least(value: f64) -> String {
    rounded(value, f64::floor)
}

/// Rounded up to four significant digits: "… at most".
pub(super) fn at_most(value: f64) -> String {
    rounded(value, f64::ceil)
}

/// A direction, each component to four decimals.
pub(super) fn direction(axis: &Vector3) -> String {
    // Plus zero: none is shown as −0.
    let [x, y, z] = [axis.x, axis.y, axis.z].map(|part| (part * 1e4).round() / 1e4 + 0.0);
    format!("({x}, {y}, {z})")
}

/// Four significant digits.
pub(super) fn about(value: f64) -> String {
    rounded(value, f64::round)
}

fn rounded(value: f64, round: fn(f64) -> f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let digits = 3 - value.abs().log10().floor() as i32;
    // A number that four digits give but for the slack of a proof stays what it is.
    let unit = 10.0_f64.powi(digits.abs());
    let steps = if digits >= 0 { value * unit } else { value / unit };
    let steps =
        if (steps - steps.round()).abs() < SLACK * steps.abs() { steps.round() } else { round(steps) };
    if !(-2..=8).contains(&digits) {
        return format!("{}e{}", steps / 1e3, 3 - digits);
    }
    if digits <= 0 {
        return format!("{}", steps * unit);
    }
    let text = format!("{:.*}", digits as usize, steps / unit);
    text.trim_end_matches('0').trim_end_matches('.').into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_rounded_to_the_side_of_the_claim() {
        for (value, down, up) in [
            (27.4567, "27.45", "27.46"),
            (27.45, "27.45", "27.45"),
            (0.3, "0.3", "0.3"),
            (1234.5, "1234", "1235"),
            (123_456.0, "123400", "123500"),
            (0.012_345, "0.01234", "0.01235"),
            (99.996, "99.99", "100"),
            (1.234_56e-7, "1.234e-7", "1.235e-7"),
            (1.234_56e12, "1.234e12", "1.235e12"),
            (20.0, "20", "20"),
        ] {
            assert_eq!((at_least(value).as_str(), at_most(value).as_str()), (down, up));
        }
        assert_eq!(about(27.456), "27.46");
        assert_eq!(at_least(0.0), "0");
        assert_eq!(at_most(f64::INFINITY), "inf");
    }
}
