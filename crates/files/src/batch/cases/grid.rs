//! Grids as a source of cases: all combinations of given values of some keys.

use super::{MAX_CASES, check_distinct};
use crate::batch::{BatchError, Case};
use crate::spec::{Base, Override, cut};

/// An axis of a grid: a key with its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    key: String,
    values: Vec<String>,
}

impl Axis {
    /// Parses an axis in one of two notations. The text `key=start:stop:count` gives `count`
    /// uniformly spaced values, including both ends. The text `key=a,b,c` lists the values, which
    /// may be of any type, such as `[1, 0, 0],[0, 1, 0]`.
    ///
    /// # Errors
    /// Returns an error if the text does not describe an axis.
    pub fn parse(text: &str) -> Result<Self, BatchError> {
        let remedy = "write key=start:stop:count, as in maneuver.duration_s=20:200:37, or key=a,b,c";
        let wrong = |reason: String| Err(BatchError::argument("E0110", format!("--over: {reason}"), remedy));
        let Some((key, values)) = text.split_once('=') else {
            return wrong(format!("`{}` has no `=`", cut(text, 60)));
        };
        let (key, values) = (key.trim(), values.trim());
        let values = match values.split(':').collect::<Vec<_>>()[..] {
            [start, stop, count] if !values.contains(['"', '\'', '[', '{']) => {
                let number = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
                let (Some(start), Some(stop)) = (number(start), number(stop)) else {
                    return wrong(format!("`{}` does not begin with two numbers", cut(values, 60)));
                };
                match count.trim().parse::<u64>() {
                    Err(_) => return wrong(format!("the count `{}` is not a whole number", cut(count, 40))),
                    Ok(0) => return wrong(format!("`{}` has no values", cut(values, 60))),
                    Ok(count) if count > MAX_CASES => return Err(too_many(u128::from(count))),
                    Ok(1) if start != stop => {
                        return wrong(format!("one value cannot be both {start} and {stop}"));
                    }
                    Ok(count) => spaced(start, stop, count),
                }
            }
            _ => split(values).into_iter().map(String::from).collect(),
        };
        if values.iter().any(|value| value.is_empty()) {
            return wrong(format!("`{key}` has an empty value", key = cut(key, 60)));
        }
        // `Override::new` checks the path of the key and the notation of the value.
        if let Err(reason) = Override::new(key, &values[0]) {
            return wrong(reason);
        }
        Ok(Self { key: key.into(), values })
    }

    /// Returns the key of the axis, a dotted path of the spec.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// Returns the values of the axis, in the notation of a spec.
    pub fn values(&self) -> &[String] {
        &self.values
    }
}

/// Returns `count` uniformly spaced numbers from `start` to `stop` as texts. Integers are written
/// without a decimal point, so that an axis can vary a number of steps.
fn spaced(start: f64, stop: f64, count: u64) -> Vec<String> {
    let value = |index: u64| match index {
        0 => start,
        index if index + 1 == count => stop,
        // A weighted mean of the two ends accumulates no rounding errors, unlike repeated addition.
        index => {
            let part = index as f64 / (count - 1) as f64;
            start * (1.0 - part) + stop * part
        }
    };
    // The values are rounded to remove the rounding errors of the mean: 20:40:3 gives 30 and not
    // 30.000000000000004.
    let text = |value: f64| {
        let short: f64 = format!("{value:.13e}").parse().unwrap_or(value);
        let value = if (short - value).abs() <= 2.0 * f64::EPSILON * value.abs() { short } else { value };
        if value.fract() == 0.0 && value.abs() < 9e15 { format!("{value:.0}") } else { format!("{value:?}") }
    };
    (0..count).map(|index| text(value(index))).collect()
}

