//! The JSON Schema agrees with the reader.

use super::{BASE, ORBIT, SIMULATION, bad, good};
use serde_json::Value;
use slewkit_files::spec;

/// Calls `visit` with the dotted path, the name and the schema of every property.
fn walk(schema: &Value, path: &str, visit: &mut impl FnMut(&str, &str, &Value)) {
    for inner in [schema.get("items"), Some(schema)].into_iter().flatten() {
        for variant in inner.get("oneOf").and_then(Value::as_array).into_iter().flatten() {
            walk(variant, path, visit);
        }
        for (name, property) in inner.get("properties").and_then(Value::as_object).into_iter().flatten() {
            visit(path, name, property);
            let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            walk(property, &path, visit);
        }
    }
}

#[test]
fn every_property_is_described_and_known_to_the_reader() {
    let schema = spec::schema();
    let mut count = 0;
    super::load_any(SIMULATION, &[]).unwrap();
    for (kind, text) in [ORBIT, SIMULATION].into_iter().enumerate() {
        walk(&schema["oneOf"][kind], "", &mut |path, name, property| {
            count += 1;
            assert!(property["description"].as_str().is_some_and(|text| text.len() > 4), "{path} {name}");
            if path.contains("points") || path.contains("rivals") || path == "environment" {
                return;
            }
            // Set to something wrong, a known key is complained about by its value, not as unknown.
            let key = if path.is_empty() { name.to_string() } else { format!("{path}.{name}") };
            let key = key.replace("bodies.", "bodies.0.").replace("expect.end.", "expect.end.0.");
            if let Err(errors) = super::load_any(text, &[&format!("{key}=true")]) {
                assert!(errors.0.iter().all(|finding| !finding.reason.contains("unknown")), "{errors}");
            }
        });
    }
    assert!(count > 350, "{count}");
}

#[test]
fn schema_is_of_draft_2020_12_and_closed() {
    let schema = spec::schema();
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    let required = [&["format", "body", "start", "maneuver"][..], &["format", "simulation", "bodies"]];
    for (kind, required) in required.into_iter().enumerate() {
        assert_eq!(schema["oneOf"][kind]["additionalProperties"], false);
        assert_eq!(schema["oneOf"][kind]["required"], serde_json::json!(required));
    }
    // A maneuver has an end, or stops.
    assert!(schema["oneOf"][0].to_string().contains(r#""required":["stop"]"#), "{}", schema["oneOf"][0]);
}

#[test]
fn what_the_schema_requires_the_reader_requires() {
    for (key, line) in [("format", "format = 1\n"), ("maneuver.duration_s", "duration_s = 60\n")] {
        let errors = bad(&BASE.replace(line, ""), &[]);
        assert_eq!(errors.0[0].key, key);
    }
    good(ORBIT, &[]);
}
