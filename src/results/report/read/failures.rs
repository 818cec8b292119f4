//! The failures of a report, of evaluations and searches alike, from its tables.

use std::collections::{BTreeMap, BTreeSet};

use polars::prelude::{
    DataFrame, DataType, Expr, IntoLazy, JoinArgs, JoinType, LazyFrame, MaintainOrderJoin, PolarsResult, col,
};

use super::{ReadError, StoredReport};
use crate::failure::{Failure, FoundBy};
use crate::record::columns::{DRIVER, EPISODE, MIN_GAP, NUMBER, REWARD, RUN_ID, TOWN};
use crate::record::{CellKey, EPISODES, EpisodeTable, RunKey};
use crate::report::actors::{ACTORS, NEEDED, ROLE};
use crate::report::aggregate::{REQUIREMENTS, SEARCHES};
use crate::report::failure_table::{FAILURES, Row, failure_table, read_failures};
use crate::tables::{APPLIES, METHOD, REQUIREMENT, SEARCH_BLOCK, SEARCH_RUN};
use compile::RunId;

/// The number of rows of a table that are read at once.
const ROWS: usize = 1 << 17;

/// The touches of evaluations, with what the table of failures has of each.
#[derive(Debug)]
pub struct Touches {
    runs: BTreeMap<RunId, Vec<DataFrame>>,
}

impl Touches {
    /// The episodes of a run, each with what the table of failures has of its touch.
    ///
    /// # Errors
    /// Those of polars, of a damaged table.
    pub fn beside(&self, run: RunId, episodes: &DataFrame) -> PolarsResult<LazyFrame> {
        let mut touches: Option<DataFrame> = None;
        for part in self.runs.get(&run).into_iter().flatten() {
            match &mut touches {
                Some(all) => drop(all.vstack_mut(part)?),
                None => touches = Some(part.clone()),
            }
        }
        let touches = touches.unwrap_or_else(|| failure_table().frame(&[]));
        let is_known = |name: &str| episodes.get_column_index(name).is_some();
        let more: Vec<Expr> =
            touches.get_column_names().iter().filter(|name| !is_known(name)).map(|name| col(name.as_str())).collect();
        let number = col(NUMBER.name).cast(DataType::UInt32).alias(EPISODE.name);
        let touches = touches.lazy().select([vec![number], more].concat());
        let order = JoinArgs { maintain_order: MaintainOrderJoin::Left, ..JoinArgs::new(JoinType::Left) };
        Ok(episodes.clone().lazy().join(touches, [col(EPISODE.name)], [col(EPISODE.name)], order))
    }
}

impl StoredReport {
    /// The names of the requirements that its table has degrees of: those of its evaluations, and the goals of its searches.
    ///
    /// # Errors
    /// A table that is damaged, or that the report has as CSV only.
    pub fn requirements(&self) -> Result<BTreeSet<String>, ReadError> {
        let mut names = BTreeSet::new();
        self.each_part(REQUIREMENTS, ROWS, |rows| {
            names.extend(REQUIREMENT.read(rows)?.iter().flatten().map(String::from));
            Ok(())
        })?;
        Ok(names)
    }

    /// The names of those that applied in an episode, with the runs of evaluations in which they did.
    ///
    /// # Errors
    /// As [`StoredReport::requirements`].
    pub fn applied_requirements(&self) -> Result<BTreeMap<String, BTreeSet<RunId>>, ReadError> {
        let mut names: BTreeMap<String, BTreeSet<RunId>> = BTreeMap::new();
        self.each_part(REQUIREMENTS, ROWS, |rows| {
            let (requirement, applies, run) = (REQUIREMENT.read(rows)?, APPLIES.read(rows)?, RUN_ID.read(rows)?);
            for row in (0..rows.height()).filter(|row| applies.get(*row) == Some(true)) {
                let Some(name) = requirement.get(row) else { continue };
                let runs = names.entry(name.into()).or_default();
                runs.extend(run.get(row).and_then(|run| run.parse::<RunId>().ok()));
            }
            Ok(())
        })?;
        Ok(names)
    }

    /// All failures, in the order of their table. Bumps are among them, and violations at the touch of a collision.
    ///
    /// # Errors
    /// A table that is damaged, or that the report has as CSV only.
    pub fn failures(&self) -> Result<Vec<Failure>, ReadError> {
        let keys = self.keys()?;
        let mut found = Vec::new();
        self.each_part(FAILURES, ROWS, |rows| {
            found.extend(read_failures(rows, &keys)?);
            Ok(())
        })?;
        self.add_needs(&mut found)?;
        Ok(found)
    }

