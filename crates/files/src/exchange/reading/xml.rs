//! AEM in XML.

use super::elements::{Token, Tokens, attribute, closed};
use super::message::{Block, Metadata, Version};
use super::rows::Rows;
use super::{Number, Piece, Wrong};
use crate::spec::cut;

/// A row on its way.
#[derive(Default)]
struct Row<'t> {
    date: Option<Piece<'t>>,
    values: Vec<(&'t str, Number)>,
}

/// Units that numbers of an AEM may have.
const UNITS: [&str; 4] = ["deg", "deg/s", "1/s", "s"];

/// Names in version 1.0 of angles and rates by their place in the sequence, and the names that they have here.
const BY_PLACE: [(&str, &str, &str); 6] = [
    ("rotationAngles", "rotation1", "ANGLE_1"),
    ("rotationAngles", "rotation2", "ANGLE_2"),
    ("rotationAngles", "rotation3", "ANGLE_3"),
    ("rotationRates", "rotation1", "RATE_1"),
    ("rotationRates", "rotation2", "RATE_2"),
    ("rotationRates", "rotation3", "RATE_3"),
];

/// What has been read.
#[derive(Default)]
struct Reading<'t> {
    rows: Rows,
    open: Vec<Piece<'t>>,
    said: Option<(Piece<'t>, Piece<'t>)>,
    version: Option<Version>,
    keys: Metadata<'t>,
    block: Option<Block>,
    row: Row<'t>,
}

/// Reads the file.
pub(super) fn read(text: &str) -> Result<Rows, Wrong> {
    let mut tokens = Tokens::of(text);
    let mut reading = Reading::default();
    while let Some(token) = tokens.next()? {
        match token {
            Token::Open(name, attributes) => reading.open(name, attributes)?,
            Token::Text(piece) => {
                let Some(name) = reading.open.last() else {
                    return piece.wrong("text outside of all elements", "remove it");
                };
                reading.said = Some((*name, piece));
            }
            Token::Close(name) => reading.close(name)?,
        }
    }
    match reading.open.last() {
        Some(name) => name.wrong(format!("<{}> is not closed", cut(name.text, 30)), "the file is cut off"),
        None => Ok(reading.rows),
    }
}

impl<'t> Reading<'t> {
    fn open(&mut self, name: Piece<'t>, attributes: Piece<'t>) -> Result<(), Wrong> {
        match name.text {
            "aem" => {
                let Some(number) = attribute(attributes, "version") else {
                    return name.wrong("the message does not say its version", "write version=\"2.0\"");
                };
                self.version = Some(Version::of(number)?);
            }
            "metadata" => self.keys = Metadata::default(),
            "attitudeState" => self.row = Row::default(),
            _ if self.open.is_empty() && name.text != "ndm" => {
                return name
                    .wrong(format!("<{}> is no attitude ephemeris", cut(name.text, 30)), "give an <aem>");
            }
            _ => {}
        }
        if let Some(unit) = attribute(attributes, "units").filter(|unit| !UNITS.contains(&unit.text)) {
            return unit.wrong(
                format!("the unit {} is not known here", cut(unit.text, 20)),
                "angles are in deg, rates in deg/s",
            );
        }
        self.open.push(name);
        self.said = None;
        Ok(())
    }

    fn close(&mut self, name: Piece<'t>) -> Result<(), Wrong> {
        let opened = closed(&mut self.open, name)?;
        let value = self.said.take().filter(|(of, _)| of.at == opened.at).map(|(_, piece)| piece);
        let inside = |element: &str| self.open.iter().any(|piece| piece.text == element);
        match name.text {
            "metadata" => {
                let version =
                    self.version.map_or_else(|| name.wrong("there is no <aem>", "give an <aem>"), Ok)?;
                let read = self.keys.block(version, name)?;
                read.begin(name, &mut self.rows)?;
                self.block = Some(read);
            }
            "attitudeState" => {
                let Some(block) = &self.block else {
                    return name.wrong("data before any metadata", "put <metadata> before <data>");
                };
                finish(&self.row, block, opened, &mut self.rows)?;
            }
            _ if inside("metadata") => {
                self.keys.add(opened, value.unwrap_or(Piece { at: opened.at, text: "" }))?;
            }
            "EPOCH" if inside("attitudeState") => self.row.date = value,
            "COMMENT" => {}
            _ if inside("attitudeState") => {
                if let Some(value) = value {
                    let place = BY_PLACE.iter().find(|(of, at, _)| opened.text == *at && inside(of));
                    let name = place.map_or(opened.text, |(_, _, name)| name);
                    self.row.values.push((name, value.number()?));
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// Adds the row.
fn finish(row: &Row<'_>, block: &Block, at: Piece<'_>, rows: &mut Rows) -> Result<(), Wrong> {
    let Some(moment) = row.date else {
        return at.wrong("the state has no <EPOCH>", "give the date of every state");
    };
    let names = block.layout.names();
    let mut numbers = Vec::with_capacity(names.len());
    for name in names {
        let mut found = row.values.iter().filter(|(key, _)| *key == name);
        match (found.next(), found.next()) {
            (Some((_, value)), None) => numbers.push(*value),
            (None, _) => {
                return at.wrong(format!("the state has no <{name}>"), "give what ATTITUDE_TYPE says");
            }
            (Some(_), Some(_)) => return at.wrong(format!("the state has <{name}> twice"), "give it once"),
        }
    }
    block.named_row(at, moment, &numbers, rows)
}
