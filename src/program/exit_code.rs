/// How a command ends. The error is an exit code, too; its reason has been printed.
pub type Ended = Result<ExitCode, ExitCode>;

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
    /// A condition of `--fail-if` is true, or needs an interval over more runs.
    GateFailed = 7,
    /// A repetition differs from its report, or a file of the report was changed.
    Differs = 8,
    /// Tasks to merge are missing, or those of a campaign that no process works on.
    Incomplete = 9,
    /// The user stopped it.
    Interrupted = 130,
}

impl ExitCode {
    pub fn of_gate(passes: bool) -> Self {
        if passes { Self::Done } else { Self::GateFailed }
    }

    /// Of two exit codes the first that is not success.
    pub fn or(self, next: Self) -> Self {
        if self == Self::Done { next } else { self }
    }
}

impl From<ExitCode> for std::process::ExitCode {
    fn from(code: ExitCode) -> Self {
        Self::from(code as u8)
    }
}
