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
    /// All of them, in order.
    pub const ALL: [Self; 11] = [
        Self::Done,
        Self::Internal,
        Self::Usage,
        Self::Scenario,
        Self::Nothing,
        Self::RunFailed,
        Self::WriteFailed,
        Self::GateFailed,
        Self::Differs,
        Self::Incomplete,
        Self::Interrupted,
    ];

    /// Of two exit codes the first that is no success.
    pub fn or(self, next: Self) -> Self {
        if self == Self::Done { next } else { self }
    }

    /// Its meaning, for the reference.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::Internal => "internal error: a bug of `falsify`",
            Self::Usage => "wrong usage, or a missing file",
            Self::Scenario => "errors in a scenario",
            Self::Nothing => "nothing to run",
            Self::RunFailed => "a training failed, a driver failed as a program, or a reward was not a number",
            Self::WriteFailed => "a file cannot be written",
            Self::GateFailed => "a `--fail-if` condition is true, or needs an interval that too few runs have",
            Self::Differs => {
                "a repeated episode or training came out differently, or a file of a report was changed (`verify`, `replay`, `export`)"
            }
            Self::Incomplete => {
                "work is missing: a shard to merge (`merge`), or a part of a campaign on which no process works (`status`)"
            }
            Self::Interrupted => "interrupted by Ctrl-C or SIGTERM",
        }
    }
}

impl From<ExitCode> for std::process::ExitCode {
    fn from(code: ExitCode) -> Self {
        Self::from(code as u8)
    }
}
