//! Names the runs and searches of a campaign, each with a unique name.

use std::collections::BTreeMap;

#[cfg(doc)]
use super::Fingerprint;
use super::plan::{Campaign, Training};
use super::run_id::RunId;

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

    /// What a training depends on. A smoke run takes fewer steps than the files say.
    fn and_training(self, training: &Training) -> Self {
        self.and(&training.fingerprint.to_string()).and(&training.config.total_steps.to_string())
    }
}

impl Campaign {
    /// Names the evaluations and the searches for a user's seed.
    ///
    /// A name depends on the campaign's name, the keys of the run, the seed, and what the files and settings say about the run
    /// ([`Fingerprint`]), for a trained pedestrian also about its training. It does not depend on the number of episodes, since the
    /// first ones are the same. So a changed driver, place or seed gives other names, and an equal name is the same run. A compiled plan
    /// has the names for seed 1.
    pub fn name_runs(&mut self, seed: u64) {
        let mut register = Register::default();
        let campaign = Names::new(&self.name).and(&seed.to_string());
        for evaluation in &mut self.evaluations {
            let key = &evaluation.trained;
            let names = campaign.clone().and(&evaluation.block.to_string()).and(evaluation.controller.name());
            let names = names.and(&key.reward).and(&key.town).and(&key.policy).and(&key.run.to_string());
            let names = names.and(&evaluation.town).and(&evaluation.policy);
            let names =
                names.and(&evaluation.vehicle).and(&evaluation.adversary).and(&evaluation.fingerprint.to_string());
            let training = evaluation.training().map(|training| &self.trainings[training]);
            evaluation.id = register.name(match training.or(evaluation.first.as_deref()) {
                Some(training) => names.and_training(training),
                None => names,
            });
        }
        for search in &mut self.searches {
            let key = &search.key;
            let names = campaign.clone().and("search").and(&key.block.to_string()).and(&key.falsifier);
            let names = names.and(&key.town).and(&key.policy).and(&key.run.to_string());
            let names = names.and(&search.fingerprint.to_string());
            search.key.id = register.name(names.and(&search.budget.to_string()));
        }
        for estimation in &mut self.estimations {
            let key = &estimation.key;
            let names = campaign.clone().and("estimate").and(&key.block.to_string());
            let names = names.and(&key.walker).and(&key.requirement).and(&key.town).and(&key.policy);
            let names = names.and(&key.run.to_string()).and(&estimation.fingerprint.to_string());
            estimation.key.id = register.name(names.and(&estimation.budget.to_string()));
        }
        for cover in &mut self.covers {
            let key = &cover.key;
            let names = campaign.clone().and("cover").and(&key.block.to_string()).and(&key.pedestrian);
            let names = names.and(&key.town).and(&key.policy).and(&cover.fingerprint.to_string());
            let names = names.and(cover.failure_name()).and(&format!("{:?}", cover.epsilon));
            cover.key.id = register.name(names.and(&cover.budget.to_string()));
        }
        for harden in &mut self.hardenings {
            let key = &harden.key;
            let names = campaign.clone().and("harden").and(&key.block.to_string()).and(&key.policy);
            let names = names.and(&key.run.to_string()).and(&harden.fingerprint.to_string());
            harden.key.id = register.name(names.and(&harden.settings()));
        }
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
