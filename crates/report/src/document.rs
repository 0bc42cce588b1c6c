//! Pictures and animated body of a page as one JSON document. Numbers have only as many digits as a
//! screen can resolve.

use super::Shown;
use crate::draw::{Axis, Chart, Curve, Picture, Scale, Shape, Sky, SkyCone, SkyDisc};
use serde_json::{Value, json};
use slewkit::Vector3;

/// Returns the data from which the script of a page draws the pictures and the body.
pub(super) fn document(shown: &[Shown], body: &Value) -> Value {
    let mut grids = Vec::new();
    let charts: Vec<Value> = shown
        .iter()
        .filter_map(|shown| match &shown.picture {
            Picture::Chart(chart) => Some(chart_document(shown.key, chart, &mut grids)),
            Picture::Sky(sky) => Some(sky_document(shown.key, sky)),
            // Pictures of these kinds are in the page as SVG.
            Picture::Map(_) | Picture::Ground(_) | Picture::Gantt(_) => None,
        })
        .collect();
    let grids: Vec<Value> = grids.iter().map(|grid: &Vec<f64>| numbers(grid.iter().copied(), 9)).collect();
    json!({ "charts": charts, "grids": grids, "body": body })
}

/// Rounds numbers to `digits` significant digits; a number that is not finite becomes `null`.
pub(super) fn numbers(values: impl Iterator<Item = f64>, digits: usize) -> Value {
    let rounded = |value: f64| -> Option<f64> { format!("{value:.*e}", digits - 1).parse().ok() };
    values.map(|value| json!(rounded(value).filter(|value| value.is_finite()))).collect()
}

/// Returns the three components of a vector, rounded to six significant digits.
pub(super) fn vector(vector: &Vector3) -> Value {
    numbers(vector.iter().copied(), 6)
}

/// Returns the JSON of a chart. Abscissas that several curves share are stored once, in `grids`.
fn chart_document(key: &str, chart: &Chart, grids: &mut Vec<Vec<f64>>) -> Value {
    let curve = |curve: &Curve| {
        let mut points = curve.shape.points();
        // The script searches for a value by abscissa and needs increasing abscissas. The abscissas
        // of a curve with marks, such as work or step size, may decrease.
        if matches!(curve.shape, Shape::Marked(_)) {
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let x: Vec<f64> = points.iter().map(|point| point.0).collect();
        let same = |grid: &Vec<f64>| {
            grid.len() == x.len() && grid.iter().zip(&x).all(|(a, b)| a.to_bits() == b.to_bits())
        };
        let grid = grids.iter().position(same).unwrap_or_else(|| {
            grids.push(x);
            grids.len() - 1
        });
        json!({
            "name": curve.name,
            "style": curve.style,
            "marked": matches!(curve.shape, Shape::Marked(_)),
            "grid": grid,
            "y": numbers(points.iter().map(|point| point.1), 7),
        })
    };
    let curves: Vec<Value> = chart.legible_curves().iter().map(curve).collect();
    let axis = |axis: &Axis| json!({ "label": axis.label, "log": axis.scale == Scale::Logarithmic });
    let levels: Vec<Value> =
        chart.levels.iter().map(|level| json!({ "value": level.value, "label": level.label })).collect();
    let spans: Vec<Value> = chart
        .spans
        .iter()
        .map(|span| json!({ "from": span.from, "to": span.to, "label": span.label }))
        .collect();
    json!({
        "key": key, "kind": "chart", "title": chart.title, "x": axis(&chart.x), "y": axis(&chart.y),
        "curves": curves, "levels": levels, "spans": spans,
    })
}

fn sky_document(key: &str, sky: &Sky) -> Value {
    let view = sky.view();
    let labels: Vec<Value> =
        sky.labels(&view).iter().map(|(text, at)| json!({ "text": text, "at": vector(at) })).collect();
    let tracks: Vec<Value> = sky
        .tracks
        .iter()
        .map(|track| {
            let points: Vec<Value> = track.points.iter().map(vector).collect();
            json!({ "name": track.name, "style": track.style, "points": points })
        })
        .collect();
    let rings: Vec<Value> = sky
        .rings
        .iter()
        .map(|ring| {
            let points: Vec<Value> = ring.points.iter().map(vector).collect();
            json!({ "style": ring.style, "filled": ring.filled, "points": points })
        })
        .collect();
    let marks: Vec<Value> =
        sky.marks.iter().map(|mark| json!({ "name": mark.name, "at": vector(&mark.at) })).collect();
    json!({
        "key": key, "kind": "sky", "title": sky.title,
        "view": {
            "middle": vector(&view.middle), "right": vector(&view.right), "up": vector(&view.up), "reach": view.reach,
        },
        "cones": sky.cones.iter().map(cone).collect::<Vec<_>>(),
        "discs": sky.discs.iter().map(disc).collect::<Vec<_>>(), "tracks": tracks, "rings": rings, "mark\
            s": marks, "labels": labels,
    })
}

/// Returns the JSON of a cone.
pub(super) fn cone(cone: &SkyCone) -> Value {
    json!({
        "name": cone.name, "axis": vector(&cone.axis), "half_angle": cone.half_angle,
        "asks": cone.asks.word(), "acts": cone.acts, "when": cone.when, "way": way(&cone.way),
    })
}

/// Returns the JSON of a moving disc.
pub(super) fn disc(disc: &SkyDisc) -> Value {
    json!({ "name": disc.name, "kind": disc.kind.word(), "way": way(&disc.way) })
}

/// Returns the samples of a moving cone or disc, equally spaced in time, as rows `[x, y, z, angle]`:
/// its unit direction and its half angle \[rad\].
fn way(way: &[(Vector3, f64)]) -> Value {
    way.iter().map(|(at, angle)| numbers(at.iter().chain([angle]).copied(), 6)).collect()
}
