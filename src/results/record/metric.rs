//! The metrics that runs and cells have of the columns of episodes.

use polars::prelude::DataType;

use super::episodes::named;
use super::{Column, ColumnReference, Entry, Family, Role, columns};
use world::env::LeftOut;
use world::judge::Label;

/// A number that is calculated from the episodes of a run and from the runs of a cell. It is a column of the table of runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Metric {
    /// A number of episodes; a cell has the sum over its runs.
    Count(Count),
    /// A mean over episodes; a cell has mean and standard deviation over its runs.
    Mean(Mean),
    /// A ratio of two counts; a cell has mean and standard deviation over its runs, and the interval of the sums.
    Rate(Rate),
}

/// All metrics, in the order of their tables. A new metric is one entry here.
pub fn metrics() -> Vec<Metric> {
    use Metric::{Count, Mean, Rate};
    let mut all = vec![
        Count(EPISODES),
        Count(ERRORS),
        Count(COLLISIONS),
        Count(TOUCHES),
        Count(FRONT_TOUCHES),
        Rate(COLLISION_RATE),
        Rate(TOUCH_RATE),
        Rate(FRONT_RATE),
        Mean(EPISODE_REWARD),
        Mean(EPISODE_LENGTH),
        Mean(IMPACT_SPEED),
        Count(FORESEEABLE_COLLISIONS),
    ];
    all.extend(Label::ALL.map(|label| Count(labelled(label))));
    all.extend([
        Count(FAULT_COLLISIONS),
        Count(WALKED_INTO_COLLISIONS),
        Rate(PREVENTABLE_RATE),
        Rate(PREVENTABLE_SHARE),
        Rate(FAULT_RATE),
        Mean(EXPECTED_PREVENTABLE),
        Count(PLACED_STARTS),
        Rate(PLACED_RATE),
        Mean(AVOIDABLE_INJURY),
        Count(ALL_EPISODES),
        Count(LEFT_OUT_EPISODES),
        Rate(LEFT_OUT_RATE),
        Count(ROAD_END_EPISODES),
        Count(LEFT_ROAD_EPISODES),
        Rate(LEFT_ROAD_RATE),
        Mean(LEFT_LANE),
    ]);
    all
}

/// A number of episodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Count {
    /// The column.
    pub name: &'static str,
    doc: &'static str,
    /// Which episodes count.
    pub which: Which,
}

/// Which episodes a number is of. Only those that count are meant where nothing else is said.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Which {
    /// Those that count: without error, and not left out.
    Valid,
    InError,
    LeftOut,
    /// Those that are left out for this reason.
    LeftOutFor(LeftOut),
    /// Those without error, also where they are left out.
    All,
    /// Those for which a column is true.
    True(&'static str),
    /// Those without error for which a column is true, also where they are left out.
    TrueOfAll(&'static str),
    /// Those with this verdict.
    Labelled(Label),
    /// Those that ended so.
    Ended(&'static str),
    /// Those that ended in a collision or a bump.
    Touched,
}

/// Over which episodes a mean is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// Those that count; a missing value counts as 0.
    Valid,
    /// Those without error that have a value, also where they are left out.
    All,
    /// Those that count and ended in a collision.
    Collisions,
}

/// A mean over episodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// The column.
    pub name: &'static str,
    /// The column of the table of episodes.
    pub column: &'static str,
    unit: &'static str,
    doc: &'static str,
    role: Role,
    /// The episodes that it is over.
    pub over: Over,
}

/// A ratio of two counts, missing where the denominator is 0, with Wilson's 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rate {
    /// The column.
    pub name: &'static str,
    /// The numerator.
    pub part: Count,
    /// The denominator.
    pub whole: Count,
    doc: &'static str,
}

impl Count {
    /// The number of these episodes, in a column of this name.
    pub const fn new(name: &'static str, which: Which, doc: &'static str) -> Self {
        Self { name, doc, which }
    }
}

impl Mean {
    /// The mean of a column over the episodes that count.
    pub const fn new(column: &Column<f64>, doc: &'static str) -> Self {
        Self { name: column.name, column: column.name, unit: column.unit, doc, role: column.role, over: Over::Valid }
    }

