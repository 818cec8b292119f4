use std::collections::BTreeSet;

use polars::prelude::{AnyValue, DataFrame};

use super::condition::{Bound, Comparison, Condition, Extreme, GateError, is_end};
use crate::jobs::{NEEDLESS, SPARED};
use crate::record::columns::{BLOCK, BODY, DRIVER, PEDESTRIAN, TOWN, TRAIN_TOWN, VEHICLE, WORLD};
use crate::record::{CellKey, ColumnReference, Role, Table, TableReference, cell_key};
use crate::report::aggregate::{search_cell_reference, search_key};
use crate::report::cell_table::{NOT_TESTED, PASSED, SCORE, applied_to, gate_columns, gate_table};
use crate::report::compare::{ALL_UNTRAINED, COMMON_STARTS, DIFFERING, TRIED_STARTS};
use crate::report::{Findings, NOT_MET};
use crate::tables::STARTS;
use crate::tables::metrics::{EPISODES, MEAN};
use base::statistics::{MIN_RUNS, disagreement, mcnemar};
use compile::{Campaign, Evaluation, Search, SearchKey};

/// A condition under which a run fails, as `preventable_rate > 0.05 and town == village`. It is about metrics of cells, or about those of
/// searches when it names one that only searches have.
///
/// Conditions on words of a cell's key choose the cells. All others must be true for the gate to be broken. With `max over pedestrians` or
/// `min over pedestrians` before a column, a gate judges one cell of each place: that of the controller with the greatest or least value.
#[derive(Debug, Clone, PartialEq)]
pub struct Gate {
    text: String,
    about_searches: bool,
    /// Whether a row that cannot be judged passes.
    allow_unjudged: bool,
    conditions: Vec<Condition>,
}

/// The result of a gate for a cell.
#[derive(Debug, Clone, PartialEq)]
pub enum Judged {
    /// The condition is false; the columns that it used, with their values.
    Passed(Vec<(String, String)>),
    /// The condition is true; the columns that it used, with their values.
    Broken(Vec<(String, String)>),
    /// A column has no value there, so the condition cannot be evaluated, and the gate fails.
    Missing(String),
    /// A column has no value there since nothing happened that it is about: no collision, or the requirement never applied. Or the user allows rows that cannot
    /// be judged. That is worth a warning.
    NoValue(String),
    /// No row has a value in this column. The gate judged nothing, so it fails.
    MissingEverywhere(String),
    /// No episode or start of the row was evaluated, so nothing is known there, and the gate fails.
    NothingEvaluated,
    /// The driver left the road in this share of the episodes, at least half of them. No failures is then meaningless, and the gate fails.
    OffRoad(f64),
    /// The condition is false, but a single failure in this number of episodes would have made it true. That is worth a warning.
    Thin(u64),
    /// The same of a price, whose encounters are another number.
    ThinPrice(u64),
    /// The condition is about an interval over fewer runs than any interval needs. It could never be true, so the gate fails.
    TooFewRuns(TooFewRuns),
    /// The condition is about a share of starts, and a search tried this number of them: too few for any share, and the gate fails.
    TooFewSearched(u64),
    /// A recheck looked at this number of starts, without a fault of either driver: too few to say anything, and the gate fails.
    TooFewRechecked(u64),
    /// The condition is about a test of a protocol, of which this number of cases have no result at the test speed, and the gate fails.
    NotTested(u64),
    /// The condition is about old failures, of which the new driver did not meet this number. That is worth a warning, and the gate fails if no row has one
    /// that it met.
    NotMet { failures: u64, all: bool },
    /// The condition is false, and this number of episodes of the row ended in an error, so the gate fails.
    InError(u64),
    /// The condition is about a probability that this number of common starts could not give, whatever happens in them. It could never be true, so
    /// the gate fails.
    TooFewStarts(u64),
    /// The gate is about other cells.
    Elsewhere,
}

