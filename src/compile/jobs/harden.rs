use std::fmt;
use std::sync::Arc;

use super::{Job, Planned};
use crate::{Fingerprint, Programs, RunId};
use base::seed::Seed;
use base::signature::short;
use world::env::Scenario;
use world::falsifier::Controller;
use world::hardening::{Attack, Hardening};

/// The names that distinguish a hardening from the others of its campaign.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct HardenKey {
    /// Its short name.
    pub id: RunId,
    /// Name of the driving policy.
    pub policy: String,
    /// Number of the `harden` block in its campaign, from 0.
    pub block: u32,
    /// Number of the run, from 0.
    pub run: u32,
}

/// `idm, run 0`.
impl fmt::Display for HardenKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, run {}", self.policy, self.run)
    }
}

/// A driver that is to be hardened.
#[derive(Debug, Clone)]
pub struct Harden {
    /// Its names.
    pub key: HardenKey,
    pub hardening: Arc<Hardening>,
    pub written: Arc<WrittenPolicy>,
    /// The digest of what the files say about it.
    pub fingerprint: Fingerprint,
    /// The programs of the user that it depends on.
    pub programs: Programs,
}

impl Harden {
    /// The seed of all that it draws: the same for all drivers.
    pub fn seed(&self, seed: &Seed) -> Seed {
        seed.child("harden").index(self.key.run.into())
    }

    /// All numbers and names of the block that its results depend on, as a text.
    pub fn settings(&self) -> String {
        let Hardening { driver, towns, attacks, test_towns, walkers, rivals, rule, .. } = &*self.hardening;
        let Hardening { budget, rounds, candidates, lessons, traffic, episodes, .. } = &*self.hardening;
        let names =
            |places: &[(String, Arc<Scenario>)]| places.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        let attackers = |all: &[Attack]| all.iter().map(|(name, ..)| name.clone()).collect::<Vec<_>>();
        format!(
            "{:?} {:?} {:?} {:?} {:?} {:?} {rule:?} {:?}",
            driver.keys,
            names(towns),
            attackers(attacks),
            names(test_towns),
            walkers.iter().map(Controller::name).collect::<Vec<_>>(),
            attackers(rivals),
            (budget, rounds, candidates, lessons, traffic, episodes)
        )
    }

    /// Simulator ticks that it may use at most, about: the attacks, and the test by falsifiers.
    pub fn budget(&self) -> u64 {
        let Hardening { budget, rounds, towns, attacks, test_towns, rivals, .. } = &*self.hardening;
        let attacks = u64::from(*rounds) * (attacks.len() * towns.len()) as u64;
        budget.saturating_mul(attacks + 2 * (rivals.len() * test_towns.len()) as u64)
    }
}

impl Planned for Harden {
    fn run_number(&self) -> u32 {
        self.key.run
    }

    fn places(&self) -> Vec<(&str, &Arc<Scenario>)> {
        let towns = self.hardening.towns.iter().chain(&self.hardening.test_towns);
        towns.map(|(town, scenario)| (town.as_str(), scenario)).collect()
    }

    fn programs(&self) -> &Programs {
        &self.programs
    }

    fn fingerprint(&self) -> Fingerprint {
        self.fingerprint
    }

    fn units(&self, _: u32) -> u64 {
        self.budget()
    }

    fn inputs(&self) -> String {
        let HardenKey { policy, block, run, .. } = &self.key;
        format!("harden {policy:?} {block} {run} {} {}", self.fingerprint, self.settings())
    }

    /// Some falsifiers learn.
    fn depends_on_processor(&self) -> bool {
        true
    }

    fn shorten(&mut self) {
        let small = Arc::make_mut(&mut self.hardening);
        let longest = small.towns.iter().map(|(_, town)| u64::from(town.episode.ticks + town.most_run_up())).max();
        small.budget = small.budget.min(10 * longest.unwrap_or(0));
        small.rounds = 1;
        small.candidates = small.candidates.min(3);
        small.lessons = small.lessons.min(2);
        small.traffic = small.traffic.min(2);
        small.episodes = small.episodes.min(5);
    }

