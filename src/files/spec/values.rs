//! One value at a time: its type, its shape, its range. Every function collects what is wrong in
//! `faults` and returns the value only if nothing is.

use super::keys::{Kind, MAX_LISTED, MAX_STEPS};
use super::quantity::{self as q, Quantity, Sign};
use super::section::Parsed;
use super::tree::Integer;
use super::{Limits, Node, Span, Value, cut, show};
use crate::maneuver::Problem;
use crate::{Matrix3, Vector3};

/// What is wrong with a value: code, place, reason, remedy.
pub(crate) type Fault = (&'static str, Span, String, String);

/// Reads a value of this kind, one that holds no tables.
pub(crate) fn read(kind: Kind, node: &Node, faults: &mut Vec<Fault>) -> Option<Parsed> {
    let several = |vectors: Vec<[f64; 3]>| Parsed::Vectors(vectors.into_iter().map(Vector3::from).collect());
    let matrix = |rows: [[f64; 3]; 3]| Parsed::Matrix(Matrix3::from_fn(|row, column| rows[row][column]));
    match kind {
        Kind::Format => format_version(node, faults).map(Parsed::Whole),
        Kind::Text(most) => text(node, most, faults).map(|text| Parsed::Text(text.into())),
        Kind::Texts(most) => texts(node, most, faults).map(Parsed::Texts),
        Kind::Choice(now, later) => choice(node, now, later, faults).map(|word| Parsed::Text(word.into())),
        Kind::Number(quantity) => number(node, &quantity, faults).map(Parsed::Number),
        Kind::Limit(quantity) => limit(node, &quantity, faults).map(Parsed::Number),
        Kind::Limits(quantity, count) => limits(node, &quantity, count, faults).map(Parsed::Limits),
        Kind::Steps => steps(node, faults).map(Parsed::Whole),
        Kind::LongSteps => long_steps(node, faults).map(Parsed::Whole),
        Kind::Count(least, most) => count(node, least, most, faults).map(Parsed::Whole),
        Kind::Vector(quantity) => vector(node, &quantity, faults).map(|given| Parsed::Vector(given.into())),
        Kind::Vectors(quantity) => vectors(node, &quantity, faults).map(several),
        Kind::Axes => axes(node, &q::COMPONENT, faults).map(several),
        Kind::Vertices(quantity) => vertices(node, &quantity, faults).map(several),
        Kind::Faces => faces(node, faults).map(Parsed::Faces),
        Kind::Quaternion => numbers(node, &q::ENTRY, "numbers", faults).map(Parsed::Quaternion),
        Kind::Matrix => rows(node, &q::ENTRY, faults).map(matrix),
        Kind::Inertia => inertia(node, &q::INERTIA, faults).map(matrix),
        Kind::Weight => weight(node, &q::WEIGHT, faults).map(Parsed::Weight),
        Kind::HeavenlyBody => {
            heavenly_body(node, faults);
            None
        }
        Kind::Table(_) | Kind::List(..) | Kind::Directions | Kind::Later(_) => None,
    }
}

/// Most inputs of one kind, and so the longest list of numbers that can make sense.
const MAX_AXES: usize = crate::mechanics::actuators::ActuatorSet::MAX_INPUTS;

/// The value is of another type.
fn wrong_type(node: &Node, wanted: &str, faults: &mut Vec<Fault>) {
    let remedy = match &node.value {
        Value::Text(text) if wanted.contains("number") && text.trim().parse::<f64>().is_ok() => {
            format!("remove the quotes: {}", cut(text.trim(), 40))
        }
        _ => format!("write {wanted}"),
    };
    faults.push(("E0024", node.span, format!("expected {wanted}, found {}", node.value.kind()), remedy));
}

/// A number within the range of its quantity.
fn number(node: &Node, quantity: &Quantity, faults: &mut Vec<Fault>) -> Option<f64> {
    let Value::Number(number) = &node.value else {
        let wanted = if quantity.unit.is_empty() {
            "a number".into()
        } else {
            format!("a number in {}", quantity.unit)
        };
        wrong_type(node, &wanted, faults);
        return None;
    };
    let value = number.value;
    let Quantity { name, unit, smallest, largest, sign } = *quantity;
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    if !value.is_finite() {
        let found =
            if value.is_nan() { "nan is not a number" } else { "the value is infinite or beyond 1e308" };
        let reason = format!("{found}; {name} must be finite");
        faults.push((
            "E0030",
            node.span,
            reason,
            format!("write a finite number, at most {}{unit}", show(largest)),
        ));
    } else if (sign == Sign::Positive && value <= 0.0) || (sign == Sign::NotNegative && value < 0.0) {
        let wanted = if sign == Sign::Positive { "positive" } else { "zero or positive" };
        let reason = format!("{name} of {}{unit} is not possible: it must be {wanted}", show(value));
        faults.push(("E0032", node.span, reason, format!("write a {wanted} number")));
    } else if value.abs() > largest || (value != 0.0 && value.abs() < smallest) {
        let reason = format!(
            "{}{unit} is outside the range of {name}, {} to {}{unit}",
            show(value),
            show(smallest),
            show(largest)
        );
        faults.push(("E0031", node.span, reason, "check the exponent and the unit".into()));
    } else {
        return Some(value);
    }
    None
}

/// A limit: positive and finite.
fn limit(node: &Node, quantity: &Quantity, faults: &mut Vec<Fault>) -> Option<f64> {
    let none = "leave the key out: without it there is no limit";
    match &node.value {
        Value::Number(number) if number.value.is_nan() => {
            let reason = "nan is not a number, and no limit".to_string();
            faults.push(("E0030", node.span, reason, format!("write a positive number, or {none}")));
            None
        }
        Value::Number(number) if number.value.is_infinite() => {
            let reason = format!("a limit of {} is not a limit", number.value);
            faults.push(("E0030", node.span, reason, none.into()));
            None
        }
        Value::Number(number) if number.value <= 0.0 => {
            let Quantity { name, unit, .. } = *quantity;
            let (leaves, remedy) = match unit {
                _ if name.ends_with("norm") => {
                    ("nothing to act with", "write a positive limit, or leave the key out")
                }
                "N·m" => (
                    "nothing to turn the body with",
                    "for an underactuated body leave the axis out of `torque_axes_body`, for a failed wheel the wheel",
                ),
                "N" => ("nothing to push the body with", "leave the axis out of the force axes"),
                "N·m·s" => ("the wheel no momentum to take", "leave the wheel out"),
                "deg/s" | "rad/s" => ("no way to turn", "write a positive rate"),
                _ => ("the input no way to change", "write a positive rate of change"),
            };
            let reason = format!("{name} of {} {unit} leaves {leaves}", show(number.value));
            faults.push(("E0061", node.span, reason, remedy.into()));
            None
        }
        _ => number(node, quantity, faults),
    }
}

/// One limit for all, or a list: `count` of them if that is known, else at most [`MAX_AXES`].
fn limits(node: &Node, quantity: &Quantity, count: Option<usize>, faults: &mut Vec<Fault>) -> Option<Limits> {
    let Value::Array(items) = &node.value else {
        return limit(node, quantity, faults).map(Limits::All);
    };
    let items = match count {
        Some(count) => self::items(node, count, "limits (x, y, z), or is one number", faults)?,
        None if items.len() > MAX_AXES => {
            let reason = format!("{} limits, at most {MAX_AXES} are possible", items.len());
            faults.push(("E0034", node.span, reason, "give one limit per axis".into()));
            return None;
        }
        None => items,
    };
    let limits: Vec<_> = items.iter().filter_map(|item| limit(item, quantity, faults)).collect();
    (limits.len() == items.len()).then_some(Limits::Each(limits))
}

/// One vector, or a list of them, at most [`MAX_AXES`]; none of length zero.
fn vectors(node: &Node, quantity: &Quantity, faults: &mut Vec<Fault>) -> Option<Vec<[f64; 3]>> {
    match &node.value {
        Value::Array(items) if items.is_empty() => {
            let reason = "the list is empty".to_string();
            faults.push(("E0026", node.span, reason, "give one vector or several: [[0, 0, 1]]".into()));
            None
        }
        Value::Array(items) if items.iter().all(|item| matches!(item.value, Value::Number(_))) => {
            let vector = vector(node, quantity, faults)?;
            not_zero(node, vector, faults).then(|| vec![vector])
        }
        Value::Array(_) => axes(node, quantity, faults),
        other => {
            let reason = format!("expected a vector or a list of vectors, found {}", other.kind());
            faults.push(("E0025", node.span, reason, "write [0, 0, 1] or [[0, 0, 1], [0, 1, 0]]".into()));
            None
        }
    }
}

fn not_zero(node: &Node, vector: [f64; 3], faults: &mut Vec<Fault>) -> bool {
    let zero = vector.iter().all(|value| *value == 0.0);
    if zero {
        let reason = "an axis of length zero has no direction".into();
        faults.push(("E0054", node.span, reason, "leave the axis out, or give it a direction".into()));
    }
    !zero
}

/// Most boresights or directions of one constraint.
pub(crate) const MAX_DIRECTIONS: usize = MAX_AXES;

/// Heavenly bodies that a user may think of.
const HEAVENLY: [&str; 10] =
    ["sun", "moon", "earth", "mercury", "venus", "mars", "jupiter", "saturn", "uranus", "neptune"];

/// A heavenly body in place of a direction: without ephemerides and an epoch nobody knows where it is.
pub(crate) fn heavenly_body(node: &Node, faults: &mut Vec<Fault>) {
    let Value::Text(body) = &node.value else {
        return wrong_type(
            node,
            "a direction: { ra_deg = 231.0, dec_deg = -18.3 } or { vector = [0, 0, 1] }",
            faults,
        );
    };
    let lower = body.to_lowercase();
    let fixed = "write its direction at the time of the maneuver: { ra_deg = 231.0, dec_deg = -18.3 }";
    if HEAVENLY.contains(&lower.as_str()) {
        let reason = format!(
            "where \"{lower}\" stands depends on the time: that takes an epoch and an ephemeris, which are not read yet"
        );
        faults.push(("E0073", node.span, reason, fixed.into()));
    } else {
        let known = super::suggest::nearest(&lower, HEAVENLY.into_iter());
        let meant = known.map_or(String::new(), |known| format!("did you mean \"{known}\"? Then "));
        let reason = format!("unknown body \"{}\"", cut(body, 40));
        faults.push(("E0072", node.span, reason, format!("{meant}{fixed}")));
    }
}

/// Texts of one line, at most `most` of them.
fn texts(node: &Node, most: usize, faults: &mut Vec<Fault>) -> Option<Vec<String>> {
    let Value::Array(items) = &node.value else {
        let reason = format!("expected a list of texts, found {}", node.value.kind());
        faults.push(("E0025", node.span, reason, "write [\"one\", \"two\"]".into()));
        return None;
    };
    if items.len() > most {
        let reason = format!("the list has {}, the limit is {most}", items.len());
        faults.push(("E0034", node.span, reason, "shorten it".into()));
        return None;
    }
    let texts: Vec<_> = items.iter().filter_map(|item| text(item, 200, faults)).map(str::to_string).collect();
    (texts.len() == items.len()).then_some(texts)
}

/// A whole number from `least` to `most`.
fn count(node: &Node, least: i64, most: i64, faults: &mut Vec<Fault>) -> Option<u64> {
    let value = integer(node, faults)?;
    if !(least..=most).contains(&value) {
        let reason = format!("{value} is outside {least} to {most}");
        faults.push(("E0031", node.span, reason, format!("write a whole number from {least} to {most}")));
        return None;
    }
    u64::try_from(value).ok()
}

/// Any whole number that fits.
fn integer(node: &Node, faults: &mut Vec<Fault>) -> Option<i64> {
    let Value::Number(number) = &node.value else {
        wrong_type(node, "a whole number", faults);
        return None;
    };
    match number.integer {
        Integer::Exact(value) => return Some(value),
        Integer::TooLarge => {
            let reason = format!("{} is too large for a whole number", show(number.value));
            faults.push(("E0027", node.span, reason, format!("write a whole number below {:e}", 9e18)));
        }
        Integer::Fraction if !number.value.is_finite() => {
            let reason = format!("{} is not a whole number", number.value);
            faults.push(("E0030", node.span, reason, "write a whole number".into()));
        }
        Integer::Fraction => {
            let reason = format!("{} is not a whole number", show(number.value));
            let remedy = format!("write {} or {}", number.value.floor(), number.value.ceil());
            faults.push(("E0035", node.span, reason, remedy));
        }
    }
    None
}

/// The number of steps of a plan.
fn steps(node: &Node, faults: &mut Vec<Fault>) -> Option<u64> {
    let value = integer(node, faults)?;
    if value < Problem::MIN_STEPS as i64 {
        let reason = format!("{value} is too few: a plan needs at least {} steps", Problem::MIN_STEPS);
        faults.push(("E0033", node.span, reason, "100 is a good start; or leave the key out".into()));
    } else if value > Problem::MAX_STEPS as i64 {
        faults.push(too_many_steps(node.span, value as f64));
    } else {
        return u64::try_from(value).ok();
    }
    None
}

/// More steps than a plan may have, with the memory that they would take.
pub(crate) fn too_many_steps(span: Span, steps: f64) -> Fault {
    // A node holds state, inputs, costates and the transition matrix of the sweep: about 1 kB on SO(3).
    let gigabytes = steps * 1e3 / 1e9;
    let reason = format!(
        "{} steps are too many: they would need about {} GB, the limit of a plan is {}",
        show(steps),
        super::quantity::short(gigabytes),
        Problem::MAX_STEPS
    );
    ("E0034", span, reason, "use fewer steps; a thousand are plenty for most maneuvers".into())
}

/// The number of steps of a simulation.
fn long_steps(node: &Node, faults: &mut Vec<Fault>) -> Option<u64> {
    let value = integer(node, faults)?;
    if value < 1 {
        let reason = format!("{value} is too few: a simulation needs at least 1 step");
        faults.push(("E0033", node.span, reason, "write how many, or give step_s instead".into()));
    } else if value > MAX_STEPS {
        faults.push(too_many_long_steps(node.span, value as f64));
    } else {
        return u64::try_from(value).ok();
    }
    None
}

/// More steps than a simulation may have.
pub(crate) fn too_many_long_steps(span: Span, steps: f64) -> Fault {
    let reason = format!(
        "{} steps are too many: a simulation may have {}, a minute or more even for a single free body",
        show(steps),
        show(MAX_STEPS as f64)
    );
    ("E0034", span, reason, "take longer steps, a method of higher order, or a shorter duration".into())
}

/// The elements of a list that may be long; `sample` shows one of them in brackets.
fn long_list<'a>(node: &'a Node, what: &str, sample: &str, faults: &mut Vec<Fault>) -> Option<&'a [Node]> {
    match &node.value {
        Value::Array(items) if items.len() > MAX_LISTED => {
            let reason = format!("{} {what}, at most {MAX_LISTED} can stand in a spec", items.len());
            faults.push((
                "E0034",
                node.span,
                reason,
                "put the shape into an OBJ file: obj = \"shape.obj\"".into(),
            ));
            None
        }
        Value::Array(items) => Some(items),
        other => {
            let reason = format!("expected a list of {what}, found {}", other.kind());
            faults.push(("E0025", node.span, reason, format!("write {sample}")));
            None
        }
    }
}

