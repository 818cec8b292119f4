/// The exit codes of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExitCode {
    /// Success.
    Done = 0,
    /// A bug.
    Internal = 1,
    /// Wrong arguments, or a named file is missing.
    Usage = 2,
    /// A scenario has errors.
    Scenario = 3,
    /// No campaign was found.
    Nothing = 4,
    /// A training or an external driver failed.
    RunFailed = 5,
    /// A report cannot be written.
    WriteFailed = 6,
    /// A condition of `--fail-if` is true.
    GateFailed = 7,
    /// A repetition differs from its report.
    Differs = 8,
    /// Tasks to merge are missing.
    Incomplete = 9,
    /// The user stopped it.
    Interrupted = 130,
}

impl From<ExitCode> for std::process::ExitCode {
    fn from(code: ExitCode) -> Self {
        Self::from(code as u8)
    }
}
