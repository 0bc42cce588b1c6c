//! Rounded numbers for text. Files contain all digits.

/// Formats `value` to `digits` significant digits, without an exponent if the text stays readable:
/// `12.7`, `1.25e-07`.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let scientific = format!("{value:.*e}", digits - 1);
    // The exponent is taken from the rounded number: 9.99999 to three digits is 10.0.
    let exponent: i32 = scientific.split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or_default();
    if (-3..7).contains(&exponent) {
        let decimals = usize::try_from(digits as i32 - 1 - exponent).unwrap_or(0);
        format!("{value:.decimals$}")
    } else {
        padded(&scientific)
    }
}

/// Formats all digits of a number. An exponent replaces a long row of zeros: `0.02`, `3e-5`.
pub fn exact(value: f64) -> String {
    if plain(value) { format!("{value}") } else { format!("{value:e}") }
}

/// Formats to `digits` significant digits, but keeps all digits before the decimal point, and omits
/// zeros at the end: `12.7`, `1.25e-7`.
pub fn rounded(value: f64, digits: usize) -> String {
    if !plain(value) {
        let text = format!("{value:.*e}", digits - 1);
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", without_zeros(mantissa));
    }
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    decimals(value, (digits as i32 - 1 - value.abs().log10().floor() as i32).max(0) as usize)
}

/// Formats to four significant digits, but keeps all digits before the decimal point, and omits
/// zeros at the end.
pub fn short(value: f64) -> String {
    rounded(value, 4)
}

/// Formats to `decimals` decimals, without zeros at the end.
pub fn decimals(value: f64, decimals: usize) -> String {
    without_zeros(&format!("{value:.decimals$}")).into()
}

/// Formats a value rounded down to four significant digits, so that "no plan is shorter than …"
/// stays true.
pub fn at_least(value: f64) -> String {
    to_one_side(value, 4, f64::floor)
}

/// Formats a value rounded up to four significant digits, so that "… at most" stays true.
pub fn at_most(value: f64) -> String {
    to_one_side(value, 4, f64::ceil)
}

/// Formats a value rounded to four significant digits, even if it has more digits before the
/// decimal point.
pub fn about(value: f64) -> String {
    to_one_side(value, 4, f64::round)
}

/// Returns the smallest number of four significant digits that is not below a positive `value`; 0
/// for 0.
pub fn rounded_up(value: f64) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    // A product with a power of ten is seldom exact, so the text is parsed as a spec would be.
    let unit = 10_f64.powi(value.log10().floor() as i32 - 3);
    let text = format!("{:.3e}", (value / unit).ceil() * unit);
    text.parse().unwrap_or(value)
}

/// Formats two figures for a comparison, with at least `digits` digits and enough to distinguish
/// them. `told` formats one figure to a number of digits. Equal figures have equal texts.
pub fn told_apart(pair: [f64; 2], digits: usize, told: impl Fn(f64, usize) -> String) -> [String; 2] {
    // Two numbers whose first seventeen digits are equal are equal.
    const MOST: usize = 17;
    let mut found = pair.map(|value| told(value, digits));
    for digits in digits..=MOST {
        if found[0] != found[1] || pair[0] == pair[1] {
            break;
        }
        found = pair.map(|value| told(value, digits));
    }
    found
}

/// Formats a required value, rounded down, and a possible value, rounded up, with at least four
/// digits and enough to show that the required value is larger.
pub fn exceeding(needed: f64, possible: f64) -> [String; 2] {
    let of = |digits| [to_one_side(needed, digits, f64::floor), to_one_side(possible, digits, f64::ceil)];
    let value = |text: &String| text.parse().unwrap_or(f64::NAN);
    let mut found = of(4);
    for digits in 5..=15 {
        let [first, second]: [f64; 2] = found.each_ref().map(value);
        if first > second || needed <= possible {
            break;
        }
        found = of(digits);
    }
    found
}

