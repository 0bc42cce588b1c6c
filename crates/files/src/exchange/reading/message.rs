//! Metadata of AEM files in keyword notation and XML, and the rows that they describe.

use super::between::Between;
use super::layout::{Attitude, Axes, Layout, Rates, sequence};
use super::rows::Rows;
use super::{Number, Piece, Wrong, half_unit};
use crate::epoch::{Epoch, Scale};
use crate::exchange::frames::{Meaning, meaning};
use crate::spec::cut;

/// Version of an attitude ephemeris message (AEM).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Version {
    One,
    Two,
}

impl Version {
    pub fn of(piece: Piece<'_>) -> Result<Self, Wrong> {
        match piece.text {
            "1.0" => Ok(Self::One),
            "2.0" => Ok(Self::Two),
            other => piece.wrong(
                format!("version {} is not known", cut(other, 20)),
                "give an AEM of version 1.0 or 2.0",
            ),
        }
    }
}

/// Keys and values of a block of metadata, as read from the file.
#[derive(Debug, Default)]
pub(super) struct Metadata<'t> {
    keys: Vec<(&'static str, Piece<'t>)>,
}

/// Keys that the metadata of AEM 1.0 or 2.0 may have.
const KNOWN: [&str; 22] = [
    "OBJECT_NAME",
    "OBJECT_ID",
    "CENTER_NAME",
    "REF_FRAME_A",
    "REF_FRAME_B",
    "ATTITUDE_DIR",
    "TIME_SYSTEM",
    "START_TIME",
    "USEABLE_START_TIME",
    "USEABLE_STOP_TIME",
    "STOP_TIME",
    "ATTITUDE_TYPE",
    "QUATERNION_TYPE",
    "EULER_ROT_SEQ",
    "RATE_FRAME",
    "ANGVEL_FRAME",
    "INTERPOLATION_METHOD",
    "INTERPOLATION_DEGREE",
    "COMMENT",
    "ATTITUDE_DIRECTION",
    "MESSAGE_ID",
    "CLASSIFICATION",
];

impl<'t> Metadata<'t> {
    /// Adds a key with its value. An unknown key and a key that is given twice are errors.
    pub fn add(&mut self, key: Piece<'t>, value: Piece<'t>) -> Result<(), Wrong> {
        let Some(name) = KNOWN.into_iter().find(|known| key.is(known)) else {
            let reason = format!("unknown key `{}` in the metadata of an AEM", cut(key.text, 40));
            return key.wrong(reason, "check the spelling");
        };
        if name == "COMMENT" {
            return Ok(());
        }
        if self.get(name).is_some() {
            return key.wrong(format!("`{name}` is given twice"), "give it once in a block");
        }
        if value.text.is_empty() {
            return key.wrong(format!("`{name}` has no value"), "write KEY = value");
        }
        self.keys.push((name, value));
        Ok(())
    }

