//! Numbers for people; files have all digits.

/// `value` to `digits` significant digits, plain where that is readable: `12.7`, `1.25e-07`.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let scientific = format!("{value:.*e}", digits - 1);
    // After rounding: 9.99999 to three digits is 10.0.
    let exponent: i32 = scientific.split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or_default();
    if (-3..7).contains(&exponent) {
        let decimals = usize::try_from(digits as i32 - 1 - exponent).unwrap_or(0);
        format!("{value:.decimals$}")
    } else {
        padded(&scientific)
    }
}

/// An error: two digits and an exponent of two places, `4.0e-13`.
pub fn error(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return "not finite".into();
    }
    padded(&format!("{value:.1e}"))
}

/// A time: `2.4 ms`, `3.2 s`.
pub fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.0} µs", 1e6 * s),
        s if s < 1.0 => format!("{:.1} ms", 1e3 * s),
        s => format!("{s:.1} s"),
    }
}

/// `count` of something, with a plural: `1 turn`, `2 turns`.
pub fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Exponents of at least two places.
fn padded(scientific: &str) -> String {
    match scientific.split_once('e') {
        Some((mantissa, exponent)) => {
            let (sign, digits) = match exponent.strip_prefix('-') {
                Some(digits) => ('-', digits),
                None => ('+', exponent),
            };
            format!("{mantissa}e{sign}{digits:0>2}")
        }
        None => scientific.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people_keep_their_digits() {
        for (value, text) in [
            (12.7, "12.7000"),
            (0.06, "0.0600000"),
            (999_999.96, "1000000"),
            (9.999996, "10.0000"),
            (1.25e-7, "1.25000e-07"),
            (-3.0e12, "-3.00000e+12"),
            (0.0, "0"),
        ] {
            assert_eq!(significant(value, 6), text);
        }
        assert_eq!(error(4e-13), "4.0e-13");
        assert_eq!(error(0.0), "0");
        assert_eq!(error(f64::NAN), "not finite");
        assert_eq!(error(2.04e120), "2.0e+120");
        assert_eq!(time(0.0024), "2.4 ms");
        assert_eq!(time(2.4e-5), "24 µs");
    }
}
