use std::fmt;
use std::str::FromStr;

use crate::compile::RunId;

/// The name of an episode or of a failure of a search, `RUN:EPISODE`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EpisodeName {
    /// The run or the search.
    pub run: RunId,
    /// Number of the episode, or of the failure of the search.
    pub number: u32,
}

/// A text that is not the name of an episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("write RUN:EPISODE, as in 1a2b3c4d:17: eight hexadecimal digits and a number")]
pub struct NoEpisodeName;

impl FromStr for EpisodeName {
    type Err = NoEpisodeName;

    fn from_str(text: &str) -> Result<Self, NoEpisodeName> {
        let (run, number) = text.split_once(':').ok_or(NoEpisodeName)?;
        let number = Some(number).filter(|number| number.bytes().all(|byte| byte.is_ascii_digit()));
        Ok(Self {
            run: run.parse().map_err(|_| NoEpisodeName)?,
            number: number.and_then(|number| number.parse().ok()).ok_or(NoEpisodeName)?,
        })
    }
}

impl fmt::Display for EpisodeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.run, self.number)
    }
}
