//! Scenario files, and the choice of one scenario of them.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use base::diagnostic::{Colour, Severity, Sources, records, render};
use base::files;
use compile::{Catalog, Overrides, Plan, Search, SearchKey, compile_with, episodes_seed};
use episode::Scenario;
use lang::{Reader, Unreadable, library};
use numpy::PyReadonlyArray2;
use process::ProcessOpener;
use pyo3::exceptions::{PyFileNotFoundError, PyIsADirectoryError, PyOSError, PyPermissionError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use verdict::Sizes;

use super::driver::{Raised, with_driver};
use super::recording::judged;
use super::world::Starts;
use super::worlds::Worlds;

/// Reads regular files of the disk.
struct Disk;

impl Reader for Disk {
    fn text(&self, path: &Path) -> std::io::Result<String> {
        files::text(path)
    }

    fn bytes(&self, path: &Path) -> std::io::Result<Vec<u8>> {
        files::bytes(path)
    }

    fn identity(&self, path: &Path) -> PathBuf {
        files::identity(path)
    }
}

/// The names that choose a scenario of a plan, and the scenario.
#[pyclass(module = "falsify_av._core", frozen)]
#[derive(Clone)]
pub struct Choice {
    /// Name of the campaign.
    pub campaign: String,
    /// The block it is from: `train`, `evaluate` or `search`.
    pub task: &'static str,
    /// Number of the block among those of its kind; 0 for `train`.
    pub block: u32,
    /// Name of the town.
    pub town: String,
    /// Name of the driver.
    pub policy: String,
    /// Name of the reward; empty if the block has none.
    pub reward: String,
    /// The scenario.
    pub scenario: Arc<Scenario>,
    pub starts: Starts,
}

impl Choice {
    /// Whether the names agree that a user gives.
    fn names(&self) -> (&str, &str, &str, &str) {
        (&self.campaign, &self.town, &self.policy, &self.reward)
    }
}

/// Every scenario of a plan: of each campaign first those of trainings, then those of evaluations, then those of searches.
fn choices(plan: &Plan) -> Vec<Choice> {
    let mut all = Vec::new();
    for campaign in &plan.campaigns {
        let choice = |task, block, town: &str, policy: &str, reward: &str, scenario: &Arc<Scenario>| {
            let place: Arc<str> = town.into();
            Choice {
                campaign: campaign.name.clone(),
                task,
                block,
                town: town.into(),
                policy: policy.into(),
                reward: reward.into(),
                scenario: scenario.clone(),
                starts: Arc::new(move |seed| episodes_seed(seed, &place)),
            }
        };
        all.extend(campaign.all::<compile::Training>().map(|training| {
            let key = &training.key;
            choice("train", 0, &key.town, &key.policy, &key.reward, &training.scenario)
        }));
        all.extend(campaign.all::<compile::Evaluation>().map(|evaluation| {
            let reward = &evaluation.trained.reward;
            choice(
                "evaluate",
                evaluation.origin.block,
                &evaluation.town,
                &evaluation.policy,
                reward,
                &evaluation.scenario,
            )
        }));
        all.extend(campaign.all::<Search>().map(|search| {
            let key = &search.key;
            let first = Search { key: SearchKey { run: 0, ..key.clone() }, ..search.clone() };
            let starts: Starts = Arc::new(move |seed| first.starts(seed));
            Choice { starts, ..choice("search", key.block, &key.town, &key.policy, &key.reward, &search.scenario) }
        }));
    }
    // An evaluation has one entry for each controller, a training one for each run.
    let mut seen = std::collections::BTreeSet::new();
    all.retain(|each| {
        let names = each.names();
        seen.insert((each.task, each.block, [names.0, names.1, names.2, names.3].map(String::from)))
    });
    all
}

/// The scenarios of checked files.
#[pyclass(module = "falsify_av._core", frozen)]
pub struct Scenarios {
    choices: Vec<Choice>,
    /// Why there may be none, in words.
    without_campaigns: String,
}

/// Reads, checks and compiles files. Returns the scenarios (none when the files have errors), the diagnostics as text, and the diagnostics
/// as JSON.
#[pyfunction]
#[pyo3(signature = (files, settings, maps, allow_external))]
pub fn load(
    py: Python<'_>,
    files: Vec<PathBuf>,
    settings: Vec<String>,
    maps: Vec<(String, PathBuf)>,
    allow_external: bool,
) -> PyResult<(Option<Scenarios>, String, String)> {
    py.detach(|| {
        let catalog = match allow_external {
            true => Catalog::builtin().with_opener(Arc::new(ProcessOpener::default())),
            false => Catalog::builtin(),
        };
        let mut sources = Sources::default();
        let overrides = Overrides { maps: maps.into_iter().collect(), settings, ..Overrides::default() };
        let compiled = compile_with(&files, &overrides, &catalog, &Disk, &mut sources).map_err(unreadable)?;
        let text: Vec<String> = compiled.diagnostics.iter().map(|each| render(each, &sources, Colour::Never)).collect();
        let known = records(&compiled.diagnostics, &sources);
        let known = serde_json::to_string(&known).map_err(|error| PyValueError::new_err(error.to_string()))?;
        let wrong = compiled.diagnostics.iter().any(|each| each.severity == Severity::Error);
        let plan = compiled.plan.filter(|_| !wrong);
        if let Some(town) = plan.as_ref().and_then(|plan| overrides.maps.keys().find(|town| !plan.has_town(town))) {
            return Err(PyValueError::new_err(format!("a map is given for the town `{town}`, which nothing uses")));
        }
        let scenarios =
            plan.map(|plan| Scenarios { choices: choices(&plan), without_campaigns: plan.without_campaigns() });
        Ok((scenarios, text.join("\n"), known))
    })
}

/// The bytes of a network of the standard library, an ONNX file.
#[pyfunction]
pub fn shipped_network(name: &str) -> PyResult<&'static [u8]> {
    let network = library::place(&format!("std/{name}")).and_then(|place| library::network(&place));
    network.ok_or_else(|| PyValueError::new_err(format!("the library has no network `{name}`")))
}

