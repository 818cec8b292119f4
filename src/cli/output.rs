use clap::ValueEnum;

/// Who reads the output of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Output {
    /// Tables for people.
    Human,
    /// One JSON object a line, for programs.
    Json,
}
