//! A writer of MCAP: chunked and indexed, with checksums, not compressed.
//!
//! The crate `mcap` without its compressors brings 15 crates and 15 s of compilation, for thirteen kinds of records of which none is read here.
//!
//! # Source
//! The MCAP format specification, version 0; the checksum is that of ISO 3309 (CRC-32).

use std::collections::BTreeMap;

use super::AUTHOR;

/// The first and last bytes of a file.
const MAGIC: &[u8] = b"\x89MCAP0\r\n";
/// A chunk that has reached this size is closed (bytes).
const CHUNK: usize = 1 << 20;

/// The kinds of records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Header = 0x01,
    Footer = 0x02,
    Schema = 0x03,
    Channel = 0x04,
    Message = 0x05,
    Chunk = 0x06,
    MessageIndex = 0x07,
    ChunkIndex = 0x08,
    Statistics = 0x0b,
    Metadata = 0x0c,
    MetadataIndex = 0x0d,
    SummaryOffset = 0x0e,
    DataEnd = 0x0f,
}

/// A channel that is to be opened, with its schema.
#[derive(Debug, Clone, Copy)]
pub(super) struct Channel<'a> {
    pub topic: &'a str,
    pub schema: &'a str,
    pub schema_encoding: &'a str,
    pub schema_data: &'a [u8],
    pub message_encoding: &'a str,
    pub metadata: &'a [(&'a str, &'a str)],
}

/// The number of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ChannelId(u16);

/// A recording in memory.
#[derive(Debug)]
pub(super) struct Recording {
    file: Bytes,
    chunk: Chunk,
    /// Records that the summary repeats or that belong to it, by kind.
    schemas: Bytes,
    channels: Bytes,
    chunks: Bytes,
    metadata: Bytes,
    /// The number of records of metadata, and of chunks.
    counts: [u32; 2],
    /// The number of messages of each channel.
    messages: BTreeMap<ChannelId, u64>,
    /// The earliest and the latest time (ns).
    span: Option<(u64, u64)>,
}

/// The chunk that is being filled.
#[derive(Debug, Default)]
struct Chunk {
    records: Bytes,
    /// Times and offsets of the messages of each channel.
    index: BTreeMap<ChannelId, Vec<(u64, u64)>>,
    span: Option<(u64, u64)>,
}

impl Recording {
    /// An empty recording.
    pub fn new() -> Self {
        let mut file = Bytes(MAGIC.to_vec());
        file.record(Kind::Header, |content| {
            content.text("");
            content.text(AUTHOR);
        });
        Self {
            file,
            chunk: Chunk::default(),
            schemas: Bytes::default(),
            channels: Bytes::default(),
            chunks: Bytes::default(),
            metadata: Bytes::default(),
            counts: [0; 2],
            messages: BTreeMap::new(),
            span: None,
        }
    }

    /// Writes a metadata record. It precedes the chunk that is being filled.
    pub fn metadata(&mut self, name: &str, entries: &[(&str, &str)]) {
        let start = self.file.len();
        self.file.record(Kind::Metadata, |content| {
            content.text(name);
            content.texts(entries);
        });
        let length = self.file.len() - start;
        self.metadata.record(Kind::MetadataIndex, |content| {
            content.u64(start);
            content.u64(length);
            content.text(name);
        });
        self.counts[0] += 1;
    }

    /// Opens a channel, with a schema of its own.
    pub fn channel(&mut self, channel: &Channel) -> ChannelId {
        // A format has a few channels.
        let id = ChannelId(self.messages.len() as u16 + 1);
        self.messages.insert(id, 0);
        for list in [&mut self.schemas, &mut self.chunk.records] {
            list.record(Kind::Schema, |content| {
                content.u16(id.0);
                content.text(channel.schema);
                content.text(channel.schema_encoding);
                content.sized(|data| data.0.extend_from_slice(channel.schema_data));
            });
        }
        for list in [&mut self.channels, &mut self.chunk.records] {
            list.record(Kind::Channel, |content| {
                content.u16(id.0);
                content.u16(id.0);
                content.text(channel.topic);
                content.text(channel.message_encoding);
                content.texts(channel.metadata);
            });
        }
        id
    }

