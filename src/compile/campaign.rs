use base::signature::{DeclarationId, Form, Keys, Value};
use base::{choice, keys};
use world::env::StartParameter;
use world::judge::Blame;

choice! {
    /// What a pedestrian is trained for at once.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Together {
        Policies = "policies",
        Towns = "towns",
        All = "all",
    }
}

keys! {
    /// What is run: which pedestrians are trained, where they are evaluated, and which falsifiers are compared.
    pub struct CampaignKeys = "campaign" {
        /// The model of car under test.
        vehicle: DeclarationId as Reference("vehicle"),
        /// The pedestrian.
        adversary: DeclarationId as Reference("adversary"),
        /// Where episodes begin.
        spawn: DeclarationId as Reference("spawn"),
        /// How long they last.
        episode: DeclarationId as Reference("episode"),
        /// What is required of episodes beside no collision: each has a rate, and its violations are failures. Without the key a collision is the only
        /// failure.
        requirements: Option<Vec<DeclarationId>> as Reference("requirement"),
        /// How pedestrians are trained, where any are.
        training: Option<DeclarationId> as Reference("training"),
        /// Published figures to stand beside those of this campaign.
        beside: Option<Vec<DeclarationId>> as Reference("published"),
    }
}

keys! {
    /// Where the episodes of a block happen, and against which drivers.
    pub struct PlaceKeys {
        /// Towns.
        towns: Vec<DeclarationId> as Reference("town"),
        /// Drivers.
        policies: Vec<DeclarationId> as Reference("policy"),
    }
}

keys! {
    /// How the episodes of a block begin.
    pub struct StartKeys {
        /// Where these episodes begin, instead of the campaign's `spawn`.
        spawn: Option<DeclarationId> as Reference("spawn"),
    }
}

keys! {
    /// Trains one pedestrian for every town, policy, reward and run.
    pub struct TrainKeys = "train" {
        ..places: PlaceKeys,
        /// Rewards to train for.
        rewards: Vec<DeclarationId> as Reference("reward"),
        /// Trainings of each, with different seeds.
        runs: u32 as whole(1, 10_000) = "5",
        /// Trains one pedestrian against all `policies`, in all `towns`, or both, whose episodes alternate; without it each
        /// pair of town and driver has a pedestrian of its own.
        together: Option<Together>,
        ..start: StartKeys,
    }
    .explained("towns", "Towns to train in.")
    .explained("policies", "Drivers to train against.")
}

keys! {
    /// Trains a car to drive, by the campaign's `training`, in all towns together, among pedestrians and other cars. The report gets its network as
    /// `drivers/NAME.onnx`, which `onnx` drives with.
    pub struct DriveKeys = "drive" {
        /// Towns to drive in.
        towns: Vec<DeclarationId> as Reference("town"),
        /// The driver that it imitates before it learns by itself; the other cars have it, too.
        imitates: DeclarationId as Reference("policy"),
        /// Decisions in which it imitates; 0 for none. The more the better; a million needs 0.4 GB of memory.
        demonstrations: u32 as whole(0, 10_000_000) = "200_000",
        /// Ticks for which an action is kept while it learns by itself, so that its attempts differ; as a driver it chooses anew in every tick.
        hold: u32 as whole(1, 100) = "4",
        // The catalogue adds the words.
        /// Who walks, in turns, as in `evaluate`: words, or `controller`s of the file, such as networks that attack it.
        pedestrians: Vec<Value> as WordOrReference(Vec::new(), "controller") = "[natural]",
        /// Other cars in each town.
        cars: usize as whole(0, 100) = "3",
        /// Reward a second of driving at the limit along the route; less for less, and for more than the limit.
        progress: f64 as within(RATIO, 0.0, 1e6) = "0.1",
        /// Cost a second of full discomfort: jerk, lateral acceleration, hard braking and turns of the wheel.
        comfort: f64 as within(RATIO, 0.0, 1e6) = "0.1",
        /// Cost a second of a metre beside the route or more.
        lane: f64 as within(RATIO, 0.0, 1e6) = "0.05",
        /// Cost a second of standing without a road user or a light ahead.
        standing: f64 as within(RATIO, 0.0, 1e6) = "0.03",
        /// Cost of a red light that is passed.
        red_light: f64 as within(RATIO, 0.0, 1e6) = "3",
        /// Cost of a collision at low speed, twice as much at 10 m/s; and of leaving the route.
        collision: f64 as within(RATIO, 0.0, 1e6) = "5",
        /// Trainings, with different seeds.
        runs: u32 as whole(1, 10_000) = "1",
        ..start: StartKeys,
    }
}

