//! Files of slew-time tables: `.npz` archives, which this program reads, and Parquet tables for
//! other programs.
//!
//! The archive contains these arrays of doubles. L is the number of angles, D the number of
//! directions and N = L·D the number of nodes, which are ordered by angle:
//!
//! | array | shape | meaning |
//! |---|---|---|
//! | `directions` | D × 3 | unit axes of the turns, body axes |
//! | `angles_rad` | L | angles of the turns |
//! | `values` | L × D | minimum times \[s\], or efforts |
//! | `gradients` | N × 3 | gradients of the values with respect to the rotation vector, body axes |
//! | `bounds` | L × D | rigorous lower bounds of the values |
//! | `fixed_axis` | L × D | durations of turns about their fixed axes \[s\]; absent if they are not known |
//! | `axes` | 3 × 3 | columns: the axes of the octahedron, body axes |
//! | `symmetry` | k × 9 | signed permutations of these axes, row after row |
//! | `reference_torque`, `reference_rate` | 3 × 3 | the closed form that the interpolation divides by |
//! | `bound_numbers` | 20 | constants of the lower bound |
//! | `errors` | 6 | number of test turns; median, 99 % quantile, minimum and maximum of the relative error; median ratio of bound to plan |
//! | `version`, `is_effort`, `divisions`, `duration_s`, `scales`, `settling_s`, `planned` | 1 | properties of the table |
//! | `spec_checksum` | 2 | the hash of the spec, upper and lower 32 bits |

use crate::exchange::{Array, Arrays, read_arrays};
use crate::export::ExportError;
use crate::fingerprint::Fingerprint;
use crate::spec::SpecDocument;
use slewkit::sequence::table::{Errors, Nodes};
use slewkit::sequence::{LegBound, Quantity, SlewTable, TableError};
use slewkit::{Matrix3, Vector3};
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use thiserror::Error;

/// Version of the file format, which defines the arrays of an archive.
const VERSION: f64 = 1.0;

/// Name of the array of turns about fixed axes, which a table may lack.
const FIXED_AXIS: &str = "fixed_axis";

