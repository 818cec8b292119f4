use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::jobs::work;
use crate::record::CellKey;
use crate::report::text_forms::is_formula;
use compile::{Evaluation, ExternalProgram, Job, Training};

/// All data that are needed to repeat a campaign.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of this program.
    pub version: String,
    /// Digest of the code that affects numbers; results of other code are not continued.
    pub code: String,
    pub campaign: String,
    /// The user's seed.
    pub seed: u64,
    /// Values that were set outside the files or by a `matrix`, as `name = value`.
    pub settings: Vec<String>,
    /// Whether it was a smoke run.
    pub smoke: bool,
    /// Whether every training and every episode is there.
    pub complete: bool,
    /// Whether the user stopped it.
    pub stopped: bool,
    /// The number of threads; they influence only the times.
    pub threads: usize,
    /// Vector instructions of the processor, on which the last bits of a training depend.
    pub vector_instructions: String,
    /// Simulator ticks of the evaluations.
    pub evaluation_ticks: u64,
    /// Episodes in which the driver failed as a program.
    pub errors: u64,
    /// Simulator ticks of the searches, without those of evaluations after them.
    pub search_ticks: u64,
    /// Wall time of the whole campaign (s).
    pub wall_time_s: f64,
    /// What was found about each driver under test, in a sentence.
    pub answer: Vec<String>,
    /// The input of the program, for a repetition.
    pub call: Call,
    /// The scenario files and the files that they name, in the order they were read.
    pub files: Vec<ScenarioFile>,
    pub trainings: Vec<TrainingRecord>,
    /// The other jobs that were asked for, in the order of the plan.
    pub runs: Vec<RunRecord>,
    /// The drivers that see no pedestrians.
    pub baselines: Vec<String>,
    /// The programs of the user that drive or walk.
    pub programs: Vec<ProgramRecord>,
    /// The other files of the report, by their paths in it. A manifest that was cut has none.
    #[serde(default)]
    pub report_files: Vec<FileRecord>,
}

/// The input of the program, besides the seed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Call {
    /// The folder in which it ran: other paths are relative to it.
    pub folder: String,
    /// The scenario files that were named.
    pub scenarios: Vec<String>,
    /// Each `--map`, as `TOWN=FILE`.
    pub maps: Vec<String>,
    /// Each `--set`, as `NAME=VALUE`.
    pub set: Vec<String>,
    /// Whether scenarios could start programs.
    pub allow_external: bool,
}

impl Call {
    /// The options that a repetition of an episode needs, with a blank after each.
    pub const fn replay_options(&self) -> &'static str {
        if self.allow_external { "--allow-external " } else { "" }
    }
}

/// A scenario file, or a map or model that it names.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScenarioFile {
    /// Its path as given.
    pub path: String,
    /// BLAKE3 of its contents.
    pub blake3: String,
    /// The file of the report that holds its contents, relative to the report's folder; empty for a file of the standard library and for
    /// one that is too large.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub held: String,
}

/// A job that was asked for, except a training.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Its short name.
    pub id: String,
    /// Its full key in words, which no other run of the campaign has.
    pub what: String,
    /// The number of episodes, or the budget in episodes or simulator ticks.
    pub amount: u64,
    /// Digest of what the files and settings say about it, without its training.
    pub fingerprint: String,
    /// Number of its block in the campaign, from 0.
    pub block: u32,
    /// The model of the car and the body of the pedestrian of an evaluation; empty of other jobs.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub vehicle: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub body: String,
    /// The name of the rule of its starts; empty of other jobs.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub spawn: String,
}

/// A program of the user that drives or walks.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProgramRecord {
    /// The name of the driver or the controller.
    pub name: String,
    /// As the scenario has it.
    pub command: String,
    /// The folder of the scenario, as the manifest has the paths of scenarios; empty for the one of the run.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub folder: String,
    /// The key `version` of the scenario; empty without one.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub version: String,
    /// Whether the report holds these files, in `programs/NAME`.
    pub is_held: bool,
    /// BLAKE3 of the files that the scenario declares, by their paths relative to the folder of the scenario.
    pub files: BTreeMap<String, String>,
}