keys! {
    /// Tries every pedestrian in every town against every policy.
    pub struct EvaluateKeys = "evaluate" {
        ..places: PlaceKeys,
        /// Episodes of each; all pedestrians have the same starts.
        episodes: u32 as whole(1, 1_000_000) = "1_000",
        // The catalogue adds the words of the others.
        /// Which pedestrians walk: trained ones with the mean action of their policy (`trained`) or drawing from it as in
        /// training (`stochastic`), the same network before its training (`untrained`), one that acts at random, one that walks straight at the ego (`homing`), one that walks to where it
        /// would meet the ego (`intercept`), one that crosses as recorded pedestrians do (`natural`), the target of a test
        /// (`scripted`), or a `controller` of the file. Only the first three need a `train` block.
        pedestrians: Vec<Value> as WordOrReference(vec![TRAINED, STOCHASTIC, UNTRAINED], "controller") = "[trained, random]",
        /// Models of car to try them against, instead of the campaign's `vehicle`.
        vehicles: Option<Vec<DeclarationId>> as Reference("vehicle"),
        /// Bodies and readings to try them with, instead of the campaign's `adversary`.
        adversaries: Option<Vec<DeclarationId>> as Reference("adversary"),
        ..start: StartKeys,
    }
    .explained("towns", "Towns to try them in.")
    .explained("policies", "Drivers to try them against.")
}

keys! {
    /// Lets falsifiers look for failures, each with the same budget and the same starts.
    pub struct SearchKeys = "search" {
        ..places: PlaceKeys,
        /// Who searches.
        falsifiers: Vec<DeclarationId> as Reference("falsifier"),
        /// Simulator ticks that each may use.
        budget: u64 as ticks(1, 1_000_000_000_000) = "1_000_000",
        /// The requirement that the searches try to violate, instead of a collision. It takes the place of their rewards: an episode earns more the
        /// less robust it is, and more than 1 for a violation.
        goal: Option<DeclarationId> as Reference("requirement"),
        /// Searches of each, with different seeds and starts.
        runs: u32 as whole(1, 10_000) = "10",
        /// Episodes in which the pedestrian that a falsifier returns is evaluated afterwards, outside the budget.
        episodes: u32 as whole(0, 1_000_000) = "200",
        /// The pedestrian, instead of the campaign's `adversary`.
        adversary: Option<DeclarationId> as Reference("adversary"),
        ..start: StartKeys,
    }
    .explained("towns", "Towns to search in.")
    .explained("policies", "Drivers to find failures of.")
}

keys! {
    /// Estimates how likely failures are in an encounter with a pedestrian that walks as people do.
    pub struct EstimateKeys = "estimate" {
        ..places: PlaceKeys,
        /// Who walks, each by itself: pedestrians that learn nothing, such as `natural`, or a `controller` of the file. The probability is that of an encounter with
        /// this pedestrian, from a start that the `spawn` draws.
        pedestrians: Vec<Value> as WordOrReference(Vec::new(), "controller") = "[natural]",
        /// The requirement whose violations are estimated, instead of collisions.
        requirement: Option<DeclarationId> as Reference("requirement"),
        /// What the `relative_error` is about: any failure, one that a careful human would have avoided, or a fault. All three are estimated.
        event: Blame = "fault",
        /// Standard error, as a share of the probability, at which it ends.
        relative_error: f64 as within(RATIO, 0.001, 1.0) = "0.1",
        /// Simulator ticks after which it ends; a batch that has begun is finished.
        budget: u64 as ticks(1, 1_000_000_000_000) = "20_000_000",
        /// Estimates of each, with different seeds.
        runs: u32 as whole(1, 10_000) = "1",
        /// Encounters per hour of driving, if you know them: then failures per hour are stated.
        encounters_per_hour: Option<f64> as within(RATIO, 0.0, 1_000_000.0),
        /// Encounters per 1,000 km, if you know them: then failures per 1,000 km are stated.
        encounters_per_1000_km: Option<f64> as within(RATIO, 0.0, 1_000_000_000.0),
        /// The pedestrian, instead of the campaign's `adversary`.
        adversary: Option<DeclarationId> as Reference("adversary"),
        ..start: StartKeys,
    }
    .explained("towns", "Towns in which they meet.")
    .explained("policies", "Drivers whose failures are estimated.")
}

