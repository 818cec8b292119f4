use std::io;

/// Why an episode cannot be exported. Nothing is written then.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    #[error("{format} cannot represent {what}")]
    NotRepresentable { format: &'static str, what: String },
    #[error("cannot make {format}: {source}")]
    Encoding { format: &'static str, source: io::Error },
}