    fn get(&self, name: &str) -> Option<Piece<'t>> {
        self.keys.iter().find(|(key, _)| *key == name).map(|(_, value)| *value)
    }

    fn needed(&self, name: &str, end: Piece<'_>) -> Result<Piece<'t>, Wrong> {
        self.get(name).map_or_else(
            || end.wrong(format!("the metadata have no `{name}`"), format!("add {name} = …")),
            Ok,
        )
    }

    /// Returns the description of a block from its metadata. `end` is the position at which the
    /// metadata end, for messages.
    pub fn block(&self, version: Version, end: Piece<'_>) -> Result<Block, Wrong> {
        let needed = |name: &str| self.needed(name, end);
        needed("OBJECT_NAME")?;
        let (a, b) = (needed("REF_FRAME_A")?, needed("REF_FRAME_B")?);
        let scale = needed("TIME_SYSTEM")?;
        let Some(scale) = Scale::named(scale.text) else {
            let reason = format!("the time system {} is not supported", cut(scale.text, 20));
            return scale.wrong(reason, "give UTC, TAI, TT, TDB or GPS");
        };
        let kind = needed("ATTITUDE_TYPE")?;
        let (start, stop) = (needed("START_TIME")?, needed("STOP_TIME")?);
        let span = self.span(start, stop, scale)?;
        let (body_is_a, guessed) = body_is_a(a, b)?;
        let (reference, body) = if body_is_a { (b, a) } else { (a, b) };
        let (mut to_b, mut scalar_first) = (true, false);
        if version == Version::One {
            let direction = needed("ATTITUDE_DIR")?;
            to_b = match direction.text {
                _ if direction.is("A2B") => true,
                _ if direction.is("B2A") => false,
                _ => return direction.wrong("ATTITUDE_DIR is A2B or B2A", "write ATTITUDE_DIR = A2B"),
            };
            if kind.text.get(..10).is_some_and(|start| start.eq_ignore_ascii_case("QUATERNION")) {
                let order = needed("QUATERNION_TYPE")?;
                scalar_first = match order.text {
                    _ if order.is("FIRST") => true,
                    _ if order.is("LAST") => false,
                    _ => {
                        return order
                            .wrong("QUATERNION_TYPE is FIRST or LAST", "write QUATERNION_TYPE = LAST");
                    }
                };
            }
        } else if let Some(key) = self.get("ATTITUDE_DIR").or(self.get("QUATERNION_TYPE")) {
            return key.wrong(
                "this key belongs to version 1.0",
                "remove it: attitudes lead from A to B, scalar last",
            );
        }
        // The numbers describe the orientation of the frame Y relative to the frame X. Y is B if
        // the attitude leads from A to B, and A otherwise.
        let (x, y) = if to_b { ("REF_FRAME_A", "REF_FRAME_B") } else { ("REF_FRAME_B", "REF_FRAME_A") };
        let (x_name, y_name) = if to_b { (a, b) } else { (b, a) };
        let axes = |key: &str| -> Result<Option<Axes>, Wrong> {
            let Some(frame) = self.get(key) else { return Ok(None) };
            if frame.is(y) || frame.is(y_name.text) {
                Ok(Some(Axes::Y))
            } else if frame.is(x) || frame.is(x_name.text) {
                Ok(Some(Axes::X))
            } else {
                let (a, b) = (cut(a.text, 30), cut(b.text, 30));
                let reason = format!("{key} is neither of the two frames, {a} and {b}");
                frame.wrong(reason, "name one of them, or REF_FRAME_A or REF_FRAME_B")
            }
        };
        let (attitude, rates) = self.kind(version, kind, scalar_first, end, &axes)?;
        let layout = Layout { attitude, rates, inverse: body_is_a == to_b };
        let names = [reference.text.to_string(), body.text.to_string()];
        let (between, note) = self.between()?;
        let object = [self.get("OBJECT_NAME"), self.get("OBJECT_ID")]
            .map(|name| name.map_or("", |name| name.text).to_string());
        Ok(Block { layout, scale, names, named_at: reference.at, guessed, span, between, note, object })
    }

    /// Returns the meaning of the numbers in a row, from the attitude type.
    fn kind(
        &self,
        version: Version,
        kind: Piece<'_>,
        scalar_first: bool,
        end: Piece<'_>,
        axes: &dyn Fn(&str) -> Result<Option<Axes>, Wrong>,
    ) -> Result<(Attitude, Rates), Wrong> {
        let euler = || Ok(Attitude::Euler(sequence(self.needed("EULER_ROT_SEQ", end)?)?));
        let velocity = || match axes("ANGVEL_FRAME")? {
            Some(axes) => Ok(Rates::Velocity(axes)),
            None => end.wrong("the metadata have no `ANGVEL_FRAME`", "name the frame of the rates"),
        };
        // Some programs write a blank in place of the underscore in the name.
        let name: String =
            kind.text.to_ascii_uppercase().chars().map(|c| if c == ' ' { '_' } else { c }).collect();
        let quaternion = Attitude::Quaternion { scalar_first };
        let old = || -> Result<Rates, Wrong> {
            let order = self.get("EULER_ROT_SEQ").map(sequence).transpose()?;
            Ok(Rates::Old(axes("RATE_FRAME")?.unwrap_or(Axes::Y), order))
        };
        match (name.as_str(), version) {
            ("QUATERNION", _) => Ok((quaternion, Rates::None)),
            ("QUATERNION/DERIVATIVE", _) => Ok((quaternion, Rates::Derivative)),
            ("QUATERNION/ANGVEL", Version::Two) => Ok((quaternion, velocity()?)),
            ("QUATERNION/RATE", Version::One) => Ok((quaternion, old()?)),
            ("EULER_ANGLE", _) => Ok((euler()?, Rates::None)),
            ("EULER_ANGLE/DERIVATIVE", Version::Two) => Ok((euler()?, Rates::Derivative)),
            ("EULER_ANGLE/ANGVEL", Version::Two) => Ok((euler()?, velocity()?)),
            ("EULER_ANGLE/RATE", Version::One) => Ok((euler()?, old()?)),
            ("SPIN", _) => Ok((Attitude::Spin(0), Rates::None)),
            ("SPIN/NUTATION", _) | ("SPIN/NUTATION_MOM", Version::Two) => {
                Ok((Attitude::Spin(3), Rates::None))
            }
            (_, version) => {
                let rates = match version {
                    Version::One => "DERIVATIVE or RATE",
                    Version::Two => "DERIVATIVE or ANGVEL",
                };
                let number = if version == Version::One { "1.0" } else { "2.0" };
                kind.wrong(
                    format!("version {number} has no attitude type {}", cut(kind.text, 30)),
                    format!("give QUATERNION or EULER_ANGLE, alone or with /{rates}, or SPIN, alone or with /NUTATION"),
                )
            }
        }
    }

    /// Returns the interpolation method between the rows. If the program does not support the
    /// method that the file names, also returns a note that states this.
    fn between(&self) -> Result<(Between, Option<String>), Wrong> {
        let Some(method) = self.get("INTERPOLATION_METHOD") else { return Ok((Between::Unsaid, None)) };
        let degree = match self.get("INTERPOLATION_DEGREE") {
            None => None,
            Some(piece) => match piece.text.parse::<usize>() {
                Ok(degree) if degree > 0 => Some(degree),
                _ => {
                    let reason = format!("the interpolation degree {} is not supported", cut(piece.text, 20));
                    return piece.wrong(reason, "give a whole number from 1");
                }
            },
        };
        Ok(match Between::named(method.text, degree) {
            Ok(between) => (between, None),
            Err(why) => (Between::Unsaid, Some(not_used(&why))),
        })
    }

    /// Returns the time span of the block and the part of it that the file calls usable.
    fn span(&self, start: Piece<'_>, stop: Piece<'_>, scale: Scale) -> Result<Span, Wrong> {
        let of = |piece: Piece<'_>| date(piece, scale);
        let span = [of(start)?, of(stop)?];
        if span[1].since(&span[0]) < 0.0 {
            return stop.wrong("STOP_TIME is before START_TIME", "swap the two times");
        }
        let useable = |name: &str| self.get(name).map(of).transpose();
        let useable = [useable("USEABLE_START_TIME")?, useable("USEABLE_STOP_TIME")?];
        let digits = half_second(start.text).max(half_second(stop.text));
        Ok(Span { span, useable, digits })
    }
}

