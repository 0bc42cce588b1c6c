//! First pass over a spec: checks every key against the tables of [`super::keys`], in the order of
//! the file.

use super::keys::{ATTITUDE, DIRECTION, Key, Kind, REST_IN_ORBIT, ROOT, SIMULATION_ROOT, TARGET, Table};
use super::section::{Given, MAX_FINDINGS, Parsed, join};
use super::suggest::nearest;
use super::values::{self, Fault, Read, wrong};
use super::{Entry, Finding, Node, Report, Section, Span, Spot, Value, cut};

/// Reads every value of a spec and checks names, types, shapes and ranges.
///
/// `table` has the keys of this kind of spec: of a maneuver or of a simulation.
pub(crate) fn check(root: &Node, table: &'static Table, findings: Vec<Finding>) -> Section {
    let rounding = root.entry("rounding").map(|entry| &entry.node.value);
    let keeps_rounding = matches!(rounding, Some(Value::Text(word)) if word == "keep");
    let report = Report::default();
    report.extend(findings);
    let mut checker = Checker { findings: Vec::new(), root: table, keeps_rounding, report };
    let section = checker.table(root, table, "");
    section.report.extend(checker.findings);
    section
}

struct Checker {
    findings: Vec<Finding>,
    /// Table of the keys of the whole spec.
    root: &'static Table,
    keeps_rounding: bool,
    /// Report that the sections share with the second pass.
    report: Report,
}

/// Returns whether a key has an effect if the selector of its table has the word `selected`.
fn applies(key: &Key, selected: Option<&str>) -> bool {
    key.only.is_empty() || selected.is_some_and(|kind| key.only.contains(&kind))
}

/// Returns the name of the table at `path` for messages.
fn table_name(path: &str) -> String {
    if path.is_empty() { "the spec".into() } else { format!("[{path}]") }
}

impl Checker {
    fn full(&self) -> bool {
        self.findings.len() >= MAX_FINDINGS
    }

    fn error(&mut self, (code, span, reason, remedy): Fault, key: &str) {
        if !self.full() {
            self.findings.push(Finding::error_at(code, Spot { span, key: key.into() }, reason, remedy));
        }
    }

    fn table(&mut self, node: &Node, table: &'static Table, path: &str) -> Section {
        let keeps_rounding = self.keeps_rounding;
        let (path_of, report) = (path.into(), self.report.clone());
        let mut section =
            Section { span: node.span, table, path: path_of, keeps_rounding, report, given: Vec::new() };
        if !matches!(node.value, Value::Table(_)) {
            let (reason, remedy) = match &node.value {
                Value::Array(items) if items.iter().any(|item| matches!(item.value, Value::Table(_))) => (
                    format!("`{path}` is a list of tables, and one table is needed"),
                    format!("write [{path}], once"),
                ),
                other => {
                    let remedy = if std::ptr::eq(table, &raw const ATTITUDE) {
                        attitude_sample(other)
                    } else {
                        table_sample(table)
                    };
                    (format!("`{path}` is {}, and a table is needed", other.kind()), remedy)
                }
            };
            self.error(("E0024", node.span, reason, remedy), path);
            // The value is added as a key without a name, so that the table is not also reported as
            // empty.
            let (name, span) = (String::new(), node.span);
            section.given.push(Given { name, span, is_empty_list: false, value: None });
            return section;
        }
        let selected = table.selector.and_then(|selector| match &node.entry(selector)?.node.value {
            Value::Text(word) => Some(word.as_str()),
            _ => None,
        });
        let mut suggested = Vec::new();
        for entry in node.entries() {
            // The value of this key is a word. Numbers are probably a rate whose key lacks the
            // unit, so the key is treated as unknown.
            let numbers = matches!(entry.node.value, Value::Array(_) | Value::Number(_));
            let key = table.key(&entry.key).filter(|key| !(key.name == REST_IN_ORBIT && numbers));
            let value = match key {
                _ if self.full() => None,
                None => {
                    suggested.extend(self.unknown(entry, table, path));
                    None
                }
                Some(key) if applies(key, selected) => self.value(entry, key, &join(path, key.name)),
                Some(key) => {
                    self.misplaced(entry, key, table, selected, path);
                    values::read(key.kind, &entry.node).ok()
                }
            };
            section.given.push(Given {
                name: entry.key.clone(),
                span: entry.node.span,
                is_empty_list: matches!(&entry.node.value, Value::Array(items) if items.is_empty()),
                value,
            });
        }
        if self.full() {
            return section;
        }
        self.contradictions(node, table, path);
        // A key that is probably misspelt is not also reported as missing.
        let missing = |name: &str| node.entry(name).is_none() && !suggested.contains(&name);
        for key in table.keys.iter().filter(|key| applies(key, selected) && missing(key.name)) {
            self.missing(node, key, path);
        }
        let belongs = |name: &&str| table.key(name).is_some_and(|key| applies(key, selected));
        for (group, sample) in table.one_of.iter().filter(|(group, _)| group.iter().any(belongs)) {
            if group.iter().all(|name| missing(name)) {
                let first = table.key(group[0]).filter(|_| path.is_empty());
                let is_table = first.is_some_and(|key| matches!(key.kind, Kind::Table(_)));
                let name = if is_table { format!("[{}]", group[0]) } else { format!("`{}`", group[0]) };
                let reason = format!("{} needs {name}", table_name(path));
                let fault = ("E0021", opening(node, path), reason, added(sample));
                self.error(fault, &join(path, group[0]));
            }
        }
        section
    }