/// Formats an error with two digits and an exponent of at least two digits: `4.0e-13`.
pub fn error(value: f64) -> String {
    scientific(value, 1)
}

/// Formats a number with `decimals` decimals and an exponent of at least two digits: `4.12e-13`.
pub fn scientific(value: f64, decimals: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return "not finite".into();
    }
    padded(&format!("{value:.decimals$e}"))
}

/// Formats a time in a suitable unit: `2.4 ms`, `3.2 s`.
pub fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.0} µs", 1e6 * s),
        s if s < 1.0 => format!("{:.1} ms", 1e3 * s),
        s => format!("{s:.1} s"),
    }
}

/// Formats `count` and a noun in singular or plural: `1 turn`, `2 turns`.
pub fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Returns whether a number is readable without an exponent.
fn plain(value: f64) -> bool {
    value == 0.0 || !value.is_finite() || (1e-4..1e7).contains(&value.abs())
}

/// Relative tolerance within which a number counts as exactly representable by four digits. It is
/// much larger than the slack of proofs, and much smaller than the last of four digits. With more
/// digits it is a fraction of the last digit.
const SLACK: f64 = 3e-6;

fn to_one_side(value: f64, digits: i32, round: fn(f64) -> f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let decimals_of = digits - 1 - value.abs().log10().floor() as i32;
    // A number that equals its rounding up to the slack of a proof is not rounded to one side.
    let slack = SLACK * 10.0_f64.powi(4 - digits);
    let unit = 10.0_f64.powi(decimals_of.abs());
    let steps = if decimals_of >= 0 { value * unit } else { value / unit };
    let steps =
        if (steps - steps.round()).abs() < slack * steps.abs() { steps.round() } else { round(steps) };
    if !(-2..=8).contains(&(decimals_of - (digits - 4))) {
        return format!("{}e{}", steps / 10.0_f64.powi(digits - 1), digits - 1 - decimals_of);
    }
    if decimals_of <= 0 { format!("{}", steps * unit) } else { decimals(steps / unit, decimals_of as usize) }
}

/// Removes zeros at the end of the decimals.
fn without_zeros(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

/// Extends the exponent to at least two digits.
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
    fn figures_that_differ_are_told_with_the_digits_that_show_it() {
        let told = |pair| told_apart(pair, 4, rounded);
        assert_eq!(told([0.1042, 0.10416]), ["0.1042", "0.10416"]);
        assert_eq!(told([0.2, 0.1]), ["0.2", "0.1"]);
        assert_eq!(told([0.3, 0.3]), ["0.3", "0.3"]);
        let [more, less] = told([1.0 + f64::EPSILON, 1.0]);
        assert!(more != less, "{more} {less}");
        assert_eq!(exceeding(12.342, 5.0), ["12.34", "5"]);
        assert_eq!(exceeding(0.104_21, 0.104_19), ["0.10421", "0.10419"]);
        assert_eq!(exceeding(2.000_001e9, 2e9), ["2.000001e9", "2e9"]);
    }

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

    #[test]
    fn figures_in_messages_have_no_zeros_at_the_end() {
        for (value, text) in [
            (0.3, "0.3"),
            (100.0, "100"),
            (12.345_6, "12.35"),
            (123_456.7, "123457"),
            (-0.000_25, "-0.00025"),
            (1e-5, "1e-5"),
            (2.504_9e9, "2.505e9"),
            (0.0, "0"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(short(value), text);
        }
        assert_eq!(rounded(1.0 / 3.0, 9), "0.333333333");
        assert_eq!((exact(3e-5), exact(0.1 + 0.2)), ("3e-5".into(), "0.30000000000000004".into()));
        assert_eq!(decimals(0.25, 4), "0.25");
        assert_eq!(scientific(4.123e-4, 2), "4.12e-04");
        assert_eq!(rounded_up(12.340_1), 12.35);
        assert_eq!(rounded_up(0.0), 0.0);
    }

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