/// Reason why a file is not a valid slew-time table.
#[derive(Debug, Error)]
pub enum TableFileError {
    /// The `.npz` archive cannot be read.
    #[error("{0}")]
    Archive(#[from] io::Error),
    /// The archive lacks this array, or the array has a wrong shape.
    #[error("the array `{0}` is missing or has another shape")]
    Array(&'static str),
    /// The file has another version of the file format, which is given.
    #[error("the file has version {0} of the arrays, and this program reads version 1")]
    Version(f64),
    /// The numbers in the file do not form a valid slew-time table.
    #[error(transparent)]
    Table(#[from] TableError),
}

/// Returns a hash of a spec and of the version of the program.
///
/// # Errors
/// Returns an error if the spec cannot be serialised.
pub fn checksum(spec: &SpecDocument) -> Result<u64, ExportError> {
    let text = serde_json::to_vec(spec)?;
    Ok(u64::from_str_radix(&Fingerprint::of_program().and(&text).text(), 16).unwrap_or_default())
}

/// Writes a slew-time table as `.npz`; `checksum` is the hash of its spec.
///
/// # Errors
/// Returns the errors of the output stream.
pub fn write_npz(table: &SlewTable, checksum: u64, output: &mut dyn Write) -> Result<(), ExportError> {
    let nodes = table.nodes();
    let (angles, rows) = (nodes.angles.len(), nodes.values.len());
    let width = rows / angles;
    let directions: Vec<f64> =
        table.vectors().take(width).flat_map(|vector| Vec::from(vector.normalize().as_slice())).collect();
    let by_rows = |matrix: &Matrix3| Vec::from(matrix.transpose().as_slice());
    let gradients: Vec<f64> =
        nodes.gradients.iter().flat_map(|gradient| Vec::from(gradient.as_slice())).collect();
    let flag = |value: bool| f64::from(u8::from(value));
    let Errors { count, median, most, lowest, highest, bound } = nodes.errors;
    let mut arrays = Arrays::new(output);
    arrays.add("directions", width, 3, &directions)?;
    arrays.add("angles_rad", angles, 1, &nodes.angles)?;
    arrays.add("values", angles, width, &nodes.values)?;
    arrays.add("gradients", rows, 3, &gradients)?;
    arrays.add("bounds", angles, width, &nodes.bounds)?;
    if !nodes.fixed_axis.is_empty() {
        arrays.add(FIXED_AXIS, angles, width, &nodes.fixed_axis)?;
    }
    arrays.add("axes", 3, 3, &by_rows(&nodes.axes))?;
    let maps: Vec<f64> = nodes.maps.iter().flat_map(by_rows).collect();
    arrays.add("symmetry", nodes.maps.len(), 9, &maps)?;
    arrays.add("reference_torque", 3, 3, &by_rows(&nodes.reference[0]))?;
    arrays.add("reference_rate", 3, 3, &by_rows(&nodes.reference[1]))?;
    arrays.add("bound_numbers", LegBound::NUMBERS, 1, &nodes.bound)?;
    arrays.add("errors", 6, 1, &[count as f64, median, most, lowest, highest, bound])?;
    let facts = [
        ("version", VERSION),
        ("is_effort", flag(nodes.quantity == Quantity::Effort)),
        ("divisions", nodes.divisions as f64),
        ("duration_s", nodes.duration_s),
        ("scales", flag(nodes.scales)),
        ("settling_s", nodes.settling_s),
        ("planned", nodes.planned as f64),
    ];
    for (name, value) in facts {
        arrays.add(name, 1, 1, &[value])?;
    }
    let halves = [checksum >> 32, checksum & 0xffff_ffff].map(|half| half as f64);
    arrays.add("spec_checksum", 2, 1, &halves)?;
    Ok(arrays.close()?)
}

/// Reads a slew-time table that [`write_npz`] has written.
///
/// # Errors
/// Returns a [`TableFileError`] if the input is not such an archive, or if its numbers do not form
/// a valid table.
pub fn read_npz(input: impl Read) -> Result<SlewTable, TableFileError> {
    let arrays = Found(read_arrays(input)?);
    let version = arrays.fact("version")?;
    if version.total_cmp(&VERSION).is_ne() {
        return Err(TableFileError::Version(version));
    }
    let whole = |name: &'static str| -> Result<usize, TableFileError> {
        let value = arrays.fact(name)?;
        let fits = (0.0..=1e9).contains(&value) && value.fract().total_cmp(&0.0).is_eq();
        if fits { Ok(value as usize) } else { Err(TableFileError::Array(name)) }
    };
    let flag = |value: f64| value.total_cmp(&1.0).is_eq();
    let maps = arrays.get("symmetry")?.numbers.chunks_exact(9).map(Matrix3::from_row_slice);
    let errors = arrays.of("errors", 6)?;
    let gradients = &arrays.get("gradients")?.numbers;
    let bound: [f64; LegBound::NUMBERS] = arrays
        .of("bound_numbers", LegBound::NUMBERS)?
        .try_into()
        .map_err(|_| TableFileError::Array("bound_numbers"))?;
    Ok(SlewTable::new(Nodes {
        quantity: if flag(arrays.fact("is_effort")?) { Quantity::Effort } else { Quantity::Time },
        divisions: whole("divisions")?,
        axes: arrays.matrix("axes")?,
        maps: maps.collect(),
        angles: arrays.get("angles_rad")?.numbers.clone(),
        values: arrays.get("values")?.numbers.clone(),
        gradients: gradients.chunks_exact(3).map(Vector3::from_column_slice).collect(),
        bounds: arrays.get("bounds")?.numbers.clone(),
        fixed_axis: arrays.0.get(FIXED_AXIS).map(|found| found.numbers.clone()).unwrap_or_default(),
        duration_s: arrays.fact("duration_s")?,
        scales: flag(arrays.fact("scales")?),
        reference: [arrays.matrix("reference_torque")?, arrays.matrix("reference_rate")?],
        bound,
        settling_s: arrays.fact("settling_s")?,
        planned: whole("planned")?,
        errors: Errors {
            count: errors[0].clamp(0.0, 1e9) as usize,
            median: errors[1],
            most: errors[2],
            lowest: errors[3],
            highest: errors[4],
            bound: errors[5],
        },
    })?)
}

/// Arrays of an archive, by name.
struct Found(BTreeMap<String, Array>);

impl Found {
    fn get(&self, name: &'static str) -> Result<&Array, TableFileError> {
        self.0.get(name).ok_or(TableFileError::Array(name))
    }

    /// Returns the numbers of the array `name`. Returns an error if it is missing or does not have
    /// `size` elements.
    fn of(&self, name: &'static str, size: usize) -> Result<&[f64], TableFileError> {
        let numbers = &self.get(name)?.numbers[..];
        if numbers.len() == size { Ok(numbers) } else { Err(TableFileError::Array(name)) }
    }

    fn fact(&self, name: &'static str) -> Result<f64, TableFileError> {
        Ok(self.of(name, 1)?[0])
    }

    fn matrix(&self, name: &'static str) -> Result<Matrix3, TableFileError> {
        Ok(Matrix3::from_row_slice(self.of(name, 9)?))
    }
}

/// Writes a slew-time table as Parquet. Each node is a row with the rotation vector, the value, its
/// gradient, the lower bound and, if it is known, the duration of the turn about the fixed axis. The
/// other data of the table are metadata of the file.
///
/// # Errors
/// Returns the errors of the output stream. Always returns an error in a build without the feature
/// `parquet`.
pub fn write_parquet(table: &SlewTable, checksum: u64, output: &mut dyn Write) -> Result<(), ExportError> {
    #[cfg(feature = "parquet")]
    {
        use crate::exchange::parquet::{Cells, Kind, ParquetTable};
        let nodes = table.nodes();
        let value = if nodes.quantity == Quantity::Time { "time_s" } else { "effort" };
        let names = ["rotation_x_rad", "rotation_y_rad", "rotation_z_rad", value, "lower_bound"]
            .into_iter()
            .chain(["gradient_x", "gradient_y", "gradient_z"])
            .chain((!nodes.fixed_axis.is_empty()).then_some("fixed_axis_s"));
        let columns: Vec<_> = names.map(|name| (name.to_string(), Kind::Number)).collect();
        let notes = [
            ("spec_checksum", format!("{checksum:016x}")),
            ("settling_s", nodes.settling_s.to_string()),
            ("duration_s", nodes.duration_s.to_string()),
            ("errors_99_percent", nodes.errors.most.to_string()),
            ("errors_lowest", nodes.errors.lowest.to_string()),
            ("errors_highest", nodes.errors.highest.to_string()),
            ("errors_turns", nodes.errors.count.to_string()),
        ];
        let mut file = ParquetTable::new(output, &columns, &notes)?;
        let vectors: Vec<Vector3> = table.vectors().collect();
        let numbers = |of: &dyn Fn(usize) -> f64| {
            Cells::Numbers((0..nodes.values.len()).map(|row| Some(of(row))).collect())
        };
        let mut rows = vec![
            numbers(&|row| vectors[row].x),
            numbers(&|row| vectors[row].y),
            numbers(&|row| vectors[row].z),
            numbers(&|row| nodes.values[row]),
            numbers(&|row| nodes.bounds[row]),
            numbers(&|row| nodes.gradients[row].x),
            numbers(&|row| nodes.gradients[row].y),
            numbers(&|row| nodes.gradients[row].z),
        ];
        if !nodes.fixed_axis.is_empty() {
            rows.push(numbers(&|row| nodes.fixed_axis[row]));
        }
        file.rows(&rows)?;
        Ok(file.close()?)
    }
    #[cfg(not(feature = "parquet"))]
    {
        let _ = (table, checksum, output);
        Err(crate::exchange::Lacking::Parquet.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slewkit::sequence::TableOptions;
    use slewkit::{Body, Inertia, Problem, Settings, State, lie};

    fn table() -> SlewTable {
        let body = Body { inertia: Inertia::diagonal(Vector3::new(2.0, 1.6, 1.1)).unwrap(), mass: None };
        let still = State::at_rest(Matrix3::identity());
        let problem = Problem::attitude(body, still, still, 10.0);
        let angles_deg = vec![60.0, 180.0];
        let options = TableOptions {
            divisions: Some(2),
            angles_deg,
            checks: 5,
            settling_s: 7.0,
            ..TableOptions::default()
        };
        SlewTable::make(&problem, &Settings::default(), &options, &mut |_| true).unwrap()
    }

    fn written(table: &SlewTable) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_npz(table, 0x0123_4567_89ab_cdef, &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn a_table_survives_its_file() {
        let table = table();
        let read = read_npz(&written(&table)[..]).unwrap();
        assert_eq!(read.nodes(), table.nodes());
        let turn = lie::exp(&Vector3::new(0.4, -0.8, 1.2));
        assert_eq!(read.value(&turn).to_bits(), table.value(&turn).to_bits());
        assert_eq!(read.bound(&turn).to_bits(), table.bound(&turn).to_bits());
        assert_eq!(read.nodes().settling_s, 7.0);
    }

    #[test]
    fn other_archives_are_refused() {
        let mut bytes: Vec<u8> = Vec::new();
        let mut arrays = Arrays::new(&mut bytes);
        arrays.add("version", 1, 1, &[2.0]).unwrap();
        arrays.close().unwrap();
        assert!(matches!(read_npz(&bytes[..]), Err(TableFileError::Version(_))));
        assert!(matches!(read_npz(&b"PK"[..]), Err(TableFileError::Archive(_))));
        let whole = written(&table());
        assert!(read_npz(&whole[..whole.len() / 2]).is_err());
    }
}
