//! JSON Schema of specs, generated from the tables of keys in [`super::keys`].

use super::keys::{ATTITUDE, DIRECTION, Kind, MAX_LISTED, ROOT, SIMULATION_ROOT, TARGET, Table};
use super::quantity::{Quantity, Sign};
use super::values::{MAX_DIRECTIONS, MAX_INTERVALS};
use serde_json::{Map, Value, json};

/// Returns the JSON Schema (draft 2020-12) of specs, which editors can use for both JSON and TOML.
pub fn schema() -> Value {
    let titled = |root, title: &str| {
        let mut schema = table(root);
        if let Value::Object(schema) = &mut schema {
            schema.insert("title".into(), json!(title));
        }
        schema
    };
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "slewkit spec, format 1",
        "oneOf": [titled(&ROOT, "maneuver, to be planned"), titled(&SIMULATION_ROOT, "simulation")],
    })
}

fn table(table: &'static Table) -> Value {
    match table.selector {
        None => variant(table, None),
        Some(selector) => {
            let words = match table.key(selector).map(|key| key.kind) {
                Some(Kind::Choice(words, _)) => words,
                _ => &[],
            };
            json!({ "oneOf": words.iter().map(|word| variant(table, Some((selector, word)))).collect::<Vec<_>>() })
        }
    }
}

/// Returns the schema of a table whose selector has the given word.
fn variant(table: &'static Table, selected: Option<(&str, &str)>) -> Value {
    let mut properties = Map::new();
    let mut required = Vec::new();
    for key in table.keys {
        let applies = key.only.is_empty() || selected.is_some_and(|(_, word)| key.only.contains(&word));
        if !applies || matches!(key.kind, Kind::HeavenlyBody) {
            continue;
        }
        let mut value = match selected {
            Some((selector, word)) if selector == key.name => json!({ "const": word }),
            _ => kind(key.kind),
        };
        if let Value::Object(value) = &mut value {
            let unit = match key.kind {
                Kind::Number(quantity)
                | Kind::Vector(quantity)
                | Kind::Vertices(quantity)
                | Kind::Limit(quantity)
                | Kind::Limits(quantity, _)
                    if !quantity.unit.is_empty() =>
                {
                    format!(" Unit: {}.", quantity.unit)
                }
                Kind::Inertia => " Unit: kg·m².".into(),
                _ => String::new(),
            };
            value.insert("description".into(), json!(format!("{}{unit}", key.doc)));
        }
        properties.insert(key.name.into(), value);
        if key.sample.is_some() {
            required.push(key.name);
        }
    }
    let mut all: Vec<Value> = Vec::new();
    for group in table.exclusive {
        for (index, first) in group.iter().enumerate() {
            for second in &group[index + 1..] {
                if properties.contains_key(*first) && properties.contains_key(*second) {
                    all.push(json!({ "not": { "required": [first, second] } }));
                }
            }
        }
    }
    for (group, _) in table.one_of {
        let known = group.iter().filter(|name| properties.contains_key(**name));
        let known: Vec<_> = known.map(|name| json!({ "required": [name] })).collect();
        if !known.is_empty() {
            all.push(json!({ "anyOf": known }));
        }
    }
    if std::ptr::eq(table, &raw const ATTITUDE) {
        all.push(json!({ "oneOf": notations() }));
    }
    if std::ptr::eq(table, &raw const DIRECTION) {
        all.push(json!({ "oneOf": [{ "required": ["ra_deg", "dec_deg"] }, { "required": ["vector"] }] }));
    }
    let mut out = Map::new();
    out.insert("type".into(), json!("object"));
    out.insert("properties".into(), Value::Object(properties));
    out.insert("required".into(), json!(required));
    out.insert("additionalProperties".into(), json!(false));
    if !all.is_empty() {
        out.insert("allOf".into(), Value::Array(all));
    }
    Value::Object(out)
}

/// Returns, for each notation of an attitude, the schema that requires its keys.
fn notations() -> Vec<Value> {
    let together = ["axis", "angle_deg", "angle_rad", "ra_deg", "dec_deg", "roll_deg"];
    let alone = ATTITUDE.keys.iter().filter(|key| !together.contains(&key.name));
    let mut out = vec![
        json!({ "required": ["axis", "angle_deg"] }),
        json!({ "required": ["axis", "angle_rad"] }),
        json!({ "required": ["ra_deg", "dec_deg", "roll_deg"] }),
    ];
    out.extend(alone.map(|key| json!({ "required": [key.name] })));
    out
}