    /// The same mean, in a column of this name.
    pub const fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }
}

impl Rate {
    /// A ratio of two counts, in a column of this name.
    pub const fn new(name: &'static str, part: Count, whole: Count, doc: &'static str) -> Self {
        Self { name, part, whole, doc }
    }
}

impl Metric {
    /// Its column in the table of runs.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Count(count) => count.name,
            Self::Mean(mean) => mean.name,
            Self::Rate(rate) => rate.name,
        }
    }

    /// Whether it has no value without a touch.
    pub fn is_of_collisions(&self) -> bool {
        match self {
            Self::Count(_) => false,
            Self::Mean(mean) => mean.over == Over::Collisions,
            Self::Rate(rate) => !matches!(rate.whole.which, Which::Valid | Which::All),
        }
    }

    /// Its column in a table whose rows give its value.
    pub fn entry<'t, R>(&self, value: impl Fn(&R) -> Option<f64> + 't) -> Entry<'t, R> {
        let ColumnReference { name, unit, doc, role, figure, .. } = self.reference();
        let entry = match self {
            Self::Count(_) => Entry::new::<u32, _>(name, unit, doc, move |row| value(row).map(|count| count as u32)),
            _ => Entry::new::<f64, _>(name, unit, doc, value),
        };
        entry.of_figure(figure, role)
    }

    pub fn reference(&self) -> ColumnReference {
        let (unit, doc, holds, role) = match self {
            Self::Count(count) => ("", count.doc, DataType::UInt32, Role::Plain),
            Self::Mean(mean) => (mean.unit, mean.doc, DataType::Float64, mean.role),
            Self::Rate(rate) => ("", rate.doc, DataType::Float64, Role::Share),
        };
        let name = self.name();
        ColumnReference { name: name.into(), unit: unit.into(), doc: doc.into(), holds, role, figure: name.into() }
    }
}

pub const RUNS: Count = Count::new("runs", Which::Valid, "number of runs");
pub const EPISODES: Count = Count::new(
    "episodes",
    Which::Valid,
    "number of episodes that count; those in error and those that are left out (`left_out`) are missing here and in every rate and mean",
);
pub const ERRORS: Count = Count::new("errors", Which::InError, "number of episodes in error");
pub const COLLISIONS: Count =
    Count::new("collisions", Which::Ended(named::COLLISION), "number of collisions, in which the car moved");
pub const BUMPS: Count =
    Count::new("bumps", Which::Ended(named::BUMP), "number of bumps, in which a pedestrian touched the standing car");
pub const TOUCHES: Count = Count::new("touches", Which::Touched, "number of collisions and bumps");
pub const FRONT_TOUCHES: Count =
    Count::new("front_touches", Which::True(columns::FRONT.name), "number of collisions and bumps in the front sector");
pub const FORESEEABLE_COLLISIONS: Count = Count::new(
    "foreseeable_collisions",
    Which::True(columns::FORESEEABLE.name),
    "number of collisions with a foreseeable pedestrian",
);

pub const FAULT_COLLISIONS: Count =
    Count::new("fault_collisions", Which::True(columns::FAULT.name), "number of faults");
pub const AVOIDABLE_INJURY: Mean = Mean::new(
    &columns::AVOIDABLE_INJURY,
    "mean over episodes of the risk of a severe injury that a careful human would have spared; times 1,000 it is per 1,000 episodes",
);
pub const WALKED_INTO_COLLISIONS: Count = Count::new(
    "walked_into_collisions",
    Which::True(columns::WALKED_INTO.name),
    "number of collisions in which the pedestrian walked into the side or the rear",
);