impl Judged {
    /// Whether the run fails by it.
    pub fn fails(&self) -> bool {
        !matches!(
            self,
            Self::Passed(_)
                | Self::Thin(_)
                | Self::ThinPrice(_)
                | Self::NoValue(_)
                | Self::NotMet { all: false, .. }
                | Self::Elsewhere
        )
    }

    /// Why it fails or is worth a warning, for people. `place` is ` in ` and the name of the row, or empty.
    pub fn reason(&self, place: &str) -> Option<String> {
        let starts = |count: u64| if count == 1 { "1 start".to_string() } else { format!("{count} starts") };
        Some(match self {
            Self::Broken(values) => format!("{}{place}", in_words(values)),
            Self::TooFewRuns(few) => format!("{few}{place}"),
            Self::Missing(column) => {
                format!("there is no {column}{place}, so nothing is judged there; --allow-unjudged lets it pass")
            }
            Self::NoValue(column) => format!("there is no {column}{place}"),
            Self::MissingEverywhere(column) => {
                format!("there is no {column}{place}, nor in any other row, so nothing was judged")
            }
            Self::TooFewStarts(count) => format!(
                "{count} common starts are too few{place}: even a failure in each of them would not make it true; run more episodes"
            ),
            Self::TooFewSearched(count) => {
                format!("{}{place} cannot show a share; give the search a larger `budget`", starts(*count))
            }
            Self::TooFewRechecked(count) => {
                format!(
                    "without a fault of either driver, {}{place} cannot show anything; give `--starts 10` or more",
                    starts(*count)
                )
            }
            Self::NotMet { failures, all } => format!(
                "the new driver did not meet {failures} of the failures{place}: nothing is known of them{}",
                if *all { ", nor of any other" } else { "" }
            ),
            Self::InError(episodes) => {
                format!("episodes in error{place}: {episodes}; nothing is known of them")
            }
            Self::NotTested(cases) => format!("cases of the test without a result at the test speed{place}: {cases}"),
            Self::NothingEvaluated => format!("nothing was evaluated{place}, so nothing can be judged"),
            Self::OffRoad(share) => format!(
                "the driver left the road in {:.0} % of the episodes{place}: that nothing failed there says nothing; gate on `left_road_rate`, too",
                100.0 * share
            ),
            Self::Thin(episodes) => format!(
                "{episodes} episodes{place} cannot show so low a rate: a single failure would have made it true; run more episodes"
            ),
            Self::ThinPrice(encounters) => format!(
                "{encounters} encounters{place} cannot show so low a rate: a single delay would have made it true; give the campaign a larger `price`"
            ),
            Self::Passed(_) | Self::Elsewhere => return None,
        })
    }
}

/// Columns with their values.
fn in_words(values: &[(String, String)]) -> String {
    let each = values.iter().map(|(column, value)| format!("{column} is {value}"));
    each.collect::<Vec<_>>().join(", ")
}

/// An end of an interval, or a standard deviation, that too few runs have. `Display` gives the reason and what to write instead.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "there is no `{column}`, since {}{}",
    if *is_deviation { "a single run has no deviation; give more `runs`".into() } else { format!("fewer than {MIN_RUNS} runs have no interval, and the cases of a test have none at all") },
    instead.as_ref().map_or(String::new(), |instead| format!("; write `{instead}`, or give more `runs`"))
)]
pub struct TooFewRuns {
    pub column: String,
    /// Whether it is a standard deviation.
    pub is_deviation: bool,
    /// A column that answers nearly the same question and has a value.
    pub instead: Option<String>,
}

impl TooFewRuns {
    /// Judges a row by a condition; `None` if its column has a value, or if runs are not the reason that it has none.
    fn of(cells: &DataFrame, condition: &Condition, row: usize) -> Option<Self> {
        let column = &condition.column.name;
        let (runs, found) = (number(&value(cells, RUNS, row))?, number(&value(cells, column, row)));
        let is_deviation = condition.column.role == Role::Deviation;
        let needed = if is_deviation { 2.0 } else { MIN_RUNS as f64 };
        if !(is_deviation || is_end(&condition.column)) || found.is_some() || runs >= needed {
            return None;
        }
        let instead = condition.instead.iter().find(|other| number(&value(cells, other, row)).is_some());
        Some(Self { column: column.to_string(), is_deviation, instead: instead.cloned() })
    }
}

