use polars::prelude::{Column as Values, DataFrame, PolarsResult};

use super::{CellEvidence, Comparison, Figure, Quantiles, Transfer};
use crate::record::columns::{
    ADVERSARY, BLOCK, CONTROLLER, IMPACT_SPEED, MIN_TTC, PET, REWARD, TRAIN_POLICY, TRAIN_TOWN, VEHICLE,
};
use crate::record::{Column, Entry, Family, Interval, Table, cell_key};
use crate::report::aggregate::CELLS;
use base::statistics::wilson;
use world::judge::Reference;

const OTHER_CONTROLLER: Column<String> =
    Column::new("other_controller", "", "controller of the cell that is subtracted");
const OTHER_POLICY: Column<String> = Column::new(
    "other_policy",
    "",
    "driving policy of that cell: another one than `policy` where drivers are compared",
);
const OTHER_REWARD: Column<String> = Column::new("other_reward", "", "reward of that cell");
const FIGURE: Column<String> =
    Column::new("figure", "", "`collision_rate`, `moving_rate`, `preventable_rate` or `fault_rate`: what is compared");
const VALUE: Column<f64> = Column::new("value", "", "mean over the runs of the cell");
const OTHER_VALUE: Column<f64> = Column::new("other_value", "", "mean over the runs of the other cell");
const DIFFERENCE: Column<f64> = Column::new("difference", "", "`value` less `other_value`");
const DIFFERENCE_STUDENT: Interval = Interval::new(
    "difference_student",
    "",
    "Student's interval with Welch's degrees of freedom; its variance is that between the trainings of either cell plus that of the \
     common episodes (at least that of one episode). Missing if one side is a single training, or has two or three runs",
);
const P_HOLM: Column<f64> = Column::new(
    "p_holm",
    "",
    "`p` adjusted for all tests of its kind in the table by Holm's method, so that in 95 % of campaigns no finding of its kind \
     below 0.05 is false; a kind is all rows that compare controllers, or all that compare drivers",
);

const CHANGED: Column<String> = Column::new(
    "changed",
    "",
    "`town`: home is the town of the training; `policy`: home is the driving policy of the training. The other one is the same on both \
     sides",
);
const HOME_TOWN: Column<String> = Column::new("home_town", "", "town at home");
const HOME_POLICY: Column<String> = Column::new("home_policy", "", "driving policy at home");
const AWAY_TOWN: Column<String> = Column::new("away_town", "", "town away");
const AWAY_POLICY: Column<String> = Column::new("away_policy", "", "driving policy away");
const HOME_VALUE: Column<f64> =
    Column::new("home_value", "", "mean at home over the trainings that were evaluated in both places");
const AWAY_VALUE: Column<f64> = Column::new("away_value", "", "mean of the same trainings away");
const GAP: Column<f64> =
    Column::new("gap", "", "`home_value` less `away_value`: above 0 the part that does not transfer");
const GAP_STUDENT: Interval = Interval::new(
    "gap_student",
    "",
    "Student's 95 % interval over the gaps of the trainings, with the variance of the starts; missing for fewer than four trainings",
);

const BY_RUN: Family<String> = Family::new(
    "_by_run",
    "as the figure",
    "the figure of each run, in their order, with blanks between; `–` for a run without it",
);
const IQM: Family<f64> = Family::new(
    "_iqm",
    "as the figure",
    "mean over the runs without the best and the worst quarter, these rounded down (as rliable's interquartile mean); of three runs \
     all, of five the middle three",
);
const AVOIDED: Family<u64> = Family::new(
    "_avoided_collisions",
    "",
    "number of collisions that the reference driver avoids, those with a standing car included",
);
const REST: Family<f64> = Family::new(
    "_collision_rate",
    "",
    "the other collisions of all episodes: what remains if that driver brakes from where the danger began. Episodes without a collision \
     are not run again, so it never is above `collision_rate`",
);

const LEARNT: Column<String> = Column::new(
    "learnt",
    "",
    "whether the trainings of the cell learnt, by the mean reward of an episode: `no` where a training is significantly below an untrained \
     controller with the same reward and starts, `yes` where each training is significantly above one and none is below, else `unclear`. About \
     these trainings: normal test over common episodes, at 5 % after Holm's correction for all such pairs of the campaign. Missing for \
     untrained controllers",
);
const TRAININGS_DISAGREE: Column<String> = Column::new(
    "trainings_disagree",
    "",
    "`yes` where the standard deviation of the trainings' mean rewards is more than twice what the draw of episodes explains and more than \
     half of their mean gain over `random` (over 0 without it), else `no`. Missing for untrained controllers and for a single training",
);

