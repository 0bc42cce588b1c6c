//! Reading of list values: numbers, vectors, matrices, texts, intervals, faces.

use super::{Read, count, limit, number, text, wrong};
use crate::spec::keys::MAX_LISTED;
use crate::spec::quantity::{ELAPSED, Quantity};
use crate::spec::{Limits, Node, Value, show};
use slewkit::mechanics::ActuatorSet;

/// Largest number of inputs of one kind, and so of elements of a list with one number for each
/// input.
const MAX_AXES: usize = ActuatorSet::MAX_INPUTS;

/// Largest number of boresights or directions of one constraint.
pub(crate) const MAX_DIRECTIONS: usize = MAX_AXES;

/// Reads every element of a list with `read`. Returns all values or, if any element has an error,
/// all errors.
pub(crate) fn each<I, T>(
    items: impl IntoIterator<Item = I>,
    mut read: impl FnMut(I) -> Read<T>,
) -> Read<Vec<T>> {
    let (mut values, mut faults) = (Vec::new(), Vec::new());
    for item in items {
        match read(item) {
            Ok(value) => values.push(value),
            Err(more) => faults.extend(more),
        }
    }
    if faults.is_empty() { Ok(values) } else { Err(faults) }
}

/// Returns the elements of a list. If the value is not a list, the error describes the expected
/// elements with `what` and shows the sample `sample`.
fn list<'a>(node: &'a Node, what: &str, sample: &str) -> Read<&'a [Node]> {
    match &node.value {
        Value::Array(items) => Ok(items),
        other => {
            let reason = format!("expected a list of {what}, found {}", other.kind());
            wrong("E0025", node, reason, format!("write {sample}"))
        }
    }
}

/// Returns the elements of a list, which must have `wanted` elements; messages call them `what`.
fn items<'a>(node: &'a Node, wanted: usize, what: &str) -> Read<&'a [Node]> {
    let (described, sample) = (format!("{wanted} {what}"), format!("a list in brackets, {wanted} {what}"));
    let items = list(node, &described, &sample)?;
    if items.len() == wanted {
        return Ok(items);
    }
    let reason = format!("has {} entries, and needs {described}", items.len());
    wrong("E0026", node, reason, format!("write a list of {wanted}"))
}

/// Returns the elements of a list of any length; messages show the sample `sample`.
fn long_list<'a>(node: &'a Node, what: &str, sample: &str) -> Read<&'a [Node]> {
    let items = list(node, what, sample)?;
    if items.len() > MAX_LISTED {
        let reason = format!("{} {what}: a spec may hold at most {MAX_LISTED}", items.len());
        return wrong("E0034", node, reason, "put the shape into an OBJ file: obj = \"shape.obj\"");
    }
    Ok(items)
}

/// Reads a list of `N` numbers.
pub(super) fn numbers<const N: usize>(node: &Node, quantity: &Quantity, what: &str) -> Read<[f64; N]> {
    let values = each(items(node, N, what)?, |item| number(item, quantity))?;
    // The conversion cannot fail, because the list has `N` values.
    <[f64; N]>::try_from(values).map_err(|_| Vec::new())
}

/// Reads a list of three numbers.
pub(super) fn vector(node: &Node, quantity: &Quantity) -> Read<[f64; 3]> {
    numbers(node, quantity, "numbers (x, y, z)")
}

/// Reads three rows of three numbers.
pub(super) fn rows(node: &Node, quantity: &Quantity) -> Read<[[f64; 3]; 3]> {
    let items = items(node, 3, "rows of three numbers")?;
    let rows = each(items, |row| numbers(row, quantity, "numbers in a row"))?;
    <[_; 3]>::try_from(rows).map_err(|_| Vec::new())
}