    /// Reports a key that has an effect only with another word of the selector. If the selector
    /// itself is invalid, only that error is reported.
    fn misplaced(
        &mut self,
        entry: &Entry,
        key: &Key,
        table: &'static Table,
        selected: Option<&str>,
        path: &str,
    ) {
        if let (Some(kind), Some(selector)) = (selected, table.selector)
            && table.keys.iter().any(|key| key.only.contains(&kind))
        {
            let reason = format!(
                "`{}` does not belong to {selector} = \"{}\", only to \"{}\"",
                key.name,
                cut(kind, 40),
                key.only.join("\", \"")
            );
            self.error(("E0020", entry.key_span, reason, "remove the key".into()), &join(path, key.name));
        }
    }

    /// Reports keys of the same table that exclude each other.
    fn contradictions(&mut self, node: &Node, table: &'static Table, path: &str) {
        for group in table.exclusive {
            let given: Vec<&Entry> =
                node.entries().iter().filter(|entry| group.contains(&entry.key.as_str())).collect();
            if let [first, second, ..] = given[..] {
                let reason = format!("both `{}` and `{}` are given", first.key, second.key);
                let fault = ("E0028", second.key_span, reason, "give only one of the two".into());
                self.error(fault, &join(path, &second.key));
            }
        }
    }

    /// Reports that the key `key` is missing, if it is required.
    fn missing(&mut self, node: &Node, key: &Key, path: &str) {
        let Some(sample) = key.sample else { return };
        let (code, reason) = match key.kind {
            Kind::Format => ("E0022", "the spec does not state the version of its format".into()),
            Kind::Table(_) => ("E0021", format!("{} needs [{}]", table_name(path), key.name)),
            Kind::List(..) if path.is_empty() => {
                ("E0021", format!("{} needs [[{}]]", table_name(path), key.name))
            }
            _ => ("E0021", format!("{} needs `{}`", table_name(path), key.name)),
        };
        self.error((code, opening(node, path), reason, added(sample)), &join(path, key.name));
    }

    fn value(&mut self, entry: &Entry, key: &'static Key, path: &str) -> Option<Parsed> {
        let node = &entry.node;
        let read = match key.kind {
            Kind::Table(table) => Ok(Parsed::Tables(vec![self.table(node, table, path)])),
            Kind::List(table, most) => return self.list(node, table, most, path),
            Kind::Directions => self.directions(node, path),
            Kind::Targets => self.targets(node, path),
            kind => values::read(kind, node),
        };
        let faults = match read {
            Ok(value) => return Some(value),
            Err(faults) => faults,
        };
        // At most three errors of a list are reported, because further errors are usually similar.
        for mut fault in faults.into_iter().take(3) {
            if !fault.2.contains(&format!("`{}`", key.name)) {
                fault.2 = format!("`{}`: {}", key.name, fault.2);
            }
            self.error(fault, path);
        }
        None
    }

