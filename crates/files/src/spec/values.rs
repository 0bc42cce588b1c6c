//! Reading of single values. The type, shape and range of a value are checked; the result is the
//! value or a list of all its errors.

mod lists;

use super::grid;
use super::keys::{Kind, StepsOf};
use super::quantity::{self as q, Quantity, Sign};
use super::section::Parsed;
use super::suggest::nearest;
use super::tree::{self, Integer};
use super::{Node, Span, Value, cut, show};
use slewkit::{Matrix3, Vector3};

pub(crate) use lists::{MAX_DIRECTIONS, MAX_INTERVALS, each};

/// Code, position, reason and remedy of an error in a value.
pub(crate) type Fault = (&'static str, Span, String, String);

/// The result of reading: a value, or all its errors.
pub(crate) type Read<T> = Result<T, Vec<Fault>>;

/// Returns the result of reading a value that has one error.
pub(crate) fn wrong<T>(
    code: &'static str,
    node: &Node,
    reason: impl Into<String>,
    remedy: impl Into<String>,
) -> Read<T> {
    Err(vec![(code, node.span, reason.into(), remedy.into())])
}

/// Reads a value of the kind `kind`; tables are read elsewhere.
pub(crate) fn read(kind: Kind, node: &Node) -> Read<Parsed> {
    let several = |vectors: Vec<[f64; 3]>| Parsed::Vectors(vectors.into_iter().map(Vector3::from).collect());
    let matrix = |rows: [[f64; 3]; 3]| Parsed::Matrix(Matrix3::from_fn(|row, column| rows[row][column]));
    Ok(match kind {
        Kind::Format => Parsed::Whole(format_version(node)?),
        Kind::Text(most) => Parsed::Text(text(node, most)?.into()),
        Kind::Texts(most) => Parsed::Texts(lists::texts(node, most)?),
        Kind::Choice(now, later) => Parsed::Text(choice(node, now, later)?.into()),
        Kind::Number(quantity) => Parsed::Number(number(node, &quantity)?),
        Kind::Limit(quantity) => Parsed::Number(limit(node, &quantity)?),
        Kind::Limits(quantity, count) => Parsed::Limits(lists::limits(node, &quantity, count)?),
        Kind::Steps(of) => Parsed::Whole(steps(node, of)?),
        Kind::Count(least, most) => Parsed::Whole(count(node, least, most)?),
        Kind::Vector(quantity) => Parsed::Vector(lists::vector(node, &quantity)?.into()),
        Kind::Vectors(quantity) => several(lists::vectors(node, &quantity)?),
        Kind::Axes => several(lists::axes(node, &q::COMPONENT)?),
        Kind::Vertices(quantity) => several(lists::vertices(node, &quantity)?),
        Kind::Intervals => {
            let pairs = lists::intervals(node)?;
            Parsed::Square(pairs.into_iter().map(Vec::from).collect())
        }
        Kind::Interval => Parsed::Square(vec![lists::interval(node)?.into()]),
        Kind::Flag => Parsed::Flag(flag(node)?),
        Kind::Faces => Parsed::Faces(lists::faces(node)?),
        Kind::Quaternion => Parsed::Quaternion(lists::numbers(node, &q::ENTRY, "numbers")?),
        Kind::Matrix => matrix(lists::rows(node, &q::ENTRY)?),
        Kind::Inertia => matrix(lists::inertia(node, &q::INERTIA)?),
        Kind::Weight => Parsed::Square(lists::square(node, &q::WEIGHT, "weights", "axis")?),
        Kind::Square(quantity) => {
            Parsed::Square(lists::square(node, &quantity, "numbers", "number of the key")?)
        }
        Kind::Spread(quantity) => Parsed::Limits(lists::spread(node, &quantity)?),
        Kind::HeavenlyBody => return heavenly_body(node),
        Kind::Table(_) | Kind::List(..) | Kind::Directions | Kind::Targets => {
            return Err(Vec::new());
        }
    })
}

/// Returns the error that a value has the wrong type; `wanted` describes the expected type.
fn wrong_type<T>(node: &Node, wanted: &str) -> Read<T> {
    let remedy = match &node.value {
        Value::Text(text) if wanted.contains("number") && text.trim().parse::<f64>().is_ok() => {
            format!("remove the quotes: {}", cut(text.trim(), 40))
        }
        _ => format!("write {wanted}"),
    };
    wrong("E0024", node, format!("expected {wanted}, found {}", node.value.kind()), remedy)
}

/// Reads a boolean.
fn flag(node: &Node) -> Read<bool> {
    match node.value {
        Value::Boolean(value) => Ok(value),
        _ => wrong_type(node, "true or false"),
    }
}

/// Reads a number, which must lie in the range of its quantity.
fn number(node: &Node, quantity: &Quantity) -> Read<f64> {
    let Quantity { name, unit, smallest, largest, sign } = *quantity;
    let Value::Number(number) = &node.value else {
        let of_unit = if unit.is_empty() { String::new() } else { format!(" in {unit}") };
        return wrong_type(node, &format!("a number{of_unit}"));
    };
    let value = number.value;
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    if !value.is_finite() {
        let found =
            if value.is_nan() { "nan is not a number" } else { "the value is infinite or beyond 1e308" };
        let reason = format!("{found}; {name} must be finite");
        wrong("E0030", node, reason, format!("write a finite number, at most {}{unit}", show(largest)))
    } else if (sign == Sign::Positive && value <= 0.0) || (sign == Sign::NotNegative && value < 0.0) {
        let wanted = if sign == Sign::Positive { "positive" } else { "zero or positive" };
        let reason = format!("{name} of {}{unit} is impossible: it must be {wanted}", show(value));
        wrong("E0032", node, reason, format!("write a {wanted} number"))
    } else if value.abs() > largest || (value != 0.0 && value.abs() < smallest) {
        let (value, least, most) = (show(value), show(smallest), show(largest));
        let reason = format!("{value}{unit} is outside the range of {name}, {least} to {most}{unit}");
        wrong("E0031", node, reason, "check the exponent and the unit")
    } else {
        Ok(value)
    }
}

/// Reads a limit, which must be positive and finite.
fn limit(node: &Node, quantity: &Quantity) -> Read<f64> {
    let none = "remove the key for no limit";
    let Value::Number(tree::Number { value, .. }) = node.value else { return number(node, quantity) };
    if value.is_nan() {
        let remedy = format!("write a positive number, or {none}");
        return wrong("E0030", node, "nan is not a number and not a limit", remedy);
    }
    if value.is_infinite() {
        return wrong("E0030", node, format!("{value} is not a limit"), none);
    }
    if value > 0.0 {
        return number(node, quantity);
    }
    let Quantity { name, unit, .. } = *quantity;
    let (leaves, remedy) = match unit {
        _ if name.ends_with("norm") => ("no input", "write a positive limit, or remove the key"),
        "N·m" => (
            "no input to turn the body",
            "for an underactuated body remove the axis from `torque_axes_body`, for a failed wheel \
            remove the wheel",
        ),
        "N" => ("no input to push the body", "remove the axis from the force axes"),
        "N·m·s" => ("the wheel no momentum to store", "remove the wheel"),
        "deg/s" | "rad/s" => ("no rotation", "write a positive rate"),
        "" => ("no cost of fuel", "write a positive price, or remove the key: the price is then 1"),
        _ => ("no change of the input", "write a positive rate of change"),
    };
    let amount = format!("{} {unit}", show(value));
    wrong("E0061", node, format!("{name} of {} leaves {leaves}", amount.trim_end()), remedy)
}

/// Names of celestial bodies that a user may try to use as directions.
const HEAVENLY: [&str; 10] =
    ["sun", "moon", "earth", "mercury", "venus", "mars", "jupiter", "saturn", "uranus", "neptune"];

/// Returns the error that a celestial body is given as a direction. Its direction is unknown
/// without an ephemeris and an epoch.
pub(crate) fn heavenly_body<T>(node: &Node) -> Read<T> {
    let fixed = "write direction = \"sun\", with an epoch; or its direction at the time of the maneuver: { \
     ra_deg = 231.0, dec_deg = -18.3 }";
    let Value::Text(body) = &node.value else {
        let wanted = "a direction: { ra_deg = 231.0, dec_deg = -18.3 } or { vector = [0, 0, 1] }";
        return wrong_type(node, wanted);
    };
    let lower = body.to_lowercase();
    if HEAVENLY.contains(&lower.as_str()) {
        let reason =
            format!("the direction of \"{lower}\" depends on the time, and this key is for fixed directions");
        return wrong("E0073", node, reason, fixed);
    }
    let meant = nearest(&lower, HEAVENLY.into_iter()).map(|known| format!("did you mean \"{known}\"? Then "));
    let reason = format!("unknown body \"{}\"", cut(body, 40));
    wrong("E0072", node, reason, format!("{}{fixed}", meant.unwrap_or_default()))
}

/// Reads an integer from `least` to `most`.
fn count(node: &Node, least: i64, most: i64) -> Read<u64> {
    let value = integer(node)?;
    match u64::try_from(value) {
        Ok(count) if (least..=most).contains(&value) => Ok(count),
        _ => {
            let reason = format!("{value} is outside {least} to {most}");
            wrong("E0031", node, reason, format!("write a whole number from {least} to {most}"))
        }
    }
}

/// Reads an integer that fits into 64 bits.
fn integer(node: &Node) -> Read<i64> {
    let Value::Number(number) = &node.value else { return wrong_type(node, "a whole number") };
    let value = number.value;
    match number.integer {
        Integer::Exact(value) => Ok(value),
        Integer::TooLarge => {
            let reason = format!("{} is too large for a whole number", show(value));
            wrong("E0027", node, reason, format!("write a whole number below {:e}", 9e18))
        }
        Integer::Fraction if !value.is_finite() => {
            wrong("E0030", node, format!("{value} is not a whole number"), "write a whole number")
        }
        Integer::Fraction => {
            let reason = format!("{} is not a whole number", show(value));
            wrong("E0035", node, reason, format!("write {} or {}", value.floor(), value.ceil()))
        }
    }
}

/// Reads the number of steps of a plan or a simulation.
fn steps(node: &Node, of: StepsOf) -> Read<u64> {
    let value = integer(node)?;
    let (code, reason, remedy) = match u64::try_from(value) {
        Ok(count) if count > of.most() => grid::too_many(of, count as f64),
        Ok(count) if count >= of.least() => return Ok(count),
        _ => grid::too_few(of, value),
    };
    wrong(code, node, reason, remedy)
}

/// Reads a text of one line with at most `most` characters.
fn text(node: &Node, most: usize) -> Read<&str> {
    let Value::Text(text) = &node.value else { return wrong_type(node, "text in quotes") };
    let length = text.chars().count();
    if length > most {
        let reason = format!("the text has {length} characters, the limit is {most}");
        return wrong("E0034", node, reason, "shorten it");
    }
    Ok(text)
}

/// Reads a word, which must be in the list `now`. A word in the list `later` is reported as not yet
/// supported.
fn choice<'a>(node: &'a Node, now: &[&'static str], later: &[&'static str]) -> Read<&'a str> {
    /// Largest number of words that a message lists in full.
    const LONG: usize = 12;
    let quoted =
        |words: &[&str]| words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ");
    let Value::Text(word) = &node.value else {
        let some = if now.len() > LONG { format!("{}, …", quoted(&now[..3])) } else { quoted(now) };
        return wrong_type(node, &format!("one of {some}"));
    };
    if now.contains(&word.as_str()) {
        return Ok(word);
    }
    if later.contains(&word.as_str()) {
        let reason = format!("\"{word}\" is planned, but this version of slew does not support it yet");
        return wrong("E0019", node, reason, format!("this version has {}", quoted(now)));
    }
    let remedy = match nearest(word, now.iter().chain(later).copied()) {
        Some(known) => format!("did you mean \"{known}\"?"),
        None => format!("write one of {}", quoted(now)),
    };
    let word = cut(word, 40);
    let reason = if now.len() > LONG {
        format!("\"{word}\" is not one of the {} known words", now.len())
    } else {
        format!("\"{word}\" is not one of {}", quoted(now))
    };
    wrong("E0020", node, reason, remedy)
}

/// Reads the version of the format, which must be 1.
fn format_version(node: &Node) -> Read<u64> {
    count(node, 1, 1).or_else(|faults| match &node.value {
        Value::Number(number) if faults.iter().any(|fault| fault.0 == "E0031") => {
            let version = show(number.value);
            let reason = format!("the spec has format {version}, and this program reads format 1");
            wrong("E0023", node, reason, "write format = 1, or use a version of slew that reads it")
        }
        _ => Err(faults),
    })
}
