use std::io;

/// Why an episode cannot be exported. Nothing is written then.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The format cannot hold a part of the episode.
    #[error("{format} cannot represent {what}")]
    NotRepresentable {
        /// The name of the format.
        format: &'static str,
        /// The part, with the reason.
        what: String,
    },
    /// The format needs a program that is missing or fails.
    #[error("`{program}`, which makes {format}, {problem}")]
    Program {
        /// The name of the format.
        format: &'static str,
        /// The program.
        program: &'static str,
        /// What it does not do.
        problem: String,
    },
    /// The bytes of the format cannot be made.
    #[error("cannot make {format}: {source}")]
    Encoding {
        /// The name of the format.
        format: &'static str,
        /// The cause.
        source: io::Error,
    },
}