    /// Reads one direction or a list of directions.
    fn directions(&mut self, node: &Node, path: &str) -> Read<Parsed> {
        let sample = "{ vector = [0, 0, 1] }, or { ra_deg = 231.0, dec_deg = -18.3 }";
        let items = match &node.value {
            Value::Table(_) => return Ok(Parsed::Tables(vec![self.table(node, &DIRECTION, path)])),
            Value::Array(items) => items,
            _ => return values::heavenly_body(node),
        };
        let numbers = |items: &[Node]| items.iter().all(|item| matches!(item.value, Value::Number(_)));
        if items.len() == 3 && numbers(items) {
            // Three numbers can only be a vector.
            let vector = Entry { key: "vector".into(), key_span: node.span, node: node.clone() };
            let table = Node { span: node.span, value: Value::Table(vec![vector]) };
            return Ok(Parsed::Tables(vec![self.table(&table, &DIRECTION, path)]));
        }
        if items.iter().any(|item| matches!(item.value, Value::Number(_))) {
            let reason = "expected a direction, found a list of numbers";
            return wrong("E0025", node, reason, format!("write {sample}"));
        }
        if items.is_empty() {
            let remedy = format!("give one direction or several: {sample}");
            return wrong("E0026", node, "the list of directions is empty", remedy);
        }
        if items.len() > values::MAX_DIRECTIONS {
            let reason = format!("{} directions, the limit is {}", items.len(), values::MAX_DIRECTIONS);
            return wrong("E0034", node, reason, "use several constraints");
        }
        let tables = values::each(items.iter().enumerate(), |(index, item)| match item.value {
            Value::Table(_) => Ok(self.table(item, &DIRECTION, &format!("{path}.{index}"))),
            _ => values::heavenly_body(item),
        });
        Ok(Parsed::Tables(tables?))
    }

    /// Reads a target or a list of targets, given as words or tables.
    fn targets(&mut self, node: &Node, path: &str) -> Read<Parsed> {
        let mut one = |node: &Node, path: &str| match &node.value {
            Value::Table(_) => Ok(self.table(node, &TARGET, path)),
            Value::Text(_) => {
                let word = Entry { key: "at".into(), key_span: node.span, node: node.clone() };
                Ok(self.table(&Node { span: node.span, value: Value::Table(vec![word]) }, &TARGET, path))
            }
            _ => {
                let reason = format!("expected a target, found {}", node.value.kind());
                wrong(
                    "E0025",
                    node,
                    reason,
                    "write \"sun\", or { at = \"ground\", latitude_deg = 48.1, longitude_deg = 11.6 }",
                )
            }
        };
        let Value::Array(items) = &node.value else { return Ok(Parsed::Tables(vec![one(node, path)?])) };
        if items.is_empty() || items.len() > values::MAX_DIRECTIONS {
            let reason = format!("a list of {} targets", items.len());
            return wrong("E0026", node, reason, format!("give from 1 to {}", values::MAX_DIRECTIONS));
        }
        let tables =
            values::each(items.iter().enumerate(), |(index, item)| one(item, &format!("{path}.{index}")));
        Ok(Parsed::Tables(tables?))
    }

    fn list(&mut self, node: &Node, table: &'static Table, most: usize, path: &str) -> Option<Parsed> {
        let Value::Array(items) = &node.value else {
            let reason = format!("expected a list of tables, found {}", node.value.kind());
            let remedy = match node.value {
                Value::Table(_) => format!("write [[{path}]], with two brackets, once for each"),
                _ => format!("write [ {} ]", table_sample(table).trim_start_matches("write ")),
            };
            self.error(("E0025", node.span, reason, remedy), path);
            return None;
        };
        if items.len() > most {
            let reason = format!("the list has {}, the limit is {most}", items.len());
            self.error(("E0034", node.span, reason, "shorten it".into()), path);
            return None;
        }
        let tables =
            items.iter().enumerate().map(|(index, item)| self.table(item, table, &format!("{path}.{index}")));
        Some(Parsed::Tables(tables.collect()))
    }

    /// Returns the error that a table belongs to the other kind of spec; `None` for other entries.
    fn of_the_other_kind(&self, entry: &Entry, path: &str) -> Option<Fault> {
        let simulation = std::ptr::eq(self.root, &raw const SIMULATION_ROOT);
        let other = if simulation { &ROOT } else { &SIMULATION_ROOT };
        let key = other.key(&entry.key).filter(|_| path.is_empty())?;
        let (of, this, remedy) = match (simulation, key.name) {
            (true, "body" | "start") => {
                ("maneuver", "simulation", "a simulation has [[bodies]], each with its attitude at the start")
            }
            (true, _) => (
                "maneuver",
                "simulation",
                "remove it; or remove [simulation] and [[bodies]] to plan a maneuver",
            ),
            (false, _) => (
                "simulation",
                "maneuver",
                "remove it; or remove [maneuver], [start] and [end] to simulate bodies",
            ),
        };
        let reason = format!("`{}` belongs to a {of}, but this spec is a {this}", key.name);
        Some(("E0018", entry.key_span, reason, remedy.into()))
    }

