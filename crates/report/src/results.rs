//! Pictures of the results of a batch: the cost as a function of the keys of a sweep, or its
//! distribution over random draws.

use super::cases_told::told_of_cases;
use super::page::{Content, Words, written};
use super::summary::{Tone, parts};
use super::words::Table;
use super::{MOST_POINTS, Shown};
use crate::draw::{Axis, Chart, Curve, Map, Picture, Shape, Span, thinned};
use serde_json::Value;
use slewkit::numerics::figures::{short, significant};
use slewkit_files::batch::{CaseResult, Header, Shard, Tally};

/// Largest number of cases that are drawn as individual points. If a batch has more cases, only the
/// distribution is shown.
pub const MOST_PICTURED: usize = 100_000;
/// Largest number of different values of a key for which the map has one row or column for each
/// value.
const MOST_CELLS: usize = 400;
/// Number of bars of a histogram.
const BARS: usize = 60;
/// Largest number of failed cases that the table lists.
const LISTED: usize = 50;

/// Results of a batch, in the form that its pictures and tables use.
#[derive(Clone, Debug)]
pub struct Cases {
    header: Header,
    tally: Tally,
    /// Values of the keys, as text, and the cost of the first [`MOST_PICTURED`] cases. The cost of
    /// a failed case is `None`.
    points: Vec<(Vec<String>, Option<f64>)>,
    /// Terminal attitude error of the continuous motion for each solved case \[deg\].
    misses: Vec<f64>,
    failed: Vec<CaseResult>,
}

impl Cases {
    /// Creates an empty record for the results of a batch with the header `header`.
    pub fn new(header: &Header) -> Self {
        Self {
            header: header.clone(),
            tally: Tally::default(),
            points: vec![],
            misses: vec![],
            failed: vec![],
        }
    }

    /// Adds the result of one case.
    pub fn add(&mut self, result: &CaseResult) {
        self.tally.add(result);
        if self.points.len() < MOST_PICTURED {
            let text = |key: &String| match result.set.get(key) {
                Some(Value::String(text)) => text.clone(),
                Some(value) => value.to_string(),
                None => String::new(),
            };
            let cost = result.cost.filter(|_| result.is_solved());
            self.points.push((self.header.keys.iter().map(text).collect(), cost));
        }
        if result.is_solved() {
            self.misses.extend(result.verified.as_ref().and_then(|verdict| verdict.continuous_attitude_deg));
        } else if self.failed.len() < LISTED {
            self.failed.push(result.clone());
        }
    }

    /// Returns the counts and extremes of all results.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Returns the name of the spec.
    pub fn name(&self) -> &str {
        &self.header.spec
    }

    /// Returns the pictures with their names in files.
    pub fn pictures(&self) -> Vec<Shown> {
        let mut shown = Vec::new();
        // Costs of effort, time and fuel have different units and cannot share a picture.
        let one = self.tally.objectives.len() <= 1;
        let whole = one && self.tally.cases as usize <= self.points.len();
        shown.extend((whole && self.header.keys.len() == 1).then(|| self.over_one()).flatten());
        shown.extend((whole && self.header.keys.len() == 2).then(|| self.over_two()).flatten());
        for costs in self.tally.objectives.values().filter(|_| one) {
            shown.extend(distribution("distribution", "Distribution of the cost", "cost", &costs.all));
        }
        let title = "Distribution of the miss of the continuous motion";
        shown.extend(distribution("miss", title, "miss of the attitude, deg", &self.misses));
        shown
    }

