//! STK attitude files (`.a`): keywords, followed by rows. A row has the time since the scenario
//! epoch \[s\], a quaternion that rotates the reference axes into the body axes, and possibly the
//! rate in body axes \[deg/s\].

use super::between::Between;
use super::layout::{Attitude, Axes, Layout, Rates};
use super::message::not_used;
use super::rows::Rows;
use super::{Number, Piece, Wrong, lines, wrong};
use crate::epoch::{Epoch, Scale};
use crate::spec::cut;

/// Row formats that are supported, with the layout of the numbers that follow the time.
const FORMATS: [(&str, bool, Rates); 4] = [
    ("AttitudeTimeQuaternions", false, Rates::None),
    ("AttitudeTimeQuatScalarFirst", true, Rates::None),
    ("AttitudeTimeQuatAngVels", false, Rates::Velocity(Axes::Y)),
    ("AttitudeTimeQuatScalarFirstAngVels", true, Rates::Velocity(Axes::Y)),
];
const MONTHS: [&str; 12] =
    ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"];

/// Returns whether a file that begins with the text `start` is an STK attitude file.
pub(super) fn begins(start: &str) -> bool {
    start.get(..6).is_some_and(|start| start.eq_ignore_ascii_case("stk.v."))
}

/// Reads an STK attitude file and returns its rows.
pub(super) fn read(text: &str) -> Result<Rows, Wrong> {
    let mut rows = Rows::default();
    let (mut epoch, mut layout, mut began, mut ended) = (None, None, false, false);
    let (mut order, mut method, mut count) = (None, None, None);
    let mut last = Piece { at: 0, text: "" };
    for line in lines(text).skip(1) {
        if line.text.starts_with('#') {
            continue;
        }
        last = line;
        let (word, rest) = line.text.split_at(line.text.find(char::is_whitespace).unwrap_or(line.text.len()));
        let key = Piece { at: line.at, text: word };
        let value = Piece { at: line.at + word.len(), text: rest }.trimmed();
        if key.is("BEGIN") && value.is("Attitude") {
            began = true;
        } else if key.is("END") && value.is("Attitude") {
            ended = true;
            break;
        } else if !began {
            return line.wrong("BEGIN Attitude is needed here", "give an attitude file of STK");
        } else if key.is("ScenarioEpoch") {
            epoch = Some(date(value)?);
        } else if key.is("CoordinateAxes") {
            rows.named_at = Some(value.at);
            rows.found.reference_frame = Some(value.text.to_string());
        } else if key.is("InterpolationOrder") {
            order = Some(whole(value)?);
        } else if key.is("InterpolationMethod") {
            method = Some(value);
        } else if key.is("NumberOfAttitudePoints") {
            count = Some((whole(value)?, value));
        } else if key.is("TimeFormat") {
            if !value.is("EpSec") {
                let reason = format!("times in the format {} are not supported", cut(value.text, 20));
                return value.wrong(reason, "give seconds from ScenarioEpoch: TimeFormat EpSec");
            }
        } else if key.is("CoordinateAxesEpoch") {
            return key
                .wrong("axes of a date are not supported", "give attitudes in CoordinateAxes ICRF or J2000");
        } else if key.text.len() > 12 && key.text[..12].eq_ignore_ascii_case("AttitudeTime") {
            let Some((_, scalar_first, rates)) = FORMATS.iter().find(|(name, ..)| key.is(name)) else {
                let reason = format!("rows of {} are not supported", cut(key.text, 40));
                return key.wrong(reason, "write AttitudeTimeQuaternions or AttitudeTimeQuatAngVels");
            };
            layout = Some(Layout {
                attitude: Attitude::Quaternion { scalar_first: *scalar_first },
                rates: *rates,
                inverse: false,
            });
            let between = between(method, order).unwrap_or_else(|why| {
                rows.note(not_used(&why));
                Between::Unsaid
            });
            rows.begin(between);
        } else if key.text.starts_with(|sign: char| sign.is_ascii_digit() || "+-.".contains(sign)) {
            let Some(layout) = &layout else {
                return line.wrong(
                    "this row is before the line that states what the rows hold",
                    "write AttitudeTimeQuaternions above",
                );
            };
            let words = line.words();
            if words.len() != layout.count() + 1 {
                let reason =
                    format!("the row has {} numbers, but {} are needed", words.len(), layout.count() + 1);
                return line.wrong(reason, "give time, quaternion, and rates where the file has them");
            }
            let numbers = words.iter().map(|word| word.number()).collect::<Result<Vec<Number>, _>>()?;
            rows.add(line, numbers[0], layout.read(&numbers[1..]).row)?;
        } else if !KNOWN.iter().any(|known| key.is(known)) {
            rows.note(format!("`{}`, which is not supported", cut(key.text, 40)));
        }
    }
    if !ended {
        return last.wrong("END Attitude is missing", "the file is cut off");
    }
    if let Some((count, piece)) = count
        && count != rows.found.time.len()
    {
        let reason =
            format!("NumberOfAttitudePoints is {count}, but the file has {} rows", rows.found.time.len());
        return piece.wrong(reason, "correct it, or the rows: the file may be cut off");
    }
    match (epoch, rows.found.time.first()) {
        (Some(epoch), Some(first)) => rows.found.epoch = Some(epoch.after(*first)),
        (None, _) => {
            return wrong(
                0,
                1,
                "the file has no ScenarioEpoch",
                "add ScenarioEpoch 21 Nov 2026 07:00:00.000",
            );
        }
        _ => {}
    }
    Ok(rows)
}

/// Keywords that do not affect the attitudes and are ignored.
const KNOWN: [&str; 3] = ["BlockingFactor", "CentralBody", "MessageLevel"];

/// Returns the interpolation method between rows, or the reason why it is not used. If the file
/// states only the order, the method is Lagrange; if it states only the method, the order is 1.
fn between(method: Option<Piece<'_>>, order: Option<usize>) -> Result<Between, String> {
    if method.is_none() && order.is_none() {
        return Ok(Between::Unsaid);
    }
    Between::named(method.map_or("Lagrange", |method| method.text), Some(order.unwrap_or(1)))
}

fn whole(piece: Piece<'_>) -> Result<usize, Wrong> {
    piece.text.parse().or_else(|_| {
        piece.wrong(format!("`{}` is not a whole number", cut(piece.text, 20)), "write a whole number")
    })
}

/// Parses a date in UTC, such as `21 Nov 2026 07:00:00.000`.
fn date(piece: Piece<'_>) -> Result<Epoch, Wrong> {
    let words = piece.words();
    let iso = match words[..] {
        [day, month, year, clock] => MONTHS
            .iter()
            .position(|name| month.is(name))
            .map(|month| format!("{}-{:02}-{:0>2}T{:0>8}", year.text, month + 1, day.text, clock.text)),
        _ => None,
    };
    let remedy = "write ScenarioEpoch 21 Nov 2026 07:00:00.000";
    let Some(iso) = iso else { return piece.wrong("this is not a date in a format of STK", remedy) };
    Epoch::in_scale(&iso, Scale::Utc).or_else(|error| piece.wrong(error.to_string(), remedy))
}