/// Determines which of the frames A and B is the body frame. Returns true if it is A; the second
/// value is true if the names do not determine this, so that it was guessed.
pub(super) fn body_is_a(a: Piece<'_>, b: Piece<'_>) -> Result<(bool, bool), Wrong> {
    match (meaning(a.text), meaning(b.text)) {
        (Meaning::Body, Meaning::Body) => {
            let reason =
                format!("{} and {} are both frames of the spacecraft", cut(a.text, 30), cut(b.text, 30));
            b.wrong(reason, "give the attitude of one of them relative to a reference frame")
        }
        (Meaning::Unknown, Meaning::Unknown) => Ok((false, true)),
        (Meaning::Body, _) | (Meaning::Unknown, _)
            if meaning(b.text) != Meaning::Body && meaning(a.text) == Meaning::Body =>
        {
            Ok((true, false))
        }
        (Meaning::Unknown, Meaning::Inertial(_) | Meaning::Orbit(_) | Meaning::Moving) => Ok((true, false)),
        (_, Meaning::Body | Meaning::Unknown) => Ok((false, false)),
        _ => {
            let reason =
                format!("neither {} nor {} is a frame of the spacecraft", cut(a.text, 30), cut(b.text, 30));
            b.wrong(reason, "give the attitude of the body relative to a reference frame")
        }
    }
}

/// Start and end of the data of a block.
#[derive(Clone, Debug)]
struct Span {
    span: [Epoch; 2],
    useable: [Option<Epoch>; 2],
    /// Uncertainty of the start and the end due to the printed digits of the dates \[s\].
    digits: f64,
}

/// Layout of the rows of a block, and the meaning of their numbers.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub layout: Layout,
    pub scale: Scale,
    /// Names of the reference frame and of the body frame.
    names: [String; 2],
    /// Byte position of the name of the reference frame, for messages.
    named_at: usize,
    /// True if the names of the frames do not determine which of them is the body frame, so that it
    /// was guessed.
    guessed: bool,
    span: Span,
    between: Between,
    /// Note that the interpolation method of the file is not used; `None` if it is used or absent.
    note: Option<String>,
    /// Name and number of the object whose attitude is given.
    object: [String; 2],
}

/// Returns the note that the interpolation method of the file is not used, for the reason `why`.
pub(super) fn not_used(why: &str) -> String {
    format!("the motion between rows by INTERPOLATION_METHOD {why}: judged at one rate")
}

/// Parses a date in the time scale of the block.
pub(super) fn date(piece: Piece<'_>, scale: Scale) -> Result<Epoch, Wrong> {
    Epoch::in_scale(piece.text, scale)
        .or_else(|error| piece.wrong(error.to_string(), "write 2026-11-21T07:00:00.25"))
}

