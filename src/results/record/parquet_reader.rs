use std::io::{BufReader, Read, Seek, SeekFrom};
use std::ops::Range;

use polars::prelude::{DataFrame, PolarsError, PolarsResult};
use polars_io::SerReader;
use polars_io::mmap::MmapBytesReader;
use polars_io::parquet::read::{FileMetadata, ParquetReader};
use polars_parquet_format::thrift::protocol::TCompactInputProtocol;
use polars_parquet_format::{PageHeader, PageType, thrift};

use base::contained::contained;

/// The least number of bytes of a row, compressed. Rows of reports have 20 bytes and more.
const ROW_BYTES: u64 = 8;
/// How many times larger than the file its columns may be.
const MAX_GROWTH: u64 = 256;
/// Files below this size (bytes) may have as many rows, and columns as large, as one of this size.
const SMALL: u64 = 1 << 16;

/// Reads a table without nested columns from Parquet of a length (bytes): some of its columns and some of its rows (the first and a count), or all.
/// A file that says it holds much more than fits into it is refused, since a lack of memory would end the process. A panic of the reader is an error.
///
/// # Errors
/// The file is not Parquet, it is damaged, or it would take too much memory.
pub fn read_parquet<R: MmapBytesReader>(
    mut source: R,
    length: u64,
    columns: Option<&[&str]>,
    rows: Option<(usize, usize)>,
) -> PolarsResult<DataFrame> {
    let read = contained(|| {
        let metadata = ParquetReader::new(&mut source).get_metadata()?.clone();
        let (count, size) = said_size(&metadata, &mut source).map_err(|error| damaged(&error))?;
        let length = length.max(SMALL);
        if count > length / ROW_BYTES || size > length.saturating_mul(MAX_GROWTH) {
            let reason =
                format!("it says that it has {count} rows in {size} bytes, more than fit into its {length} bytes");
            return Err(PolarsError::ComputeError(reason.into()));
        }
        let columns = columns.map(|names| names.iter().map(ToString::to_string).collect());
        ParquetReader::new(source).with_columns(columns).with_slice(rows).finish()
    });
    read.unwrap_or_else(|reason| Err(damaged(&reason)))
}

/// The most rows that any part of a file says it has, and the bytes that it says they take in memory. A number below 0 is a very large one.
fn said_size(metadata: &FileMetadata, source: &mut (impl Read + Seek)) -> thrift::Result<(u64, u64)> {
    let mut source = BufReader::new(source);
    let (mut count, mut size) = (metadata.num_rows as u64, 0_u64);
    for group in &metadata.row_groups {
        count = count.max(group.num_rows() as u64);
        let mut of_pages = 0_u64;
        for column in group.parquet_columns() {
            let (most, bytes) = said_pages(&mut source, column.byte_range(), column.num_values() as u64)?;
            count = count.max(most);
            of_pages = of_pages.saturating_add(bytes);
        }
        size = size.saturating_add(of_pages.max(group.total_byte_size() as u64));
    }
    Ok((count, size))
}

/// The same of a column with this number of values, whose pages are in a range of bytes.
fn said_pages(source: &mut (impl Read + Seek), range: Range<u64>, values: u64) -> thrift::Result<(u64, u64)> {
    let (mut most, mut size, mut seen, mut place) = (values, 0_u64, 0_u64, range.start);
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

fn damaged(reason: &dyn ToString) -> PolarsError {
    PolarsError::ComputeError(format!("it is damaged ({})", reason.to_string()).into())
}
