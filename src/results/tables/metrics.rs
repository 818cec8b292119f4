//! The metrics of runs and cells. A new metric is one entry in [`METRICS`].

use polars::prelude::{DataType, Expr, col, lit};

use crate::record::episodes::named;
use crate::record::{Column, ColumnReference, Family, Role, columns};
use episode::LeftOut;
use verdict::{Label, RestsOn};

/// A number of the episodes of a run, and of the runs of a cell.
///
/// Without a `whole` it is a count: the sum of `part`, also over the runs of a cell. With one it is the sum of `part` divided by that count, missing where that is
/// 0; a cell has the mean over its runs. A share also has Wilson's 95 % interval of the sums.
#[derive(Debug, Clone, Copy)]
pub struct Metric {
    /// The column.
    pub name: &'static str,
    pub unit: &'static str,
    /// What it means, for `reports/README.md`.
    pub doc: &'static str,
    pub role: Role,
    /// What is summed over the rows of the table of episodes.
    pub part: fn() -> Expr,
    /// The count that it is a ratio to.
    pub whole: Option<&'static Metric>,
    /// The count that a share is a part of; `None` of other metrics. A share has Wilson's interval.
    pub counted: Option<&'static Metric>,
    /// What is inferred of it beyond the episodes of a cell.
    pub inference: Inference,
}

/// What is inferred of a metric from the runs of a cell and from cells with common starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Inference {
    #[default]
    None,
    /// Student's interval about further trainings.
    Trainings,
    /// The same, and comparisons of pedestrians, of drivers and of reports.
    Pairs,
}

