use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{CODE, Header, Ids, State, Store, StoreError, vector_instructions};
use crate::campaign::{Task, tasks};
use crate::record::RunKey;
use compile::{CHUNK, Campaign, ExternalProgram, changed_files};

/// What the store remembers of a campaign: the tasks that it wanted last, and the inputs from which each of its tasks was last made. It
/// only explains; a task is there or not there without it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Index {
    /// The names of all its tasks.
    pub wanted: BTreeSet<String>,
    /// What each of them is, and its size: updates, episodes, ticks.
    #[serde(default)]
    pub plan: BTreeMap<String, (String, u64)>,
    /// The command that it was last run with.
    #[serde(default)]
    pub command: String,
    /// The names of the tasks that this command was to make: those of its shard; all without any.
    #[serde(default)]
    pub own: BTreeSet<String>,
    /// The folder for reports that it was last run for, for people.
    #[serde(default)]
    pub out: String,
    /// The finished tasks, by what they are.
    done: BTreeMap<String, Made>,
    /// The files of programs that finished tasks were made with: their digests by their paths, by the fingerprint of the task.
    #[serde(default)]
    programs: BTreeMap<String, BTreeMap<String, String>>,
}

/// The inputs from which a task was made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Made {
    id: String,
    fingerprint: String,
    code: String,
    seed: u64,
    /// The lineage of a training; empty for other tasks and for trainings without one.
    #[serde(default)]
    lineage: String,
}

/// What is known of a task before a run.
#[derive(Debug, Clone, PartialEq)]
pub enum Known {
    /// It is stored.
    Finished,
    /// A part of it is stored: a number of its updates or episodes.
    Begun(u64, u64),
    /// It is not stored, or not used, for this reason.
    Missing(String),
    /// It was made with other files of a program: these, in words.
    Edited(String),
}

impl Index {
    /// What the store remembers of a campaign; empty when there is nothing, or it is damaged.
    ///
    /// # Errors
    /// Its file is there and cannot be read.
    pub fn read(store: &Store, name: &str) -> Result<Self, StoreError> {
        let text = store.campaign_text(name)?;
        Ok(text.and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default())
    }

    /// Records what a campaign wants, and which of these tasks are stored.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&mut self, store: &Store, name: &str, campaign: &Campaign, seed: u64) -> Result<(), StoreError> {
        let ids = Ids::new(campaign, seed);
        self.wanted = tasks(campaign).map(|task| ids.get(task).to_string()).collect();
        let planned = |task| (ids.get(task).to_string(), (task_name(campaign, task), amount(campaign, task)));
        self.plan = tasks(campaign).map(planned).collect();
        for task in tasks(campaign) {
            let id = ids.get(task);
            if store.head(id).is_some_and(|head| head.is_ok_and(|header| header.state == State::Finished)) {
                let (fingerprint, code) = (fingerprint(campaign, task), CODE.to_string());
                self.note_programs(campaign, task, &fingerprint);
                let made = Made { id: id.to_string(), fingerprint, code, seed, lineage: lineage(campaign, task) };
                self.done.insert(task_name(campaign, task), made);
            }
        }
        let done: BTreeSet<&String> = self.done.values().map(|made| &made.fingerprint).collect();
        self.programs.retain(|fingerprint, _| done.contains(fingerprint));
        self.out = store.place().out().to_string_lossy().into_owned();
        let text = serde_json::to_string(self).expect("strings and numbers have a form in JSON");
        store.put_campaign_text(name, &text)
    }

    /// The name of the training that was finished last under the names of this one, if this one differs from it only in its steps.
    pub(super) fn shorter(&self, campaign: &Campaign, training: usize, seed: u64) -> Option<&str> {
        let task = Task::Training(training);
        let made = self.done.get(&task_name(campaign, task))?;
        let lineage = lineage(campaign, task);
        let same = !lineage.is_empty() && made.lineage == lineage && made.seed == seed && made.code == CODE;
        same.then_some(made.id.as_str())
    }

    fn note_programs(&mut self, campaign: &Campaign, task: Task, fingerprint: &str) {
        let files = program_files(campaign, task);
        if !files.is_empty() {
            self.programs.insert(fingerprint.to_owned(), files);
        }
    }

    /// What is known of a task and, if it must be run, why.
    pub fn look(&self, store: &Store, campaign: &Campaign, task: Task, ids: &Ids, seed: u64) -> Known {
        let (id, wanted) = (ids.get(task), amount(campaign, task));
        if let Some(program) = programs(campaign, task).find(|program| program.is_unknown())
            && store.head(id).is_some()
        {
            return Known::Missing(format!("`{}` declares no `files`", program.name));
        }
        match store.head(id) {
            Some(Ok(header)) => match header.state {
                State::Finished if header.done < wanted && is_counted(task) => {
                    return Known::Begun(header.done, wanted);
                }
                State::Finished => return Known::Finished,
                State::Begun => return Known::Begun(header.done, wanted),
                State::Failed => return Known::Missing("failed".into()),
            },
            Some(Err(reason)) => return Known::Missing(reason.into()),
            None => {}
        }
        if let Task::Training(training) = task
            && let Some(Ok(header)) =
                self.shorter(campaign, training, seed).and_then(|name| store.head_of(&store.path_of(name)))
            && continues(&header, campaign, task)
        {
            return Known::Begun(header.done, wanted);
        }
        let Some(made) = self.done.get(&task_name(campaign, task)) else { return Known::Missing("new".into()) };
        let why = match made {
            _ if made.id == id.to_string() => "gone",
            _ if made.seed != seed => "seed changed",
            _ if made.fingerprint != fingerprint(campaign, task) => {
                let then = self.programs.get(&made.fingerprint);
                if let Some(files) = then.and_then(|then| changed(then, campaign, task)) {
                    return Known::Edited(files);
                }
                "scenario changed"
            }
            _ if made.code != CODE => "code changed",
            _ => "training changed",
        };
        Known::Missing(why.into())
    }
}