/// A list of points.
fn vertices(node: &Node, quantity: &Quantity, faults: &mut Vec<Fault>) -> Option<Vec<[f64; 3]>> {
    let items = long_list(node, "vertices", "[[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]]", faults)?;
    let points: Vec<_> = items.iter().filter_map(|item| vector(item, quantity, faults)).collect();
    (points.len() == items.len()).then_some(points)
}

/// A list of triangles, vertices counted from 1.
fn faces(node: &Node, faults: &mut Vec<Fault>) -> Option<Vec<[u32; 3]>> {
    let list = long_list(node, "faces", "[[1, 2, 3], [1, 4, 2], [2, 4, 3], [3, 4, 1]]", faults)?;
    let triangle = |face: &Node, faults: &mut Vec<Fault>| {
        let corners = items(face, 3, "vertices, counted from 1", faults)?;
        let corners: Vec<u32> = corners
            .iter()
            .filter_map(|corner| count(corner, 1, MAX_LISTED as i64, faults))
            .filter_map(|corner| u32::try_from(corner).ok())
            .collect();
        <[u32; 3]>::try_from(corners).ok()
    };
    let faces: Vec<_> = list.iter().filter_map(|face| triangle(face, faults)).collect();
    (faces.len() == list.len()).then_some(faces)
}