impl Gate {
    /// Parses a gate. Its columns are looked up in the tables of cells and of searches, which are the same for all campaigns.
    ///
    /// # Errors
    /// It has another form, or names no column.
    pub fn parse(text: &str) -> Result<Self, GateError> {
        match Self::of_columns(text, &gate_columns(&requirements_in(text))) {
            Err(error @ GateError::Column { .. }) => match Self::of_columns(text, &search_cell_reference().columns) {
                Ok(gate) => Ok(Self { about_searches: true, ..gate }),
                Err(GateError::Column { .. }) => Err(error),
                Err(other) => Err(other),
            },
            parsed => parsed,
        }
    }

    /// Parses a gate about another table.
    ///
    /// # Errors
    /// It has another form, or names no column of the table.
    pub fn of_table(text: &str, table: &TableReference) -> Result<Self, GateError> {
        Self::of_columns(text, &table.columns)
    }

    fn of_columns(text: &str, columns: &[ColumnReference]) -> Result<Self, GateError> {
        let text = text.trim().to_string();
        if [" or ", "||", "&&"].iter().any(|word| text.contains(word)) {
            return Err(GateError::Joined { text });
        }
        let conditions: Vec<Condition> =
            text.split(" and ").map(|part| Condition::parse(part, columns)).collect::<Result<_, _>>()?;
        if conditions.iter().filter(|condition| condition.over.is_some()).count() > 1 {
            return Err(GateError::Extremes { text });
        }
        if let Some(never) = conditions.iter().find(|condition| !condition.can_hold_with(&conditions)) {
            return Err(GateError::Never { text, name: never.column.name.to_string() });
        }
        Ok(Self { text, about_searches: false, allow_unjudged: false, conditions })
    }

    /// Lets rows pass that it cannot judge.
    #[must_use]
    pub fn allowing_unjudged(self, allow_unjudged: bool) -> Self {
        Self { allow_unjudged, ..self }
    }

    pub fn text(&self) -> &str {
        &self.text
    }

    /// The row that passes with the value nearest to the first number of the condition, and its values in words; `None` if none passes or the condition has no
    /// number.
    pub fn nearest(&self, judged: &[Judged]) -> Option<(usize, String)> {
        let (column, bound) = self.conditions.iter().find_map(|condition| match condition.bound {
            Bound::Number(bound) => Some((&*condition.column.name, bound)),
            Bound::Word(_) => None,
        })?;
        let distance = |values: &[(String, String)]| {
            let value = values.iter().find(|(name, _)| name == column)?.1.parse::<f64>().ok()?;
            Some((value - bound).abs())
        };
        let passed = judged.iter().enumerate().filter_map(|(row, judged)| match judged {
            Judged::Passed(values) => Some((distance(values)?, row, values)),
            _ => None,
        });
        let (_, row, values) = passed.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some((row, in_words(values)))
    }

    pub fn is_about_searches(&self) -> bool {
        self.about_searches
    }

    /// Checks that the gate judges a row of one of these campaigns. A condition with a typo would pass for ever.
    ///
    /// # Errors
    /// No campaign has such a row.
    pub fn check(&self, campaigns: &[Campaign]) -> Result<(), GateError> {
        let keys = if self.about_searches {
            let keys: Vec<&SearchKey> =
                campaigns.iter().flat_map(Campaign::all::<Search>).map(|each| &each.key).collect();
            Table::new("", "").columns(search_key(|key: &&SearchKey| key)).frame(&keys)
        } else {
            let keys: Vec<CellKey> = campaigns.iter().flat_map(Campaign::all::<Evaluation>).map(CellKey::of).collect();
            Table::new("", "").columns(cell_key(|key: &CellKey| key)).frame(&keys)
        };
        self.check_requirements(campaigns)
            .and_then(|()| self.check_keys(&keys))
            .map_err(|reason| GateError::AboutNothing { text: self.text.clone(), reason })
    }