/// Reads an inertia, given as three rows or as its diagonal.
pub(super) fn inertia(node: &Node, quantity: &Quantity) -> Read<[[f64; 3]; 3]> {
    let is_array = |item: &Node| matches!(item.value, Value::Array(_));
    let count = match &node.value {
        Value::Array(items) if items.is_empty() || items.iter().any(is_array) => return rows(node, quantity),
        Value::Array(items) => items.len(),
        _ => 0,
    };
    if count == 6 {
        let reason = "six numbers do not determine the sign convention of the products of inertia";
        let remedy = "write the whole matrix: \
                      [[Jxx, Jxy, Jxz], [Jxy, Jyy, Jyz], [Jxz, Jyz, Jzz]] with Jxy = −∫xy dm";
        return wrong("E0044", node, reason, remedy);
    }
    let [x, y, z] = numbers(node, quantity, "numbers (a diagonal) or three rows of three")?;
    Ok([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]])
}

/// Reads an axis, which is a vector of nonzero length.
fn axis(node: &Node, quantity: &Quantity) -> Read<[f64; 3]> {
    let axis = vector(node, quantity)?;
    if axis.iter().all(|value| *value == 0.0) {
        let reason = "an axis of length zero has no direction";
        return wrong("E0054", node, reason, "remove the axis, or give it a direction");
    }
    Ok(axis)
}

/// Reads a list of at most [`MAX_AXES`] axes.
pub(super) fn axes(node: &Node, quantity: &Quantity) -> Read<Vec<[f64; 3]>> {
    let items = list(node, "axes", "one axis per inner list: [[1, 0, 0], [0, 1, 0]]")?;
    if !items.is_empty() && items.iter().all(|item| matches!(item.value, Value::Number(_))) {
        let reason = "expected a list of axes, found a list of numbers: one axis";
        return wrong("E0025", node, reason, "put the axis in a list: [[1, 0, 0]]");
    }
    if items.len() > MAX_AXES {
        let reason = format!("{} axes, the limit is {MAX_AXES}", items.len());
        return wrong("E0034", node, reason, "use fewer axes");
    }
    each(items, |item| axis(item, quantity))
}

/// Reads a vector, or a list of at most [`MAX_AXES`] vectors, all of nonzero length.
pub(super) fn vectors(node: &Node, quantity: &Quantity) -> Read<Vec<[f64; 3]>> {
    match &node.value {
        Value::Array(items) if items.is_empty() => {
            wrong("E0026", node, "the list is empty", "give one vector or several: [[0, 0, 1]]")
        }
        Value::Array(items) if items.iter().all(|item| matches!(item.value, Value::Number(_))) => {
            Ok(vec![axis(node, quantity)?])
        }
        Value::Array(_) => axes(node, quantity),
        other => {
            let reason = format!("expected a vector or a list of vectors, found {}", other.kind());
            wrong("E0025", node, reason, "write [0, 0, 1] or [[0, 0, 1], [0, 1, 0]]")
        }
    }
}

/// Reads a common limit for all inputs, or a list of limits. The list must have `count` elements;
/// if `count` is `None`, it may have at most [`MAX_AXES`].
pub(super) fn limits(node: &Node, quantity: &Quantity, count: Option<usize>) -> Read<Limits> {
    let Value::Array(given) = &node.value else { return Ok(Limits::All(limit(node, quantity)?)) };
    if let Some(count) = count {
        items(node, count, "limits (x, y, z), or is one number")?;
    } else if given.len() > MAX_AXES {
        let reason = format!("{} limits: at most {MAX_AXES} are possible", given.len());
        return wrong("E0034", node, reason, "give one limit for each axis");
    }
    Ok(Limits::Each(each(given, |item| limit(item, quantity))?))
}

/// Reads a common number for all items, or a list of at most [`MAX_AXES`] numbers, one for each
/// item.
pub(super) fn spread(node: &Node, quantity: &Quantity) -> Read<Limits> {
    let Value::Array(given) = &node.value else { return Ok(Limits::All(number(node, quantity)?)) };
    if given.is_empty() || given.len() > MAX_AXES {
        let reason = format!("has {} numbers, and one for all or one for each is needed", given.len());
        return wrong("E0026", node, reason, "write one number, or a list");
    }
    Ok(Limits::Each(each(given, |item| number(item, quantity))?))
}

