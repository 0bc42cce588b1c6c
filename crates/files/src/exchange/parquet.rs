//! Parquet tables with columns of numbers and texts, readable by pandas, Polars, DuckDB and Spark.
//!
//! The tables are not compressed, because the digits of plans hardly shrink and every codec would
//! add a dependency. Cells may be empty.

use super::Record;
use crate::export::{ExportError, wide_table};
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use std::io::{self, Write};
use std::sync::Arc;

/// Cells of one column; `None` for an empty cell.
pub(crate) enum Cells {
    Numbers(Vec<Option<f64>>),
    Integers(Vec<Option<i64>>),
    Flags(Vec<Option<bool>>),
    Texts(Vec<Option<String>>),
}

/// Type of the cells of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Number,
    Integer,
    Flag,
    Text,
}

impl Kind {
    fn column(self, head: &str) -> Result<Type, ParquetError> {
        let (physical, logical) = match self {
            Self::Number => (Physical::DOUBLE, None),
            Self::Integer => (Physical::INT64, None),
            Self::Flag => (Physical::BOOLEAN, None),
            Self::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        Type::primitive_type_builder(head, physical)
            .with_logical_type(logical)
            .with_repetition(Repetition::OPTIONAL)
            .build()
    }
}

/// A Parquet table that is being written, one group of rows at a time.
pub(crate) struct ParquetTable<'o> {
    output: &'o mut dyn Write,
    /// Parquet writer. Its buffer holds the bytes that have not been passed to the output yet.
    writer: SerializedFileWriter<Vec<u8>>,
}

impl<'o> ParquetTable<'o> {
    /// Begins a table with these columns; `notes` are key-value metadata of the file.
    pub fn new(
        output: &'o mut dyn Write,
        columns: &[(String, Kind)],
        notes: &[(&str, String)],
    ) -> io::Result<Self> {
        let notes = notes.iter().map(|(key, value)| KeyValue::new((*key).into(), value.clone()));
        let properties = WriterProperties::builder()
            .set_created_by(concat!("slewkit ", env!("CARGO_PKG_VERSION")).into())
            .set_key_value_metadata(Some(notes.collect()))
            .build();
        let fields = columns.iter().map(|(head, kind)| kind.column(head).map(Arc::new));
        let begun = fields.collect::<Result<Vec<_>, _>>().and_then(|fields| {
            let schema = Type::group_type_builder("slew").with_fields(fields).build()?;
            SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))
        });
        Ok(Self { output, writer: begun.map_err(io::Error::other)? })
    }

    /// Appends a group of rows. `columns` has the cells of all columns in the order of the header,
    /// with the types of the header. All columns must have equal length.
    pub fn rows(&mut self, columns: &[Cells]) -> io::Result<()> {
        let mut write = || {
            let mut group = self.writer.next_row_group()?;
            for cells in columns {
                match cells {
                    Cells::Numbers(cells) => column::<DoubleType>(&mut group, cells),
                    Cells::Integers(cells) => column::<Int64Type>(&mut group, cells),
                    Cells::Flags(cells) => column::<BoolType>(&mut group, cells),
                    Cells::Texts(cells) => {
                        let bytes = |text: &Option<String>| text.as_deref().map(ByteArray::from);
                        column::<ByteArrayType>(&mut group, &cells.iter().map(bytes).collect::<Vec<_>>())
                    }
                }?;
            }
            group.close()?;
            self.writer.flush().map_err(ParquetError::from)
        };
        write().map_err(io::Error::other)?;
        self.output.write_all(&std::mem::take(self.writer.inner_mut()))
    }

    /// Writes the end of the file.
    pub fn close(self) -> io::Result<()> {
        self.output.write_all(&self.writer.into_inner().map_err(io::Error::other)?)
    }
}

/// Writes the next column of a row group.
fn column<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
    cells: &[Option<T::T>],
) -> Result<(), ParquetError> {
    let mut column = group.next_column()?.ok_or_else(|| ParquetError::General("too many columns".into()))?;
    let there: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
    let values: Vec<T::T> = cells.iter().flatten().cloned().collect();
    column.typed::<T>().write_batch(&values, Some(&there), None)?;
    column.close()
}

/// Writes a trajectory as a Parquet table with the columns of the CSV table and one row for each
/// node.
pub(super) fn write_trajectory(record: &Record<'_>, output: &mut dyn Write) -> Result<(), ExportError> {
    let table = wide_table(record.trajectory, record.problem, &record.identity, record.tables.margins);
    let columns: Vec<_> = table.iter().map(|column| (column.head.clone(), Kind::Number)).collect();
    let mut notes = vec![("name", record.problem.name.clone()), ("notes", record.notes.join("\n"))];
    notes.extend(record.identity.epoch.map(|epoch| ("epoch", epoch.to_string())));
    let mut file = ParquetTable::new(output, &columns, &notes)?;
    let cells = table.iter().map(|column| Cells::Numbers((0..record.nodes()).map(&column.cell).collect()));
    file.rows(&cells.collect::<Vec<_>>())?;
    Ok(file.close()?)
}