    fn check_requirements(&self, campaigns: &[Campaign]) -> Result<(), String> {
        let known: Vec<&str> =
            campaigns.iter().flat_map(|campaign| &*campaign.requirements).map(|each| &*each.name).collect();
        match requirements_in(&self.text).into_iter().find(|name| !known.contains(name)) {
            None => Ok(()),
            Some(name) if known.is_empty() => {
                Err(format!("no campaign requires `{name}`; name it in the key `requirements` of a campaign"))
            }
            Some(name) => Err(format!("no campaign requires `{name}`; there are {}", known.join(", "))),
        }
    }

    /// Checks that it chooses one of the rows with these keys.
    fn check_keys(&self, keys: &DataFrame) -> Result<(), String> {
        if keys.height() == 0 {
            let what = if self.about_searches { "a `search`" } else { "an `evaluate`" };
            return Err(format!("no campaign has {what} block"));
        }
        let rows = || 0..keys.height();
        let is_trained = |row: usize| value(keys, TRAIN_TOWN.name, row).get_str().is_some_and(|town| !town.is_empty());
        if let Some(condition) = self.conditions.iter().find(|each| each.is_of_trainings())
            && !rows().any(is_trained)
        {
            return Err(format!(
                "`{}` is about trained pedestrians, and no campaign evaluates one",
                condition.column.name
            ));
        }
        let chosen = |condition: &Condition, row: usize| match (&condition.bound, condition.chooses) {
            (Bound::Word(word), true) => {
                let found = value(keys, &condition.column.name, row);
                condition.is_true_of(found.get_str().unwrap_or_default(), word)
            }
            _ => !condition.is_of_trainings() || is_trained(row),
        };
        if rows().any(|row| self.conditions.iter().all(|condition| chosen(condition, row))) {
            return Ok(());
        }
        let never = self.conditions.iter().find(|condition| !rows().any(|row| chosen(condition, row)));
        let Some(condition) = never else {
            return Err("each of its words chooses some rows, but no row is chosen by all".into());
        };
        let mut known: Vec<String> = Vec::new();
        for row in rows() {
            let found = value(keys, &condition.column.name, row).get_str().unwrap_or_default().to_string();
            if !found.is_empty() && !known.contains(&found) {
                known.push(found);
            }
        }
        Err(format!("`{}` can be: {}", condition.column.name, known.join(", ")))
    }

    /// Judges every cell of a campaign, or every cell of its searches, in their order.
    pub fn judge_campaign(&self, found: &Findings<'_>) -> Vec<Judged> {
        if self.about_searches {
            return self.judge(found.searches.table());
        }
        // A campaign of searches alone has no row.
        if found.cells.is_empty() {
            return Vec::new();
        }
        let cells = gate_table(found, &requirements_in(&self.text));
        self.judge(&cells.expect("a bug: the tables of cells have one key"))
    }

    /// Judges every row of the table that it is about, in its order.
    pub fn judge(&self, cells: &DataFrame) -> Vec<Judged> {
        let mut judged = self.judge_rows(cells);
        let is_missing = |each: &Judged| matches!(each, Judged::Missing(_) | Judged::NoValue(_) | Judged::Elsewhere);
        let is_unmet = |each: &Judged| matches!(each, Judged::NotMet { all: true, .. } | Judged::Elsewhere);
        if !judged.iter().all(is_unmet) {
            judged.iter_mut().for_each(|each| {
                if let Judged::NotMet { all, .. } = each {
                    *all = false;
                }
            });
        }
        let may_be = self.conditions.iter().all(|condition| !condition.is_of_collisions);
        if may_be && !self.allow_unjudged && judged.iter().all(is_missing) {
            for each in &mut judged {
                if let Judged::Missing(column) | Judged::NoValue(column) = each {
                    *each = Judged::MissingEverywhere(std::mem::take(column));
                }
            }
        }
        judged
    }

