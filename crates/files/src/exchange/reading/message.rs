//! What AEM files of both notations say about their data, and a row of them.

use super::{Piece, Rows, Wrong};
use crate::epoch::{Epoch, Scale};
use crate::spec::cut;
use slewkit::{Vector3, lie};

/// Versions of the message.
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

/// What numbers follow the date of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// The quaternion.
    Quaternion,
    /// And its derivative.
    Derivative,
    /// And the angular velocity.
    Rate,
    /// And rates that versions and programs read in different ways: they are not taken.
    OtherRate,
}

impl Kind {
    /// Numbers behind the date.
    pub fn count(self) -> usize {
        match self {
            Self::Quaternion => 4,
            Self::Derivative => 8,
            Self::Rate | Self::OtherRate => 7,
        }
    }
}

/// Keys of a block of metadata, as they stand there.
#[derive(Debug, Default)]
pub(super) struct Metadata<'t> {
    keys: Vec<(&'t str, Piece<'t>)>,
}

/// Keys of both versions.
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
    /// Adds a key, once.
    pub fn add(&mut self, key: Piece<'t>, value: Piece<'t>) -> Result<(), Wrong> {
        if key.text == "COMMENT" {
            return Ok(());
        }
        if !KNOWN.contains(&key.text) {
            let reason = format!("unknown key `{}` in the metadata of an AEM", cut(key.text, 40));
            return key.wrong(reason, "check the spelling");
        }
        if self.keys.iter().any(|(name, _)| *name == key.text) {
            return key.wrong(format!("`{}` is given twice", key.text), "give it once in a block");
        }
        if value.text.is_empty() {
            return key.wrong(format!("`{}` has no value", key.text), "write KEY = value");
        }
        self.keys.push((key.text, value));
        Ok(())
    }

    fn get(&self, name: &str) -> Option<Piece<'t>> {
        self.keys.iter().find(|(key, _)| *key == name).map(|(_, value)| *value)
    }

    /// What the keys say together; `end` is where they end.
    pub fn block(&self, version: Version, end: Piece<'_>) -> Result<Block, Wrong> {
        let needed = |name: &str| {
            self.get(name).map_or_else(
                || end.wrong(format!("the metadata have no `{name}`"), format!("add {name} = …")),
                Ok,
            )
        };
        needed("OBJECT_NAME")?;
        let (a, b) = (needed("REF_FRAME_A")?, needed("REF_FRAME_B")?);
        let scale = needed("TIME_SYSTEM")?;
        let Some(scale) = Scale::named(scale.text) else {
            let reason = format!("the time system {} is not known here", cut(scale.text, 20));
            return scale.wrong(reason, "give UTC, TAI, TT, TDB or GPS");
        };
        let kind = self.kind(version, needed("ATTITUDE_TYPE")?)?;
        let (start, stop) = (needed("START_TIME")?, needed("STOP_TIME")?);
        if date(stop, scale)?.since(&date(start, scale)?) < 0.0 {
            return stop.wrong("STOP_TIME is before START_TIME", "exchange the two");
        }
        // B is the body unless A alone is named as one.
        let is_body = |name: &str| {
            name.starts_with("SC_BODY")
                || name.starts_with("SC ")
                || name == "SC"
                || name.starts_with("INSTRUMENT")
        };
        let mut inverse = is_body(a.text) && !is_body(b.text);
        let (reference, body) = if inverse { (b, a) } else { (a, b) };
        let mut scalar_first = false;
        if version == Version::One {
            let direction = needed("ATTITUDE_DIR")?;
            inverse ^= match direction.text {
                "A2B" => false,
                "B2A" => true,
                _ => return direction.wrong("ATTITUDE_DIR is A2B or B2A", "write ATTITUDE_DIR = A2B"),
            };
            let order = needed("QUATERNION_TYPE")?;
            scalar_first = match order.text {
                "FIRST" => true,
                "LAST" => false,
                _ => return order.wrong("QUATERNION_TYPE is FIRST or LAST", "write QUATERNION_TYPE = LAST"),
            };
        } else if let Some(key) = self.get("ATTITUDE_DIR").or(self.get("QUATERNION_TYPE")) {
            return key
                .wrong("this key is of version 1.0", "remove it: attitudes lead from A to B, scalar last");
        }
        let in_body = match self.get("ANGVEL_FRAME") {
            _ if kind != Kind::Rate => true,
            None => return end.wrong("the metadata have no `ANGVEL_FRAME`", "name the frame of the rates"),
            Some(frame) if frame.text == body.text => true,
            Some(frame) if frame.text == reference.text => false,
            Some(frame) => {
                return frame
                    .wrong("ANGVEL_FRAME is neither of the two frames", "name REF_FRAME_A or REF_FRAME_B");
            }
        };
        let names = [reference.text.to_string(), body.text.to_string()];
        Ok(Block { kind, scale, inverse, scalar_first, in_body, names })
    }

    fn kind(&self, version: Version, piece: Piece<'_>) -> Result<Kind, Wrong> {
        match (piece.text, version) {
            ("QUATERNION", _) => Ok(Kind::Quaternion),
            ("QUATERNION/DERIVATIVE", _) => Ok(Kind::Derivative),
            ("QUATERNION/ANGVEL", Version::Two) => Ok(Kind::Rate),
            ("QUATERNION/RATE", Version::One) => Ok(Kind::OtherRate),
            (other, _) => piece.wrong(
                format!("the attitude type {} is not read here", cut(other, 30)),
                "give QUATERNION, QUATERNION/DERIVATIVE or, in version 2.0, QUATERNION/ANGVEL",
            ),
        }
    }
}

