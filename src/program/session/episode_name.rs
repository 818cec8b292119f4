use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use super::Error;
use compile::RunId;

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

impl EpisodeName {
    /// Reads a name in a table of a report.
    pub(crate) fn of_table(name: String) -> Result<Self, Error> {
        name.parse().map_err(|_| Error::Usage(format!("`{name}` in a table is not the name of an episode")))
    }
}

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

/// An episode and where its report is: `RUN:EPISODE`, or `PATH/RUN:EPISODE` with the path of a report or of a folder of reports.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EpisodePath {
    /// The path; `None` if the text has only a name.
    pub report: Option<PathBuf>,
    pub name: EpisodeName,
}

impl FromStr for EpisodePath {
    type Err = NoEpisodeName;

    fn from_str(text: &str) -> Result<Self, NoEpisodeName> {
        match text.rsplit_once(std::path::is_separator) {
            // `/1a2b3c4d:17` is in the root folder.
            Some(("", name)) => Ok(Self { report: Some("/".into()), name: name.parse()? }),
            Some((path, name)) => Ok(Self { report: Some(path.into()), name: name.parse()? }),
            None => Ok(Self { report: None, name: text.parse()? }),
        }
    }
}

impl fmt::Display for EpisodePath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.report {
            Some(path) => write!(f, "{}", path.join(self.name.to_string()).display()),
            None => write!(f, "{}", self.name),
        }
    }
}

impl fmt::Display for EpisodeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.run, self.number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_precedes_a_name() {
        for (text, path) in [
            ("1a2b3c4d:17", None),
            ("reports/first_look/1a2b3c4d:17", Some("reports/first_look")),
            ("../a b/1a2b3c4d:17", Some("../a b")),
            ("/1a2b3c4d:17", Some("/")),
        ] {
            let parsed: EpisodePath = text.parse().unwrap();
            assert_eq!((parsed.report.as_deref(), parsed.name.number), (path.map(std::path::Path::new), 17));
            assert_eq!(parsed.to_string(), text);
        }
        for wrong in ["", "reports", "reports/first_look", "1a2b3c4d", "a/1a2b3c4d:", "a/1a2b3c4d:17/", "1a2b3c4d:-1"] {
            assert_eq!(wrong.parse::<EpisodePath>(), Err(NoEpisodeName), "{wrong}");
        }
    }
}
