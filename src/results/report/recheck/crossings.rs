use super::{Encounter, Encounters};
use crate::record::in_world;
use crate::report::FailureChange;
use crate::report::compare::drivers;

/// The fixed list in a town: every crossing of a grid from the same starts, met by both drivers.
#[derive(Debug, Clone)]
pub struct CrossedStarts {
    /// The old driver and the new one.
    pub policies: [String; 2],
    pub town: String,
    /// The simulator in which the new driver drives.
    pub world: String,
    /// Number of the setup (spawn, episode and pedestrian) in the town, from 0.
    pub setup: u64,
    /// Crossings from each start.
    pub crossings: u64,
    /// All encounters, start by start.
    pub encounters: Encounters,
}

impl CrossedStarts {
    /// The drivers and the town.
    pub fn title(&self) -> String {
        let setup = if self.setup == 0 { String::new() } else { format!(", setup {}", self.setup) };
        format!("{} in {}{setup}", drivers(&self.policies), in_world(&self.town, &self.world))
    }

    /// The crossings that are a fault of a driver, as they end for both. Empty if the old driver was not run.
    pub fn changes(&self) -> Vec<FailureChange> {
        let is_fault = |each: &&Encounter| each.after.fault || each.before.is_some_and(|before| before.fault);
        let faults = self.encounters.valid().filter(is_fault);
        faults.filter_map(|encounter| encounter.change(self.title())).collect()
    }
<<<<<<< HEAD
=======

    pub fn starts(&self) -> BTreeMap<u64, StartFaults> {
        let mut starts: BTreeMap<u64, StartFaults> = BTreeMap::new();
        for encounter in self.encounters.valid() {
            let faults = starts.entry(encounter.start).or_default();
            faults.before += u64::from(encounter.fault_before() == Some(true));
            faults.after += u64::from(encounter.after.fault);
            faults.injury_before += encounter.before.map_or(0.0, |met| met.avoidable_injury());
            faults.injury_after += encounter.after.avoidable_injury();
        }
        starts
    }

    /// The number of starts whose faults are so; `None` if the old driver was not run.
    pub fn count_starts(&self, is: impl Fn(StartFaults) -> bool) -> Option<u64> {
        self.encounters.has_before().then(|| self.starts().into_values().filter(|faults| is(*faults)).count() as u64)
    }

    /// The number of starts from which the new driver has a fault.
    pub fn fault_starts_after(&self) -> u64 {
        self.starts().into_values().filter(|faults| faults.after > 0).count() as u64
    }

    /// The share of a number of starts.
    pub fn share(&self, starts: u64) -> Option<f64> {
        let all = self.starts().len();
        (all > 0).then(|| starts as f64 / all as f64)
    }

    /// Probability of a change at least this uneven of the starts with a fault by chance: McNemar's exact test over starts.
    pub fn p(&self) -> Option<f64> {
        let new = self.count_starts(|faults| faults.is_new())?;
        Some(mcnemar(self.count_starts(|faults| faults.is_fixed())?, new))
    }

    /// Probability of a difference at least this large between the numbers of worse and of better starts by chance: the exact sign test.
    pub fn p_starts(&self) -> Option<f64> {
        Some(mcnemar(self.count_starts(StartFaults::is_better)?, self.count_starts(StartFaults::is_worse)?))
    }

    /// Severe injuries in the faults of the old driver, for every 1,000 crossings.
    pub fn avoidable_injury_before(&self) -> Option<f64> {
        self.per_thousand(|encounter| encounter.before.map(|met| met.avoidable_injury()))
    }

    /// Severe injuries in the faults of the new driver, for every 1,000 crossings.
    pub fn avoidable_injury_after(&self) -> Option<f64> {
        self.per_thousand(|encounter| Some(encounter.after.avoidable_injury()))
    }

    /// Severe injuries in all collisions of the new driver, avoidable or not, less those of the old one, for every 1,000 crossings.
    pub fn injury_difference(&self) -> Option<f64> {
        self.per_thousand(|encounter| Some(encounter.after.injury() - encounter.before?.injury()))
    }

