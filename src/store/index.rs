use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::{CODE, Ids, State, Store, StoreError};
use crate::campaign::{CHUNK, Cell, cells};
use crate::compile::Campaign;
use crate::record::RunKey;

/// What is remembered of a campaign: which cells it wanted last, and from what each of its cells was made last. It only explains; what
/// is there is there without it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Index {
    /// The names of all its cells.
    pub wanted: BTreeSet<String>,
    /// What each of them is, and how much: updates, episodes, ticks.
    #[serde(default)]
    pub plan: BTreeMap<String, (String, u64)>,
    /// The command that it was last run with.
    #[serde(default)]
    pub command: String,
    /// The folder for reports that it was last run for, for people.
    #[serde(default)]
    pub out: String,
    /// The cells that were finished, by what they are.
    done: BTreeMap<String, Made>,
}

/// From what a cell was made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Made {
    id: String,
    recipe: String,
    code: String,
    seed: u64,
}

/// What is known of a cell before a run.
#[derive(Debug, Clone, PartialEq)]
pub enum Known {
    /// It is there.
    Finished,
    /// It is there in part: so many of so many updates or episodes.
    Begun(u64, u64),
    /// It is not there, for this reason.
    Missing(&'static str),
}

impl Index {
    /// What is remembered of a campaign; nothing when nothing is.
    pub fn read(store: &Store, name: &str) -> Self {
        store.campaign_text(name).and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default()
    }

    /// Remembers what a campaign wants, and what of it is there.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&mut self, store: &Store, name: &str, campaign: &Campaign, seed: u64) -> Result<(), StoreError> {
        let ids = Ids::new(campaign, seed);
        self.wanted = cells(campaign).map(|cell| ids.get(cell).to_string()).collect();
        let planned = |cell| (ids.get(cell).to_string(), (cell_name(campaign, cell), amount(campaign, cell)));
        self.plan = cells(campaign).map(planned).collect();
        for cell in cells(campaign) {
            let id = ids.get(cell);
            if store.head(id).is_some_and(|head| head.is_ok_and(|header| header.state == State::Finished)) {
                let (recipe, code) = (recipe(campaign, cell), CODE.to_string());
                let made = Made { id: id.to_string(), recipe, code, seed };
                self.done.insert(cell_name(campaign, cell), made);
            }
        }
        self.out = store.place().out().to_string_lossy().into_owned();
        let text = serde_json::to_string(self).expect("strings and numbers have a form in JSON");
        store.put_campaign_text(name, &text)
    }

    /// Tells what is known of a cell, and why it must be run if it must.
    pub fn look(&self, store: &Store, campaign: &Campaign, cell: Cell, ids: &Ids, seed: u64) -> Known {
        let (id, wanted) = (ids.get(cell), amount(campaign, cell));
        match store.head(id) {
            Some(Ok(header)) => match header.state {
                State::Finished if header.done < wanted && is_counted(campaign, cell) => {
                    return Known::Begun(header.done, wanted);
                }
                State::Finished => return Known::Finished,
                State::Begun => return Known::Begun(header.done, wanted),
                State::Failed => return Known::Missing("failed"),
            },
            Some(Err(())) => return Known::Missing("damaged"),
            None => {}
        }
        let Some(made) = self.done.get(&cell_name(campaign, cell)) else { return Known::Missing("new") };
        Known::Missing(match made {
            _ if made.id == id.to_string() => "gone",
            _ if made.seed != seed => "seed changed",
            _ if made.recipe != recipe(campaign, cell) => "scenario changed",
            _ if made.code != CODE => "code changed",
            _ => "training changed",
        })
    }
}

/// Whether it is known beforehand how many episodes a cell has, which may have been made for fewer.
fn is_counted(campaign: &Campaign, cell: Cell) -> bool {
    matches!(cell, Cell::Chunk { evaluation, .. } if campaign.evaluations[evaluation].halfwidth.is_none())
}

/// Updates or episodes that a cell has when it is finished.
fn amount(campaign: &Campaign, cell: Cell) -> u64 {
    match cell {
        Cell::Training(index) => {
            let training = &campaign.trainings[index];
            let update = (training.config.rollout_steps * training.environments) as u64;
            training.config.total_steps.div_ceil(update)
        }
        Cell::Chunk { evaluation, chunk } => campaign.evaluations[evaluation].chunk(chunk).len() as u64,
        Cell::Search(index) => campaign.searches[index].budget,
    }
}

fn recipe(campaign: &Campaign, cell: Cell) -> String {
    match cell {
        Cell::Training(index) => campaign.trainings[index].recipe.to_string(),
        Cell::Chunk { evaluation, .. } => campaign.evaluations[evaluation].recipe.to_string(),
        Cell::Search(index) => campaign.searches[index].recipe.to_string(),
    }
}

/// What a cell is, for people: it tells the cells of a campaign apart.
pub fn cell_name(campaign: &Campaign, cell: Cell) -> String {
    match cell {
        Cell::Training(index) => {
            format!("train {}", campaign.trainings[index].key)
        }
        Cell::Chunk { evaluation, chunk } => {
            let key = RunKey::of(&campaign.evaluations[evaluation]);
            let first = u64::from(chunk) * u64::from(CHUNK);
            format!("try {}, run {}, from episode {first}", key.cell.in_full(), key.run)
        }
        Cell::Search(index) => {
            let key = &campaign.searches[index].key;
            format!("search {key}, block {}", key.block)
        }
    }
}
