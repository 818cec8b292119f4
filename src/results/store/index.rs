use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{CODE, Header, Ids, Store, StoreError, vector_instructions};
use crate::campaign::{State, Task, tasks};
use crate::jobs::work;
use compile::{CHUNK, Campaign, ExternalProgram, Planned, changed_files};

/// What the store remembers of a campaign: the tasks that it wanted last, and the inputs from which each of its tasks was last made. It
/// only explains; a task is there or not there without it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Index {
    /// The names of all its tasks.
    pub wanted: BTreeSet<String>,
    /// What each of them is, and its size in units of its kind.
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
        let entry = |task| (ids.get(task).to_string(), (task_name(campaign, task), task.units(campaign)));
        self.plan = tasks(campaign).map(entry).collect();
        for task in tasks(campaign) {
            let id = ids.get(task);
            if store.head(id).is_some_and(|head| head.is_ok_and(|header| header.state == State::Finished)) {
                let (fingerprint, code) = (planned(campaign, task).origin().fingerprint.to_string(), CODE.to_string());
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

    /// The name of the task that was finished last under the names of this one, if this one differs from it only in its number of units.
    pub(super) fn shorter(&self, campaign: &Campaign, task: Task, seed: u64) -> Option<&str> {
        let lineage = lineage(campaign, task);
        if lineage.is_empty() {
            return None;
        }
        let made = self.done.get(&task_name(campaign, task))?;
        (made.lineage == lineage && made.seed == seed && made.code == CODE).then_some(made.id.as_str())
    }

    fn note_programs(&mut self, campaign: &Campaign, task: Task, fingerprint: &str) {
        let files = program_files(campaign, task);
        if !files.is_empty() {
            self.programs.insert(fingerprint.to_owned(), files);
        }
    }

    /// What is known of a task and, if it must be run, why.
    pub fn look(&self, store: &Store, campaign: &Campaign, task: Task, ids: &Ids, seed: u64) -> Known {
        let (id, wanted) = (ids.get(task), task.units(campaign));
        if let Some(program) = programs(campaign, task).find(|program| program.is_unknown())
            && store.head(id).is_some()
        {
            return Known::Missing(format!("`{}` declares no `files`", program.name));
        }
        match store.head(id) {
            Some(Ok(header)) => match header.state {
                State::Finished if header.done < wanted && work(&campaign.jobs[task.job]).kind().has_episodes => {
                    return Known::Begun(header.done, wanted);
                }
                State::Finished => return Known::Finished,
                State::Begun => return Known::Begun(header.done, wanted),
                State::Failed => return Known::Missing("failed".into()),
            },
            Some(Err(reason)) => return Known::Missing(reason.into()),
            None => {}
        }
        if let Some(Ok(header)) =
            self.shorter(campaign, task, seed).and_then(|name| store.head_of(&store.path_of(name)))
            && continues(&header, campaign, task)
        {
            return Known::Begun(header.done, wanted);
        }
        let Some(made) = self.done.get(&task_name(campaign, task)) else { return Known::Missing("new".into()) };
        let why = match made {
            _ if made.id == id.to_string() => "gone",
            _ if made.seed != seed => "seed changed",
            _ if made.fingerprint != planned(campaign, task).origin().fingerprint.to_string() => {
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

fn planned(campaign: &Campaign, task: Task) -> &dyn Planned {
    campaign.jobs[task.job].planned()
}

/// The programs of the user that a task depends on, those of the job that it needs included.
pub(super) fn programs(campaign: &Campaign, task: Task) -> impl Iterator<Item = &Arc<ExternalProgram>> {
    let job = planned(campaign, task);
    let needed = job.origin().needs.map(|place| &campaign.jobs[place].origin().programs);
    job.origin().programs.iter().chain(needed.into_iter().flat_map(|programs| programs.iter()))
}

/// The digests of the files of a task's programs, by their paths.
fn program_files(campaign: &Campaign, task: Task) -> BTreeMap<String, String> {
    programs(campaign, task).flat_map(|program| program.files.clone()).collect()
}

/// Which files of a task's programs have changed; `None` if none has.
fn changed(then: &BTreeMap<String, String>, campaign: &Campaign, task: Task) -> Option<String> {
    let now = program_files(campaign, task);
    let files = changed_files(then, &now);
    let more = if files.len() > 1 { format!(" and {} more files", files.len() - 1) } else { String::new() };
    files.first().map(|first| format!("`{first}`{more}"))
}

/// Whether a task can continue a finished one of its lineage: it has at most as many units.
pub(super) fn continues(header: &Header, campaign: &Campaign, task: Task) -> bool {
    header.state == State::Finished && header.done <= task.units(campaign)
}

/// What a task must share with one that it continues; empty where there is none.
fn lineage(campaign: &Campaign, task: Task) -> String {
    let job = planned(campaign, task);
    let bits = if job.depends_on_processor() { vector_instructions() } else { "portable" };
    job.lineage().map_or(String::new(), |lineage| format!("{lineage} {bits}"))
}

/// What a task is, for people. It distinguishes the tasks of a campaign.
pub fn task_name(campaign: &Campaign, task: Task) -> String {
    let job = work(&campaign.jobs[task.job]);
    let (verb, what) = (job.kind().verb, job.what());
    match job.kind().has_episodes {
        true => format!("{verb} {what}, from episode {}", u64::from(task.part) * u64::from(CHUNK)),
        false if task.part > 0 => format!("{verb} {what}, part {}", task.part + 1),
        false => format!("{verb} {what}"),
    }
}