/// The exception of a file that cannot be read.
fn unreadable(error: Unreadable) -> PyErr {
    match error.source.kind() {
        ErrorKind::NotFound => PyFileNotFoundError::new_err(error.to_string()),
        ErrorKind::IsADirectory => PyIsADirectoryError::new_err(error.to_string()),
        ErrorKind::PermissionDenied => PyPermissionError::new_err(error.to_string()),
        _ => PyOSError::new_err(error.to_string()),
    }
}

#[pymethods]
impl Scenarios {
    /// The names of every scenario: campaign, task, block, town, driver, reward.
    fn choices(&self) -> Vec<(String, &'static str, u32, String, String, String)> {
        let names = |each: &Choice| {
            let (campaign, town, policy, reward) = each.names();
            (campaign.into(), each.task, each.block, town.into(), policy.into(), reward.into())
        };
        self.choices.iter().map(names).collect()
    }

    /// The scenario with these names. Names that are not given must leave one choice; of several blocks with it the first one counts, in the
    /// order `train`, `evaluate`, `search`.
    #[pyo3(signature = (campaign=None, town=None, driver=None, reward=None, task=None, block=None))]
    fn choose(
        &self,
        campaign: Option<&str>,
        town: Option<&str>,
        driver: Option<&str>,
        reward: Option<&str>,
        task: Option<&str>,
        block: Option<u32>,
    ) -> PyResult<Choice> {
        let mut left: Vec<&Choice> = self.choices.iter().collect();
        if left.is_empty() {
            return Err(PyValueError::new_err(self.without_campaigns.clone()));
        }
        narrow(&mut left, "campaign", campaign, |each| each.campaign.clone())?;
        narrow(&mut left, "task", task, |each| each.task.into())?;
        narrow(&mut left, "block", block.map(|block| block.to_string()).as_deref(), |each| each.block.to_string())?;
        narrow(&mut left, "town", town, |each| each.town.clone())?;
        narrow(&mut left, "driver", driver, |each| each.policy.clone())?;
        narrow(&mut left, "reward", reward, |each| each.reward.clone())?;
        let first = left[0];
        let place = |name: &str, of: fn(&Choice) -> &str| {
            let names: Vec<&str> = left.iter().map(|each| of(each)).collect();
            let names = distinct(names.iter().map(|name| name.to_string()));
            (names.len() > 1).then(|| format!("{name}= one of {}", listed(names)))
        };
        let open: Vec<String> = [
            place("campaign", |each| &each.campaign),
            place("town", |each| &each.town),
            place("driver", |each| &each.policy),
            place("reward", |each| &each.reward),
        ]
        .into_iter()
        .flatten()
        .collect();
        if !open.is_empty() {
            let text = format!("several scenarios have these names; choose with {}", open.join("; "));
            return Err(PyValueError::new_err(text));
        }
        Ok(first.clone())
    }
}

#[pymethods]
impl Choice {
    /// Makes worlds of the scenario. `driver` replaces the driver under test: a function without arguments that makes a function from messages
    /// to answers.
    #[pyo3(signature = (count, seed, driver=None))]
    fn worlds(&self, py: Python<'_>, count: usize, seed: u64, driver: Option<Py<PyAny>>) -> PyResult<Worlds> {
        let raised = Raised::default();
        let mut chosen = self.clone();
        if let Some(driver) = driver {
            chosen.scenario = Arc::new(with_driver(&chosen.scenario, driver, &raised));
        }
        py.detach(|| Worlds::new(&chosen, count, seed, raised))
    }

    /// Judges tracks that were recorded elsewhere: see [`judged`].
    #[pyo3(signature = (ego, pedestrian, dt, sizes, boxes=None))]
    fn judged<'py>(
        &self,
        py: Python<'py>,
        ego: PyReadonlyArray2<'_, f64>,
        pedestrian: PyReadonlyArray2<'_, f64>,
        dt: f64,
        sizes: [Option<f64>; 4],
        boxes: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let [length, width, radius, full_brake] = sizes;
        let sizes = Sizes { length, width, radius, full_brake };
        judged(py, &self.scenario, &ego, &pedestrian, dt, sizes, boxes.as_ref())
    }
}

/// Keeps the choices with a name; the error lists the names there are.
fn narrow(left: &mut Vec<&Choice>, what: &str, wanted: Option<&str>, name: impl Fn(&Choice) -> String) -> PyResult<()> {
    let Some(wanted) = wanted else { return Ok(()) };
    let kept: Vec<&Choice> = left.iter().copied().filter(|each| name(each) == wanted).collect();
    if kept.is_empty() {
        let known = distinct(left.iter().map(|each| name(each)));
        let text = format!("there is no {what} `{wanted}` here; there is {}", listed(known));
        return Err(PyValueError::new_err(text));
    }
    *left = kept;
    Ok(())
}

/// Names in a sentence; that of a scenario without a reward is empty.
fn listed(names: Vec<String>) -> String {
    let shown = names.into_iter().map(|name| if name.is_empty() { "\"\" (none)".into() } else { name });
    shown.collect::<Vec<_>>().join(", ")
}

/// Each name once, in order.
fn distinct(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for name in names {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all
}