/// The table of cells with all its columns: its metrics, and those of the evidence.
///
/// # Errors
/// The evidence is of other cells.
pub fn evident_cells(metrics: &DataFrame, evidence: &[CellEvidence]) -> PolarsResult<DataFrame> {
    metrics.hstack(&cell_columns(evidence))
}

/// The columns that the table of cells has in addition to its metrics, in the order of the cells.
fn cell_columns(cells: &[CellEvidence]) -> Vec<Values> {
    cell_table().values(cells)
}

/// The columns of [`cell_columns`].
pub fn cell_table() -> Table<'static, CellEvidence> {
    let above = "see [above](#which-interval-answers-which-question); cut at the bounds of the figure";
    let student = "see [above](#which-interval-answers-which-question); cut at the bounds of the figure; missing for two and three runs";
    let mut table = Table::new(CELLS, "");
    for figure in Figure::ALL {
        let name = figure.name();
        let between = move |cell: &CellEvidence| cell.between(figure).clone();
        table = table
            .column(BY_RUN.of(name, move |cell| by_run(&between(cell).by_run)))
            .column(IQM.of(name, move |cell| between(cell).iqm))
            .columns(interval(format!("{name}_bootstrap"), "as the figure", above, move |cell| between(cell).bootstrap))
            .columns(interval(format!("{name}_student"), "as the figure", student, move |cell| between(cell).student));
    }
    let all =
        "of all collisions, standing cars included; of each run the first 100,000 episodes, as for the quantiles below";
    let with = "episodes *without* a collision that have a value, of the first 100,000 of each run";
    let low = ["p01", "p10", "median"];
    table = table
        .columns(quantiles(&IMPACT_SPEED, all, ["median", "p90", "p99"], |cell| &cell.impact_speed))
        .column(Column::<u64>::new("min_ttc_episodes", "", with).of(|cell: &CellEvidence| cell.min_ttc.n))
        .columns(quantiles(&MIN_TTC, "quantile of these episodes", low, |cell| &cell.min_ttc))
        .column(Column::<u64>::new("pet_episodes", "", with).of(|cell: &CellEvidence| cell.pet.n))
        .columns(quantiles(&PET, "quantile of these episodes", low, |cell| &cell.pet));
    for reference in Reference::ALL {
        let name = reference.name();
        let rest = move |cell: &CellEvidence| cell.split(reference).1;
        table = table
            .column(AVOIDED.of(name, move |cell: &CellEvidence| cell.split(reference).0.count()))
            .column(REST.of(name, move |cell: &CellEvidence| rest(cell).share_of(&cell.episodes)))
            .columns(interval(
                format!("{}_wilson", REST.name(name)),
                "",
                "Wilson's 95 % interval of that rate",
                move |cell: &CellEvidence| Some(wilson(rest(cell), cell.episodes)),
            ));
    }
    let learning = |cell: &CellEvidence| cell.learning.clone();
    table.column(LEARNT.of(move |cell| learning(cell).map(|learning| learning.learnt().name()))).column(
        TRAININGS_DISAGREE.of(move |cell| {
            let disagree = learning(cell)?.disagree()?;
            Some(if disagree { "yes" } else { "no" })
        }),
    )
}

/// The two ends of an interval whose name is computed.
fn interval<R>(
    name: String,
    unit: &'static str,
    doc: &'static str,
    ends: impl Fn(&R) -> Option<(f64, f64)> + Copy + 'static,
) -> [Entry<'static, R>; 2] {
    let [low, high] = Interval::new("", unit, doc).of(ends);
    [low.named(format!("{name}_low")), high.named(format!("{name}_high"))]
}

fn quantiles(
    column: &Column<f64>,
    doc: &'static str,
    shares: [&str; 3],
    of: fn(&CellEvidence) -> &Quantiles,
) -> Vec<Entry<'static, CellEvidence>> {
    let quantile = |(place, share): (usize, &str)| {
        let value = move |cell: &CellEvidence| of(cell).at[place];
        Entry::new::<f64, _>(format!("{}_{share}", column.name).into(), column.unit.into(), doc.into(), value)
    };
    shares.into_iter().enumerate().map(quantile).collect()
}

/// The figure of each run, `–` for one without.
fn by_run(values: &[Option<f64>]) -> String {
    let words = values.iter().map(|value| value.map_or("–".to_string(), |value| format!("{value:.4}")));
    words.collect::<Vec<_>>().join(" ")
}

/// Comparisons as a table, one row each, in the order given.
pub fn comparison_table(comparisons: &[Comparison]) -> DataFrame {
    comparison_columns().frame(comparisons)
}