/// Splits a text at its commas, except at those within brackets, braces and quotes.
fn split(text: &str) -> Vec<&str> {
    let (mut parts, mut start, mut depth, mut quote) = (Vec::new(), 0, 0_i32, None);
    for (at, sign) in text.char_indices() {
        match (quote, sign) {
            (Some(open), sign) if sign == open => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(sign),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth -= 1,
            (None, ',') if depth == 0 => {
                parts.push(text[start..at].trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text[start..].trim());
    parts
}

fn too_many(count: u128) -> BatchError {
    let reason = format!("--over: {count} cases, the limit is {MAX_CASES}");
    BatchError::argument("E0034", reason, "use coarser grids, or fewer keys")
}

/// A grid: all combinations of the values of its axes.
#[derive(Debug)]
pub(super) struct Grid {
    axes: Vec<Axis>,
    count: u64,
}

impl Grid {
    pub fn new(axes: Vec<Axis>, base: &Base) -> Result<Self, BatchError> {
        if axes.is_empty() {
            let remedy = "give --over key=start:stop:count, or --over key=a,b,c";
            return Err(BatchError::argument("E0110", "no key is given", remedy));
        }
        let keys: Vec<String> = axes.iter().map(|axis| axis.key.clone()).collect();
        check_distinct(&keys, "--over")?;
        for axis in &axes {
            base.check_key(&axis.key, None)?;
            for value in &axis.values {
                base.check_value(&setting(&axis.key, value)?)?;
            }
        }
        let count = axes.iter().map(|axis| axis.values.len() as u128).product();
        if count > u128::from(MAX_CASES) {
            return Err(too_many(count));
        }
        Ok(Self { axes, count: count as u64 })
    }

    pub fn count(&self) -> u64 {
        self.count
    }

    pub fn keys(&self) -> Vec<String> {
        self.axes.iter().map(|axis| axis.key.clone()).collect()
    }

    /// Returns the keys and values of all axes as texts, for the hash of the batch.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.axes
            .iter()
            .flat_map(|axis| [axis.key.as_str()].into_iter().chain(axis.values.iter().map(String::as_str)))
    }

    /// Returns the case with the number `number`, counted from 1, which must not exceed the number
    /// of grid points.
    pub fn case(&self, number: u64) -> Case {
        let mut place = number - 1;
        let mut set: Vec<Override> = Vec::with_capacity(self.axes.len());
        for axis in self.axes.iter().rev() {
            let values = axis.values.len() as u64;
            // `new` has checked that every value can be set.
            set.extend(setting(&axis.key, &axis.values[(place % values) as usize]));
            place /= values;
        }
        set.reverse();
        Case { number, name: None, set, spec: None }
    }
}

fn setting(key: &str, value: &str) -> Result<Override, BatchError> {
    Override::new(key, value).map_err(|reason| {
        BatchError::argument("E0110", format!("--over: {reason}"), "write key=start:stop:count, or key=a,b,c")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_begin_and_end_where_they_say() {
        let axis = Axis::parse("maneuver.duration_s = 20:200:37").unwrap();
        assert_eq!(axis.values.len(), 37);
        assert_eq!((axis.values[0].as_str(), axis.values[36].as_str()), ("20", "200"));
        assert_eq!(axis.values[1], "25");
        let tenths = Axis::parse("a=0:1:11").unwrap();
        assert_eq!(tenths.values.join(" "), "0 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8 0.9 1");
        assert_eq!(Axis::parse("a=3:3:1").unwrap().values, ["3"]);
        assert_eq!(Axis::parse("a=1e-9:-1e-9:3").unwrap().values, ["1e-9", "0", "-1e-9"]);
    }

    #[test]
    fn lists_split_at_their_own_commas_only() {
        let axis = Axis::parse("a=[1, 0],[0, 1], \"x,y\" ,{ k = [1,2] }").unwrap();
        assert_eq!(axis.values, ["[1, 0]", "[0, 1]", "\"x,y\"", "{ k = [1,2] }"]);
        assert_eq!(Axis::parse("epoch=\"2026-11-21T07:00:00 UTC\"").unwrap().values.len(), 1);
    }

    #[test]
    fn empty_and_senseless_grids_are_refused() {
        for text in [
            "a",
            "=1",
            "a=",
            "a=1:2",
            "a=1:2:0",
            "a=1:2:1",
            "a=1:x:3",
            "a=1:2:-3",
            "a=1:2:2.5",
            "a=nan:2:3",
            "a=1:inf:3",
            "a=1,,2",
            "a=1:2:99999999999",
            "a..b=1",
        ] {
            // `1:2` is parsed as a text. The error appears when the text is set to a key that needs
            // a number.
            assert_eq!(Axis::parse(text).is_err(), text != "a=1:2", "{text}");
        }
    }
}