    fn judge_rows(&self, cells: &DataFrame) -> Vec<Judged> {
        let rows = || (0..cells.height()).filter(|row| self.is_about(cells, *row));
        let mut judged = vec![Judged::Elsewhere; cells.height()];
        let Some((over, condition)) = self.conditions.iter().find_map(|each| Some((each.over?, each))) else {
            rows().for_each(|row| judged[row] = self.judge_cell(cells, row));
            return judged;
        };
        let mut places: Vec<(Vec<String>, Vec<usize>)> = Vec::new();
        for row in rows() {
            let place = PLACE.iter().map(|column| value(cells, column, row).to_string()).collect();
            match places.iter_mut().find(|(known, _)| *known == place) {
                Some((_, members)) => members.push(row),
                None => places.push((place, vec![row])),
            }
        }
        for (_, members) in places {
            let known =
                members.iter().filter_map(|row| Some((number(&value(cells, &condition.column.name, *row))?, *row)));
            let extreme = known.reduce(|first, next| match over {
                Extreme::Max if next.0 > first.0 => next,
                Extreme::Min if next.0 < first.0 => next,
                _ => first,
            });
            // A controller without an interval might have the extreme one.
            let few = members.iter().find_map(|row| Some((*row, TooFewRuns::of(cells, condition, *row)?)));
            match extreme {
                _ if few.is_some() => few.into_iter().for_each(|(row, few)| judged[row] = Judged::TooFewRuns(few)),
                Some((_, row)) => judged[row] = self.judge_cell(cells, row),
                None if nothing_evaluated(cells, members[0]) => judged[members[0]] = Judged::NothingEvaluated,
                None => judged[members[0]] = self.absent(cells, condition, members[0]),
            }
        }
        judged
    }

    /// Whether its words choose a cell.
    fn is_about(&self, cells: &DataFrame, row: usize) -> bool {
        self.conditions.iter().all(|condition| match &condition.bound {
            Bound::Word(word) => match value(cells, &condition.column.name, row).get_str() {
                Some(found) => !condition.chooses || condition.is_true_of(found, word),
                None => false,
            },
            Bound::Number(_) => true,
        })
    }

    /// The number of common starts of a row, if even a failure in each of them on one side only would leave the probability of chance, or the end of the
    /// interval of a difference, of a single run beyond what a condition asks for.
    fn too_few_starts(&self, cells: &DataFrame, row: usize) -> Option<u64> {
        let starts = |column: &&str| number(&value(cells, column, row)).map(|starts| starts as u64);
        let is_pooled = |row: usize| value(cells, PEDESTRIAN.name, row).get_str() == Some(ALL_UNTRAINED);
        let is_exact = is_pooled(row) || number(&value(cells, RUNS, row)).is_none_or(|runs| runs == 1.0);
        let own = PAIRED_STARTS.iter().find_map(starts).filter(|_| is_exact)?;
        // Holm's correction counts the rows in which a pair differs, and of these no longer those that are shown.
        let is_out_of_reach = |condition: &&Condition| {
            let Bound::Number(bound) = condition.bound else { return false };
            let found = |column: &str, other| number(&value(cells, column, other));
            let is_counted = |other: &usize| {
                let differs = condition.differing.iter().any(|column| found(column, *other) > Some(0.0));
                let is_shown = found(&condition.column.name, *other).is_some_and(|p| p < bound);
                *other != row && is_pooled(*other) == is_pooled(row) && differs && !is_shown
            };
            let tests = 1 + (0..cells.height()).filter(is_counted).count();
            tests as f64 * mcnemar(0, own) >= bound
        };
        let is_compared = number(&value(cells, RECHECKED_STARTS, row)).is_none();
        // As many intervals hold the truth together as rows are not unchanged.
        let is_tested = |other: &usize| {
            is_pooled(*other) == is_pooled(row) && number(&value(cells, DIFFERING.name, *other)) != Some(0.0)
        };
        let together = (0..cells.height()).filter(is_tested).count().max(1);
        let all_differ = disagreement(0, own, own, 0.05 / together as f64);
        let cannot = |condition: &&Condition| {
            let is_below = matches!(condition.comparison, Comparison::Less | Comparison::AtMost);
            let is_above = matches!(condition.comparison, Comparison::More | Comparison::AtLeast);
            match (condition.column.role, &condition.bound) {
                (Role::AdjustedP, _) if is_below => is_out_of_reach(condition),
                (Role::LowerBound, Bound::Number(bound)) if is_above && is_compared => all_differ.0 <= *bound,
                (Role::UpperBound, Bound::Number(bound)) if is_below && is_compared => -all_differ.0 >= *bound,
                _ => false,
            }
        };
        self.conditions.iter().any(|condition| cannot(&condition)).then_some(own)
    }

