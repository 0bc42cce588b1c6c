//! The page of a sequence: its timeline, its stops, and the motion of the whole sequence.

use super::boresight::boresights;
use super::charts::time_axis;
use super::page::{Content, Words, written};
use super::summary::{self, sequence::verdict};
use super::tiles::Tile;
use super::words::Table;
use super::{Shown, Subject, attitude, body, charts, sphere};
use crate::draw::{Gantt, Picture, SkyMark};
use slewkit::lie;
use slewkit::maneuver::{Outcome, Problem, Solution};
use slewkit::numerics::figures::{short, significant};
use slewkit::plan::Plan;
use slewkit_files::export::{PlanFile, SequenceFile, StopRecord};
use slewkit_files::spec::LoadedSequence;

/// Returns the page of the plan of a sequence. `euler` is the sequence of the Euler angles, one of
/// [`slewkit_files::export::EULER_SEQUENCES`].
pub fn sequence_page(file: &SequenceFile<'_>, loaded: &LoadedSequence, euler: &str) -> String {
    let record = &file.record;
    let (craft, plan) = whole(file, loaded);
    let subject = &subject(&craft, &plan, loaded, euler);
    let (verdict, tone) = verdict(record.status);
    let parts = |lines: &[String]| lines.iter().map(|line| summary::parts(line)).collect::<Vec<_>>();
    let told: Vec<(String, String)> = parts(&summary::sequence::told(file, loaded))
        .into_iter()
        .scan(String::new(), |label, (own, text)| {
            if !own.is_empty() {
                label.clone_from(&own);
            }
            Some((label.clone(), own, text))
        })
        // The table below the summary lists the stops.
        .filter(|(label, ..)| label != "stops")
        .map(|(_, own, text)| (own, text))
        .collect();
    written(&Content {
        name: &record.name,
        words: &Words { verdict: verdict.into(), tone, summary: told, details: Vec::new() },
        tiles: tiles(file),
        proved: proved(file),
        shown: drawn(file, loaded, subject),
        missing: Vec::new(),
        grouped: None,
        tables: vec![stops(file)],
        body: body::body(subject),
        nodes: subject.trajectory().time.len(),
    })
}

/// Returns the pictures of the plan of a sequence, in the order of the page.
pub fn sequence_pictures(file: &SequenceFile<'_>, loaded: &LoadedSequence, euler: &str) -> Vec<Shown> {
    let (craft, plan) = whole(file, loaded);
    drawn(file, loaded, &subject(&craft, &plan, loaded, euler))
}

/// Returns the spacecraft and the motion of the whole sequence, in the form of one maneuver and its
/// plan.
fn whole(file: &SequenceFile<'_>, loaded: &LoadedSequence) -> (Problem, Plan) {
    let joined = file.joined();
    let mut craft = loaded.sequence.craft.clone().with_steps(joined.path.torque.len().max(1));
    if let Some(last) = joined.path.quaternion.last() {
        craft.end.attitude = lie::rotation_from_quaternion(last);
    }
    let mut solution = Solution::unknown();
    solution.outcome = Outcome::Converged;
    solution.trajectory = joined.path;
    (craft, Plan::new(solution, None, file.record.status))
}

/// Creates the subject of the pictures from the motion of the whole sequence. It has no results of
/// the witnesses, because they propagate each leg separately.
fn subject<'a>(
    craft: &'a Problem,
    plan: &'a Plan,
    loaded: &'a LoadedSequence,
    euler: &'a str,
) -> Subject<'a> {
    let aims = loaded.sequence.stops.iter().filter_map(|stop| loaded.boresight(&stop.name));
    Subject {
        problem: craft,
        plan,
        identity: &loaded.identity,
        sequence: euler,
        aims: aims.collect(),
        course: None,
        flight: None,
    }
}

fn drawn(file: &SequenceFile<'_>, loaded: &LoadedSequence, subject: &Subject<'_>) -> Vec<Shown> {
    let mut shown = vec![timeline(file, loaded)];
    if subject.trajectory().time.len() > 1 {
        shown.push(sky(file, loaded, subject));
        shown.extend(charts::inputs(subject));
        shown.extend(charts::of_motion(subject));
        shown.extend(attitude::turning(subject));
    }
    shown
}

/// Returns the headline figures of the page.
fn tiles(file: &SequenceFile<'_>) -> Vec<Tile> {
    let record = &file.record;
    let turning: f64 = record.stops.iter().map(|stop| stop.arrives_s - stop.leg_begins_s).sum();
    let turned: f64 = file.legs.iter().map(|leg| leg.turned_deg).sum();
    let tile = |name: &str, value: String, note: &str| Tile { name: name.into(), value, note: note.into() };
    let mut all = vec![
        tile("duration", format!("{} s", short(record.duration_s)), "holds included"),
        tile("turning", format!("{} s", short(turning)), "all legs"),
        tile("turn", format!("{turned:.1}°"), "all legs"),
    ];
    if record.minimize != "time" {
        all.push(tile(&record.minimize, significant(record.cost, 4), "all legs"));
    }
    all
}