    /// Returns the chart of the cost as a function of the key that varies. Returns `None` unless
    /// exactly one key varies and its values are numbers.
    fn over_one(&self) -> Option<Shown> {
        let mut points: Vec<(f64, f64)> = Vec::with_capacity(self.points.len());
        for (values, cost) in &self.points {
            points.push((values[0].parse().ok()?, cost.unwrap_or(f64::NAN)));
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        if points.len() < 2 || points.first()?.0 >= points.last()?.0 {
            return None;
        }
        let key = &self.header.keys[0];
        let curve = if points.len() <= 80 {
            Shape::Marked(points.clone())
        } else {
            Shape::Line(thinned(&points, MOST_POINTS))
        };
        let curves = vec![Curve { name: "cost".into(), style: 0, shape: curve }];
        let costs = || points.iter().map(|point| point.1).filter(|cost| cost.is_finite());
        let (low, high) = costs().fold((f64::INFINITY, 0.0_f64), |(a, b), cost| (a.min(cost), b.max(cost)));
        let y = if low > 0.0 && high > 30.0 * low { Axis::logarithmic("cost") } else { Axis::linear("cost") };
        let mut chart = Chart::new(format!("Cost over {key}"), Axis::linear(key.as_str()), y, curves);
        // The shaded span of a failed case extends half of the way to the neighbouring cases.
        let middle = |a: usize, b: usize| 0.5 * (points[a].0 + points[b].0);
        let span = |index: usize| Span {
            from: middle(index.saturating_sub(1), index),
            to: middle(index, (index + 1).min(points.len() - 1)),
            label: "not solved".into(),
        };
        chart.spans = (0..points.len()).filter(|index| points[*index].1.is_nan()).map(span).collect();
        Some(Shown { key: "cost", picture: Picture::Chart(chart), remark: String::new() })
    }

    /// Returns the map of the cost as a function of two keys; `None` unless exactly two keys vary.
    fn over_two(&self) -> Option<Shown> {
        let values = |index: usize| {
            let mut seen: Vec<&str> = Vec::new();
            for (values, _) in &self.points {
                let value = values[index].as_str();
                if seen.len() <= MOST_CELLS && !seen.contains(&value) {
                    seen.push(value);
                }
            }
            seen
        };
        let (xs, ys) = (values(0), values(1));
        if xs.len() < 2
            || ys.len() < 2
            || xs.len() > MOST_CELLS
            || ys.len() > MOST_CELLS
            || xs.len() * ys.len() != self.points.len()
        {
            return None;
        }
        let mut cells = vec![None; self.points.len()];
        for (values, cost) in &self.points {
            let column = xs.iter().position(|value| *value == values[0])?;
            let row = ys.iter().position(|value| *value == values[1])?;
            cells[row * xs.len() + column] = *cost;
        }
        let label = |text: &&str| text.parse::<f64>().map_or((*text).to_string(), short);
        let axis = |index: usize, values: &[&str]| {
            (self.header.keys[index].clone(), values.iter().map(label).collect::<Vec<_>>())
        };
        let map = Map {
            title: "Cost over two keys".into(),
            subtitle: format!("{} of {} cases solved and verified", self.tally.solved(), self.tally.cases),
            x: axis(0, &xs),
            y: axis(1, &ys),
            value: "cost".into(),
            none: "not solved".into(),
            cells,
        };
        Some(Shown { key: "map", picture: Picture::Map(map), remark: String::new() })
    }

    /// Returns the tables of the failed cases and of the costliest cases.
    fn tables(&self) -> Vec<Table> {
        let set = |settings: Vec<String>| settings.join(", ");
        let case = |case: u64, name: &Option<String>| match name {
            Some(name) => format!("{case} “{name}”"),
            None => case.to_string(),
        };
        let failed = self.failed.iter().map(|result| {
            let error = result.error.as_ref().map(|error| format!("{}: {}", error.code, error.reason));
            let because = error.or_else(|| result.obstruction.clone()).or_else(|| result.shortfall.clone());
            vec![
                case(result.case, &result.name),
                result.status.replace('_', " "),
                set(result.settings().collect()),
                because.unwrap_or_default(),
            ]
        });
        let costliest = self.tally.objectives.values().flat_map(|costs| &costs.costliest).map(|worst| {
            vec![case(worst.case, &worst.name), significant(worst.value, 6), set(worst.set.clone())]
        });
        let mut tables = vec![
            Table {
                title: "Cases that failed",
                head: vec!["case", "status", "values", "because"],
                rows: failed.collect(),
                remark: "At most fifty cases. `--case NUMBER -o plan.json` plans one again.",
            },
            Table {
                title: "Costliest cases",
                head: vec!["case", "cost", "values"],
                rows: costliest.collect(),
                remark: "",
            },
        ];
        tables.retain(|table| !table.rows.is_empty());
        tables
    }
}

/// Returns the chart of the distribution of the values, which shows a histogram and the cumulative
/// distribution.
fn distribution(key: &'static str, title: &str, label: &str, values: &[f64]) -> Option<Shown> {
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    let count = values.len();
    // The distribution of values that differ only by round-off has no meaning.
    if count < 20 || high - low <= 1e-9 * high.abs() {
        return None;
    }
    let bars = BARS.min(count / 10).max(5);
    let width = (high - low) / bars as f64;
    let mut counts = vec![0_u64; bars];
    for value in values {
        counts[(((value - low) / width) as usize).min(bars - 1)] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(1).max(1) as f64;
    let edge = |index: usize| low + index as f64 * width;
    let step = |(index, own): (usize, &u64)| {
        let share = *own as f64 / most;
        [(edge(index), share), (edge(index + 1), share)]
    };
    let steps = counts.iter().enumerate().flat_map(step);
    let steps = [(low, 0.0)].into_iter().chain(steps).chain([(high, 0.0)]).collect();
    let mut sum = 0;
    let below = counts.iter().enumerate().map(|(index, own)| {
        sum += own;
        (edge(index + 1), sum as f64 / count as f64)
    });
    let below = [(low, 0.0)].into_iter().chain(below).collect();
    let curves = vec![
        Curve { name: "frequency\nrelative to the highest".into(), style: 0, shape: Shape::Line(steps) },
        Curve { name: "cases below\nas a part of all".into(), style: 1, shape: Shape::Line(below) },
    ];
    let y = Axis { limits: Some((0.0, 1.05)), ..Axis::linear("part") };
    let mut chart = Chart::new(title, Axis::linear(label), y, curves);
    chart.subtitle = format!("{count} cases solved and verified");
    Some(Shown { key, picture: Picture::Chart(chart), remark: String::new() })
}

/// Returns the page of a file of results.
pub fn results_page(cases: &Cases) -> String {
    let tally = cases.tally();
    let shard = cases.header.shard.unwrap_or(Shard::ALL);
    let (there, asked) = (tally.cases, shard.count(cases.header.cases));
    let (verdict, tone) = match tally.failed() {
        _ if there < asked => {
            let solved = tally.solved();
            (format!("{there} of {asked} cases done, {solved} of them solved and verified"), Tone::Note)
        }
        0 => (format!("all {asked} cases solved and verified"), Tone::Good),
        _ => (format!("{} of {asked} cases solved and verified", tally.solved()), Tone::Note),
    };
    let verdict = if shard == Shard::ALL {
        verdict
    } else {
        format!("shard {shard} of {} cases: {verdict}", cases.header.cases)
    };
    let summary = told_of_cases(tally).iter().map(|line| parts(line)).collect();
    written(&Content {
        name: cases.name(),
        words: &Words { verdict, tone, summary, details: Vec::new() },
        tiles: Vec::new(),
        proved: Vec::new(),
        shown: cases.pictures(),
        missing: Vec::new(),
        grouped: None,
        tables: cases.tables(),
        body: Value::Null,
        nodes: 0,
    })
}