pub const PLACED_STARTS: Count = Count::new(
    "placed_starts",
    Which::TrueOfAll(columns::PLACED.name),
    "number of starts that the driver did not reach in its run-up",
);
pub const ALL_EPISODES: Count = Count::new(
    "all_episodes",
    Which::All,
    "number of episodes without error; those that count, and those that are left out",
);
pub const LEFT_OUT_EPISODES: Count = Count::new(
    "left_out_episodes",
    Which::LeftOut,
    "number of episodes that are left out; the driver did not reach its start, its car left the road before it could see a pedestrian, or it drove past \
     the end of the road",
);
pub const ROAD_END_EPISODES: Count = Count::new(
    "road_end_episodes",
    Which::LeftOutFor(LeftOut::RoadEnd),
    "number of episodes that are left out since the car drove past the end of the road",
);
pub const LEFT_ROAD_EPISODES: Count = Count::new(
    "left_road_episodes",
    Which::TrueOfAll(columns::LEFT_ROAD.name),
    "number of episodes in which the centre of the car was outside all driving lanes; those that are left out included",
);
/// Number of collisions with a verdict.
pub const fn labelled(label: Label) -> Count {
    let name = match label {
        Label::Preventable => "preventable_collisions",
        Label::Contested => "contested_collisions",
        Label::MachinePreventable => "machine_preventable_collisions",
        Label::Unpreventable => "unpreventable_collisions",
        Label::Bump => return BUMPS,
    };
    Count::new(name, Which::Labelled(label), "number of collisions with that verdict")
}

pub const COLLISION_RATE: Rate = Rate::new(
    "collision_rate",
    COLLISIONS,
    EPISODES,
    "collisions of all *episodes*; bumps do not count (the paper's moving CR)",
);
pub const TOUCH_RATE: Rate =
    Rate::new("touch_rate", TOUCHES, EPISODES, "collisions and bumps of all *episodes* (the paper's CR)");
pub const FRONT_RATE: Rate = Rate::new(
    "front_rate",
    FRONT_TOUCHES,
    TOUCHES,
    "collisions and bumps in the front sector of *all of them* (the paper's front CR); missing without any",
);
pub const PREVENTABLE_RATE: Rate =
    Rate::new("preventable_rate", labelled(Label::Preventable), EPISODES, "preventable collisions of all *episodes*");
pub const PREVENTABLE_SHARE: Rate = Rate::new(
    "preventable_share",
    labelled(Label::Preventable),
    COLLISIONS,
    "preventable collisions of all *collisions*; missing without any collision",
);
pub const FAULT_RATE: Rate = Rate::new("fault_rate", FAULT_COLLISIONS, EPISODES, "faults of all *episodes*");
pub const PLACED_RATE: Rate = Rate::new(
    "placed_rate",
    PLACED_STARTS,
    ALL_EPISODES,
    "their share of `all_episodes`; near 1 it never drives to where the pedestrian is",
);
pub const LEFT_OUT_RATE: Rate =
    Rate::new("left_out_rate", LEFT_OUT_EPISODES, ALL_EPISODES, "their share of `all_episodes`");
pub const LEFT_ROAD_RATE: Rate = Rate::new(
    "left_road_rate",
    LEFT_ROAD_EPISODES,
    ALL_EPISODES,
    "their share of `all_episodes`; near 1 the driver does not follow its route",
);
pub const LEFT_LANE: Mean = Mean {
    over: Over::All,
    ..Mean::new(
        &columns::LEFT_LANE,
        "mean time of an episode in which the car was outside its lane, over `all_episodes`",
    )
};
pub const EXPECTED_PREVENTABLE: Mean = Mean::new(
    &columns::PREVENTABLE_PROBABILITY,
    "the expected rate of collisions that a driver drawn at random would have avoided, of all *episodes*",
)
.named("expected_preventable");
pub const EPISODE_REWARD: Mean = Mean::new(&columns::EPISODE_REWARD, "mean reward of an episode");
pub const EPISODE_LENGTH: Mean = Mean::new(&columns::EPISODE_LENGTH, "mean length of an episode");
pub const IMPACT_SPEED: Mean =
    Mean { over: Over::Collisions, ..Mean::new(&columns::IMPACT_SPEED, "mean speed of the car at a collision") };
pub const MEAN: Family<f64> = Family::new("_mean", "", "mean over the runs of the cell");
