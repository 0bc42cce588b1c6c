//! Tables of attitudes: a header that names the columns with their units, followed by rows of
//! numbers. Cells are separated by commas, semicolons, tabs or blanks, and may be quoted. Lines
//! that begin with # are comments. A column without a name is ignored.

use super::layout::{Attitude, Layout, Rates};
use super::rows::Rows;
use super::{Number, Piece, Wrong, wrong};
use crate::cells::{self, separator};
use crate::spec::cut;
use slewkit::Vector3;

/// Name of the column of times. The names of the used columns are those of the tables that this
/// program writes.
const TIME: &str = "time_s";
const QUATERNION: [&str; 4] = ["quaternion_w", "quaternion_x", "quaternion_y", "quaternion_z"];
const RATE_RAD: [&str; 3] =
    ["angular_velocity_x_rad_s", "angular_velocity_y_rad_s", "angular_velocity_z_rad_s"];
const RATE_DEG: [&str; 3] =
    ["angular_velocity_x_deg_s", "angular_velocity_y_deg_s", "angular_velocity_z_deg_s"];

/// Reads a table of attitudes and returns its rows.
pub(super) fn read(text: &str) -> Result<Rows, Wrong> {
    let mut lines = lines_of_table(text);
    let Some(head) = lines.next() else {
        return wrong(0, 1, "the table has no header", "name the columns: time_s,quaternion_w,…");
    };
    let sign = separator(head.text);
    let names = cells(head, sign)?;
    for (index, name) in names.iter().enumerate() {
        if !name.text.is_empty() && names[..index].iter().any(|before| before.is(name.text)) {
            return name
                .wrong(format!("the column `{}` occurs twice", cut(name.text, 30)), "give each column once");
        }
    }
    let find = |wanted: &str| names.iter().position(|name| name.is(wanted));
    let needed = |wanted: &str| {
        find(wanted).map_or_else(
            || {
                let reason = format!("the table has no column `{wanted}`");
                head.wrong(
                    reason,
                    "the header must have time_s, quaternion_w, quaternion_x, quaternion_y, \
                        quaternion_z, and may have angular_velocity_x_rad_s …",
                )
            },
            Ok,
        )
    };
    let time = needed(TIME)?;
    let mut columns = Vec::with_capacity(7);
    for name in QUATERNION {
        columns.push(needed(name)?);
    }
    let rates = [(RATE_RAD, 1.0), (RATE_DEG, 1_f64.to_radians())];
    let rate = rates.into_iter().find(|(names, _)| names.iter().any(|name| find(name).is_some()));
    for name in rate.iter().flat_map(|(names, _)| names) {
        columns.push(needed(name)?);
    }
    let attitude = Attitude::Quaternion { scalar_first: true };
    let layout = Layout { attitude, rates: Rates::None, inverse: false };
    let mut rows = Rows::default();
    rows.found.begins = Some(0.0);
    for line in lines {
        let cells = cells(line, sign)?;
        if cells.len() != names.len() {
            let reason = format!("the row has {} cells, but the header has {}", cells.len(), names.len());
            return line.wrong(reason, "give every column in every row; the file may be cut off");
        }
        let numbers =
            columns.iter().map(|column| cells[*column].number()).collect::<Result<Vec<Number>, _>>()?;
        let mut row = layout.read(&numbers[..4]).row;
        if let Some((_, scale)) = rate {
            row.rate = Some(scale * Vector3::new(numbers[4].value, numbers[5].value, numbers[6].value));
            row.open.1 = 2.0 * scale * numbers[4..].iter().map(|number| number.half_unit).fold(0.0, f64::max);
        }
        rows.add(line, cells[time].number()?, row)?;
    }
    Ok(rows)
}

/// Returns the lines that are neither blank nor comments. A leading or trailing tab is kept,
/// because it separates cells.
fn lines_of_table(text: &str) -> impl Iterator<Item = Piece<'_>> {
    let blank = [' ', '\r', '\n'];
    let lines = text.split_inclusive('\n').scan(0, move |at, line| {
        let lead = line.len() - line.trim_start_matches(blank).len();
        let piece = Piece { at: *at + lead, text: line.trim_matches(blank) };
        *at += line.len();
        Some(piece)
    });
    lines.filter(|line| !line.text.trim().is_empty() && !line.text.starts_with('#'))
}

/// Splits a line into cells; `sign` is the separator of the cells, `None` for blanks.
fn cells(line: Piece<'_>, sign: Option<char>) -> Result<Vec<Piece<'_>>, Wrong> {
    let found = cells::cells(line.text, sign)
        .or_else(|reason| line.wrong(reason, "put a cell between two quotes, or none"))?;
    let piece = |cell: cells::Cell<'_>| {
        // Names and numbers contain no quotes, so the text of a cell is a substring of the line.
        let end = (cell.start + cell.text.len()).min(line.text.len());
        let text = line.text.get(cell.start..end).unwrap_or_default();
        Piece { at: line.at + cell.start, text }.trimmed()
    };
    Ok(found.into_iter().map(piece).collect())
}