    fn judge_cell(&self, cells: &DataFrame, row: usize) -> Judged {
        let (mut looked_at, mut missing, mut holds) = (Vec::new(), None, true);
        for condition in self.conditions.iter().filter(|condition| !condition.chooses) {
            let found = value(cells, &condition.column.name, row);
            let text = match &condition.bound {
                Bound::Word(word) => {
                    let found = found.get_str().unwrap_or_default();
                    holds &= condition.is_true_of(found, word);
                    found.to_string()
                }
                Bound::Number(bound) => match number(&found) {
                    Some(number) => {
                        holds &= condition.comparison.holds(number, *bound);
                        ((number * 1e6).round() / 1e6).to_string()
                    }
                    None => {
                        missing = missing.or_else(|| Some(self.absent(cells, condition, row)));
                        continue;
                    }
                },
            };
            looked_at.push((condition.column.name.to_string(), text));
        }
        match missing {
            None if holds => Judged::Broken(looked_at),
            _ if nothing_evaluated(cells, row) => Judged::NothingEvaluated,
            _ if let Some(cases) = self.not_tested(cells, row) => Judged::NotTested(cases),
            _ if let Some(starts) = self.too_few_starts(cells, row) => Judged::TooFewStarts(starts),
            _ if let Some(starts) = self.too_few_searched(cells, row) => Judged::TooFewSearched(starts),
            _ if let Some(starts) = too_few_rechecked(cells, row) => Judged::TooFewRechecked(starts),
            Some(judged) if holds => judged,
            _ if let Some(judged) = self.not_met(cells, row) => judged,
            _ if let Some(share) = self.off_road(cells, row) => Judged::OffRoad(share),
            _ => self.thin(cells, row).unwrap_or(Judged::Passed(looked_at)),
        }
    }

    /// The judgement of a row that has no value in a column.
    fn absent(&self, cells: &DataFrame, condition: &Condition, row: usize) -> Judged {
        let name = condition.column.name.to_string();
        match TooFewRuns::of(cells, condition, row) {
            Some(few) => Judged::TooFewRuns(few),
            None if applied(cells, condition, row) == Some(0.0) => {
                Judged::NoValue(format!("{name}, since it never applied"))
            }
            None if condition.is_of_collisions || self.allow_unjudged => Judged::NoValue(name),
            None => Judged::Missing(name),
        }
    }

    /// The old failures of a row that were not met, if there are any and a condition is about what became of the others.
    fn not_met(&self, cells: &DataFrame, row: usize) -> Option<Judged> {
        let count = |column: &str| number(&value(cells, column, row));
        let failures = count(NOT_MET).filter(|failures| *failures > 0.0)?;
        let is_about_ends = |condition: &Condition| condition.column.name.starts_with("still_");
        let all = Some(failures) == count(MET_AGAIN);
        self.conditions.iter().any(is_about_ends).then_some(Judged::NotMet { failures: failures as u64, all })
    }

