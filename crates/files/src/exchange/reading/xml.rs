//! AEM in XML (CCSDS 505.0-B).

use super::elements::{self, Element, Message, Open};
use super::message::{Block, Metadata, Version};
use super::rows::Rows;
use super::{Number, Piece, Wrong};
use crate::spec::cut;

/// A row whose elements are being read.
#[derive(Default)]
struct Row<'t> {
    date: Option<Piece<'t>>,
    values: Vec<(&'t str, Number)>,
}

/// Units that the numbers of an AEM may have.
const UNITS: [&str; 4] = ["deg", "deg/s", "1/s", "s"];

/// Names of Euler angles and rates in XML of version 1.0: the enclosing element, the element, and
/// the name of the number in the layout of a row.
const BY_PLACE: [(&str, &str, &str); 6] = [
    ("rotationAngles", "rotation1", "ANGLE_1"),
    ("rotationAngles", "rotation2", "ANGLE_2"),
    ("rotationAngles", "rotation3", "ANGLE_3"),
    ("rotationRates", "rotation1", "RATE_1"),
    ("rotationRates", "rotation2", "RATE_2"),
    ("rotationRates", "rotation3", "RATE_3"),
];

/// Blocks read so far, and the block that is being read.
#[derive(Default)]
struct Reading<'t> {
    rows: Rows,
    version: Option<Version>,
    keys: Metadata<'t>,
    block: Option<Block>,
    row: Row<'t>,
}

/// Reads an AEM in XML and returns its rows.
pub(super) fn read(text: &str) -> Result<Rows, Wrong> {
    let document = elements::document(text)?;
    let mut reading = Reading::default();
    elements::read(&document, &mut reading)?;
    Ok(reading.rows)
}

impl<'t> Message<'t> for Reading<'t> {
    const ELEMENT: &'static str = "aem";

    fn version(&mut self, number: Piece<'t>) -> Result<(), Wrong> {
        self.version = Some(Version::of(number)?);
        Ok(())
    }

    fn opened(&mut self, _: &Open<'t>, name: Piece<'t>, unit: Option<Piece<'t>>) -> Result<(), Wrong> {
        match name.text {
            "metadata" => self.keys = Metadata::default(),
            "attitudeState" => self.row = Row::default(),
            _ => {}
        }
        if let Some(unit) = unit.filter(|unit| !UNITS.contains(&unit.text)) {
            return unit.wrong(
                format!("the unit {} is not supported", cut(unit.text, 20)),
                "angles are in deg, rates in deg/s",
            );
        }
        Ok(())
    }

    fn closed(&mut self, within: &Open<'t>, element: &Element<'t>) -> Result<(), Wrong> {
        let Element { name, value } = *element;
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
                    return name.wrong("the data come before the metadata", "put <metadata> before <data>");
                };
                finish(&self.row, block, name, &mut self.rows)?;
            }
            _ if within.has("metadata") => self.keys.add(name, element.text())?,
            "EPOCH" if within.has("attitudeState") => self.row.date = value,
            "COMMENT" => {}
            _ if within.has("attitudeState") => {
                if let Some(value) = value {
                    let place = BY_PLACE.iter().find(|(of, at, _)| name.text == *at && within.has(of));
                    let name = place.map_or(name.text, |(_, _, name)| name);
                    self.row.values.push((name, value.number()?));
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// Adds a row whose elements have all been read.
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
                return at.wrong(
                    format!("the state has no <{name}>"),
                    "give the numbers that ATTITUDE_TYPE requires",
                );
            }
            (Some(_), Some(_)) => return at.wrong(format!("the state has <{name}> twice"), "give it once"),
        }
    }
    block.named_row(at, moment, &numbers, rows)
}