/// Text of one line.
fn text<'a>(node: &'a Node, most: usize, faults: &mut Vec<Fault>) -> Option<&'a str> {
    let Value::Text(text) = &node.value else {
        wrong_type(node, "text in quotes", faults);
        return None;
    };
    let length = text.chars().count();
    if length > most {
        let reason = format!("the text has {length} characters, the limit is {most}");
        faults.push(("E0034", node.span, reason, "shorten it".into()));
        return None;
    }
    Some(text)
}

/// One of some words.
fn choice<'a>(
    node: &'a Node,
    now: &[&'static str],
    later: &[&'static str],
    faults: &mut Vec<Fault>,
) -> Option<&'a str> {
    let quoted =
        |words: &[&str]| words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ");
    let Value::Text(word) = &node.value else {
        let wanted = if now.len() > 12 {
            format!("one of {}, …", quoted(&now[..3]))
        } else {
            format!("one of {}", quoted(now))
        };
        wrong_type(node, &wanted, faults);
        return None;
    };
    if now.contains(&word.as_str()) {
        return Some(word);
    }
    if later.contains(&word.as_str()) {
        let reason = format!("\"{word}\" is planned, but this version of slew does not have it yet");
        faults.push(("E0019", node.span, reason, format!("this version has {}", quoted(now))));
        return None;
    }
    let known = super::suggest::nearest(word, now.iter().chain(later).copied());
    let remedy = match known {
        Some(known) => format!("did you mean \"{known}\"?"),
        None => format!("write one of {}", quoted(now)),
    };
    // A long list is told once.
    let reason = if now.len() > 12 {
        format!("\"{}\" is none of the {} that there are", cut(word, 40), now.len())
    } else {
        format!("\"{}\" is not one of {}", cut(word, 40), quoted(now))
    };
    faults.push(("E0020", node.span, reason, remedy));
    None
}