    /// The number of cases of a test without a result at the test speed, if there are any and a condition is about the others.
    fn not_tested(&self, cells: &DataFrame, row: usize) -> Option<u64> {
        let cases = number(&value(cells, NOT_TESTED, row)).filter(|cases| *cases > 0.0)?;
        let is_about_tests = |condition: &Condition| [SCORE, PASSED].contains(&&*condition.column.name);
        self.conditions.iter().any(is_about_tests).then_some(cases as u64)
    }

    /// The number of starts that a search tried, if a condition is about a share of them and they are too few for one.
    fn too_few_searched(&self, cells: &DataFrame, row: usize) -> Option<u64> {
        let counts = [MEAN.name(STARTS.name), TRIED_STARTS.name.into()];
        let starts = counts.iter().find_map(|count| number(&value(cells, count, row)))?;
        let is_about_shares = self.conditions.iter().any(is_share);
        (is_about_shares && starts < MIN_SEARCHED).then_some(starts as u64)
    }

    /// The share of a row's episodes in which the driver left the road, if that is half of them or more and the gate is about failures.
    fn off_road(&self, cells: &DataFrame, row: usize) -> Option<f64> {
        let column = MEAN.name(LEFT_ROAD_RATE);
        let is_of_failures =
            |condition: &Condition| OF_FAILURES.iter().any(|word| condition.column.figure.starts_with(word));
        let is_about_failures = self.conditions.iter().any(is_of_failures);
        number(&value(cells, &column, row)).filter(|share| *share >= MOSTLY && is_about_failures)
    }

    /// The number of a row's episodes, or of those in which a requirement applied, if they are so few that a single failure would have made a condition on
    /// a rate true.
    fn thin(&self, cells: &DataFrame, row: usize) -> Option<Judged> {
        let is_thin = |condition: &Condition, episodes: f64| match condition.bound {
            Bound::Number(bound) if bound > 0.0 && is_share(condition) && !condition.is_of_collisions => {
                matches!(condition.comparison, Comparison::More | Comparison::AtLeast) && episodes * bound < 1.0
            }
            _ => false,
        };
        let thin = |condition: &Condition| {
            let is_price = condition.column.name == NEEDLESS;
            let all = || number(&value(cells, if is_price { SPARED.name } else { EPISODES.name }, row));
            let of = applied(cells, condition, row).or_else(all)?;
            let judged = if is_price { Judged::ThinPrice } else { Judged::Thin };
            is_thin(condition, of).then(|| judged(of as u64))
        };
        self.conditions.iter().find_map(thin)
    }
}

/// The columns that name a place: its controllers have the same starts.
const PLACE: [&str; 6] = [TOWN.name, DRIVER.name, VEHICLE.name, BODY.name, WORLD.name, BLOCK.name];

/// The share of episodes in which the driver left the road, and from which share on a row says nothing about the driver's failures.
const LEFT_ROAD_RATE: &str = "left_road_rate";
const MOSTLY: f64 = 0.5;
/// How the columns begin that are about failures.
const OF_FAILURES: [&str; 5] = ["fault", "preventable", "collision", "violation", "avoidable_injury"];

/// Minimum number of starts of a search for a share of them.
const MIN_SEARCHED: f64 = 10.0;

/// The columns of the number of starts that two drivers share, in a comparison, of its searches, and of a recheck.
const PAIRED_STARTS: [&str; 3] = [COMMON_STARTS.name, TRIED_STARTS.name, RECHECKED_STARTS];
const RECHECKED_STARTS: &str = "starts";

/// The column of the number of failures that are met again.
const MET_AGAIN: &str = "failures";

/// The column of the number of runs, in each table that has gates.
const RUNS: &str = "runs";

