//! The argument of `--shard`: one of several parts of a campaign.

use std::str::FromStr;

use results::campaign::Shard;

/// The variables in which job engines give a task its number, counted from 0 as shards are.
const NUMBERS: [&str; 2] = ["SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX"];

/// A shard on the command line: `3/16`, or `auto/16` to take the number from the environment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NamedShard {
    index: Option<u32>,
    count: u32,
}

/// Why a text is not a shard.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NoShard {
    /// It has another form.
    #[error("write INDEX/COUNT, such as 3/16, or auto/16")]
    Form,
    /// The number of shards is 0.
    #[error("there must be at least one shard")]
    Count,
    /// The index is too large.
    #[error("{count} shards are counted from 0 to {}", count - 1)]
    Index {
        /// The number of shards.
        count: u32,
    },
    /// The environment has no number.
    #[error("--shard auto/{count} needs {} or {} in the environment", NUMBERS[0], NUMBERS[1])]
    NoNumber {
        /// The number of shards.
        count: u32,
    },
    /// The variable of the environment is not the number of a shard.
    #[error("{variable} is `{value}`, but {count} shards are counted from 0 to {}", count - 1)]
    Number {
        /// The variable.
        variable: &'static str,
        /// Its value.
        value: String,
        /// The number of shards.
        count: u32,
    },
}

impl FromStr for NamedShard {
    type Err = NoShard;

    fn from_str(text: &str) -> Result<Self, NoShard> {
        let (index, count) = text.split_once('/').ok_or(NoShard::Form)?;
        let count: u32 = count.parse().map_err(|_| NoShard::Form)?;
        let index = if index == "auto" { None } else { Some(index.parse().map_err(|_| NoShard::Form)?) };
        match index {
            _ if count == 0 => Err(NoShard::Count),
            Some(index) if index >= count => Err(NoShard::Index { count }),
            _ => Ok(Self { index, count }),
        }
    }
}

impl NamedShard {
    /// The shard; its number comes from the environment if the user did not give one.
    ///
    /// # Errors
    /// The environment has no number, or one that is not a shard.
    pub fn resolve(self, variable: impl Fn(&str) -> Option<String>) -> Result<Shard, NoShard> {
        let Self { index, count } = self;
        if let Some(index) = index {
            return Ok(Shard { index, count });
        }
        let found = NUMBERS.iter().find_map(|name| Some((*name, variable(name)?)));
        let (variable, value) = found.ok_or(NoShard::NoNumber { count })?;
        match value.parse() {
            Ok(index) if index < count => Ok(Shard { index, count }),
            _ => Err(NoShard::Number { variable, value, count }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_counted_from_zero() {
        let named = |text: &str| NamedShard::from_str(text).and_then(|named| named.resolve(|_| None));
        assert_eq!(named("3/16"), Ok(Shard { index: 3, count: 16 }));
        assert!(named("16/16").unwrap_err().to_string().contains("from 0 to 15"));
        for wrong in ["3", "3/", "/4", "a/4", "1/0", "-1/4", "1/4/4"] {
            assert!(NamedShard::from_str(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn the_number_comes_from_the_environment() {
        let auto = NamedShard::from_str("auto/16").unwrap();
        let with =
            |name: &'static str, value: &'static str| move |asked: &str| (asked == name).then(|| value.to_string());
        for name in NUMBERS {
            assert_eq!(auto.resolve(with(name, "7")), Ok(Shard { index: 7, count: 16 }));
            assert!(auto.resolve(with(name, "16")).unwrap_err().to_string().contains(name));
        }
        assert!(auto.resolve(|_| None).unwrap_err().to_string().contains("SLURM_ARRAY_TASK_ID"));
    }
}
