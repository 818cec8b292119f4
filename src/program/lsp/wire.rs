//! Messages on a stream: headers, an empty line, a body.

use std::io::{BufRead, Read};

use lsp_server::Message;
use serde_json::Value;

/// The longest body that is read (bytes).
const MAX_BODY: usize = 64 << 20;

/// Why a message could not be read.
#[derive(Debug, thiserror::Error)]
pub enum WireError {
    #[error("the stream failed: {0}")]
    Stream(#[from] std::io::Error),
    /// The headers name no length, or one out of range; the start of the next message is then unknown.
    #[error("the headers name no usable length")]
    Headers,
    /// The body is not a message; the next one can be read.
    #[error("the message cannot be understood: {0}")]
    Body(String),
}

/// Reads the next message; `None` if the stream has ended.
///
/// # Errors
/// See [`WireError`]; after [`WireError::Body`] reading can continue.
pub fn read(stream: &mut impl BufRead) -> Result<Option<Message>, WireError> {
    let mut length = None;
    let mut first = true;
    loop {
        let mut line = Vec::new();
        // Headers are short: a stream of bytes without line ends must not fill the memory.
        if stream.by_ref().take(4096).read_until(b'\n', &mut line)? == 0 {
            return if first { Ok(None) } else { Err(WireError::Headers) };
        }
        first = false;
        let line = String::from_utf8_lossy(&line);
        let line = line.trim_end();
        if line.is_empty() {
            break;
        }
        let (name, value) = line.split_once(':').ok_or(WireError::Headers)?;
        if name.eq_ignore_ascii_case("content-length") {
            length = value.trim().parse::<usize>().ok();
        }
    }
    let length = length.filter(|length| *length <= MAX_BODY).ok_or(WireError::Headers)?;
    let mut body = vec![0; length];
    stream.read_exact(&mut body)?;
    let understood = serde_json::from_slice(&body).and_then(|mut message| {
        encode_addresses(&mut message);
        serde_json::from_value(message)
    });
    understood.map(Some).map_err(|error| WireError::Body(error.to_string()))
}

/// Percent-encodes what an address must not hold: some editors send `file:///home/me/ü/c.scn`, `[1]/c.scn` or `100%/c.scn`.
fn encode_addresses(message: &mut Value) {
    match message {
        Value::Object(members) => {
            for (name, member) in members {
                match member {
                    Value::String(address) if name.to_ascii_lowercase().ends_with("uri") => {
                        let bytes = address.as_bytes();
                        let plain = |(at, byte): (usize, u8)| match byte {
                            b'%' => {
                                bytes.get(at + 1..at + 3).is_some_and(|code| code.iter().all(u8::is_ascii_hexdigit))
                            }
                            _ => byte.is_ascii_graphic() && !b"\"<>\\^`{|}[]".contains(&byte),
                        };
                        let encode = |(at, byte)| {
                            if plain((at, byte)) { char::from(byte).to_string() } else { format!("%{byte:02X}") }
                        };
                        *address = bytes.iter().copied().enumerate().map(encode).collect();
                    }
                    other => encode_addresses(other),
                }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(encode_addresses),
        _ => {}
    }
}
