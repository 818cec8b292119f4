use clap::ValueEnum;

/// The reader of a command's output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Output {
    /// Tables for people.
    Human,
    /// One JSON object a line, for programs.
    Json,
}
