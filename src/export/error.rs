use std::io;

/// Why an episode cannot be exported. Nothing is written then.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The format cannot hold a part of the episode.
    #[error("{format} cannot represent {what}")]
    NotRepresentable {
        format: &'static str,
        /// The part, with the reason.
        what: String,
    },
    /// The bytes of the format cannot be made.
    #[error("cannot make {format}: {source}")]
    Encoding { format: &'static str, source: io::Error },
}
