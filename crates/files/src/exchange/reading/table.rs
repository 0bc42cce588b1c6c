//! Tables of attitudes: a head that names the columns with their units, then numbers, separated by commas, semicolons,
//! tabs or blanks. Lines that begin with # are comments.

use super::{Piece, Rows, Wrong, lines, wrong};
use crate::spec::cut;
use slewkit::Vector3;

/// Columns that are taken, with their names in our own tables.
const TIME: [&str; 1] = ["time_s"];
const QUATERNION: [&str; 4] = ["quaternion_w", "quaternion_x", "quaternion_y", "quaternion_z"];
const RATE_RAD: [&str; 3] =
    ["angular_velocity_x_rad_s", "angular_velocity_y_rad_s", "angular_velocity_z_rad_s"];
const RATE_DEG: [&str; 3] =
    ["angular_velocity_x_deg_s", "angular_velocity_y_deg_s", "angular_velocity_z_deg_s"];

/// Reads the table.
pub(super) fn read(text: &str) -> Result<Rows, Wrong> {
    let mut lines = lines(text).filter(|line| !line.text.starts_with('#'));
    let Some(head) = lines.next() else {
        return wrong(0, 1, "the table has no head", "name the columns: time_s,quaternion_w,…");
    };
    let sign = [',', ';', '\t'].into_iter().find(|sign| head.text.contains(*sign));
    let names = cells(head, sign);
    for (index, name) in names.iter().enumerate() {
        if names[..index].iter().any(|before| before.text == name.text) {
            return name.wrong(
                format!("the column `{}` is there twice", cut(name.text, 30)),
                "give each column once",
            );
        }
    }
    let find = |wanted: &str| names.iter().position(|name| name.text == wanted);
    let needed = |wanted: &str| {
        find(wanted).map_or_else(
            || {
                let reason = format!("the table has no column `{wanted}`");
                head.wrong(reason, "the head names time_s, quaternion_w, quaternion_x, quaternion_y, quaternion_z, and may name angular_velocity_x_rad_s …")
            },
            Ok,
        )
    };
    let time = needed(TIME[0])?;
    let quaternion = QUATERNION.map(needed);
    let mut columns = [0; 4];
    for (column, found) in columns.iter_mut().zip(quaternion) {
        *column = found?;
    }
    let rates = [(RATE_RAD, 1.0), (RATE_DEG, 1_f64.to_radians())];
    let rate = rates.into_iter().find(|(names, _)| names.iter().any(|name| find(name).is_some()));
    let rate = match rate {
        None => None,
        Some((names, scale)) => {
            let mut columns = [0; 3];
            for (column, name) in columns.iter_mut().zip(names) {
                *column = needed(name)?;
            }
            Some((columns, scale))
        }
    };
    let mut rows = Rows::default();
    for line in lines {
        let cells = cells(line, sign);
        if cells.len() != names.len() {
            let reason = format!("the row has {} cells, the head has {}", cells.len(), names.len());
            return line.wrong(reason, "give every column in every row; the file may be cut off");
        }
        let [w, x, y, z] = columns;
        let attitude = [cells[w].number()?, cells[x].number()?, cells[y].number()?, cells[z].number()?];
        let rate = match rate {
            None => None,
            Some(([x, y, z], scale)) => {
                Some(scale * Vector3::new(cells[x].number()?, cells[y].number()?, cells[z].number()?))
            }
        };
        rows.add(line, cells[time].number()?, attitude, rate)?;
    }
    Ok(rows)
}

/// The cells of a line.
fn cells(line: Piece<'_>, sign: Option<char>) -> Vec<Piece<'_>> {
    let Some(sign) = sign else { return line.words() };
    let mut at = line.at;
    let mut cells = Vec::new();
    for text in line.text.split(sign) {
        cells.push(Piece { at, text }.trimmed());
        at += text.len() + sign.len_utf8();
    }
    cells
}