/// The elements of a list that should have `wanted` of them; `what` names them.
fn items<'a>(node: &'a Node, wanted: usize, what: &str, faults: &mut Vec<Fault>) -> Option<&'a [Node]> {
    match &node.value {
        Value::Array(items) if items.len() == wanted => Some(items),
        Value::Array(items) => {
            let reason = format!("has {}, needs {wanted} {what}", items.len());
            let remedy = format!("write a list of {wanted}");
            faults.push(("E0026", node.span, reason, remedy));
            None
        }
        other => {
            let reason = format!("expected a list of {wanted} {what}, found {}", other.kind());
            faults.push(("E0025", node.span, reason, format!("write a list in brackets, {wanted} {what}")));
            None
        }
    }
}

/// `N` numbers.
fn numbers<const N: usize>(
    node: &Node,
    quantity: &Quantity,
    what: &str,
    faults: &mut Vec<Fault>,
) -> Option<[f64; N]> {
    let items = items(node, N, what, faults)?;
    let mut out = [0.0; N];
    let mut good = true;
    for (value, item) in out.iter_mut().zip(items) {
        match number(item, quantity, faults) {
            Some(number) => *value = number,
            None => good = false,
        }
    }
    good.then_some(out)
}

/// Three numbers.
fn vector(node: &Node, quantity: &Quantity, faults: &mut Vec<Fault>) -> Option<[f64; 3]> {
    numbers(node, quantity, "numbers (x, y, z)", faults)
}