    /// Reports an unknown key. Returns the known key that the user probably meant, if one is
    /// similar.
    fn unknown(&mut self, entry: &Entry, table: &'static Table, path: &str) -> Option<&'static str> {
        let others = table.keys.iter().map(|key| key.name).filter(|name| *name != entry.key);
        let known = nearest(&entry.key, others);
        let name = cut(&entry.key, 60);
        let fault = |code, reason: &str, remedy: String| (code, entry.key_span, reason.to_string(), remedy);
        let attitude = std::ptr::eq(table, &raw const ATTITUDE);
        let found = if attitude && entry.key.starts_with("quaternion") && !entry.key.contains("xyz") {
            let reason = "`quaternion` does not state whether the scalar is first or last";
            fault(
                "E0052",
                reason,
                "write quaternion_wxyz (scalar first) or quaternion_xyzw (scalar last)".into(),
            )
        } else if attitude && EULER.iter().any(|start| entry.key.starts_with(start)) {
            let reason = format!(
                "`{name}` is ambiguous: the key must name the sequence of Euler angles and their unit"
            );
            fault(
                "E0057",
                &reason,
                "write for example euler_zyx_deg: intrinsic, R = Rz Ry Rx, angles in that order".into(),
            )
        } else if let Some(advice) = self.of_the_other_kind(entry, path) {
            advice
        } else {
            let is_table = matches!(entry.node.value, Value::Table(_)) && path.is_empty();
            let what = if is_table { "table" } else { "key" };
            let reason = format!("unknown {what} `{name}` in {}", table_name(path));
            let remedy = match known {
                Some(known) if is_table => format!("did you mean [{known}]?"),
                Some(known) => format!("did you mean `{known}`?"),
                None => elsewhere(&entry.key, table, self.root),
            };
            fault("E0020", &reason, remedy)
        };
        self.error(found, &join(path, &entry.key));
        known.or(is_notation(&entry.key, table).then_some("attitude"))
    }
}

/// Returns the position of the header of a table. For the whole spec, the position is empty.
fn opening(node: &Node, path: &str) -> Span {
    if path.is_empty() {
        return Span::default();
    }
    match node.entries().first() {
        // An inline table or an object spans its whole text, so only its first character is marked.
        Some(first) if first.key_span.source == node.span.source && first.key_span.start < node.span.end => {
            Span { end: node.span.start + 1, ..node.span }
        }
        _ => node.span,
    }
}

/// Returns the remedy for a missing key, which proposes to add `sample`.
fn added(sample: &str) -> String {
    if sample.contains('\n') { format!("add, for example:\n{sample}") } else { format!("add {sample}") }
}

/// Returns true if `name` is a notation of an attitude that was written without the key `attitude`,
/// which `table` has.
fn is_notation(name: &str, table: &Table) -> bool {
    table.key("attitude").is_some() && ATTITUDE.key(name).is_some()
}

/// Beginnings of unknown keys that are probably meant as Euler angles.
const EULER: [&str; 5] = ["euler", "rpy", "ypr", "roll_pitch", "yaw_pitch"];

/// Returns the remedy for a value in place of an attitude table. Four numbers are treated as a
/// quaternion.
fn attitude_sample(value: &Value) -> String {
    match value {
        Value::Array(items) if items.len() == 4 => {
            "name the order: { quaternion_wxyz = [1, 0, 0, 0] } has the scalar first, quaternion_xyzw last"
        }
        Value::Array(items) if items.len() == 3 => {
            "name the notation: { euler_zyx_deg = [80, -25, 40] }, rotation_vector_deg, mrp, or matrix"
        }
        _ => "write { axis = [0, 0, 1], angle_deg = 90 }, or another notation",
    }
    .into()
}

/// Returns an inline sample of a table with its required keys.
fn table_sample(table: &Table) -> String {
    let needed = table.keys.iter().filter_map(|key| key.sample).filter(|sample| !sample.contains('\n'));
    let one_of = table.one_of.iter().map(|(_, sample)| *sample).filter(|sample| !sample.contains('\n'));
    let needed = needed.chain(one_of).take(3);
    let inside: Vec<_> = needed.collect();
    if inside.is_empty() {
        "write a table: { key = value }".into()
    } else {
        format!("write {{ {} }}", inside.join(", "))
    }
}

/// Returns advice about an unknown key that is not similar to any key of `table`: the table that
/// has this key, or the list of the keys of `table`.
pub(super) fn elsewhere(name: &str, table: &Table, root: &Table) -> String {
    if is_notation(name, table) {
        return format!("write attitude = {{ {name} = … }}");
    }
    for key in root.keys {
        if let Kind::Table(other) = key.kind
            && other.key(name).is_some()
        {
            return format!("`{name}` belongs in [{}]", key.name);
        }
    }
    let known = table.keys.iter().filter(|key| !matches!(key.kind, Kind::HeavenlyBody));
    let known: Vec<_> = known.map(|key| key.name).filter(|name| !name.starts_with('$')).collect();
    // The user may have meant any key, so all keys are listed.
    format!("the keys here are {}", known.join(", "))
}
