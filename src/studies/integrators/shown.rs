//! Numbers as the tables and messages of a comparison show them.

/// A power of ten with so many decimals and an exponent of two places, as in all reports: `4.1e-04`.
pub(super) fn power(value: f64, decimals: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let text = format!("{value:.decimals$e}");
    match text.split_once('e') {
        Some((mantissa, exponent)) => {
            let (sign, digits) = exponent.strip_prefix('-').map_or(('+', exponent), |digits| ('-', digits));
            format!("{mantissa}e{sign}{digits:0>2}")
        }
        None => text,
    }
}

/// Four digits, without zeros at the end.
pub(super) fn short(value: f64) -> String {
    if !(1e-4..1e6).contains(&value) {
        return power(value, 3);
    }
    let decimals = (3 - value.log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