/// Three rows of three numbers.
fn rows(node: &Node, quantity: &Quantity, faults: &mut Vec<Fault>) -> Option<[[f64; 3]; 3]> {
    let items = items(node, 3, "rows of three numbers", faults)?;
    let rows: Vec<_> =
        items.iter().filter_map(|row| numbers::<3>(row, quantity, "numbers in a row", faults)).collect();
    <[_; 3]>::try_from(rows).ok()
}

/// Three rows, or a diagonal.
fn inertia(node: &Node, quantity: &Quantity, faults: &mut Vec<Fault>) -> Option<[[f64; 3]; 3]> {
    let flat = match &node.value {
        Value::Array(items) => {
            !items.is_empty() && items.iter().all(|item| !matches!(item.value, Value::Array(_)))
        }
        _ => false,
    };
    if !flat {
        return rows(node, quantity, faults);
    }
    if let Value::Array(items) = &node.value
        && items.len() == 6
    {
        let reason = "six numbers do not say which sign the products of inertia carry".to_string();
        let remedy = "write the whole matrix with tensor signs: \
                      [[Jxx, Jxy, Jxz], [Jxy, Jyy, Jyz], [Jxz, Jyz, Jzz]], Jxy = −∫xy dm";
        faults.push(("E0044", node.span, reason, remedy.into()));
        return None;
    }
    let [x, y, z] = numbers(node, quantity, "numbers (a diagonal) or three rows of three", faults)?;
    Some([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]])
}