/// How the rows of a block are to be read.
#[derive(Debug)]
pub(super) struct Block {
    pub kind: Kind,
    pub scale: Scale,
    inverse: bool,
    scalar_first: bool,
    in_body: bool,
    /// Reference and body.
    names: [String; 2],
}

/// A moment in the scale of the block.
pub(super) fn date(piece: Piece<'_>, scale: Scale) -> Result<Epoch, Wrong> {
    Epoch::in_scale(piece.text, scale)
        .or_else(|error| piece.wrong(error.to_string(), "write 2026-11-21T07:00:00.25"))
}

impl Block {
    /// Takes the names over; all blocks of a file must agree. The first row of a block may be the last of the one above.
    pub fn begin(&self, at: Piece<'_>, rows: &mut Rows) -> Result<(), Wrong> {
        let [reference, body] = self.names.clone();
        let before = rows.found.reference_frame.as_ref().zip(rows.found.body_frame.as_ref());
        if before.is_some_and(|before| before != (&reference, &body)) {
            return at.wrong(
                "this block has other frames than the one above",
                "give one file for each pair of frames",
            );
        }
        (rows.found.reference_frame, rows.found.body_frame) = (Some(reference), Some(body));
        rows.begins = true;
        Ok(())
    }

    /// Adds a row: its date and numbers in the order of the file, scalar last where `scalar_first` is not said.
    pub fn row(&self, at: Piece<'_>, moment: Epoch, numbers: &[f64], rows: &mut Rows) -> Result<(), Wrong> {
        if numbers.len() != self.kind.count() {
            let reason = format!(
                "the row has {} numbers behind its date, {} are needed",
                numbers.len(),
                self.kind.count()
            );
            return at.wrong(reason, "give what ATTITUDE_TYPE says");
        }
        let [x, y, z, w] = if self.scalar_first {
            [numbers[1], numbers[2], numbers[3], numbers[0]]
        } else {
            [numbers[0], numbers[1], numbers[2], numbers[3]]
        };
        let vector = Vector3::new(x, y, z);
        let sign = if self.inverse { -1.0 } else { 1.0 };
        // Of B against A, in the axes of B: Ω = 2 (w q̇ᵥ − ẇ qᵥ − qᵥ × q̇ᵥ).
        let rate = match self.kind {
            Kind::Quaternion | Kind::OtherRate => None,
            Kind::Rate => {
                let rate = Vector3::from_column_slice(&numbers[4..7]).map(f64::to_radians);
                let attitude = lie::rotation_from_quaternion(&[w, sign * x, sign * y, sign * z]);
                Some(if self.in_body { rate } else { attitude.tr_mul(&rate) })
            }
            Kind::Derivative => {
                let [dx, dy, dz, dw] = if self.scalar_first {
                    [numbers[5], numbers[6], numbers[7], numbers[4]]
                } else {
                    [numbers[4], numbers[5], numbers[6], numbers[7]]
                };
                let (vector, moved) = (sign * vector, sign * Vector3::new(dx, dy, dz));
                Some(2.0 * (w * moved - dw * vector - vector.cross(&moved)))
            }
        };
        let first = *rows.found.epoch.get_or_insert(moment);
        rows.add(at, moment.since(&first), [w, sign * x, sign * y, sign * z], rate)
    }
}
