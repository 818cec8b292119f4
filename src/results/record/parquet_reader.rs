use std::io::{BufReader, Read, Seek, SeekFrom};
use std::ops::Range;

use polars::prelude::{DataFrame, PolarsError, PolarsResult};
use polars_io::SerReader;
use polars_io::mmap::MmapBytesReader;
use polars_io::parquet::read::{FileMetadata, ParquetReader};
use polars_parquet_format::thrift::protocol::TCompactInputProtocol;
use polars_parquet_format::{PageHeader, PageType, thrift};

use base::contained::contained;

/// Reads a table without nested columns from Parquet: some of its columns and some of its rows (the first and a count), or all. `most` is the number of rows
/// that it may have. A file that contradicts itself, has more rows, or needs more memory than the machine has is refused, since a lack of memory would end the
/// process. How well its values are compressed says nothing. A panic of the reader is an error.
///
/// # Errors
/// The file is not Parquet, it is damaged, or it has too many rows or takes too much memory.
pub fn read_parquet<R: MmapBytesReader>(
    mut source: R,
    most: u64,
    columns: Option<&[&str]>,
    rows: Option<(usize, usize)>,
) -> PolarsResult<DataFrame> {
    let read = contained(|| {
        let metadata = ParquetReader::new(&mut source).get_metadata()?.clone();
        let size = said_size(&metadata, &mut source).map_err(|error| damaged(&error))?;
        let size = size.ok_or_else(|| damaged(&"its parts say other sizes than its end"))?;
        let (count, memory) = (metadata.num_rows as u64, memory());
        let reason = match () {
            () if count > most => format!("it has {count} rows, and {most} belong to it"),
            () if size > memory => format!("it takes {size} bytes of memory, and {memory} are free"),
            () => String::new(),
        };
        if !reason.is_empty() {
            return Err(PolarsError::ComputeError(reason.into()));
        }
        let columns = columns.map(|names| names.iter().map(ToString::to_string).collect());
        ParquetReader::new(source).with_columns(columns).with_slice(rows).finish()
    });
    read.unwrap_or_else(|reason| Err(damaged(&reason)))
}

/// The number of rows that the end of a file says it has; `None` if it cannot be read.
pub fn said_rows<R: MmapBytesReader>(mut source: R) -> Option<u64> {
    contained(|| ParquetReader::new(&mut source).get_metadata().ok().map(|metadata| metadata.num_rows as u64)).ok()?
}

/// Bytes of a value in memory, without those of long texts.
const VALUE_BYTES: u64 = 16;

/// The bytes that a table takes in memory, at most; `None` if a part says that it is larger than the whole. A number below 0 is a very large one.
fn said_size(metadata: &FileMetadata, source: &mut (impl Read + Seek)) -> thrift::Result<Option<u64>> {
    let mut source = BufReader::new(source);
    let (mut rows, mut size) = (0_u64, 0_u64);
    for group in &metadata.row_groups {
        rows = rows.saturating_add(group.num_rows() as u64);
        for column in group.parquet_columns() {
            let values = column.num_values() as u64;
            let (most, bytes) = said_pages(&mut source, column.byte_range(), values)?;
            let whole = column.uncompressed_size() as u64;
            if most > values || values > group.num_rows() as u64 || bytes > whole {
                return Ok(None);
            }
            size = size.saturating_add(whole).saturating_add(values.saturating_mul(VALUE_BYTES));
        }
    }
    Ok((rows <= metadata.num_rows as u64).then_some(size))
}

/// The most values that a page of a column says it has, and the bytes of all its pages. The column has this number of values; its pages are in a range of bytes.
fn said_pages(source: &mut (impl Read + Seek), range: Range<u64>, values: u64) -> thrift::Result<(u64, u64)> {
    let (mut most, mut size, mut seen, mut place) = (0_u64, 0_u64, 0_u64, range.start);
    while seen < values {
        source.seek(SeekFrom::Start(place))?;
        let left = range.end.saturating_sub(place);
        let mut protocol = TCompactInputProtocol::new(source.by_ref().take(left), left as usize);
        let header = PageHeader::read_from_in_protocol(&mut protocol)?;
        place = source.stream_position()?.saturating_add(header.compressed_page_size as u64);
        let first = header.data_page_header.map_or(0, |page| page.num_values as u64);
        let second = header.data_page_header_v2.map_or(0, |page| page.num_values as u64);
        let dictionary = header.dictionary_page_header.map_or(0, |page| page.num_values as u64);
        most = most.max(first).max(second).max(dictionary);
        let counted = match header.type_ {
            PageType::DATA_PAGE => first,
            PageType::DATA_PAGE_V2 => second,
            _ => 0,
        };
        seen = seen.saturating_add(counted);
        size = size.saturating_add(header.uncompressed_page_size as u64);
    }
    Ok((most, size))
}

/// The memory that is free on this machine (bytes), where the system tells it.
fn memory() -> u64 {
    let told = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let line = told.lines().find_map(|line| line.strip_prefix("MemAvailable:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    kilobytes.map_or(isize::MAX as u64, |kilobytes| kilobytes.saturating_mul(1024))
}

fn damaged(reason: &dyn ToString) -> PolarsError {
    PolarsError::ComputeError(format!("it is damaged ({})", reason.to_string()).into())
}