    fn names(&self, _: &[Job]) -> Option<Vec<String>> {
        let Self { key: HardenKey { block, policy, run, .. }, fingerprint, .. } = self;
        let settings = self.settings();
        let all: [&dyn ToString; 6] = [&"harden", block, policy, run, fingerprint, &settings];
        Some(all.map(ToString::to_string).into())
    }

    fn id(&self) -> Option<RunId> {
        Some(self.key.id)
    }

    fn id_mut(&mut self) -> Option<&mut RunId> {
        Some(&mut self.key.id)
    }
}

/// A policy as the files write it.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenPolicy {
    pub name: String,
    pub kind: &'static str,
    /// Its keys with their values as written.
    pub keys: Vec<(&'static str, String)>,
    /// What each varied number is, in their order.
    pub varied: Vec<VariedKey>,
}

/// A number that is varied.
#[derive(Debug, Clone, PartialEq)]
pub enum VariedKey {
    /// The value of a key, in this unit of SI.
    Key { key: &'static str, unit: &'static str },
    /// A parameter of a program, which its greeting tells it.
    Parameter { name: String },
}

/// The key with the parameters of a program.
pub(crate) const PARAMETERS: &str = "parameters";

impl VariedKey {
    /// Whether it is the value of this key.
    pub(crate) fn is_key(&self, name: &str) -> bool {
        matches!(self, Self::Key { key, .. } if *key == name)
    }

    /// The unit of the number.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Key { unit, .. } => unit,
            Self::Parameter { .. } => "",
        }
    }
}

impl WrittenPolicy {
    /// The policy with these values (SI) for what is varied, as a line of a file.
    pub fn line(&self, values: &[f64]) -> String {
        let mut keys = self.keys.clone();
        for (varied, value) in self.varied.iter().zip(values) {
            match varied {
                VariedKey::Key { key, unit } => {
                    let text = format!("{} {unit}", short(*value)).trim_end().to_string();
                    match keys.iter_mut().find(|(name, _)| name == key) {
                        Some((_, written)) => *written = text,
                        None => keys.push((key, text)),
                    }
                }
                VariedKey::Parameter { name } => {
                    if let Some((_, written)) = keys.iter_mut().find(|(key, _)| *key == PARAMETERS) {
                        *written = with_parameter(written, name, *value);
                    }
                }
            }
        }
        let keys: Vec<String> = keys.iter().map(|(key, value)| format!("{key}: {value}")).collect();
        format!("policy {}_hardened = {}({})", self.name, self.kind, keys.join(", "))
    }
}

/// A list of parameters as a file writes it, with another value of one.
fn with_parameter(list: &str, name: &str, value: f64) -> String {
    let start = format!("\"{name}=");
    let Some((before, (_, after))) =
        list.split_once(&start).and_then(|(before, rest)| Some((before, rest.split_once('"')?)))
    else {
        return list.into();
    };
    format!("{before}{start}{}\"{after}", short(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hardened_policy_is_a_line_of_a_file() {
        let written = WrittenPolicy {
            name: "mine".into(),
            kind: "external",
            keys: vec![
                ("command", "\"python my_av.py\"".into()),
                ("parameters", "[\"gap=1\", \"width=2\"]".into()),
                ("sensors", "poor".into()),
            ],
            varied: vec![
                VariedKey::Parameter { name: "gap".into() },
                VariedKey::Key { key: "actuation_delay", unit: "s" },
            ],
        };
        assert_eq!(
            written.line(&[2.5, 0.1]),
            "policy mine_hardened = external(command: \"python my_av.py\", parameters: [\"gap=2.5\", \"width=2\"], \
             sensors: poor, actuation_delay: 0.1 s)"
        );
    }
}
