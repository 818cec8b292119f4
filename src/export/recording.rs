//! MCAP in memory: chunked and indexed, with checksums, not compressed.

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::{MessageHeader, Metadata};
use mcap::{WriteOptions, Writer};

use super::format::AUTHOR;

/// Records fail where a file cannot be written or numbers run out; a recording is in memory and has a few channels.
const IN_MEMORY: &str = "memory takes a record";

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

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct ChannelId(u16);

/// A recording in memory.
pub(super) struct Recording {
    writer: Writer<Cursor<Vec<u8>>>,
    messages: BTreeMap<ChannelId, u32>,
}

impl Recording {
    /// An empty recording.
    pub fn new() -> Self {
        let options = WriteOptions::new().compression(None).library(AUTHOR);
        Self { writer: options.create(Cursor::default()).expect(IN_MEMORY), messages: BTreeMap::new() }
    }

    /// Writes a metadata record.
    pub fn metadata(&mut self, name: &str, entries: &[(&str, &str)]) {
        self.writer.write_metadata(&Metadata { name: name.into(), metadata: owned(entries) }).expect(IN_MEMORY);
    }

    /// Opens a channel. Channels of equal schemas share one.
    pub fn channel(&mut self, channel: &Channel) -> ChannelId {
        let Channel { topic, schema, schema_encoding, schema_data, message_encoding, metadata } = *channel;
        let schema = self.writer.add_schema(schema, schema_encoding, schema_data).expect(IN_MEMORY);
        ChannelId(self.writer.add_channel(schema, topic, message_encoding, &owned(metadata)).expect(IN_MEMORY))
    }

    /// Writes a message of a time (ns).
    pub fn message(&mut self, channel: ChannelId, time: u64, data: &[u8]) {
        let sequence = self.messages.entry(channel).or_default();
        let header = MessageHeader { channel_id: channel.0, sequence: *sequence, log_time: time, publish_time: time };
        self.writer.write_to_known_channel(&header, data).expect(IN_MEMORY);
        *sequence += 1;
    }

    /// The file.
    pub fn finish(mut self) -> Vec<u8> {
        self.writer.finish().expect(IN_MEMORY);
        self.writer.into_inner().into_inner()
    }
}

fn owned(entries: &[(&str, &str)]) -> BTreeMap<String, String> {
    entries.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_recording_has_several_chunks_and_the_same_bytes_at_any_time() {
        let make = || {
            let mut recording = Recording::new();
            recording.metadata("name", &[("key", "value"), ("another", "value")]);
            let channels = ["/a", "/b", "/c"].map(|topic| {
                let (schema, schema_encoding, schema_data) = (topic, "jsonschema", b"{}".as_slice());
                let channel =
                    Channel { topic, schema, schema_encoding, schema_data, message_encoding: "json", metadata: &[] };
                recording.channel(&channel)
            });
            for (number, channel) in (0..6).zip(channels.into_iter().cycle()) {
                recording.message(channel, number, &vec![b'1'; 1 << 19]);
            }
            recording.finish()
        };
        let file = make();
        assert!(file == make());
        let summary = mcap::Summary::read(&file).unwrap().unwrap();
        assert!(summary.chunk_indexes.len() > 1, "{:?}", summary.chunk_indexes);
        assert_eq!(mcap::MessageStream::new(&file).unwrap().filter_map(Result::ok).count(), 6);
    }
}
