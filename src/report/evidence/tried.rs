use polars::prelude::{DataFrame, PolarsResult};

use super::Figure;
use crate::judge::Reference;
use crate::seed::Seed;

/// What tells cells apart.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct CellKey {
    /// Number of the `evaluate` block.
    pub block: u32,
    /// Town it was tried in.
    pub town: String,
    /// Policy it was tried against.
    pub policy: String,
    /// The model of car.
    pub vehicle: String,
    /// The adversary, for its body.
    pub adversary: String,
    /// Who it is.
    pub pedestrian: String,
    /// Name of the reward.
    pub reward: String,
    /// Town it was trained in; empty for untrained pedestrians.
    pub train_town: String,
    /// Policy it was trained against; empty for untrained pedestrians.
    pub train_policy: String,
}

impl CellKey {
    /// The branch of a seed that belongs to the place in which it was tried.
    pub(super) fn place(&self, seed: &Seed) -> Seed {
        let names = [&self.town, &self.policy, &self.vehicle, &self.adversary];
        names.iter().fold(seed.child("place").index(self.block.into()), |seed, name| seed.child(name))
    }

    /// The branch of a seed that belongs to the pedestrian.
    pub(super) fn who(&self, seed: &Seed) -> Seed {
        let names = [&self.pedestrian, &self.reward, &self.train_town, &self.train_policy];
        names.iter().fold(*seed, |seed, name| seed.child(name))
    }

    /// Whether it comes from a training.
    pub fn is_trained(&self) -> bool {
        !self.train_town.is_empty()
    }

    /// Whether another was tried in the same place: from the same beginnings, against the same driver.
    pub fn is_beside(&self, other: &Self) -> bool {
        let place = |key: &Self| [&key.town, &key.policy, &key.vehicle, &key.adversary].map(Clone::clone);
        self.block == other.block && place(self) == place(other)
    }
}

/// How many episodes of a run are looked at one by one, for sampling errors, pairs and quantiles: what memory evidence takes does not
/// grow with those beyond, which count in sums alone. From so many, an error is known to 0.3 %.
pub const KEPT: usize = 100_000;

/// What is known of an episode, in a byte.
mod is {
    pub const VALID: u8 = 1;
    pub const COLLISION: u8 = 2;
    pub const FRONT: u8 = 4;
    pub const MOVING: u8 = 8;
    pub const PREVENTABLE: u8 = 16;
    pub const ALL: [u8; 5] = [VALID, COLLISION, FRONT, MOVING, PREVENTABLE];
}

/// One run, tried: as much of its episodes as evidence needs.
#[derive(Debug, Clone)]
pub struct Tried {
    /// Its cell.
    pub key: CellKey,
    /// Number of the run.
    pub run: u32,
    /// Speeds at the collisions (m/s), of the episodes that are kept.
    pub impact_speeds: Vec<f64>,
    /// Least times to collision of the other episodes (s), of those that have one and are kept.
    pub min_ttc: Vec<f64>,
    /// Post-encroachment times of the other episodes (s), of those that have one and are kept.
    pub pet: Vec<f64>,
    /// How many collisions each reference driver avoids.
    pub avoided: [u64; 6],
    /// How many episodes there are, errors among them.
    size: usize,
    /// How many of all episodes have each flag.
    counts: [u64; 5],
    /// Sum over all episodes.
    reward: f64,
    /// Of the episodes that are kept.
    flags: Vec<u8>,
    rewards: Vec<f64>,
}

