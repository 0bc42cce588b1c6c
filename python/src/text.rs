//! Conversion of a spec that consists of Python values to TOML text, which the reader of specs
//! reads like any other spec.
//!
//! A dictionary is therefore read like a file, and its errors have the same codes, keys and
//! remedies. Every number keeps its bits. NaN and infinity are written in the notation of TOML, and
//! the reader refuses them.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyMapping, PyString, PyTuple};
use slewkit_files::spec::MAX_BYTES;
use std::fmt::Write;

/// Largest depth of nesting that is written; no valid spec reaches it. Deeper parts are omitted,
/// and the reader reports that the spec is nested too deeply. The limit is necessary because a
/// dictionary may contain itself.
const DEEPEST: usize = 40;

/// Returns the spec as TOML text.
///
/// Raises TypeError for a value that TOML cannot express, such as None.
#[pyfunction]
pub fn to_toml(spec: &Bound<'_, PyMapping>) -> PyResult<String> {
    let mut text = String::new();
    table(&mut text, &items(spec)?, "")?;
    Ok(text)
}

/// Returns the TOML text of one value, as an override needs it.
pub fn value_text(value: &Bound<'_, PyAny>) -> PyResult<String> {
    let mut text = String::new();
    inline(&mut text, value, "", 0)?;
    Ok(text)
}

type Items<'py> = Vec<(String, Bound<'py, PyAny>)>;

/// Returns the keys and values of a mapping.
fn items<'py>(mapping: &Bound<'py, PyMapping>) -> PyResult<Items<'py>> {
    let pair = |item: Bound<'py, PyAny>| {
        let (key, value): (Bound<'py, PyAny>, Bound<'py, PyAny>) = item.extract()?;
        let key = key.cast::<PyString>().map_err(|_| {
            PyTypeError::new_err(format!("the keys of a spec are text, and {} is not", shown(&key)))
        })?;
        Ok((key.to_cow()?.into_owned(), plain(value)?))
    };
    mapping.items()?.iter().map(pair).collect()
}

/// Converts NumPy arrays and numbers to Python values, and a `Rotation` of SciPy to a table with
/// its quaternion.
fn plain(value: Bound<'_, PyAny>) -> PyResult<Bound<'_, PyAny>> {
    let own = value.is_instance_of::<PyFloat>()
        || value.is_instance_of::<PyInt>()
        || value.is_instance_of::<PyString>()
        || value.is_instance_of::<PyList>()
        || value.is_instance_of::<PyDict>();
    if own {
        // A NumPy float is a subclass of the Python float, so no conversion is necessary.
        return Ok(value);
    }
    if let Ok(method) = value.getattr("as_quat") {
        let table = PyDict::new(value.py());
        table.set_item("quaternion_xyzw", method.call0()?.call_method0("tolist")?)?;
        return Ok(table.into_any());
    }
    match value.getattr("tolist") {
        Ok(method) => method.call0(),
        Err(_) => Ok(value),
    }
}

/// Writes a table: first the keys with simple values, then the nested tables with their headers.
fn table(text: &mut String, items: &Items<'_>, path: &str) -> PyResult<()> {
    let own = |value: &Bound<'_, PyAny>| {
        path.is_empty() && (value.cast::<PyMapping>().is_ok() || is_list_of_tables(value))
    };
    for (name, value) in items.iter().filter(|(_, value)| !own(value)) {
        key(text, name);
        text.push_str(" = ");
        inline(text, value, &join(path, name), 1)?;
        text.push('\n');
    }
    for (name, value) in items.iter().filter(|(_, value)| own(value)) {
        if let Ok(mapping) = value.cast::<PyMapping>() {
            header(text, "[", name, "]");
            table(text, &self::items(mapping)?, name)?;
        } else {
            for item in value.try_iter()? {
                header(text, "[[", name, "]]");
                table(text, &self::items(item?.cast::<PyMapping>()?)?, name)?;
            }
        }
    }
    Ok(())
}

fn is_list_of_tables(value: &Bound<'_, PyAny>) -> bool {
    let Ok(list) = value.cast::<PyList>() else { return false };
    !list.is_empty() && list.iter().all(|item| item.cast::<PyMapping>().is_ok())
}

fn header(text: &mut String, open: &str, name: &str, close: &str) {
    if !text.is_empty() {
        text.push('\n');
    }
    text.push_str(open);
    key(text, name);
    text.push_str(close);
    text.push('\n');
}

fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.into() } else { format!("{path}.{name}") }
}

/// Appends a key, in quotes only if TOML requires them.
fn key(text: &mut String, name: &str) {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(bare) {
        text.push_str(name);
    } else {
        quoted(text, name);
    }
}

/// Appends a text as a basic string of TOML.
fn quoted(text: &mut String, content: &str) {
    text.push('"');
    for c in content.chars() {
        match c {
            '"' => text.push_str("\\\""),
            '\\' => text.push_str("\\\\"),
            '\n' => text.push_str("\\n"),
            '\t' => text.push_str("\\t"),
            c if c.is_control() => {
                // Writing to a String cannot fail.
                let _ = write!(text, "\\u{:04X}", u32::from(c));
            }
            c => text.push(c),
        }
    }
    text.push('"');
}

/// Writes a value in one line.
fn inline(text: &mut String, value: &Bound<'_, PyAny>, path: &str, depth: usize) -> PyResult<()> {
    if depth > DEEPEST {
        text.push('0');
        return Ok(());
    }
    let value = &plain(value.clone())?;
    if let Ok(value) = value.cast::<PyBool>() {
        text.push_str(if value.is_true() { "true" } else { "false" });
    } else if let Ok(value) = value.cast::<PyFloat>() {
        number(text, value.value());
    } else if value.is_instance_of::<PyInt>() {
        text.push_str(&value.str()?.to_cow()?);
    } else if let Ok(value) = value.cast::<PyString>() {
        quoted(text, &value.to_cow()?);
    } else if let Ok(mapping) = value.cast::<PyMapping>() {
        text.push_str("{ ");
        for (index, (name, value)) in items(mapping)?.iter().enumerate() {
            if full(text) {
                break;
            }
            text.push_str(if index > 0 { ", " } else { "" });
            key(text, name);
            text.push_str(" = ");
            inline(text, value, &join(path, name), depth + 1)?;
        }
        text.push_str(" }");
    } else if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        text.push('[');
        for (index, item) in value.try_iter()?.enumerate() {
            if full(text) {
                break;
            }
            text.push_str(if index > 0 { ", " } else { "" });
            inline(text, &item?, path, depth + 1)?;
        }
        text.push(']');
    } else {
        let at = if path.is_empty() { String::new() } else { format!("{path}: ") };
        let found = shown(value);
        let remedy = if value.is_none() { "; remove the key" } else { "" };
        return Err(PyTypeError::new_err(format!("{at}{found} has no notation in a spec{remedy}")));
    }
    Ok(())
}

fn number(text: &mut String, value: f64) {
    if value.is_nan() {
        text.push_str("nan");
    } else if value.is_infinite() {
        text.push_str(if value > 0.0 { "inf" } else { "-inf" });
    } else {
        // The debug format of a float is the shortest text that reads back to the same bits.
        let _ = write!(text, "{value:?}");
    }
}

/// Returns true if the text exceeds the largest size of a spec, so that the reader will reject it.
fn full(text: &str) -> bool {
    text.len() > MAX_BYTES
}

/// Returns the text of a value for messages.
fn shown(value: &Bound<'_, PyAny>) -> String {
    let text = value.repr().map_or_else(|_| "a value".into(), |text| text.to_string());
    text.chars().take(60).collect()
}
