use polars::prelude::{DataFrame, PolarsError, PolarsResult};
use polars_io::SerReader;
use polars_io::mmap::MmapBytesReader;
use polars_io::parquet::read::ParquetReader;

use base::contained::contained;

/// The least number of bytes of a row, compressed. Rows of reports have 20 bytes and more.
const ROW_BYTES: u64 = 8;
/// How many times larger than the file its columns may be.
const MOST_GROWTH: u64 = 256;
/// Files below this size (bytes) may have as many rows, and columns as large, as one of this size.
const SMALL: u64 = 1 << 16;

/// Reads a table from Parquet of a length (bytes). A file that says it holds much more than fits into it is refused, and a panic of the reader is an
/// error.
///
/// # Errors
/// The file is not Parquet, it is damaged, or it would take too much memory.
pub fn read_parquet<R: MmapBytesReader>(mut reader: ParquetReader<R>, length: u64) -> PolarsResult<DataFrame> {
    let read = contained(|| {
        let length = length.max(SMALL);
        let metadata = reader.get_metadata()?;
        let rows = metadata.num_rows as u64;
        let size =
            metadata.row_groups.iter().fold(0_u64, |sum, group| sum.saturating_add(group.total_byte_size() as u64));
        if rows > length / ROW_BYTES || size > length.saturating_mul(MOST_GROWTH) {
            let reason =
                format!("it says that it has {rows} rows in {size} bytes, more than fit into its {length} bytes");
            return Err(PolarsError::ComputeError(reason.into()));
        }
        reader.finish()
    });
    read.unwrap_or_else(|reason| Err(PolarsError::ComputeError(format!("it is damaged ({reason})").into())))
}
