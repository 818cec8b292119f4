//! Gives the jobs of a campaign short names, each another one.

use std::collections::BTreeMap;

#[cfg(doc)]
use super::Fingerprint;
use super::run_id::RunId;
use super::{Campaign, Job};

/// Names that are in use, each by one owner.
#[derive(Default)]
struct Register {
    owners: BTreeMap<RunId, String>,
}

impl Register {
    fn name(&mut self, text: String) -> RunId {
        let free = |id: &RunId| self.owners.get(id).is_none_or(|owner| *owner == text);
        let id = (0..).map(|again| RunId::new(&text, again)).find(free).expect("there are billions of names");
        self.owners.insert(id, text);
        id
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
        let name = |job: &Job| {
            let needed = job.origin().needs.map(|place| self.jobs[place].planned());
            let names = job.planned().names(needed);
            let all = [self.name.clone(), seed.to_string()].into_iter().chain(names.iter().cloned());
            // Each name has an end, so that no two lists are one text.
            (!names.is_empty()).then(|| register.name(all.flat_map(|name| [name, "\0".into()]).collect()))
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
        assert_eq!(Register::default().name("a\0b\0".into()), id);
        for text in ["", "1234567", "123456789", "1234567g", "+1234567", "é23456"] {
            assert_eq!(text.parse::<RunId>(), Err(NoRunId { text: text.into() }));
        }
    }

    #[test]
    fn two_owners_never_share_a_name() {
        let mut register = Register::default();
        let name = || "a\0".to_string();
        let first = register.name(name());
        register.owners.insert(first, "somebody else".into());
        let second = register.name(name());
        assert!(first != second && second == RunId::new("a\0", 1) && second == register.name(name()));
    }
}