keys! {
    /// Shows with 95 % confidence how little of a box of starts can fail where its picture says that they pass. The box are the ranges of the spawn
    /// rule, and for the target of a test also the speeds and headings of the adversary. Places on the road and all else that is drawn are chance.
    pub struct CoverKeys = "cover" {
        ..places: PlaceKeys,
        // The catalogue adds the words.
        /// Who walks, as in `evaluate`: a word, or a `controller` of the file. The target of a test walks as the point of the box says.
        pedestrian: Value as WordOrReference(Vec::new(), "controller") = "natural",
        /// What counts: a `fault`, any `collision`, or the violation of a requirement.
        failure: Value as WordOrReference(vec![FAULT, COLLISION], "requirement") = "fault",
        /// The share of the box that is small enough: it ends when the bound is not above it.
        epsilon: f64 as within(RATIO, 0.000_1, 0.5) = "1 percent",
        /// Episodes that it may use at most.
        budget: u32 as whole(20, 10_000_000) = "20_000",
        /// One or two parameters in which the page draws pass and fail, instead of the first two of the box.
        picture: Option<Vec<StartParameter>>,
        /// The pedestrian, instead of the campaign's `adversary`.
        adversary: Option<DeclarationId> as Reference("adversary"),
        ..start: StartKeys,
    }
    .explained("towns", "Towns to cover.")
    .explained("policies", "Drivers to cover.")
}

keys! {
    /// Makes a driver with fewer faults: falsifiers attack it in some towns, then its keys are searched, round after round. At the end the driver as it was
    /// and as it has become meet other pedestrians in other towns. Keys are varied between their values in `from` and in `to`.
    pub struct HardenKeys = "harden" {
        /// Towns of the rounds.
        towns: Vec<DeclarationId> as Reference("town"),
        /// The driver.
        policy: DeclarationId as Reference("policy"),
        /// The same kind with one end of the range of each key that may be varied, such as `idm(time_headway: 1 s)`. Of an `external` driver the
        /// numbers at the ends of the words of its `command` may differ.
        from: DeclarationId as Reference("policy"),
        /// The same kind with the other ends.
        to: DeclarationId as Reference("policy"),
        /// Who attacks.
        falsifiers: Vec<DeclarationId> as Reference("falsifier"),
        /// Simulator ticks of each attack: of each falsifier in each town, in each round.
        budget: u64 as ticks(1, 1_000_000_000_000) = "200_000",
        /// Rounds of attack and repair.
        rounds: u32 as whole(1, 100) = "3",
        /// Values of the keys that a repair tries out.
        candidates: u32 as whole(2, 10_000) = "40",
        /// Episodes in which each of them meets each pedestrian that an attack ended up with, beside the failures themselves.
        lessons: u32 as whole(0, 100_000) = "20",
        /// Natural encounters in each town in which each of them shows its progress and its comfort.
        traffic: u32 as whole(1, 100_000) = "50",
        /// Share of the mean speed in natural encounters that a repair may cost.
        progress: f64 as share() = "5 percent",
        /// What the share of natural encounters with hard braking may rise by.
        comfort: f64 as share() = "5 percent",
        /// Deceleration over half a second above which braking is hard.
        hard_braking: f64 as positive(ACCELERATION) = "4 m/s^2",
        /// Towns of the test, in which nothing is repaired.
        test_towns: Vec<DeclarationId> as Reference("town"),
        // The catalogue adds the words.
        /// Who walks in the test, as in `evaluate`: words, or a `controller` of the file.
        pedestrians: Vec<Value> as WordOrReference(Vec::new(), "controller") = "[intercept]",
        /// Who searches in the test, with the same `budget` before and after.
        rivals: Option<Vec<DeclarationId>> as Reference("falsifier"),
        /// Episodes of the test for each town and pedestrian, and natural ones for each town.
        episodes: u32 as whole(1, 1_000_000) = "500",
        /// Repairs of it, with different seeds.
        runs: u32 as whole(1, 10_000) = "3",
        /// The pedestrian, instead of the campaign's `adversary`.
        adversary: Option<DeclarationId> as Reference("adversary"),
        ..start: StartKeys,
    }
}

keys! {
    /// Runs the campaign once for every combination of values: `name: [value, …]`, each the name of a `param`.
    struct MatrixKeys = "matrix" {}
}

/// Takes the place of a reward's name in a training of a driver.
pub const DRIVE: &str = "drive";
/// The words of trained pedestrians.
pub(super) const TRAINED: &str = "trained";
pub(super) const STOCHASTIC: &str = "stochastic";
/// The words of what a `cover` counts.
pub(super) const FAULT: &str = "fault";
pub(super) const COLLISION: &str = "collision";
/// The word of the networks with which trainings begin.
pub const UNTRAINED: &str = "untrained";

/// The form `campaign`.
pub fn form() -> Form {
    let jobs = super::grid::BLOCKS.iter().map(|block| (block.signature)());
    let blocks = std::iter::once(MatrixKeys::signature()).chain(jobs).collect();
    Form { multiplies: true, ..Form::plain(CampaignKeys::signature().holding(blocks)) }
}