/// A list of axes, at most [`MAX_AXES`].
fn axes(node: &Node, quantity: &Quantity, faults: &mut Vec<Fault>) -> Option<Vec<[f64; 3]>> {
    let Value::Array(items) = &node.value else {
        let reason = format!("expected a list of axes, found {}", node.value.kind());
        let remedy = "write one axis per inner list: [[1, 0, 0], [0, 1, 0]]";
        faults.push(("E0025", node.span, reason, remedy.into()));
        return None;
    };
    if !items.is_empty() && items.iter().all(|item| matches!(item.value, Value::Number(_))) {
        let reason = "expected a list of axes, found a list of numbers: one axis".to_string();
        faults.push(("E0025", node.span, reason, "put the axis in a list: [[1, 0, 0]]".into()));
        return None;
    }
    if items.len() > MAX_AXES {
        let reason = format!("{} axes, the limit is {MAX_AXES}", items.len());
        faults.push(("E0034", node.span, reason, "use fewer axes".into()));
        return None;
    }
    let axes: Vec<_> = items
        .iter()
        .filter_map(|axis| {
            let values = vector(axis, quantity, faults)?;
            not_zero(axis, values, faults).then_some(values)
        })
        .collect();
    (axes.len() == items.len()).then_some(axes)
}

/// A weight: n numbers (its diagonal) or n rows of n numbers. Returned as rows.
fn weight(node: &Node, quantity: &Quantity, faults: &mut Vec<Fault>) -> Option<Vec<Vec<f64>>> {
    let Value::Array(items) = &node.value else {
        let reason = format!("expected a list of weights, found {}", node.value.kind());
        faults.push(("E0025", node.span, reason, "write one number per axis: [1, 1, 1]".into()));
        return None;
    };
    let count = items.len();
    if count > MAX_AXES {
        let reason = format!("{count} weights, the limit is {MAX_AXES}");
        faults.push(("E0034", node.span, reason, "give one weight per axis".into()));
        return None;
    }
    let square = items.first().is_some_and(|item| matches!(item.value, Value::Array(_)));
    let mut rows = vec![vec![0.0; count]; count];
    let mut good = true;
    for (index, item) in items.iter().enumerate() {
        if !square {
            match number(item, quantity, faults) {
                Some(value) => rows[index][index] = value,
                None => good = false,
            }
            continue;
        }
        let Some(cells) = self::items(item, count, "numbers in a row", faults) else {
            good = false;
            continue;
        };
        for (column, cell) in cells.iter().enumerate() {
            match number(cell, quantity, faults) {
                Some(value) => rows[index][column] = value,
                None => good = false,
            }
        }
    }
    good.then_some(rows)
}

/// The version of the format, 1.
fn format_version(node: &Node, faults: &mut Vec<Fault>) -> Option<u64> {
    let mut own = Vec::new();
    let version = count(node, 1, 1, &mut own);
    match version {
        Some(_) => {}
        None if own.iter().any(|fault| fault.0 == "E0031") => {
            let version = match &node.value {
                Value::Number(number) => show(number.value),
                _ => "another".into(),
            };
            let reason = format!("the spec is in format {version}, this program reads format 1");
            faults.push(("E0023", node.span, reason, "write format = 1, or use a slew that reads it".into()));
        }
        None => faults.append(&mut own),
    }
    version
}