impl ProgramRecord {
    /// The record of a program.
    pub fn new(program: &ExternalProgram) -> Self {
        Self {
            name: program.name.clone(),
            command: program.command.clone(),
            folder: program.folder.display().to_string(),
            version: program.version.clone().unwrap_or_default(),
            is_held: false,
            files: program.files.clone(),
        }
    }

    /// Whether it may have changed unnoticed: the scenario states neither its files nor its version.
    pub fn is_unknown(&self) -> bool {
        self.files.is_empty() && self.version.is_empty()
    }
}

/// A file with its digest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FileRecord {
    /// Its path as given.
    pub path: String,
    /// BLAKE3 of its contents.
    pub blake3: String,
    /// The number of its rows, if it is a Parquet table of a report.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rows: Option<u64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrainingRecord {
    pub town: String,
    pub driver: String,
    pub reward: String,
    pub run: u32,
    /// Decisions that were taken, demonstrations and those of all candidates included.
    pub decisions: u64,
    /// Wall time (s).
    pub wall_time_s: f64,
    /// File of the trained pedestrian, relative to the manifest; empty when the training failed.
    pub pedestrian: String,
    /// The error; empty without one.
    pub error: String,
    /// Digest of what the files and settings say about it.
    pub fingerprint: String,
}

impl RunRecord {
    /// The record of a job; `None` for a training, which has a record of its own.
    pub fn of(job: &Job) -> Option<Self> {
        if job.of::<Training>().is_some() {
            return None;
        }
        let (planned, work) = (job.planned(), work(job));
        let what = match work.kind().has_episodes {
            true => work.what(),
            false => format!("{} {}", work.kind().verb, work.what()),
        };
        let CellKey { vehicle, adversary: body, .. } = job.of().map(CellKey::of).unwrap_or_default();
        let spawn = job.of().map(|evaluation: &Evaluation| evaluation.scenario.spawn.name.clone());
        Some(Self {
            id: planned.origin().id.to_string(),
            what,
            amount: (0..planned.parts()).map(|part| planned.units(part)).sum(),
            fingerprint: planned.origin().fingerprint.to_string(),
            block: planned.origin().block,
            vehicle,
            body,
            spawn: spawn.unwrap_or_default(),
        })
    }
}

impl FileRecord {
    /// Makes a record of a file.
    pub fn new(path: String, contents: &[u8]) -> Self {
        Self { path, blake3: blake3::hash(contents).to_hex().to_string(), rows: None }
    }
}

impl Manifest {
    /// The manifest as TOML.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("strings and numbers have a form in TOML")
    }

    /// Reads a manifest.
    ///
    /// # Errors
    /// The error of the parser.
    pub fn from_toml(text: &str) -> Result<Self, String> {
        let manifest: Self = toml::from_str(text).map_err(|error| error.message().to_string())?;
        let mut names = vec![&manifest.campaign];
        names.extend(&manifest.baselines);
        names.extend(manifest.programs.iter().map(|program| &program.name));
        names.extend(manifest.runs.iter().flat_map(|run| [&run.vehicle, &run.body, &run.spawn]));
        names.extend(manifest.trainings.iter().flat_map(|each| [&each.town, &each.driver, &each.reward]));
        let wrong = names.into_iter().find(|name| is_formula(name)).map(|name| format!("`{name:.40}` is no name"));
        wrong.map_or(Ok(manifest), Err)
    }

    /// The command that makes the report again, for a shell.
    pub fn command(&self) -> String {
        let call = &self.call;
        let mut words = vec!["falsify".to_string(), "run".into()];
        words.extend(self.smoke.then(|| "--smoke".into()));
        words.extend(call.allow_external.then(|| "--allow-external".into()));
        words.push(format!("--seed {}", self.seed));
        for (option, values) in [("--map", &call.maps), ("--set", &call.set)] {
            words.extend(values.iter().map(|value| format!("{option} {}", quoted(value))));
        }
        words.extend(call.scenarios.iter().map(|file| quoted(file)));
        words.join(" ")
    }
}

/// A word, quoted if a shell would change it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-=:+".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}