/// The programs of the user that a task depends on, those of its training included.
pub(super) fn programs(campaign: &Campaign, task: Task) -> impl Iterator<Item = &Arc<ExternalProgram>> {
    let (own, training) = match task {
        Task::Training(index) => (&campaign.trainings[index].programs, None),
        Task::Chunk { evaluation, .. } => {
            (&campaign.evaluations[evaluation].programs, campaign.evaluations[evaluation].training())
        }
        Task::Search(index) => (&campaign.searches[index].programs, None),
        Task::Estimate(index) => (&campaign.estimations[index].programs, None),
        Task::Cover(index) => (&campaign.covers[index].programs, None),
        Task::Harden(index) => (&campaign.hardenings[index].programs, None),
    };
    own.iter().chain(training.into_iter().flat_map(|index| campaign.trainings[index].programs.iter()))
}

/// The digests of the files of a task's programs, by their paths.
fn program_files(campaign: &Campaign, task: Task) -> BTreeMap<String, String> {
    programs(campaign, task).flat_map(|program| program.files.clone()).collect()
}

/// Which files of a task's programs have changed; none when none has.
fn changed(then: &BTreeMap<String, String>, campaign: &Campaign, task: Task) -> Option<String> {
    let now = program_files(campaign, task);
    let files = changed_files(then, &now);
    let more = if files.len() > 1 { format!(" and {} more files", files.len() - 1) } else { String::new() };
    files.first().map(|first| format!("`{first}`{more}"))
}

/// Whether the number of episodes of a task is known in advance. A stored task may have been made for fewer.
fn is_counted(task: Task) -> bool {
    matches!(task, Task::Chunk { .. })
}

/// The number of updates or episodes of a finished task.
fn amount(campaign: &Campaign, task: Task) -> u64 {
    match task {
        Task::Training(index) => {
            let training = &campaign.trainings[index];
            let update = (training.config.rollout_steps * training.environments) as u64;
            training.config.total_steps.div_ceil(update)
        }
        Task::Chunk { evaluation, chunk } => campaign.evaluations[evaluation].chunk(chunk).len() as u64,
        Task::Search(index) => campaign.searches[index].budget,
        Task::Estimate(index) => campaign.estimations[index].budget,
        Task::Cover(index) => campaign.covers[index].budget.into(),
        Task::Harden(index) => campaign.hardenings[index].budget(),
    }
}

/// Whether a training can continue from a finished one of its lineage: it has at most as many updates.
pub(super) fn continues(header: &Header, campaign: &Campaign, task: Task) -> bool {
    header.state == State::Finished && header.done <= amount(campaign, task)
}

/// What a training must share with one that it continues; empty where there is none.
fn lineage(campaign: &Campaign, task: Task) -> String {
    let Task::Training(index) = task else { return String::new() };
    let training = &campaign.trainings[index];
    let bits = if training.config.portable_bits { "portable" } else { vector_instructions() };
    training.lineage.map_or(String::new(), |lineage| format!("{lineage} {bits}"))
}

fn fingerprint(campaign: &Campaign, task: Task) -> String {
    match task {
        Task::Training(index) => campaign.trainings[index].fingerprint.to_string(),
        Task::Chunk { evaluation, .. } => campaign.evaluations[evaluation].fingerprint.to_string(),
        Task::Search(index) => campaign.searches[index].fingerprint.to_string(),
        Task::Estimate(index) => campaign.estimations[index].fingerprint.to_string(),
        Task::Cover(index) => campaign.covers[index].fingerprint.to_string(),
        Task::Harden(index) => campaign.hardenings[index].fingerprint.to_string(),
    }
}

/// What a task is, for people. It distinguishes the tasks of a campaign.
pub fn task_name(campaign: &Campaign, task: Task) -> String {
    match task {
        Task::Training(index) => {
            format!("train {}", campaign.trainings[index].key)
        }
        Task::Chunk { evaluation, chunk } => {
            let key = RunKey::of(&campaign.evaluations[evaluation]);
            let first = u64::from(chunk) * u64::from(CHUNK);
            format!("evaluate {}, run {}, from episode {first}", key.cell.in_full(), key.run)
        }
        Task::Search(index) => {
            let key = &campaign.searches[index].key;
            format!("search {key}, block {}", key.block)
        }
        Task::Estimate(index) => {
            let key = &campaign.estimations[index].key;
            format!("estimate {key}, block {}", key.block)
        }
        Task::Cover(index) => {
            let key = &campaign.covers[index].key;
            format!("cover {key}, block {}", key.block)
        }
        Task::Harden(index) => {
            let key = &campaign.hardenings[index].key;
            format!("harden {key}, block {}", key.block)
        }
    }
}