/// Reads a square matrix and returns it as a list of rows. The spec gives its n diagonal elements,
/// or n rows of n numbers. In messages, `what` describes the numbers and `which` the items to which
/// they belong.
pub(super) fn square(node: &Node, quantity: &Quantity, what: &str, which: &str) -> Read<Vec<Vec<f64>>> {
    let given = list(node, what, &format!("one number per {which}: [1, 1, 1]"))?;
    let count = given.len();
    if count > MAX_AXES {
        let reason = format!("{count} {what}: the limit is {MAX_AXES}");
        return wrong("E0034", node, reason, format!("give one number for each {which}"));
    }
    if given.first().is_some_and(|item| matches!(item.value, Value::Array(_))) {
        return each(given, |row| {
            each(items(row, count, "numbers in a row")?, |cell| number(cell, quantity))
        });
    }
    let diagonal = each(given, |item| number(item, quantity))?;
    let mut rows = vec![vec![0.0; count]; count];
    diagonal.into_iter().enumerate().for_each(|(index, value)| rows[index][index] = value);
    Ok(rows)
}

/// Reads a list of at most `most` texts of one line.
pub(super) fn texts(node: &Node, most: usize) -> Read<Vec<String>> {
    let items = list(node, "texts", "[\"one\", \"two\"]")?;
    if items.len() > most {
        let reason = format!("the list has {}, the limit is {most}", items.len());
        return wrong("E0034", node, reason, "shorten it");
    }
    each(items, |item| Ok(text(item, 200)?.to_string()))
}

/// Reads a list of vertices.
pub(super) fn vertices(node: &Node, quantity: &Quantity) -> Read<Vec<[f64; 3]>> {
    let items = long_list(node, "vertices", "[[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]]")?;
    each(items, |item| vector(item, quantity))
}

/// Largest number of time intervals for one constraint.
pub(crate) const MAX_INTERVALS: usize = 1000;

/// Reads a list of time intervals \[s\], which must be in order and must not overlap.
pub(super) fn intervals(node: &Node) -> Read<Vec<[f64; 2]>> {
    let given = list(node, "intervals", "[[0, 40], [60, 90]]")?;
    if given.len() > MAX_INTERVALS {
        let reason = format!("{} intervals, the limit is {MAX_INTERVALS}", given.len());
        return wrong("E0034", node, reason, "write fewer intervals");
    }
    let pairs = each(given, |item| numbers::<2>(item, &ELAPSED, "numbers (from, until)"))?;
    let times: Vec<f64> = pairs.iter().flatten().copied().collect();
    match times.windows(2).position(|pair| pair[0] > pair[1]) {
        Some(at) => {
            let reason = format!(
                "{} s is before {} s: intervals must be in order",
                show(times[at]),
                show(times[at + 1])
            );
            wrong(
                "E0079",
                &given[at / 2],
                reason,
                "write the intervals in the order of time, each as [from, until]",
            )
        }
        None => Ok(pairs),
    }
}

/// Reads a time interval \[s\].
pub(super) fn interval(node: &Node) -> Read<[f64; 2]> {
    let [from, until] = numbers::<2>(node, &ELAPSED, "numbers (from, until)")?;
    if from > until {
        let reason = format!("{} s is before {} s: an interval is [from, until]", show(until), show(from));
        return wrong("E0079", node, reason, "swap the two numbers");
    }
    Ok([from, until])
}

/// Reads a list of triangles; vertices are counted from 1.
pub(super) fn faces(node: &Node) -> Read<Vec<[u32; 3]>> {
    let corner = |node| Ok(u32::try_from(count(node, 1, MAX_LISTED as i64)?).unwrap_or(u32::MAX));
    each(long_list(node, "faces", "[[1, 2, 3], [1, 4, 2], [2, 4, 3], [3, 4, 1]]")?, |face| {
        let corners = each(items(face, 3, "vertices, counted from 1")?, corner)?;
        <[u32; 3]>::try_from(corners).map_err(|_| Vec::new())
    })
}
