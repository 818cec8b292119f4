use std::fmt;

use compile::{Evaluation, HERE, NO_REWARD, RunId, UNTRAINED};

/// The key of a cell of results: a controller and its training, the place of the episodes, and the driver under test.
///
/// The runs of a cell differ only in their number.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct CellKey {
    /// Number of the `evaluate` block, from 0.
    pub block: u32,
    pub town: String,
    /// Name of the driver.
    pub policy: String,
    pub vehicle: String,
    /// Name of the adversary, for its body.
    pub adversary: String,
    /// Name of the simulator in which the car drives; `here` for that of this program.
    pub world: String,
    /// The controller: `trained`, `stochastic`, `untrained`, `random`, `homing`, `intercept`, `scripted`, or the name of a declared one.
    pub controller: String,
    pub reward: String,
    /// Town of the training; empty for an untrained controller.
    pub train_town: String,
    /// Driving policy of the training; empty for an untrained controller.
    pub train_policy: String,
}

/// A town, and the simulator if it is another one; a search names none.
pub fn in_world(town: &str, world: &str) -> String {
    if ["", HERE].contains(&world) { town.into() } else { format!("{town} ({world})") }
}

/// `, evaluate 2` of the second block of a kind, which has number 1; nothing of the first.
pub fn in_block(kind: &str, number: u32) -> String {
    if number == 0 { String::new() } else { format!(", {kind} {}", number + 1) }
}

impl CellKey {
    /// The key of an evaluation's cell.
    pub fn of(evaluation: &Evaluation) -> Self {
        let trained = &evaluation.trained;
        Self {
            block: evaluation.origin.block,
            town: evaluation.town.to_string(),
            policy: evaluation.policy.to_string(),
            vehicle: evaluation.vehicle.to_string(),
            adversary: evaluation.adversary.to_string(),
            world: evaluation.world.to_string(),
            controller: evaluation.controller.name().to_string(),
            reward: trained.reward.clone(),
            train_town: trained.town.clone(),
            train_policy: trained.policy.clone(),
        }
    }

    /// The simulator in which the car drives; `here` in a search, which names none.
    pub fn simulator(&self) -> &str {
        if self.world.is_empty() { HERE } else { &self.world }
    }

    /// Whether that is another one.
    pub fn is_elsewhere(&self) -> bool {
        self.simulator() != HERE
    }

    /// `harbour`, or `harbour (metadrive)` in another simulator.
    pub fn place(&self) -> String {
        in_world(&self.town, &self.world)
    }

    /// Whether the controller comes from a training.
    pub fn is_trained(&self) -> bool {
        !self.train_town.is_empty()
    }

    /// Whether its reward distinguishes it: a trained controller, and the networks with which a training for the reward begins. Other
    /// controllers are the same for all rewards.
    pub fn is_of_reward(&self) -> bool {
        self.is_trained() || self.controller == UNTRAINED
    }

    /// Whether the controller was trained in this town against this driver.
    pub fn is_at_home(&self) -> bool {
        (&self.town, &self.policy) == (&self.train_town, &self.train_policy)
    }

    /// Whether another cell has the same place: the same block, town, vehicle, adversary and world. Cells of one place share their starts,
    /// whatever their drivers and pedestrians are.
    pub fn is_beside(&self, other: &Self) -> bool {
        let own = (self.block, &self.town, &self.vehicle, &self.adversary, &self.world);
        own == (other.block, &other.town, &other.vehicle, &other.adversary, &other.world)
    }

    /// Whether another cell has the same controller: with the same reward and training.
    pub fn has_controller_of(&self, other: &Self) -> bool {
        (&self.controller, &self.reward, &self.train_town, &self.train_policy)
            == (&other.controller, &other.reward, &other.train_town, &other.train_policy)
    }

    /// The controller with its reward and its training, as `trained r1 (harbour, idm)`; the controller alone where no reward is paid.
    pub fn who(&self) -> String {
        let Self { controller, reward, train_town, train_policy, .. } = self;
        match reward.as_str() {
            _ if self.is_trained() => format!("{controller} {reward} ({train_town}, {train_policy})"),
            NO_REWARD => controller.clone(),
            _ => format!("{controller} {reward}"),
        }
    }

    /// The full key in words: controller, town and driver, then vehicle, adversary, and which `evaluate` block if it is not the first.
    pub fn in_full(&self) -> String {
        format!("{self}, {}, {}{}", self.vehicle, self.adversary, in_block("evaluate", self.block))
    }
}

/// `trained r1 (harbour, idm) in village against idm`, and in which simulator if it is another one.
impl fmt::Display for CellKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} in {} against {}", self.who(), self.town, self.policy)?;
        if self.is_elsewhere() { write!(f, " in {}", self.world) } else { Ok(()) }
    }
}

/// The key of a run: its cell and its number.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct RunKey {
    /// The short name.
    pub id: RunId,
    pub cell: CellKey,
    /// Number of the run, from 0.
    pub run: u32,
}

impl RunKey {
    /// What it shares with runs that walk the same for other rewards: an untrained pedestrian is evaluated for each reward of a campaign, and counts once.
    pub fn of_any_reward(&self) -> (CellKey, u32) {
        let reward = if self.cell.is_of_reward() { self.cell.reward.clone() } else { String::new() };
        (CellKey { reward, ..self.cell.clone() }, self.run)
    }

    /// The key of an evaluation.
    pub fn of(evaluation: &Evaluation) -> Self {
        Self { id: evaluation.origin.id, cell: CellKey::of(evaluation), run: evaluation.trained.run }
    }
}

/// The cell, and `, run 0`.
impl fmt::Display for RunKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, run {}", self.cell, self.run)
    }
}
