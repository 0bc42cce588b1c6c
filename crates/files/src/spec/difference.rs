//! Comparison of two specs, key by key.

use super::cut;
use serde::Serialize;
use serde_json::Value;
use std::fmt;

/// A key whose values differ between two specs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Dotted path of the key.
    pub key: String,
    /// Value of the key in the first spec, as JSON.
    pub first: String,
    /// Value of the key in the second spec, as JSON.
    pub second: String,
}

/// Describes the difference between the spec of a plan and the spec against which the plan is
/// verified. Long lists of numbers are truncated.
impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        const SHOWN: usize = 60;
        let [first, second] = [&self.first, &self.second].map(|value| cut(value, SHOWN));
        write!(f, "{}: {first} in the plan, {second} in the spec", self.key)
    }
}

/// Largest relative difference between two numbers that counts as round-off, for example of an
/// angle computed on another machine.
const ROUND_OFF: f64 = 1e-12;

/// Returns the keys whose values in two trees differ by more than round-off.
pub(super) fn differences(first: &Value, second: &Value) -> Vec<Difference> {
    let mut found = Vec::new();
    compare("", first, second, &mut found);
    found
}

fn compare(key: &str, first: &Value, second: &Value, found: &mut Vec<Difference>) {
    match (first, second) {
        (Value::Object(a), Value::Object(b)) => {
            for name in a.keys().chain(b.keys().filter(|name| !a.contains_key(*name))) {
                let path = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
                let value = |map: &serde_json::Map<String, Value>| map.get(name).cloned();
                compare(&path, &value(a).unwrap_or_default(), &value(b).unwrap_or_default(), found);
            }
        }
        _ if agree(first, second) => {}
        // Tables in a list, such as constraints, are compared one by one.
        (Value::Array(a), Value::Array(b))
            if a.len() == b.len() && a.iter().chain(b).all(Value::is_object) =>
        {
            for (index, (first, second)) in a.iter().zip(b).enumerate() {
                compare(&format!("{key}.{index}"), first, second, found);
            }
        }
        _ => found.push(Difference { key: key.into(), first: first.to_string(), second: second.to_string() }),
    }
}

fn agree(first: &Value, second: &Value) -> bool {
    match (first, second) {
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(first, second)| agree(first, second))
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap_or(f64::NAN), b.as_f64().unwrap_or(f64::NAN));
            (a - b).abs() <= ROUND_OFF * a.abs().max(b.abs()).max(1.0)
        }
        (Value::Object(a), Value::Object(b)) => {
            let has = |(key, first): (&String, &Value)| b.get(key).is_some_and(|second| agree(first, second));
            a.len() == b.len() && a.iter().all(has)
        }
        _ => first == second,
    }
}
