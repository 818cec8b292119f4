use clap::ValueEnum;

/// Form of the progress.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Showing {
    /// Bars on a terminal, lines elsewhere.
    Auto,
    /// Bars for what is under way, with rates and the time left.
    Bars,
    /// A line for each job that is finished.
    Lines,
    /// No progress.
    None,
}