/// The columns of [`comparison_table`].
pub fn comparison_columns() -> Table<'static, Comparison> {
    let (count, number) = (Column::<u64>::new, Column::<f64>::new);
    Table::new(
        "comparisons",
        "One row for each pair of cells with common starts, and figure; both have the same town, vehicle, adversary and block. Where `other_policy` is \
         `policy`, a trained controller less another one: an untrained one (`random`, `homing`, `intercept`) with the same reward, or the same one \
         trained for an earlier reward. Otherwise a driver less an earlier one, met by the same controller: run by run, so trainings are paired, too. \
         The two kinds are adjusted separately.",
    )
    .columns(cell_key(|row: &Comparison| &row.first))
    .column(OTHER_CONTROLLER.of(|row: &Comparison| row.second.controller.clone()))
    .column(OTHER_POLICY.of(|row: &Comparison| row.second.policy.clone()))
    .column(OTHER_REWARD.of(|row: &Comparison| row.second.reward.clone()))
    .column(FIGURE.of(|row: &Comparison| row.figure.name()))
    .column(count("runs", "", "number of runs of the cell").of(|row: &Comparison| row.runs[0]))
    .column(count("other_runs", "", "number of runs of the other cell").of(|row: &Comparison| row.runs[1]))
    .column(count("paired_episodes", "", "episodes of the shortest of these runs").of(|row: &Comparison| row.episodes))
    .column(VALUE.of(|row: &Comparison| row.values[0]))
    .column(OTHER_VALUE.of(|row: &Comparison| row.values[1]))
    .column(DIFFERENCE.of(|row: &Comparison| row.difference))
    .columns(
        Interval::new(
            "difference_bootstrap",
            "",
            "hierarchical bootstrap: the runs of both cells are drawn independently, those of two drivers as pairs; their episodes together",
        )
        .of(|row: &Comparison| Some(row.bootstrap)),
    )
    .columns(DIFFERENCE_STUDENT.of(|row: &Comparison| row.student))
    .column(
        Column::<String>::new(
            "test",
            "",
            "`student` (that one: about further trainings), `mcnemar` (exact, one run on each side: about these two and further episodes; on \
             the first 100,000), or empty",
        )
        .of(|row: &Comparison| row.test.name()),
    )
    .column(number("p", "", "two-sided p-value; missing without a test, as where neither cell has such a collision").of(|row: &Comparison| row.p))
    .column(P_HOLM.of(|row: &Comparison| row.holm))
    .column(
        number(
            "p_benjamini_hochberg",
            "",
            "`p` adjusted by Benjamini and Hochberg's method, so that of the findings below 0.05 on average no more than 5 % are false",
        )
        .of(|row: &Comparison| row.benjamini_hochberg),
    )
}

/// Transfer gaps as a table, one row each, in the order given.
pub fn transfer_table(transfers: &[Transfer]) -> DataFrame {
    transfer_columns().frame(transfers)
}

/// The columns of [`transfer_table`].
pub fn transfer_columns() -> Table<'static, Transfer> {
    Table::new(
        "transfer",
        "One row for each trained controller, other town or other driving policy, and figure: the controller at home less the same trainings \
         away, in the same block.",
    )
    .column(REWARD.of(|row: &Transfer| row.home.reward.clone()))
    .column(TRAIN_TOWN.of(|row: &Transfer| row.home.train_town.clone()))
    .column(TRAIN_POLICY.of(|row: &Transfer| row.home.train_policy.clone()))
    .column(CONTROLLER.of(|row: &Transfer| row.home.controller.clone()))
    .column(VEHICLE.of(|row: &Transfer| row.home.vehicle.clone()))
    .column(ADVERSARY.of(|row: &Transfer| row.home.adversary.clone()))
    .column(BLOCK.of(|row: &Transfer| row.home.block))
    .column(CHANGED.of(|row: &Transfer| row.change.name()))
    .column(HOME_TOWN.of(|row: &Transfer| row.home.town.clone()))
    .column(HOME_POLICY.of(|row: &Transfer| row.home.policy.clone()))
    .column(AWAY_TOWN.of(|row: &Transfer| row.away.town.clone()))
    .column(AWAY_POLICY.of(|row: &Transfer| row.away.policy.clone()))
    .column(FIGURE.of(|row: &Transfer| row.figure.name()))
    .column(
        Column::<u64>::new("runs", "", "number of trainings that were evaluated in both places")
            .of(|row: &Transfer| row.runs),
    )
    .column(HOME_VALUE.of(|row: &Transfer| row.values[0]))
    .column(AWAY_VALUE.of(|row: &Transfer| row.values[1]))
    .column(GAP.of(|row: &Transfer| row.gap))
    .columns(
        Interval::new(
            "gap_bootstrap",
            "",
            "hierarchical bootstrap: trainings are drawn as pairs; so are the episodes of two policies in one town, which share their starts. The \
             episodes of two towns are drawn independently",
        )
        .of(|row: &Transfer| Some(row.bootstrap)),
    )
    .columns(GAP_STUDENT.of(|row: &Transfer| row.student))
}