/// The number of starts of a recheck, if no driver has a fault there and they are too few to say anything.
fn too_few_rechecked(cells: &DataFrame, row: usize) -> Option<u64> {
    let count = |column: &str| number(&value(cells, column, row));
    let starts = count(RECHECKED_STARTS).filter(|starts| *starts < MIN_SEARCHED)?;
    let is_idle = ["faults_before", "faults_after"].iter().all(|faults| count(faults) == Some(0.0));
    is_idle.then_some(starts as u64)
}

/// Whether a row is about no episode and no start.
fn nothing_evaluated(cells: &DataFrame, row: usize) -> bool {
    let counts = [EPISODES.name, &MEAN.name(STARTS.name), STARTS.name, COMMON_STARTS.name, TRIED_STARTS.name];
    counts.iter().any(|count| number(&value(cells, count, row)) == Some(0.0))
}

/// The number of a row's episodes in which the requirement of a condition applied; `None` if it is about none.
fn applied(cells: &DataFrame, condition: &Condition, row: usize) -> Option<f64> {
    let (_, requirement) = condition.column.figure.trim_end_matches(')').split_once('(')?;
    number(&value(cells, &applied_to(requirement), row))
}

/// The requirements that a gate names, each once: `violation_rate(NAME)`, `fault_rate(NAME)`.
pub fn requirements_in(text: &str) -> Vec<&str> {
    let names: BTreeSet<&str> = text.split('(').skip(1).filter_map(|rest| Some(rest.split_once(')')?.0)).collect();
    names.into_iter().collect()
}

fn is_share(condition: &Condition) -> bool {
    matches!(condition.column.role, Role::Share | Role::ShareDifference)
}

fn value<'a>(cells: &'a DataFrame, column: &str, row: usize) -> AnyValue<'a> {
    cells.column(column).and_then(|column| column.get(row)).unwrap_or(AnyValue::Null)
}

fn number(value: &AnyValue<'_>) -> Option<f64> {
    value.extract::<f64>().filter(|number| !number.is_nan())
}

#[cfg(test)]
mod tests {
    use super::*;
    use polars::prelude::df;

    #[test]
    fn a_gate_that_chooses_no_row_is_refused_before_the_run() {
        let keys = df!(
            "town" => ["harbour", "village", "village"],
            "pedestrian" => ["trained", "trained", "random"],
            "train_town" => ["harbour", "harbour", ""]
        )
        .unwrap();
        let reason = |text: &str| Gate::parse(text).unwrap().check_keys(&keys);
        assert_eq!(reason("preventable_rate > 0.05"), Ok(()));
        assert_eq!(reason("preventable_rate > 0.05 and town == village"), Ok(()));
        assert_eq!(reason("beats_untrained != yes"), Ok(()), "results are known after the run only");
        let untrained = Gate::parse("beats_untrained != yes").unwrap().check_keys(&keys.tail(Some(1))).unwrap_err();
        assert_eq!(untrained, "`beats_untrained` is about trained pedestrians, and no campaign evaluates one");
        assert!(
            reason("beats_untrained != yes and pedestrian == random").unwrap_err().contains("no row is chosen by all")
        );
        let typo = reason("preventable_rate > 0.05 and town == vilage").unwrap_err();
        assert_eq!(typo, "`town` can be: harbour, village");
        let apart = reason("preventable_rate > 0.05 and town == harbour and pedestrian == random").unwrap_err();
        assert!(apart.contains("no row is chosen by all"), "{apart}");
        let gate = Gate::parse("preventable_rate > 0.05").unwrap();
        let empty = gate.check(&[]).unwrap_err().to_string();
        assert_eq!(empty, "`preventable_rate > 0.05` matches no row: no campaign has an `evaluate` block");
    }
    #[test]
    fn a_requirement_may_be_named_twice() {
        let names = requirements_in("violation_rate(b) > 0.05 and fault_rate(b) > 0.01 and violation_rate(a) > 0");
        assert_eq!(names, ["a", "b"]);
        let columns = gate_columns(&names);
        assert_eq!(columns.iter().filter(|column| column.name == "violation_rate(b)").count(), 1);
    }
}