impl Tried {
    /// Reads the episodes of one run, and keeps those with numbers below a limit.
    ///
    /// # Errors
    /// Those of polars; none for a table made by [`episodes`](crate::report::episodes).
    pub fn new(run: &DataFrame, kept: usize) -> PolarsResult<Self> {
        let text = |name: &str| -> PolarsResult<String> {
            Ok(run.column(name)?.str()?.get(0).unwrap_or_default().to_string())
        };
        let count = |name: &str| -> PolarsResult<u32> { Ok(run.column(name)?.u32()?.get(0).unwrap_or_default()) };
        let key = CellKey {
            block: count("block")?,
            town: text("town")?,
            policy: text("policy")?,
            vehicle: text("vehicle")?,
            adversary: text("adversary")?,
            pedestrian: text("pedestrian")?,
            reward: text("reward")?,
            train_town: text("train_town")?,
            train_policy: text("train_policy")?,
        };
        let numbers = run.column("episode")?.u32()?;
        let size = numbers.into_no_null_iter().max().map_or(0, |last| last as usize + 1);
        let (mut flags, mut rewards) = (vec![0; size.min(kept)], vec![0.0; size.min(kept)]);
        let (outcomes, verdicts) = (run.column("outcome")?.str()?, run.column("verdict")?.str()?);
        let paid = run.column("episode_reward")?.f64()?;
        let truths = |name: &str| run.column(name)?.bool();
        let (hit, front, moving) = (truths("collision")?, truths("front")?, truths("moving")?);
        let values = |name: &str| run.column(name)?.f64();
        let (speed, ttc, pet) = (values("impact_speed_mps")?, values("min_ttc_s")?, values("pet_s")?);
        let mut tried = Self {
            key,
            run: count("run")?,
            impact_speeds: Vec::new(),
            min_ttc: Vec::new(),
            pet: Vec::new(),
            avoided: [0; 6],
            size,
            counts: [0; 5],
            reward: -0.0,
            flags: Vec::new(),
            rewards: Vec::new(),
        };
        for (row, episode) in numbers.into_no_null_iter().enumerate() {
            if outcomes.get(row) == Some("error") {
                continue;
            }
            let episode = episode as usize;
            let collision = hit.get(row) == Some(true);
            let flag = |holds: bool, flag: u8| if holds { flag } else { 0 };
            let known = is::VALID
                | flag(collision, is::COLLISION)
                | flag(front.get(row) == Some(true), is::FRONT)
                | flag(moving.get(row) == Some(true), is::MOVING)
                | flag(verdicts.get(row) == Some("preventable"), is::PREVENTABLE);
            let reward = paid.get(row).unwrap_or_default();
            for (count, flag) in tried.counts.iter_mut().zip(is::ALL) {
                *count += u64::from(known & flag != 0);
            }
            tried.reward += reward;
            if episode >= kept {
                continue;
            }
            (flags[episode], rewards[episode]) = (known, reward);
            if collision {
                tried.impact_speeds.extend(speed.get(row));
            } else {
                tried.min_ttc.extend(ttc.get(row));
                tried.pet.extend(pet.get(row));
            }
        }
        for (avoided, reference) in tried.avoided.iter_mut().zip(Reference::ALL) {
            *avoided = run.column(&format!("{}_avoids", reference.name()))?.bool()?.sum().unwrap_or(0).into();
        }
        (tried.flags, tried.rewards) = (flags, rewards);
        Ok(tried)
    }

    /// Episodes that the driver drove to their end.
    pub fn episodes(&self) -> u64 {
        self.count(is::VALID)
    }

    /// Collisions.
    pub fn collisions(&self) -> u64 {
        self.count(is::COLLISION)
    }

    fn count(&self, flag: u8) -> u64 {
        is::ALL.iter().zip(self.counts).find(|(known, _)| **known == flag).map_or(0, |(_, count)| count)
    }

    /// By how much what two runs have in common is more than what their kept episodes show: episodes to kept ones.
    pub fn stretch(&self, other: &Self) -> f64 {
        let kept = self.flags.len().min(other.flags.len());
        self.size.min(other.size) as f64 / kept.max(1) as f64
    }

    /// Pairs of equal beginnings, of those kept, in which only this one collided, or had another rate's event, and in which only the
    /// other did.
    pub fn discordant(&self, other: &Self, figure: Figure) -> (u64, u64) {
        let flag = part(figure);
        let both = self.flags.iter().zip(&other.flags).filter(|(a, b)| **a & **b & is::VALID != 0);
        both.fold((0, 0), |(only, others), (a, b)| match (a & flag != 0, b & flag != 0) {
            (true, false) => (only + 1, others),
            (false, true) => (only, others + 1),
            _ => (only, others),
        })
    }

    /// A figure, and by how much each episode that is kept moves it away from its mean; none when it has no value.
    pub fn influence(&self, figure: Figure) -> Option<(f64, Vec<f64>)> {
        let (whole, flag) = (if figure == Figure::Front { is::COLLISION } else { is::VALID }, part(figure));
        let count = self.count(whole) as f64;
        if count == 0.0 {
            return None;
        }
        let value = |episode: usize| match figure {
            Figure::Reward => self.rewards[episode],
            _ => f64::from(u8::from(self.flags[episode] & flag != 0)),
        };
        let counts = |episode: &usize| self.flags[*episode] & whole != 0;
        let sum = if figure == Figure::Reward { self.reward } else { self.count(flag) as f64 };
        let mean = sum / count;
        let pull = |episode| if counts(&episode) { (value(episode) - mean) / count } else { 0.0 };
        Some((mean, (0..self.flags.len()).map(pull).collect()))
    }
}

/// The flag of the episodes that count for a rate.
fn part(figure: Figure) -> u8 {
    match figure {
        Figure::Collision | Figure::Reward => is::COLLISION,
        Figure::Front => is::FRONT,
        Figure::Moving => is::MOVING,
        Figure::Preventable => is::PREVENTABLE,
    }
}