fn kind(kind: Kind) -> Value {
    let list = |count: usize, items: Value| {
        json!({ "type": "array", "items": items, "minItems": count, "maxI\
        tems": count })
    };
    let any = json!({ "type": "number" });
    match kind {
        Kind::Format => json!({ "const": 1 }),
        Kind::Text(most) => json!({ "type": "string", "maxLength": most }),
        Kind::Choice(words, _) => json!({ "enum": words }),
        Kind::Number(quantity) => number(&quantity),
        Kind::Steps(of) => json!({ "type": "integer", "minimum": of.least(), "maximum": of.most() }),
        Kind::Vertices(quantity) => {
            json!({ "type": "array", "items": list(3, number(&quantity)), "maxItems": MAX_LISTED })
        }
        Kind::Faces => {
            let corner = json!({ "type": "integer", "minimum": 1, "maximum": MAX_LISTED });
            json!({ "type": "array", "items": list(3, corner), "maxItems": MAX_LISTED })
        }
        Kind::Interval => list(2, json!({ "type": "number" })),
        Kind::Flag => json!({ "type": "boolean" }),
        Kind::Intervals => {
            json!({ "type": "array", "items": list(2, any), "maxItems": MAX_INTERVALS })
        }
        Kind::Count(least, most) => json!({ "type": "integer", "minimum": least, "maximum": most }),
        Kind::Vector(quantity) => list(3, number(&quantity)),
        Kind::Quaternion => list(4, any),
        Kind::Matrix => list(3, list(3, any)),
        Kind::Inertia => json!({ "oneOf": [list(3, any.clone()), list(3, list(3, any))] }),
        Kind::Axes => json!({ "type": "array", "items": list(3, any), "maxItems": 64 }),
        Kind::Spread(quantity) => {
            let each = json!({ "type": "array", "items": number(&quantity), "minItems": 1, "maxItems": 64 });
            json!({ "oneOf": [number(&quantity), each] })
        }
        Kind::Weight | Kind::Square(_) => json!({ "type": "array", "maxItems": 64, "items": {
            "oneOf": [any.clone(), { "type": "array", "items": any, "maxItems": 64 }] } }),
        Kind::Table(inner) => table(inner),
        Kind::List(inner, most) => json!({ "type": "array", "items": table(inner), "maxItems": most }),
        Kind::Limit(quantity) => number(&quantity),
        Kind::Limits(quantity, count) => {
            let each = match count {
                Some(count) => list(count, number(&quantity)),
                None => json!({ "type": "array", "items": number(&quantity), "maxItems": 64 }),
            };
            json!({ "oneOf": [number(&quantity), each] })
        }
        Kind::Vectors(quantity) => {
            let vector = list(3, number(&quantity));
            json!({ "oneOf": [vector, several(vector.clone())] })
        }
        Kind::Directions => {
            let vector =
                json!({ "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3 });
            json!({ "oneOf": [table(&DIRECTION), several(table(&DIRECTION)), vector] })
        }
        Kind::Targets => {
            let word = json!({ "type": "string" });
            json!({ "oneOf": [word, table(&TARGET), several(table(&TARGET)), several(word)] })
        }
        Kind::Texts(most) => json!({ "type": "array", "items": { "type": "string" }, "maxItems": most }),
        Kind::HeavenlyBody => json!(false),
    }
}

/// Returns the schema of a list with at least one element.
fn several(items: Value) -> Value {
    json!({ "type": "array", "items": items, "minItems": 1, "maxItems": MAX_DIRECTIONS })
}

fn number(quantity: &Quantity) -> Value {
    let mut out = Map::new();
    out.insert("type".into(), json!("number"));
    match quantity.sign {
        Sign::Any => drop(out.insert("minimum".into(), json!(-quantity.largest))),
        Sign::NotNegative => drop(out.insert("minimum".into(), json!(0))),
        Sign::Positive => drop(out.insert("exclusiveMinimum".into(), json!(0))),
    }
    out.insert("maximum".into(), json!(quantity.largest));
    Value::Object(out)
}
