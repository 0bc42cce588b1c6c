//! Summary of a sequence: the order of its stops, its duration and cost, a line for each stop, the
//! results of the witnesses, and the proof of optimality.

use super::brief::proof;
use super::inputs;
use super::lines::{Lines, Tone, clipped, headline};
use slewkit::maneuver::Solution;
use slewkit::numerics::figures::{counted, short, significant};
use slewkit::plan::Status;
use slewkit::verify::Margin;
use slewkit_files::export::{OrderProof, PlanFile, SequenceFile, SequenceRecord, StopRecord};
use slewkit_files::spec::{LoadedSequence, escape};

/// The largest number of characters of the name of a stop.
const NAME: usize = 16;

/// Largest number of stops that the summary lists. The plan file contains all stops.
const SHOWN: usize = 30;

/// Largest number of cones that the summary lists.
const CONES: usize = 4;

/// Returns the summary of the plan of a sequence: headline and lines.
pub fn sequence(colour: bool, file: &SequenceFile<'_>, loaded: &LoadedSequence) -> Vec<String> {
    let record = &file.record;
    let (verdict, tone) = verdict(record.status);
    let mut lines = vec![headline(colour, &record.name, verdict, tone)];
    lines.extend(told(file, loaded));
    lines
}

/// Returns the verdict on a sequence as a short phrase, with its tone.
pub fn verdict(status: Status) -> (&'static str, Tone) {
    match status {
        Status::Solved => ("solved and verified", Tone::Good),
        Status::Infeasible => ("infeasible", Tone::Bad),
        Status::NotConverged => ("not converged", Tone::Bad),
        Status::LimitReached => ("limit reached", Tone::Bad),
        Status::VerificationFailed => ("verification failed", Tone::Bad),
        Status::Interrupted => ("interrupted", Tone::Note),
    }
}

/// Returns the lines of the summary of a sequence below its headline.
pub fn told(file: &SequenceFile<'_>, loaded: &LoadedSequence) -> Vec<String> {
    let record = &file.record;
    let mut lines = Vec::new();
    lines.text("sequence", order(record));
    lines.text("whole", whole(file));
    let rows = file.legs.iter().zip(&record.stops).take(SHOWN);
    let head = [("turn", 8), ("in", 9), ("arrives", 10), ("holds", 10), ("until", 10)];
    let head: String = head.iter().map(|(word, width)| format!("{word:>width$}")).collect();
    lines.line("stops", format!("{:<NAME$}{head}", ""));
    for (leg, stop) in rows {
        lines.line("", row(leg, stop));
    }
    if file.legs.len() > SHOWN {
        lines.line("", format!("… {} in all; the plan file has them", file.legs.len()));
    }
    let mut late: Vec<&StopRecord> = record.stops.iter().filter(|stop| stop.late_s > 0.0).collect();
    late.sort_by(|a, b| b.late_s.total_cmp(&a.late_s));
    lines.lines(
        "late",
        late.iter().take(3).map(|stop| format!("{}: {} s", escape(&stop.name), short(stop.late_s))),
    );
    let failed = file.legs.iter().zip(&record.stops).find(|(leg, _)| leg.status != Status::Solved);
    if let Some((leg, stop)) = failed {
        let (word, _) = verdict(leg.status);
        lines.text("stopped", format!("at the leg to {}: {word}", escape(&stop.name)));
        let reasons = leg.obstruction.iter().chain(&leg.shortfall);
        lines.texts("because", reasons.map(|text| escape(text)));
        return lines;
    }
    let margins = file.legs.iter().filter_map(|leg| leg.verified.as_ref()).flat_map(|found| &found.margins);
    let mut margins: Vec<Margin> = margins.cloned().collect();
    margins.sort_by(|a, b| a.scaled.total_cmp(&b.scaled));
    lines.extend(inputs::told(&loaded.sequence.craft, &file.joined().path, &margins, &loaded.identity));
    lines.lines("rate", fastest(&file.legs));
    lines.texts("clearance", clearances(file));
    lines.lines("arrives", arrives(&file.legs));
    lines.texts("proof", proved(file, loaded));
    lines
}

/// Describes the optimality of the leg with the weakest proof; `None` if no leg has a proof.
fn proved(file: &SequenceFile<'_>, loaded: &LoadedSequence) -> Option<String> {
    let craft = &loaded.sequence.craft;
    let solutions: Option<Vec<Solution>> =
        file.legs.iter().map(|leg| leg.plan().ok().map(|plan| plan.solution)).collect();
    let solutions = solutions?;
    let (weakest, solution) = solutions.iter().enumerate().min_by(|(_, a), (_, b)| {
        a.proved(craft).cmp(&b.proved(craft)).then(b.gap_part().total_cmp(&a.gap_part()))
    })?;
    let text = proof(craft, solution);
    if solutions.iter().all(|other| other.proved(craft) == solution.proved(craft)) {
        let each = if solutions.len() > 1 { "each leg is " } else { "" };
        return Some(format!("{each}{text}"));
    }
    Some(format!("the weakest on the leg to {}: {text}", escape(&file.record.stops[weakest].name)))
}