/// Declares metrics, and the list of them if it is named first; the comment of each is its meaning.
macro_rules! metrics {
    (all $shown:vis $ALL:ident; $($(#[doc = $doc:literal])+ $visible:vis $NAME:ident = $made:expr;)*) => {
        /// The metrics, in the order of their tables.
        $shown const $ALL: [&Metric; [$(stringify!($NAME)),*].len()] = [$(&$NAME),*];
        $crate::tables::metrics::metrics! { $($(#[doc = $doc])+ $visible $NAME = $made;)* }
    };
    ($($(#[doc = $doc:literal])+ $visible:vis $NAME:ident = $made:expr;)*) => {
        $(
            $(#[doc = $doc])+
            $visible const $NAME: Metric = $made.meaning(concat!($($doc),+).trim_ascii());
        )*
    };
}
pub(super) use metrics;

/// Counts that metrics are ratios to, and that no table has.
pub(super) const HIDDEN: [&Metric; 1] = [&LANE_EPISODES];

pub(super) const fn count(name: &'static str, part: fn() -> Expr) -> Metric {
    Metric { name, unit: "", doc: "", role: Role::Plain, part, whole: None, counted: None, inference: Inference::None }
}

pub(super) const fn share(name: &'static str, part: &'static Metric, whole: &'static Metric) -> Metric {
    Metric { role: Role::Share, whole: Some(whole), counted: Some(part), ..count(name, part.part) }
}

/// The mean of a column over these episodes; a missing value counts as 0.
const fn mean(column: &Column<f64>, part: fn() -> Expr, whole: &'static Metric) -> Metric {
    Metric { unit: column.unit, role: column.role, whole: Some(whole), ..count(column.name, part) }
}

impl Metric {
    /// Whether it is a number of episodes.
    pub const fn is_count(&self) -> bool {
        self.whole.is_none()
    }

    /// The column of the sum of its part: that of a count is its value.
    pub(super) fn part_column(&self) -> String {
        if self.is_count() { self.name.into() } else { format!("{}_part", self.name) }
    }

    pub(super) const fn meaning(self, doc: &'static str) -> Self {
        Self { doc, ..self }
    }

    /// With a name other than that of its column.
    const fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// With more inferred of it.
    const fn inferring(self, inference: Inference) -> Self {
        Self { inference, ..self }
    }

    /// Whether it is a ratio of two counts, which has Wilson's interval.
    pub const fn is_share(&self) -> bool {
        self.counted.is_some()
    }

    /// Between what its values lie: a share from 0 to 1, what has a unit from 0 on.
    pub const fn bounds(&self) -> (f64, f64) {
        match self.counted {
            Some(_) => (0.0, 1.0),
            None if self.unit.is_empty() => (f64::NEG_INFINITY, f64::INFINITY),
            None => (0.0, f64::INFINITY),
        }
    }

    /// What it is a rate or a mean of, for people: `fault` of `fault_rate`, `reward` of `episode_reward`.
    pub fn word(&self) -> &'static str {
        self.name.trim_end_matches("_rate").trim_start_matches("episode_")
    }

    /// Whether it has no value without a touch.
    pub fn is_of_collisions(&self) -> bool {
        self.whole.is_some_and(|whole| [COLLISIONS.name, TOUCHES.name].contains(&whole.name))
    }

    pub fn reference(&self) -> ColumnReference {
        let holds = if self.is_count() { DataType::UInt32 } else { DataType::Float64 };
        let Self { name, unit, doc, role, .. } = *self;
        ColumnReference { name: name.into(), unit: unit.into(), doc: doc.into(), holds, role, figure: name.into() }
    }
}

impl PartialEq for Metric {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Metric {}

/// The metrics with intervals about further trainings, in the order of [`METRICS`].
pub fn inferred() -> impl Iterator<Item = &'static Metric> {
    METRICS.into_iter().filter(|metric| metric.inference != Inference::None)
}

/// The metrics in which pedestrians, drivers and reports are compared.
pub fn compared() -> impl DoubleEndedIterator<Item = &'static Metric> {
    METRICS.into_iter().filter(|metric| metric.inference == Inference::Pairs)
}

/// What the charts of a training draw: the reward, then shares.
pub const LEARNT: [&Metric; 3] = [&EPISODE_REWARD, &COLLISION_RATE, &FAULT_RATE];

/// The metrics of an overview: those that are compared, the last first, and those of the paper.
pub fn pooled() -> impl Iterator<Item = &'static Metric> {
    compared().rev().chain([&TOUCH_RATE, &EPISODE_REWARD])
}

/// Episodes without error.
fn ran() -> Expr {
    col(columns::OUTCOME.name).neq(lit(named::ERROR))
}

/// Those that count: without error, and not left out.
fn counts() -> Expr {
    ran().and(col(columns::LEFT_OUT.name).eq(lit("")))
}

fn ended(outcome: &'static str) -> Expr {
    counts().and(col(columns::OUTCOME.name).eq(lit(outcome)))
}

fn collided() -> Expr {
    ended(named::COLLISION)
}

fn labelled(label: Label) -> Expr {
    counts().and(col(columns::VERDICT.name).eq(lit(label.name())))
}

fn resting(on: RestsOn) -> Expr {
    counts().and(is(&columns::FAULT)).and(col(columns::RESTS_ON.name).eq(lit(on.name())))
}

fn is(column: &Column<bool>) -> Expr {
    col(column.name).fill_null(lit(false))
}

/// The values of a column in these episodes; 0 elsewhere.
fn of(episodes: Expr, column: &Column<f64>) -> Expr {
    polars::prelude::when(episodes).then(col(column.name)).otherwise(lit(0.0))
}

metrics! {
    all pub METRICS;
    /// number of episodes that count; those in error and those that are left out (`left_out`) are missing here and in every rate and mean
    pub EPISODES = count("episodes", counts);
    /// number of episodes in error
    pub ERRORS = count("errors", || ran().not());
    /// number of collisions, in which the car moved
    pub COLLISIONS = count("collisions", collided);
    /// number of collisions and bumps
    pub TOUCHES = count("touches", || collided().or(ended(named::BUMP)));
    /// number of collisions and bumps in the front sector
    pub FRONT_TOUCHES = count("front_touches", || counts().and(is(&columns::FRONT)));
    /// collisions of all *episodes*; bumps do not count (the paper's moving CR)
    pub COLLISION_RATE = share("collision_rate", &COLLISIONS, &EPISODES).inferring(Inference::Pairs);
    /// collisions and bumps of all *episodes* (the paper's CR)
    pub TOUCH_RATE = share("touch_rate", &TOUCHES, &EPISODES).inferring(Inference::Trainings);
    /// collisions and bumps in the front sector of *all of them* (the paper's front CR); missing without any
    pub FRONT_RATE = share("front_rate", &FRONT_TOUCHES, &TOUCHES).inferring(Inference::Trainings);
    /// mean reward of an episode
    pub EPISODE_REWARD = mean(&columns::EPISODE_REWARD, || of(counts(), &columns::EPISODE_REWARD), &EPISODES).inferring(Inference::Trainings);
    /// mean length of an episode
    pub EPISODE_LENGTH = mean(&columns::EPISODE_LENGTH, || of(counts(), &columns::EPISODE_LENGTH), &EPISODES).inferring(Inference::Trainings);
    /// mean speed of the car at a collision
    pub IMPACT_SPEED = mean(&columns::IMPACT_SPEED, || of(collided(), &columns::IMPACT_SPEED), &COLLISIONS).inferring(Inference::Trainings);
    /// number of collisions with a foreseeable pedestrian
    pub FORESEEABLE_COLLISIONS = count("foreseeable_collisions", || counts().and(is(&columns::FORESEEABLE)));
    /// number of collisions with that verdict
    pub PREVENTABLE_COLLISIONS = count("preventable_collisions", || labelled(Label::Preventable));
    /// number of collisions with that verdict
    pub CONTESTED_COLLISIONS = count("contested_collisions", || labelled(Label::Contested));
    /// number of collisions with that verdict
    pub MACHINE_PREVENTABLE_COLLISIONS = count("machine_preventable_collisions", || labelled(Label::MachinePreventable));
    /// number of collisions with that verdict
    pub UNPREVENTABLE_COLLISIONS = count("unpreventable_collisions", || labelled(Label::Unpreventable));
    /// number of bumps, in which a pedestrian touched the standing car
    pub BUMPS = count("bumps", || ended(named::BUMP));
    /// number of faults
    pub FAULT_COLLISIONS = count("fault_collisions", || counts().and(is(&columns::FAULT)));
    /// number of faults whose `rests_on` is that
    ANTICIPATION_FAULTS = count("anticipation_faults", || resting(RestsOn::Anticipation));
    /// number of faults whose `rests_on` is that
    EARLY_GATE_FAULTS = count("early_gate_faults", || resting(RestsOn::EarlyGate));
    /// number of faults whose `rests_on` is that
    BOTH_FAULTS = count("both_faults", || resting(RestsOn::Both));
    /// number of faults whose `rests_on` is that
    NEITHER_FAULTS = count("neither_faults", || resting(RestsOn::Neither));
    /// number of collisions in which the pedestrian walked into the side or the rear
    pub WALKED_INTO_COLLISIONS = count("walked_into_collisions", || counts().and(is(&columns::WALKED_INTO)));
    /// preventable collisions of all *episodes*
    pub PREVENTABLE_RATE = share("preventable_rate", &PREVENTABLE_COLLISIONS, &EPISODES).inferring(Inference::Pairs);
    /// preventable collisions of all *collisions*; missing without any collision
    pub PREVENTABLE_SHARE = share("preventable_share", &PREVENTABLE_COLLISIONS, &COLLISIONS);
    /// faults of all *episodes*
    pub FAULT_RATE = share("fault_rate", &FAULT_COLLISIONS, &EPISODES).inferring(Inference::Pairs);
    /// the expected rate of collisions that a driver drawn at random would have avoided, of all *episodes*
    pub EXPECTED_PREVENTABLE = mean(&columns::PREVENTABLE_PROBABILITY, || of(counts(), &columns::PREVENTABLE_PROBABILITY), &EPISODES).named("expected_preventable");
    /// number of starts that the driver did not reach in its run-up
    pub PLACED_STARTS = count("placed_starts", || ran().and(is(&columns::PLACED)));
    /// their share of `all_episodes`; near 1 it never drives to where the pedestrian is
    pub PLACED_RATE = share("placed_rate", &PLACED_STARTS, &ALL_EPISODES);
    /// mean over episodes of the risk of a severe injury that a careful human would have spared; times 1,000 it is per 1,000 episodes
    pub AVOIDABLE_INJURY = mean(&columns::AVOIDABLE_INJURY, || of(counts(), &columns::AVOIDABLE_INJURY), &EPISODES);
    /// number of episodes without error; those that count, and those that are left out
    pub ALL_EPISODES = count("all_episodes", ran);
    /// number of episodes that are left out; the driver did not reach its start, its car left the road before it could see a pedestrian, or it drove past the
    /// end of the road
    pub LEFT_OUT_EPISODES = count("left_out_episodes", || ran().and(counts().not()));
    /// their share of `all_episodes`
    pub LEFT_OUT_RATE = share("left_out_rate", &LEFT_OUT_EPISODES, &ALL_EPISODES);
    /// number of episodes that are left out since the car drove past the end of the road
    pub ROAD_END_EPISODES = count("road_end_episodes", || ran().and(col(columns::LEFT_OUT.name).eq(lit(LeftOut::RoadEnd.name()))));
    /// number of episodes in which the centre of the car was outside all driving lanes; those that are left out included
    pub LEFT_ROAD_EPISODES = count("left_road_episodes", || ran().and(is(&columns::LEFT_ROAD)));
    /// their share of `all_episodes`; near 1 the driver does not follow its route
    pub LEFT_ROAD_RATE = share("left_road_rate", &LEFT_ROAD_EPISODES, &ALL_EPISODES);
    /// mean time of an episode in which the car was outside its lane, over `all_episodes`
    pub LEFT_LANE = mean(&columns::LEFT_LANE, || of(ran(), &columns::LEFT_LANE), &LANE_EPISODES);
}

metrics! {
    /// number of episodes without error in which the car was on a road with lanes, also where they are left out
    LANE_EPISODES = count("lane_episodes", || ran().and(col(columns::LEFT_LANE.name).is_not_null()));
}

/// The counts of faults by what they rest on, in the order of [`RestsOn::ALL`].
pub const RESTING: [&Metric; 4] = [&ANTICIPATION_FAULTS, &EARLY_GATE_FAULTS, &BOTH_FAULTS, &NEITHER_FAULTS];

/// What the answer of a comparison weighs, with the plural of what a rate is of; searches count with the first.
pub const ANSWER: [(&Metric, &str); 3] = [
    (&FAULT_RATE, "faults"),
    (&COLLISION_RATE, "collisions"),
    (&IMPACT_SPEED, "collisions that are worse than on the other side"),
];

/// The number of runs of a cell.
pub const RUNS: Column<u32> = Column::new("runs", "", "number of runs");
pub const MEAN: Family<f64> = Family::new("_mean", "", "mean over the runs of the cell");

/// The counts of touches with each verdict, in the order of [`Label::ALL`].
pub const LABELLED: [&Metric; Label::COUNT] = [
    &PREVENTABLE_COLLISIONS,
    &CONTESTED_COLLISIONS,
    &MACHINE_PREVENTABLE_COLLISIONS,
    &UNPREVENTABLE_COLLISIONS,
    &BUMPS,
];