    fn per_thousand(&self, of: impl Fn(&Encounter) -> Option<f64>) -> Option<f64> {
        let values: Vec<f64> = self.encounters.valid().map(of).collect::<Option<_>>()?;
        (!values.is_empty()).then(|| 1000.0 * values.iter().sum::<f64>() / values.len() as f64)
    }
}

impl StartFaults {
    /// Whether the new driver's faults weigh more.
    pub fn is_worse(self) -> bool {
        self.injury_after > self.injury_before
    }

    /// Whether the old driver's faults weigh more.
    pub fn is_better(self) -> bool {
        self.injury_after < self.injury_before
    }

    /// Whether only the new driver has a fault.
    pub fn is_new(self) -> bool {
        self.before == 0 && self.after > 0
    }

    /// Whether only the old driver has a fault.
    pub fn is_fixed(self) -> bool {
        self.before > 0 && self.after == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::RerunOutcome;

    /// A start for each word; each letter is a crossing: `n`ew, `f`ixed, `s`ame, `e`rror, or none.
    fn crossed(starts: &[&str]) -> CrossedStarts {
        let met = |fault: bool| RerunOutcome { impact_speed: fault.then_some(10.0), fault, ..RerunOutcome::default() };
        let encounter = |start: usize, crossing: usize, letter: char| Encounter {
            name: String::new(),
            start: start as u64,
            crossing: crossing as u64,
            before: Some(met(matches!(letter, 'f' | 's'))),
            after: if letter == 'e' { RerunOutcome::error() } else { met(matches!(letter, 'n' | 's')) },
            incident: None,
        };
        let of = |(start, word): (usize, &&str)| -> Vec<Encounter> {
            word.chars().enumerate().map(|(crossing, letter)| encounter(start, crossing, letter)).collect()
        };
        CrossedStarts {
            policies: ["old".into(), "new".into()],
            town: "harbour".into(),
            world: "here".into(),
            setup: 0,
            crossings: 4,
            encounters: Encounters(starts.iter().enumerate().flat_map(of).collect()),
            holm: None,
        }
    }

    #[test]
    fn starts_and_crossings_are_counted_apart() {
        let crossed = crossed(&["n...", "nn..", "ns..", "f...", "ff.s", "...e"]);
        assert_eq!(crossed.count_starts(StartFaults::is_new), Some(2));
        assert_eq!(crossed.count_starts(StartFaults::is_fixed), Some(1));
        assert_eq!(crossed.fault_starts_after(), 4);
        assert_eq!(crossed.encounters.count(|before, after| after.fault && !before.fault), Some(4));
        assert_eq!(crossed.encounters.count(|before, after| !after.fault && before.fault), Some(3));
        assert_eq!((crossed.encounters.errors(), crossed.share(3)), (1, Some(0.5)));
        assert_eq!(crossed.p(), Some(1.0), "two against one");
        let risk = verdict::severe_injury_risk(10.0);
        let after = crossed.avoidable_injury_after().unwrap();
        assert!((after - 1000.0 * risk * 6.0 / 23.0).abs() < 1e-9, "an error is no crossing");
        // Six collisions now, and five before.
        assert!((crossed.injury_difference().unwrap() - 1000.0 * risk * 1.0 / 23.0).abs() < 1e-9);
    }

    #[test]
    fn six_starts_that_are_all_worse_are_no_chance() {
        let worse = crossed(&["n", "n", "n", "n", "n", "n"]);
        assert!((worse.p().unwrap() - 2.0 / 64.0).abs() < 1e-12);
        // A start from which there was a fault before can be worse, too.
        let saturated = crossed(&["sn", "sn", "sn", "sn", "sn", "sn"]);
        assert_eq!(saturated.p(), Some(1.0));
        assert!((saturated.p_starts().unwrap() - 2.0 / 64.0).abs() < 1e-12);
    }

    #[test]
    fn without_the_old_driver_nothing_is_new() {
        let mut alone = crossed(&["n", "s"]);
        alone.encounters.0.iter_mut().for_each(|encounter| encounter.before = None);
        assert_eq!((alone.p(), alone.count_starts(StartFaults::is_new), alone.fault_starts_after()), (None, None, 2));
        assert_eq!((alone.avoidable_injury_before(), alone.injury_difference()), (None, None));
    }
>>>>>>> 623b1967 (Roads, episodes, verdicts and searches are packages of their own)
}
