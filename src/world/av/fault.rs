/// Why a driver could not drive. An episode in which this happens counts neither as passed nor as failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// Its process could not be started.
    #[error("could not be started")]
    NotStarted,
    /// Its greeting did not follow the protocol, or was of an unsupported version.
    #[error("greeted wrongly: {0}")]
    Greeting(&'static str),
    /// It did not answer in time.
    #[error("did not answer within {limit_ms} ms")]
    Late {
        /// The time it had (ms).
        limit_ms: u32,
    },
    /// It ended, or closed its output.
    #[error("ended before it answered")]
    Ended,
    /// It ended during other episodes, of which this was one.
    #[error("was restarted during the episode")]
    Restarted,
    /// The user asked to stop while it was waited for. Its episode is not over: nothing is concluded from it.
    #[error("was not waited for, since the user asked to stop")]
    Stopped,
    /// It gave an answer that makes no sense.
    #[error("gave a wrong answer: {0}")]
    Answer(&'static str),
}
