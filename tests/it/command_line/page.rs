//! The content of a page of `slew report`, taken apart.

/// Returns a page and its script data in parts.
pub fn data(page: &str) -> serde_json::Value {
    let rest = page.split("<script type=\"application/json\" id=\"data\">").nth(1).unwrap();
    serde_json::from_str(rest.split("</script>").next().unwrap()).unwrap()
}

/// Returns the ordinates of the one curve of a picture.
pub fn curve(data: &serde_json::Value, key: &str) -> Vec<f64> {
    let chart = data["charts"].as_array().unwrap().iter().find(|chart| chart["key"] == key).unwrap();
    chart["curves"][0]["y"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
}

/// Returns the picture `key` of a page.
pub fn picture<'a>(data: &'a serde_json::Value, key: &str) -> &'a serde_json::Value {
    let all = data["charts"].as_array().unwrap();
    all.iter().find(|chart| chart["key"] == key).unwrap_or_else(|| panic!("no {key}"))
}

/// Returns the times and values of a curve.
pub fn points(data: &serde_json::Value, curve: &serde_json::Value) -> Vec<(f64, f64)> {
    let grid = &data["grids"][curve["grid"].as_u64().unwrap() as usize];
    let numbers = |list: &serde_json::Value| -> Vec<f64> {
        list.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
    };
    numbers(grid).into_iter().zip(numbers(&curve["y"])).collect()
}

pub fn problem(name: &str) -> String {
    format!("{}/../../problems/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// Returns the cells of the row of a table that begins with `first`.
pub fn row<'a>(page: &'a str, first: &str) -> Vec<&'a str> {
    let start = format!("<tr><td>{first}</td>");
    let rest = page.split(&start).nth(1).unwrap_or_else(|| panic!("no row {first}"));
    let row = rest.split("</tr>").next().unwrap();
    row.split("<td>").skip(1).map(|cell| cell.trim_end_matches("</td>")).collect()
}