    /// Writes a message of a time (ns).
    pub fn message(&mut self, channel: ChannelId, time: u64, data: &[u8]) {
        let sequence = self.messages.entry(channel).or_default();
        let offset = self.chunk.records.len();
        self.chunk.records.record(Kind::Message, |content| {
            content.u16(channel.0);
            content.u32(*sequence as u32);
            content.u64(time);
            content.u64(time);
            content.0.extend_from_slice(data);
        });
        *sequence += 1;
        self.chunk.index.entry(channel).or_default().push((time, offset));
        for span in [&mut self.span, &mut self.chunk.span] {
            *span = Some(span.map_or((time, time), |(first, last)| (first.min(time), last.max(time))));
        }
        if self.chunk.records.0.len() >= CHUNK {
            self.close_chunk();
        }
    }

    fn close_chunk(&mut self) {
        let Chunk { records, index, span } = std::mem::take(&mut self.chunk);
        if records.0.is_empty() {
            return;
        }
        let (first, last) = span.unwrap_or_default();
        let start = self.file.len();
        self.file.record(Kind::Chunk, |content| {
            content.u64(first);
            content.u64(last);
            content.u64(records.len());
            content.u32(crc32(&records.0));
            content.text("");
            content.u64(records.len());
            content.0.extend_from_slice(&records.0);
        });
        let end = self.file.len();
        let mut offsets = Vec::new();
        for (channel, messages) in &index {
            offsets.push((channel.0, self.file.len()));
            self.file.record(Kind::MessageIndex, |content| {
                content.u16(channel.0);
                content.sized(|list| {
                    for (time, offset) in messages {
                        list.u64(*time);
                        list.u64(*offset);
                    }
                });
            });
        }
        let index_length = self.file.len() - end;
        self.chunks.record(Kind::ChunkIndex, |content| {
            content.u64(first);
            content.u64(last);
            content.u64(start);
            content.u64(end - start);
            content.counts(offsets.iter().copied());
            content.u64(index_length);
            content.text("");
            content.u64(records.len());
            content.u64(records.len());
        });
        self.counts[1] += 1;
    }

    /// The file.
    pub fn finish(mut self) -> Vec<u8> {
        self.close_chunk();
        let checksum = crc32(&self.file.0);
        self.file.record(Kind::DataEnd, |content| content.u32(checksum));
        let statistics = self.statistics();
        let summary = self.file.len();
        let mut groups = Vec::new();
        for (kind, records) in [
            (Kind::Schema, &self.schemas),
            (Kind::Channel, &self.channels),
            (Kind::Statistics, &statistics),
            (Kind::ChunkIndex, &self.chunks),
            (Kind::MetadataIndex, &self.metadata),
        ] {
            if !records.0.is_empty() {
                groups.push((kind, self.file.len(), records.len()));
                self.file.0.extend_from_slice(&records.0);
            }
        }
        let offsets = self.file.len();
        for (kind, start, length) in groups {
            self.file.record(Kind::SummaryOffset, |content| {
                content.0.push(kind as u8);
                content.u64(start);
                content.u64(length);
            });
        }
        self.file.record(Kind::Footer, |content| {
            content.u64(summary);
            content.u64(offsets);
            content.u32(0);
        });
        // The checksum covers the summary and the footer up to the checksum itself.
        let end = self.file.0.len() - 4;
        let checksum = crc32(&self.file.0[summary as usize..end]);
        self.file.0[end..].copy_from_slice(&checksum.to_le_bytes());
        self.file.0.extend_from_slice(MAGIC);
        self.file.0
    }

