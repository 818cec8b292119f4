//! Gives the jobs of a campaign short names, each another one.

use std::collections::BTreeMap;

#[cfg(doc)]
use super::Fingerprint;
use super::run_id::RunId;
use super::{Campaign, Job};

/// The number of bytes that the names of most runs take together.
const TYPICAL: usize = 256;

/// Names that are in use, each by one owner.
#[derive(Default)]
struct Register {
    owners: BTreeMap<RunId, String>,
}

impl Register {
    fn name(&mut self, names: Names) -> RunId {
        let Names(text) = names;
        let free = |id: &RunId| self.owners.get(id).is_none_or(|owner| *owner == text);
        let id = (0..).map(|again| RunId::new(&text, again)).find(free).expect("there are billions of names");
        self.owners.insert(id, text);
        id
    }
}

/// Names in one text, each with its end.
#[derive(Clone)]
struct Names(String);

impl Names {
    fn new(first: &str) -> Self {
        Self(String::with_capacity(TYPICAL)).and(first)
    }

    fn and(mut self, name: &str) -> Self {
        self.0.push_str(name);
        self.0.push('\0');
        self
    }
}

impl Campaign {
    /// Names the jobs for a user's seed.
    ///
    /// A name depends on the campaign's name, the keys of the job, the seed, and what the files and settings say about the job
    /// ([`Fingerprint`]), for a trained pedestrian also about its training. It does not depend on the number of episodes, since the
    /// first ones are the same. So a changed driver, place or seed gives other names, and an equal name is the same run. A compiled plan
    /// has the names for seed 1.
    pub fn name_runs(&mut self, seed: u64) {
        let mut register = Register::default();
        let campaign = Names::new(&self.name).and(&seed.to_string());
        let name = |job: &Job| {
            let names = job.planned().names(&self.jobs);
            let text = names.iter().fold(campaign.clone(), |all, name| all.and(name));
            (!names.is_empty()).then(|| register.name(text))
        };
        let names: Vec<Option<RunId>> = self.jobs.iter().map(name).collect();
        let mut names = names.into_iter();
        self.rename(|_| names.next().flatten());
    }
}

#[cfg(test)]
mod tests {
    use super::super::run_id::NoRunId;
    use super::*;

    #[test]
    fn a_name_is_that_of_blake3_and_returns_from_its_text() {
        let id = RunId::new("a\0b\0", 0);
        assert_eq!(id.to_string().parse(), Ok(id));
        assert_eq!(Register::default().name(Names::new("a").and("b")), id);
        assert_ne!(Register::default().name(Names::new("ab").and("")), id);
        for text in ["", "1234567", "123456789", "1234567g", "+1234567", "é23456"] {
            assert_eq!(text.parse::<RunId>(), Err(NoRunId { text: text.into() }));
        }
    }

    #[test]
    fn two_owners_never_share_a_name() {
        let mut register = Register::default();
        let name = || Names::new("a");
        let first = register.name(name());
        register.owners.insert(first, "somebody else".into());
        let second = register.name(name());
        assert!(first != second && second == RunId::new("a\0", 1) && second == register.name(name()));
    }
}