/// Returns sentences that state what is proved about the order of the stops and about the legs.
fn proved(file: &SequenceFile<'_>) -> Vec<String> {
    let mut told = vec![match (file.record.proof.name(), file.record.order_gap) {
        ("all_orders", _) => "No other order of the legs found is better: all orders were compared.".into(),
        ("lower_bound", Some(gap)) => format!(
            "No other order of the legs found is better by more than {} %: a lower bound of all orders \
            proves it.",
            significant(100.0 * gap, 2)
        ),
        _ => "The order is the given one.".into(),
    }];
    told.push("Each leg is the best one that its search found, and was verified separately.".into());
    told
}

/// Returns the table of all stops and of the legs to them.
fn stops(file: &SequenceFile<'_>) -> Table {
    let row = |(leg, stop): (&PlanFile<'_>, &StopRecord)| {
        let time = |seconds: f64| format!("{seconds:.3}");
        let peak = leg.verified.as_ref().map(|found| found.peak_rate_rad_s.to_degrees());
        vec![
            stop.name.clone(),
            time(stop.leg_begins_s),
            time(stop.arrives_s),
            time(stop.hold_begins_s),
            time(stop.leaves_s),
            format!("{:.1}", leg.turned_deg),
            significant(leg.cost, 5),
            peak.map_or(String::new(), |peak| significant(peak, 3)),
            leg.status.name().replace('_', " "),
        ]
    };
    Table {
        title: "Stops",
        head: vec![
            "stop",
            "leg begins, s",
            "arrives, s",
            "hold from, s",
            "until, s",
            "turn, deg",
            "cost of the leg",
            "peak rate, deg/s",
            "leg",
        ],
        rows: file.legs.iter().zip(&file.record.stops).map(row).collect(),
        remark: "The file has the plan of each leg: `jq '.legs[0]'` takes the first one out.",
    }
}

/// Draws the boresight tracks with the numbers of the stops. The number of a stop marks the
/// direction of its boresight on arrival. A stop that is given by an attitude has a number only if
/// the maneuver has a single boresight.
fn sky(file: &SequenceFile<'_>, loaded: &LoadedSequence, subject: &Subject<'_>) -> Shown {
    let mut shown = sphere::sky(subject);
    if let Picture::Sky(sky) = &mut shown.picture {
        let path = subject.trajectory();
        let boresights = boresights(subject);
        let only = (boresights.len() == 1).then(|| boresights[0].vector);
        for (index, stop) in file.record.stops.iter().enumerate() {
            let boresight = loaded.boresight(&stop.name).or(only);
            let node = path.time.partition_point(|time| *time < stop.arrives_s).min(path.time.len() - 1);
            let attitude = lie::rotation_from_quaternion(&path.quaternion[node]);
            sky.marks.extend(
                boresight.map(|vector| SkyMark { name: (index + 1).to_string(), at: attitude * vector }),
            );
        }
    }
    shown
}

/// Draws the times of slews, waits, holds and windows, and the times at which limits and cones are
/// active.
fn timeline(file: &SequenceFile<'_>, loaded: &LoadedSequence) -> Shown {
    let stops = &file.record.stops;
    let mut rows = vec![
        ("slews".to_string(), stops.iter().map(|stop| [stop.leg_begins_s, stop.arrives_s]).collect()),
        (
            "waits, settles".to_string(),
            stretches(stops.iter().map(|stop| [stop.arrives_s, stop.hold_begins_s])),
        ),
        ("holds".to_string(), stretches(stops.iter().map(|stop| [stop.hold_begins_s, stop.leaves_s]))),
    ];
    let end = file.record.duration_s;
    let windows = loaded.sequence.stops.iter().map(|stop| stop.visit.window.map(|time| time.clamp(0.0, end)));
    rows.push(("windows".into(), stretches(windows.filter(|[from, until]| (until - from) < end))));
    for (leg, stop) in file.legs.iter().zip(stops) {
        for active in &leg.active {
            let row = match rows.iter().position(|(name, _)| *name == active.name) {
                Some(row) => row,
                None => {
                    rows.push((active.name.clone(), Vec::new()));
                    rows.len() - 1
                }
            };
            let half = 0.5 * leg.step_s;
            let mut times: Vec<f64> = active.time_s.clone();
            times.sort_by(f64::total_cmp);
            for time in times {
                let [from, until] =
                    [time - half, time + half].map(|time| (stop.leg_begins_s + time).clamp(0.0, end));
                match rows[row].1.last_mut() {
                    Some(last) if from <= last[1] + half => last[1] = until,
                    _ => rows[row].1.push([from, until]),
                }
            }
        }
    }
    rows.retain(|(_, bars)| !bars.is_empty());
    let gantt = Gantt {
        title: "Timeline".into(),
        subtitle: format!("{}; limits and cones are shown while they act", time_axis().label),
        end,
        rows,
    };
    Shown { key: "timeline", picture: Picture::Gantt(gantt), remark: String::new() }
}

/// Returns the time intervals of positive length, sorted by their start.
fn stretches(all: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut all: Vec<[f64; 2]> = all.filter(|[from, until]| until > from).collect();
    all.sort_by(|a, b| a[0].total_cmp(&b[0]));
    all
}