    /// The touches of evaluations, run by run.
    ///
    /// # Errors
    /// As [`StoredReport::failures`].
    pub fn touches(&self) -> Result<Touches, ReadError> {
        let mut runs: BTreeMap<RunId, Vec<DataFrame>> = BTreeMap::new();
        self.each_part(FAILURES, ROWS, |rows| {
            let (ids, requirements) = (RUN_ID.read(rows)?, REQUIREMENT.read(rows)?);
            let mut first = 0;
            while first < rows.height() {
                let is_same = |row: &usize| ids.get(*row) == ids.get(first);
                let count = (first..rows.height()).take_while(is_same).count();
                let own = rows.slice(first as i64, count).filter(&requirements.slice(first as i64, count).is_null())?;
                if let Some(id) = ids.get(first).and_then(|id| id.parse().ok()) {
                    runs.entry(id).or_default().push(own);
                }
                first += count;
            }
            Ok(())
        })?;
        Ok(Touches { runs })
    }

    /// The keys of evaluations and searches.
    fn keys(&self) -> Result<BTreeMap<RunId, (RunKey, FoundBy)>, ReadError> {
        let runs = self.run_rows()?.into_iter().map(|run| (run.key.id, (run.key, FoundBy::Evaluation)));
        let mut keys: BTreeMap<_, _> = runs.collect();
        self.each_part(SEARCHES, ROWS, |rows| {
            for row in 0..rows.height() {
                let key = search_key_of(Row(rows, row))?;
                keys.insert(key.id, (key, FoundBy::Search));
            }
            Ok(())
        })?;
        Ok(keys)
    }

    /// Episodes of evaluations without a touch, in which the gap between car and pedestrian was smaller than this (m) at some time.
    ///
    /// # Errors
    /// As [`StoredReport::failures`].
    pub fn near_misses(&self, gap: f64) -> Result<Vec<Failure>, ReadError> {
        let (keys, mut found) = (self.keys()?, Vec::new());
        let mut walked = BTreeSet::new();
        let runs = self.run_rows()?;
        let first: BTreeSet<RunId> =
            runs.iter().filter(|run| walked.insert(run.key.of_any_reward())).map(|run| run.key.id).collect();
        self.each_part(EPISODES, ROWS, |rows| {
            let (table, gaps) = (EpisodeTable::new(rows)?, MIN_GAP.read(rows)?);
            let is_near = |row: usize| gaps.get(row).is_some_and(|smallest| smallest < gap);
            for row in table.rows().filter(|row| table.counts(*row) && !table.is_touch(*row) && is_near(*row)) {
                let (key, found_by) = Row(rows, row).key(&keys)?;
                if first.contains(&key.id) {
                    found.push(Failure::new(key, found_by, table.episode(row).into()));
                }
            }
            Ok(())
        })?;
        Ok(found)
    }

    /// Adds which actors the failures of a cast need.
    fn add_needs(&self, failures: &mut [Failure]) -> Result<(), ReadError> {
        let mut needs: BTreeMap<(String, u64), Vec<String>> = BTreeMap::new();
        self.each_part(ACTORS, ROWS, |rows| {
            (0..rows.height()).try_for_each(|number| {
                let row = Row(rows, number);
                let named = needs.entry((row.text(&RUN_ID)?, row.count(&NUMBER)?)).or_default();
                let role = row.text(&ROLE)?;
                if row.holds(&NEEDED)? && !named.contains(&role) {
                    named.push(role);
                }
                Ok(())
            })
        })?;
        for failure in failures {
            failure.needs = needs.get(&(failure.key.id.to_string(), failure.number)).map(|roles| roles.join(" "));
        }
        Ok(())
    }
}

/// The key of a search, whose falsifier is the controller, in the table of searches.
fn search_key_of(row: Row<'_>) -> PolarsResult<RunKey> {
    let cell = CellKey {
        controller: row.text(&METHOD)?,
        reward: row.text(&REWARD)?,
        town: row.text(&TOWN)?,
        policy: row.text(&DRIVER)?,
        block: row.count(&SEARCH_BLOCK)? as u32,
        ..CellKey::default()
    };
    Ok(RunKey { id: row.run_id()?, cell, run: row.count(&SEARCH_RUN)? as u32 })
}
