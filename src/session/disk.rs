use std::cell::RefCell;
use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

use crate::lang::Reader;
use crate::report::FileRecord;

/// The longest file that is read (bytes): the data of a device may have no end.
const MOST_BYTES: u64 = 512 << 20;

/// Reads files of the disk, up to 512 MiB each.
#[derive(Debug, Clone, Copy, Default)]
pub struct Disk;

impl Reader for Disk {
    fn text(&self, path: &Path) -> Result<String> {
        String::from_utf8(self.bytes(path)?).map_err(|error| Error::new(ErrorKind::InvalidData, error))
    }

    fn bytes(&self, path: &Path) -> Result<Vec<u8>> {
        let file = File::open(path)?;
        // Room for the whole file, and for one byte more to see that it has ended.
        let size = file.metadata().map_or(0, |known| known.len().min(MOST_BYTES) + 1);
        let mut bytes = Vec::with_capacity(size as usize);
        file.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(Error::other(format!("it has more than {} MiB", MOST_BYTES >> 20)));
        }
        Ok(bytes)
    }
}

/// Reads through another reader and keeps a record of each file.
pub(super) struct Recording<'a> {
    reader: &'a dyn Reader,
    /// Whether records have digests.
    digests: bool,
    records: RefCell<Vec<FileRecord>>,
}

impl<'a> Recording<'a> {
    /// Reads through this reader.
    pub fn new(reader: &'a dyn Reader, digests: bool) -> Self {
        Self { reader, digests, records: RefCell::default() }
    }

    /// Makes a record of a file.
    pub fn record(&self, path: &Path, contents: &[u8]) -> FileRecord {
        let path = path.display().to_string();
        if self.digests { FileRecord::new(path, contents) } else { FileRecord { path, blake3: String::new() } }
    }

    /// The records of the files, in the order in which they were read.
    pub fn into_records(self) -> Vec<FileRecord> {
        self.records.into_inner()
    }

    fn note(&self, path: &Path, contents: &[u8]) {
        let record = self.record(path, contents);
        self.records.borrow_mut().push(record);
    }
}

impl Reader for Recording<'_> {
    fn text(&self, path: &Path) -> Result<String> {
        self.reader.text(path).inspect(|text| self.note(path, text.as_bytes()))
    }

    fn bytes(&self, path: &Path) -> Result<Vec<u8>> {
        self.reader.bytes(path).inspect(|bytes| self.note(path, bytes))
    }
}
