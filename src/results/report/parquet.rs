//! Parquet files whose text columns are plain strings.
//!
//! polars stores its own Arrow schema in the file, in which text has the type `string_view`. Readers of Arrow then take that type, for
//! which pyarrow has no filters. Without that schema they take the type that Parquet states: a string.

use std::io::Write;
use std::sync::PoisonError;

use polars::prelude::{DataFrame, PolarsResult, Schema};
use polars_io::parquet::write::{BatchedWriter, ParquetWriter};

/// A Parquet file that is written part by part.
pub struct ParquetFile<W: Write>(BatchedWriter<W>);

impl<W: Write> ParquetFile<W> {
    /// Starts a file for rows with these columns.
    ///
    /// # Errors
    /// Those of polars and of the writer.
    pub fn new(writer: W, schema: &Schema) -> PolarsResult<Self> {
        Ok(Self(ParquetWriter::new(writer).batched(schema)?))
    }

    /// Adds rows as a row group. The chunks of their columns must be aligned.
    ///
    /// # Errors
    /// Those of polars and of the writer.
    pub fn add(&mut self, rows: &DataFrame) -> PolarsResult<()> {
        self.0.write_batch(rows)
    }

    /// Writes the end of the file, without the Arrow schema of polars.
    ///
    /// # Errors
    /// Those of polars and of the writer.
    pub fn finish(&mut self) -> PolarsResult<()> {
        let mut file = self.0.get_writer().lock().unwrap_or_else(PoisonError::into_inner);
        file.end(Some(Vec::new())).map(|_| ())
    }
}

/// Writes a whole table.
///
/// # Errors
/// Those of polars and of the writer.
pub fn write_parquet<W: Write>(writer: W, table: &DataFrame) -> PolarsResult<()> {
    let mut rows = table.clone();
    rows.rechunk_mut();
    let mut file = ParquetFile::new(writer, rows.schema())?;
    file.add(&rows)?;
    file.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use polars::prelude::{DataType, NamedFrom, Series};
    use polars_io::SerReader;
    use polars_io::parquet::read::ParquetReader;
    use std::io::Cursor;

    #[test]
    fn text_is_a_plain_string_and_all_values_are_read_back() {
        let table = DataFrame::new(
            2,
            vec![
                Series::new("town".into(), ["harbour", "village"]).into(),
                Series::new("run".into(), [0_u32, 7]).into(),
                Series::new("n".into(), [1_u64 << 60, 0]).into(),
                Series::new("rate".into(), [Some(0.5), None]).into(),
                Series::new("front".into(), [Some(true), None]).into(),
            ],
        )
        .unwrap();
        let mut bytes = Vec::new();
        write_parquet(&mut bytes, &table).unwrap();
        // The key of the Arrow schema is stored as it is, in the uncompressed end of the file.
        assert!(!bytes.windows(12).any(|part| part == b"ARROW:schema"), "readers would take the view type from it");
        let mut with_schema = Vec::new();
        ParquetWriter::new(&mut with_schema).finish(&mut table.clone()).unwrap();
        assert!(with_schema.windows(12).any(|part| part == b"ARROW:schema"), "polars stores it otherwise");
        let read = ParquetReader::new(Cursor::new(bytes)).finish().unwrap();
        assert!(read.equals_missing(&table), "{read}");
        assert_eq!(
            read.dtypes(),
            [DataType::String, DataType::UInt32, DataType::UInt64, DataType::Float64, DataType::Boolean]
        );
    }
}