    fn statistics(&self) -> Bytes {
        let mut records = Bytes::default();
        let (first, last) = self.span.unwrap_or_default();
        records.record(Kind::Statistics, |content| {
            content.u64(self.messages.values().sum());
            content.u16(self.messages.len() as u16);
            content.u32(self.messages.len() as u32);
            content.u32(0);
            self.counts.iter().for_each(|count| content.u32(*count));
            content.u64(first);
            content.u64(last);
            content.counts(self.messages.iter().map(|(channel, count)| (channel.0, *count)));
        });
        records
    }
}

/// Values in little-endian order, one after the other.
#[derive(Debug, Default)]
struct Bytes(Vec<u8>);

impl Bytes {
    fn len(&self) -> u64 {
        self.0.len() as u64
    }

    fn u16(&mut self, value: u16) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn u32(&mut self, value: u32) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn u64(&mut self, value: u64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.sized(|content| content.0.extend_from_slice(text.as_bytes()));
    }

    fn texts(&mut self, entries: &[(&str, &str)]) {
        self.sized(|content| {
            for (key, value) in entries {
                content.text(key);
                content.text(value);
            }
        });
    }

    fn counts(&mut self, entries: impl Iterator<Item = (u16, u64)>) {
        self.sized(|content| {
            for (key, value) in entries {
                content.u16(key);
                content.u64(value);
            }
        });
    }

    /// Content after its length of four bytes.
    fn sized(&mut self, content: impl FnOnce(&mut Self)) {
        let place = self.0.len();
        self.u32(0);
        content(self);
        let length = (self.0.len() - place - 4) as u32;
        self.0[place..place + 4].copy_from_slice(&length.to_le_bytes());
    }

    fn record(&mut self, kind: Kind, content: impl FnOnce(&mut Self)) {
        self.0.push(kind as u8);
        let place = self.0.len();
        self.u64(0);
        content(self);
        let length = (self.0.len() - place - 8) as u64;
        self.0[place..place + 8].copy_from_slice(&length.to_le_bytes());
    }
}

fn crc32(bytes: &[u8]) -> u32 {
    const TABLE: [u32; 256] = table();
    !bytes.iter().fold(u32::MAX, |crc, byte| (crc >> 8) ^ TABLE[((crc ^ u32::from(*byte)) & 0xff) as usize])
}

const fn table() -> [u32; 256] {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut value = byte as u32;
        let mut bit = 0;
        while bit < 8 {
            value = if value & 1 == 1 { (value >> 1) ^ 0xedb8_8320 } else { value >> 1 };
            bit += 1;
        }
        table[byte] = value;
        byte += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_that_of_the_standard() {
        // The check value of CRC-32 in the catalogue of CRC algorithms.
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
        assert_eq!(crc32(b""), 0);
    }

    #[test]
    fn a_long_recording_has_several_chunks_and_every_record_ends_where_the_next_starts() {
        let mut recording = Recording::new();
        recording.metadata("name", &[("key", "value")]);
        let channel = recording.channel(&Channel {
            topic: "/t",
            schema: "s",
            schema_encoding: "jsonschema",
            schema_data: b"{}",
            message_encoding: "json",
            metadata: &[],
        });
        let message = vec![b'1'; CHUNK / 2];
        (0..5).for_each(|number| recording.message(channel, number, &message));
        let file = recording.finish();
        let body = file.strip_prefix(MAGIC).and_then(|rest| rest.strip_suffix(MAGIC)).unwrap();
        let (mut kinds, mut place) = (Vec::new(), 0);
        while place < body.len() {
            kinds.push(body[place]);
            let length = u64::from_le_bytes(body[place + 1..place + 9].try_into().unwrap());
            place += 9 + length as usize;
        }
        assert_eq!(place, body.len());
        let expected = [1, 0x0c, 6, 7, 6, 7, 6, 7, 0x0f, 3, 4, 0x0b, 8, 8, 8, 0x0d, 0x0e, 0x0e, 0x0e, 0x0e, 0x0e, 2];
        assert_eq!(kinds, expected);
    }
}