/// Returns half a unit of the last printed digit of the seconds of a date \[s\].
pub(super) fn half_second(date: &str) -> f64 {
    let clock = date.trim_end_matches(['Z', 'z']);
    half_unit(clock.rsplit(':').next().unwrap_or(clock))
}

/// Largest difference between two angular velocities that count as equal \[rad/s\]: the round-off
/// of single precision at 1 rad/s.
const ONE_RATE: f64 = 1e-7;

impl Block {
    /// Begins a block of rows. Its frames and its object must be those of the previous blocks. The
    /// first row of a block may repeat the last row of the previous block.
    pub fn begin(&self, at: Piece<'_>, rows: &mut Rows) -> Result<(), Wrong> {
        let [reference, body] = self.names.clone();
        let before = rows.found.reference_frame.as_ref().zip(rows.found.body_frame.as_ref());
        let same =
            |(a, b): (&String, &String)| a.eq_ignore_ascii_case(&reference) && b.eq_ignore_ascii_case(&body);
        if before.is_some_and(|before| !same(before)) {
            return at.wrong(
                "this block has other frames than the one above",
                "give one file for each pair of frames",
            );
        }
        let object = rows.object.get_or_insert_with(|| self.object.clone());
        if !object.iter().zip(&self.object).all(|(one, other)| one.eq_ignore_ascii_case(other)) {
            let reason = format!(
                "this block is of {}, the one above of {}",
                cut(&self.object.join(" "), 60),
                cut(&object.join(" "), 60)
            );
            return at.wrong(reason, "give one file for each object");
        }
        if self.guessed {
            rows.note(format!(
                "which of {reference} and {body} is the body: no registry has the names, and B is taken for \
                    it"
            ));
        }
        if let Attitude::Spin(_) = self.layout.attitude {
            rows.note("rates of the file: SPIN gives only the rate about an axis that itself moves".into());
        }
        rows.named_at.get_or_insert(self.named_at);
        (rows.found.reference_frame, rows.found.body_frame) = (Some(reference), Some(body));
        if let Some(note) = &self.note {
            rows.note(note.clone());
        }
        rows.begin(self.between);
        Ok(())
    }

    /// Adds a row from its date and its numbers, which are in the order of the keyword notation.
    pub fn row(
        &self,
        at: Piece<'_>,
        moment: Piece<'_>,
        numbers: &[Number],
        rows: &mut Rows,
    ) -> Result<(), Wrong> {
        self.add(&self.layout, at, moment, numbers, rows)
    }

    /// Adds a row from its date and its numbers, which are in the order of [`Layout::names`].
    pub fn named_row(
        &self,
        at: Piece<'_>,
        moment: Piece<'_>,
        numbers: &[Number],
        rows: &mut Rows,
    ) -> Result<(), Wrong> {
        self.add(&self.layout.of_names(), at, moment, numbers, rows)
    }

    fn add(
        &self,
        layout: &Layout,
        at: Piece<'_>,
        written: Piece<'_>,
        numbers: &[Number],
        rows: &mut Rows,
    ) -> Result<(), Wrong> {
        if numbers.len() != layout.count() {
            let reason = format!(
                "the row has {} numbers after its date, but {} are needed",
                numbers.len(),
                layout.count()
            );
            return at.wrong(reason, "give the numbers that ATTITUDE_TYPE requires");
        }
        let moment = date(written, self.scale)?;
        let told = layout.read(numbers);
        let first = *rows.found.epoch.get_or_insert(moment);
        let time = moment.since(&first);
        self.within(written, &moment, rows)?;
        if told.apart > ONE_RATE {
            rows.leave_rates_out();
        }
        rows.add(at, Number { value: time, half_unit: half_second(written.text) }, told.row)
    }

    /// Checks that a row lies within the time span of its block. Counts the row if it is outside of
    /// the span that the file calls usable.
    fn within(&self, written: Piece<'_>, moment: &Epoch, rows: &mut Rows) -> Result<(), Wrong> {
        let Span { span: [start, stop], useable, digits } = &self.span;
        let open = digits.max(half_second(written.text));
        if moment.since(start) < -open || stop.since(moment) < -open {
            let reason = format!(
                "this row is not between START_TIME {} and STOP_TIME {} of its block",
                start.calendar_text(),
                stop.calendar_text()
            );
            return written.wrong(reason, "correct the span, or the row");
        }
        let early = useable[0].is_some_and(|from| moment.since(&from) < -open);
        let late = useable[1].is_some_and(|to| to.since(moment) < -open);
        if early || late {
            rows.unusable();
        }
        Ok(())
    }
}