/// Describes the order of the stops, and what is proved about it.
fn order(record: &SequenceRecord) -> String {
    let stops = counted(record.stops.len(), "stop");
    if record.status == Status::Interrupted || record.status == Status::LimitReached {
        return format!("{stops} so far: the search was stopped");
    }
    match record.proof {
        OrderProof::AllOrders | OrderProof::LowerBound if record.late_s > 0.0 => {
            format!("{stops}; no order that keeps every window was found")
        }
        OrderProof::None => format!("{stops} in the best order of those that were tried"),
        OrderProof::Given => format!("{stops} in the given order"),
        OrderProof::AllOrders => {
            format!("{stops} in the best order for the legs that were found")
        }
        OrderProof::LowerBound => {
            let gap = 100.0 * record.order_gap.unwrap_or(f64::NAN);
            format!("{stops}; another order of these legs saves at most {} %", significant(gap, 2))
        }
    }
}

/// Describes the duration and the cost of the whole sequence.
fn whole(file: &SequenceFile<'_>) -> String {
    let record = &file.record;
    let turning: f64 = record.stops.iter().map(|stop| stop.arrives_s - stop.leg_begins_s).sum();
    let rests = record.duration_s - turning;
    let mut text = format!("{} s", short(record.duration_s));
    if rests > 0.0 {
        text.push_str(&format!(", of which {} s at stops", short(rests)));
    }
    if record.minimize != "time" {
        text.push_str(&format!("; {} {}, the sum of all legs", record.minimize, significant(record.cost, 6)));
    }
    text
}

/// Returns the table row of a stop: the angle and duration of the slew to it, and its times.
fn row(leg: &PlanFile<'_>, stop: &StopRecord) -> String {
    let name = clipped(&escape(&stop.name), NAME - 1);
    let turned = format!("{:.1}°", leg.turned_deg);
    // A leg that does not move takes less than the round-off of the time.
    let lasting = stop.arrives_s - stop.leg_begins_s;
    let lasting = if lasting <= f64::EPSILON * stop.arrives_s { 0.0 } else { lasting };
    let lasting = format!("{} s", significant(lasting, 4));
    let [arrives, holds, until] =
        [stop.arrives_s, stop.hold_begins_s, stop.leaves_s].map(|time| format!("{time:.2}"));
    format!("{name:<NAME$}{turned:>8} {lasting:>8} {arrives:>9} {holds:>9} {until:>9}")
}

/// Returns the smallest clearance to each cone over all legs, in increasing order.
fn clearances(file: &SequenceFile<'_>) -> Vec<String> {
    let of_leg = |(leg, stop): (&PlanFile<'_>, &StopRecord)| {
        let margins = leg.verified.as_ref().map_or(Vec::new(), |found| found.margins.clone());
        let cones = margins.into_iter().filter(|margin| margin.unit == "deg");
        cones.map(|margin| (margin, stop.name.clone())).collect::<Vec<_>>()
    };
    let mut all: Vec<(Margin, String)> = file.legs.iter().zip(&file.record.stops).flat_map(of_leg).collect();
    all.sort_by(|(a, _), (b, _)| a.margin.total_cmp(&b.margin));
    let mut told: Vec<(String, String)> = Vec::new();
    for (Margin { name, margin, .. }, stop) in all {
        if !told.iter().any(|(other, _)| *other == name) {
            let text =
                format!("{}: {} deg, on the leg to {}", escape(&name), significant(margin, 3), escape(&stop));
            told.push((name, text));
        }
    }
    told.into_iter().map(|(_, text)| text).take(CONES).collect()
}

/// Describes the largest angular rate of all legs.
fn fastest(legs: &[PlanFile<'_>]) -> Option<String> {
    let found = legs.iter().filter_map(|leg| leg.verified.as_ref());
    let rate = found.map(|found| found.peak_rate_rad_s.to_degrees()).reduce(f64::max)?;
    Some(format!("{} deg/s at most", significant(rate, 3)))
}

/// Describes the largest terminal error of the continuous motion over all legs.
fn arrives(legs: &[PlanFile<'_>]) -> Option<String> {
    let found = legs.iter().filter_map(|leg| leg.verified.as_ref());
    let off = found.map(|found| found.continuous_attitude_rad.to_degrees()).reduce(f64::max)?;
    Some(format!("{} deg off at most, in the true motion", significant(off, 2)))
}
