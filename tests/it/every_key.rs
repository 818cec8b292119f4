//! Every documented key can change an outcome.
//!
//! For each key of each kind there are two scenarios that differ in this key alone and end differently. The keys come from the catalogue of
//! the language, so a new key is tried without an entry here: values from its type and its bounds take the place of its default until an
//! outcome differs. `tests/suite/keys.toml` has what a key needs beyond that, and the keys that may change nothing, with the reason.
//!
//! An outcome is what a report shows: how an episode ended, after which time, at which speed, with which verdict and reward; the learning curve
//! of a training; the failures of a search; the tables of a report.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::{Arc, LazyLock};

use base::diagnostic::{Diagnostic, Severity, Sources};
use base::seed::Seed;
use base::signature::{Form, Param, Signature, Type};
use base::units::Dimension;
use compile::{Campaign, Catalog, Cover, Estimation, Evaluation, Harden, Job, Plan, Planned, Pricing, compile};
use episode::{Ending, Outcome, Trace, WORLD_PROTOCOL};
use falsify::session::{Input, RunOptions, Session};
use lang::Reader;
use learn::ActorCritic;
use rand::RngExt;
use results::campaign::{self, NoStore, Silent, Task};
use results::jobs::{SearchResult, TrainingResult, watch};
use results::record::{EpisodeRow, RunKey};
use serde::Deserialize;
use serde_json::json;
use verdict::{Judged, Verdict};
use world::av::external::{Link, Opener, Program};
use world::av::{Exit, Fault};

/// What the scenarios are made of: `tests/suite/keys.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    /// Declarations of each form, `the_FORM` and `other_FORM`. That under test takes the place of the first.
    stage: BTreeMap<String, String>,
    /// The blocks of the campaign around a declaration under test, by its form; `*` for all others.
    campaign: BTreeMap<String, String>,
    /// Keys that a declaration or a block has besides the key under test: those that must be given, and those that keep the work small. The
    /// text of the key `+` is put in as it is.
    given: BTreeMap<String, BTreeMap<String, String>>,
    /// What a key needs to show its effect.
    needs: BTreeMap<String, Need>,
    /// Keys that may change no outcome, and why.
    silent: BTreeMap<String, String>,
}

/// What a key needs to show its effect.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Need {
    /// Keys of the same declaration or block; one with an empty text is left out.
    with: BTreeMap<String, String>,
    /// Other declarations of the stage, instead of those of their forms; `campaign` for the blocks of the campaign.
    stage: BTreeMap<String, String>,
    /// The value under test; without it, values of its type are tried.
    value: Option<String>,
    /// Whether the tables of a report are compared instead of the episodes, as always for published figures.
    report: bool,
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/suite/keys.toml");
    toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
});

/// A catalogue whose external drivers, controllers and worlds run inside the test.
fn catalog() -> Catalog {
    Catalog::builtin().with_opener(Arc::new(Inside)).with_map_writer(Arc::new(|_| Ok(String::new())))
}

/// Opens programs that need half a second for everything. A driver brakes for the number of actors that it knows of, and keeps less of its speed
/// the nearer the end of its route is; the argument of the command, the number of its files and its parameters are its acceleration. A pedestrian walks at the car at
/// that speed. In a world the car is slowed down by that deceleration, and it needs two seconds for a town.
struct Inside;

impl Opener for Inside {
    fn asks(&self) -> bool {
        true
    }

    fn open(&self, program: &Program) -> Result<Box<dyn Link>, Fault> {
        let argument: f64 = program.words.get(1).and_then(|word| word.parse().ok()).unwrap_or(1.0);
        let argument = argument + program.files.len() as f64 + program.parameters.values().sum::<f64>();
        Ok(Box::new(InsideLink { argument, car: json!(null), is_native: false, answer: Vec::new() }))
    }
}

struct InsideLink {
    argument: f64,
    /// The car of a world, and whether a driver of the world drives it.
    car: serde_json::Value,
    is_native: bool,
    answer: Vec<u8>,
}

impl InsideLink {
    /// The answer of a world. Its second driver brakes harder than the first.
    fn world(&mut self, message: &serde_json::Value, limit: f64) -> Result<serde_json::Value, Fault> {
        match message["type"].as_str() {
            Some("hello") => Ok(
                json!({ "protocol": WORLD_PROTOCOL, "name": "inside", "version": "1", "drivers": ["first", "second"],
                "friction": true, "lights": true, "seeds": true }),
            ),
            Some("load") if limit < 2.0 => Err(Fault::Late { limit_ms: 2000 }),
            Some("load") => Ok(json!({ "lanes": null })),
            Some(kind) => {
                if kind == "begin" {
                    self.car = message["ego"].clone();
                    self.is_native = message["driver"].is_string();
                    self.argument += if message["driver"] == "second" { 3.0 } else { 0.0 };
                } else {
                    let [x, y, yaw, speed] = ["x", "y", "yaw", "speed"].map(|key| self.car[key].as_f64().unwrap());
                    let ours = message["control"]["acceleration"].as_f64().filter(|_| !self.is_native).unwrap_or(0.0);
                    let (way, slower) = (speed * 0.05, (speed + (ours - self.argument) * 0.05).max(0.0));
                    self.car = json!({ "x": x + way * libm::cos(yaw), "y": y + way * libm::sin(yaw), "yaw": yaw, "speed": slower });
                }
                let places = message["pedestrians"].as_array().unwrap().iter();
                let places: Vec<_> = places.map(|walker| json!([walker["x"], walker["y"]])).collect();
                let tick = message["tick"].as_u64().unwrap_or(0);
                Ok(json!({ "tick": tick, "ego": self.car, "pedestrians": places }))
            }
            None => Err(Fault::Answer("a message without a type")),
        }
    }
}

impl Link for InsideLink {
    fn send(&mut self, message: &[u8], limit: f64) -> Result<(), Fault> {
        if limit < 0.5 {
            return Err(Fault::Late { limit_ms: 500 });
        }
        let message: serde_json::Value = serde_json::from_slice(message).unwrap();
        if message["protocol"] == WORLD_PROTOCOL || message["worlds"].is_null() && message["type"] != "hello" {
            self.answer = serde_json::to_vec(&self.world(&message, limit)?).unwrap();
            return Ok(());
        }
        let action = |world: &serde_json::Value| {
            if world["state"].is_array() {
                return json!({ "id": world["id"], "action": [0.0, self.argument] });
            }
            let count = |key: &str| world[key].as_array().unwrap().len() as f64;
            let acceleration = self.argument * count("route") / 20.0 - 2.0 * count("actors");
            json!({ "id": world["id"], "acceleration": acceleration })
        };
        let answer = match message["worlds"].as_array() {
            Some(worlds) => json!({ "actions": worlds.iter().map(action).collect::<Vec<_>>() }),
            None => json!({ "protocol": message["protocol"] }),
        };
        self.answer = serde_json::to_vec(&answer).unwrap();
        Ok(())
    }

    fn line(&mut self, line: &mut Vec<u8>, _: usize) -> Result<(), Fault> {
        line.append(&mut self.answer);
        Ok(())
    }

    fn exact(&mut self, _: &mut [u8]) -> Result<(), Fault> {
        Err(Fault::Ended(Exit::Unknown))
    }
}

/// Reads one text as `keys.scn`, two maps, four networks that drive, two that walk, and networks of a training.
struct Files(String);

impl Reader for Files {
    fn text(&self, path: &Path) -> std::io::Result<String> {
        match path.file_name().and_then(|name| name.to_str()) {
            Some("keys.scn") => Ok(self.0.clone()),
            Some("long.xodr") => Ok(map(300.0)),
            Some("short.xodr") => Ok(map(120.0)),
            _ => Err(std::io::ErrorKind::NotFound.into()),
        }
    }

    fn bytes(&self, path: &Path) -> std::io::Result<Vec<u8>> {
        let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/onnx/follow.onnx");
        match path.file_name().and_then(|name| name.to_str()) {
            Some("follow.onnx") => std::fs::read(model),
            // The same with half the gain.
            Some("gentle.onnx") => {
                let mut bytes = std::fs::read(model)?;
                let gain = [4.0_f32.to_le_bytes(), 1.0_f32.to_le_bytes()].concat();
                let place = bytes.windows(8).position(|window| window == gain).expect("the network has a gain");
                bytes[place..place + 4].copy_from_slice(&2.0_f32.to_le_bytes());
                Ok(bytes)
            }
            Some("policy.bin") => Ok(POLICIES[0].clone()),
            Some("other.bin") => Ok(POLICIES[1].clone()),
            Some("walker.onnx") => Ok(walker(1)),
            Some("stroller.onnx") => Ok(walker(2)),
            Some("start.safetensors") => Ok(networks(3, &[64, 64]).to_safetensors(&BTreeMap::new())),
            _ => self.text(path).map(String::into_bytes),
        }
    }
}

/// The weights of two networks without training that drive as PufferDrive's policy.
static POLICIES: LazyLock<[Vec<u8>; 2]> = LazyLock::new(|| {
    [1, 2].map(|seed| {
        let mut stream = Seed::root(seed).stream();
        (0..614_172).flat_map(|_| (stream.random::<f32>() - 0.5).to_le_bytes()).collect()
    })
});

/// A network without training that controls a pedestrian.
fn walker(seed: u64) -> Vec<u8> {
    let bounds = [(-std::f64::consts::PI, std::f64::consts::PI), (0.0, 3.5)];
    networks(seed, &[8]).to_onnx(&bounds, &BTreeMap::new())
}

/// Networks without training.
fn networks(seed: u64, hidden: &[usize]) -> ActorCritic {
    ActorCritic::new(4, 2, hidden, 0.0, &mut Seed::root(seed).stream())
}

/// A straight street of this length (m) as OpenDRIVE.
fn map(length: f64) -> String {
    let lane = |id: i32, kind: &str| {
        format!(
            "<lane id=\"{id}\" type=\"{kind}\" level=\"false\"><width sOffset=\"0\" a=\"3.5\" b=\"0\" c=\"0\" d=\"0\"/></lane>"
        )
    };
    format!(
        "<OpenDRIVE><header revMajor=\"1\" revMinor=\"4\"/><road name=\"\" length=\"{length}\" id=\"1\" junction=\"-1\">\
         <type s=\"0\" type=\"town\"><speed max=\"40\" unit=\"km/h\"/></type>\
         <planView><geometry s=\"0\" x=\"0\" y=\"0\" hdg=\"0\" length=\"{length}\"><line/></geometry></planView>\
         <lanes><laneSection s=\"0\"><left>{}</left><center>{}</center><right>{}</right></laneSection></lanes></road></OpenDRIVE>",
        lane(1, "driving"),
        lane(0, "none"),
        lane(-1, "driving")
    )
}

/// A key of the language.
struct Key<'a> {
    form: &'a Form,
    /// The kind; none for `form name { … }`.
    kind: Option<&'a Signature>,
    block: Option<&'a Signature>,
    param: &'a Param,
}

/// `driver idm.margin`, `town.street.through`, `sensors *.near` for any kind.
fn path_of(form: &str, kind: Option<&str>, block: Option<&str>, key: &str) -> String {
    let kind = kind.map_or(String::new(), |kind| format!(" {kind}"));
    let block = block.map_or(String::new(), |block| format!(".{block}"));
    let key = if key.is_empty() { String::new() } else { format!(".{key}") };
    format!("{form}{kind}{block}{key}")
}

impl Key<'_> {
    /// The names of an entry in the tables: its own, and that for any kind.
    fn paths(&self, key: &str) -> [String; 2] {
        let (form, block) = (self.form.name, self.block.map(|block| block.name));
        [path_of(form, self.kind.map(|kind| kind.name), block, key), path_of(form, Some("*"), block, key)]
    }

    fn entry<T>(&self, table: &'static BTreeMap<String, T>, key: &str) -> Option<&'static T> {
        self.paths(key).iter().find_map(|path| table.get(path))
    }

    /// The keys that the declaration or the block has in any case.
    fn given(&self) -> BTreeMap<String, String> {
        self.entry(&TABLES.given, "").cloned().unwrap_or_default()
    }

    /// The scenario in which this key has a value, or is left as it is.
    fn scenario(&self, value: Option<&str>, need: &Need) -> String {
        let form = self.form.name;
        let mut text = String::from("edition 1\n");
        for (other, declared) in TABLES.stage.iter().filter(|(other, _)| *other != form) {
            let _ = writeln!(text, "{}", need.stage.get(other).unwrap_or(declared));
        }
        // Other declarations of the form are not under test.
        let others = TABLES.stage.get(form).map_or("", String::as_str);
        if let Some((_, other)) = others.split_once(&format!("{form} other_{form}")) {
            let _ = writeln!(text, "{form} other_{form}{other}");
        }
        let kind = self.kind.map_or(String::new(), |kind| format!(" = {}", kind.name));
        let own = Some((self.param.name, value));
        let top = Key { block: None, ..*self };
        let _ = match self.block {
            None => write!(text, "{form} the_{form}{kind} {{\n{}", self.body(&need.with, own)),
            Some(_) => write!(text, "{form} the_{form}{kind} {{\n{}", top.body(&BTreeMap::new(), None)),
        };
        if form == "campaign" {
            for (block, written) in &TABLES.campaign {
                if self.block.is_some_and(|own| own.name == block) {
                    let _ = writeln!(text, "{block} {{\n{}}}", self.body(&need.with, own));
                } else if matches!(block.as_str(), "train" | "evaluate" | "search") {
                    let _ = writeln!(text, "{written}");
                }
            }
            return text + "}\n";
        }
        if let Some(block) = self.block {
            // Streets have names.
            let name = if block.name == "street" { " under_test" } else { "" };
            let _ = writeln!(text, "{}{name} {{\n{}}}", block.name, self.body(&need.with, own));
        }
        let blocks = TABLES.campaign.get(form).unwrap_or(&TABLES.campaign["*"]);
        let blocks = need.stage.get("campaign").unwrap_or(blocks);
        let _ = writeln!(
            text,
            "}}\ncampaign c {{\n  vehicle: the_vehicle  body: the_body  spawn: the_spawn  episode: the_episode\n{blocks}\n}}"
        );
        text
    }

    /// The keys of a declaration or a block, with the value of the one under test.
    fn body(&self, with: &BTreeMap<String, String>, own: Option<(&str, Option<&str>)>) -> String {
        let mut keys = self.given();
        keys.extend(with.clone());
        keys.retain(|_, value| !value.is_empty());
        if let Some((name, Some(value))) = own {
            keys.insert(name.to_string(), value.to_string());
        }
        let rest = keys.remove("+").unwrap_or_default();
        keys.iter().map(|(name, value)| format!("  {name}: {value}\n")).collect::<String>() + &rest + "\n"
    }

    /// The value that the key has when it is left as it is.
    fn present(&self, need: &Need) -> Option<String> {
        let written = need.with.get(self.param.name).cloned().or_else(|| self.given().remove(self.param.name));
        written.or_else(|| self.param.default.map(str::to_string)).filter(|value| !value.is_empty())
    }
}

/// Values of a type to try, those far from the present one first.
fn values(ty: &Type, present: Option<&str>) -> Vec<String> {
    let quantity = |dimension: &Dimension, min: f64, max: f64| -> Vec<f64> {
        let known =
            present.and_then(|text| text.split_whitespace().next()).and_then(|number| number.parse::<f64>().ok());
        let known = known.unwrap_or(1.0);
        let sizes = if *dimension == Dimension::ANGLE {
            vec![20.0, 90.0, 5.0, -45.0, 170.0]
        } else {
            vec![3.0 * known, 0.3 * known, 10.0 * known, 0.05 * known, 0.5, 2.0, 8.0, 30.0, 0.0, -1.0]
        };
        let degrees = if *dimension == Dimension::ANGLE { std::f64::consts::PI / 180.0 } else { 1.0 };
        sizes.into_iter().map(|size| size.clamp(min / degrees, max / degrees)).collect()
    };
    let unit = |dimension: &Dimension| dimension.usual_units().first().copied().unwrap_or_default();
    match ty {
        Type::Quantity { dimension, min, max } | Type::Distribution { dimension, min, max } => {
            quantity(dimension, *min, *max).into_iter().map(|size| format!("{size:?} {}", unit(dimension))).collect()
        }
        Type::Range { dimension, min, max } => {
            let sizes = quantity(dimension, *min, *max);
            let range =
                |low: f64, high: f64| format!("{:?} {1} .. {2:?} {1}", low.min(high), unit(dimension), high.max(low));
            vec![range(sizes[0], sizes[1]), range(sizes[1], sizes[2]), range(sizes[0], sizes[0])]
        }
        Type::Integer { min, max } | Type::Ticks { min, max } => {
            let known = present.and_then(|text| text.replace('_', "").parse::<i64>().ok()).unwrap_or(10);
            [known * 3, known / 3, known + 1, known / 2, 1, 2, 40].map(|size| size.clamp(*min, *max).to_string()).into()
        }
        Type::Boolean => vec!["true".into(), "false".into()],
        Type::Choice(words) | Type::Step(words) => words.iter().map(|word| format!("\"{word}\"")).collect(),
        Type::Reference(form) => vec![format!("other_{form}")],
        Type::WordOrReference(words, form) => {
            words.iter().map(|word| format!("\"{word}\"")).chain([format!("other_{form}")]).collect()
        }
        Type::List(item) => values(item, None).into_iter().map(|value| format!("[{value}]")).collect(),
        Type::Text
        | Type::Path
        | Type::Point
        | Type::WordOrPoint(_)
        | Type::Pose
        | Type::Condition(_)
        | Type::Formula(_)
        | Type::Requirement(_) => Vec::new(),
    }
}

/// The plan of a scenario, or what is wrong with it.
fn plan(text: &str) -> Result<Plan, String> {
    let files = Files(text.to_string());
    let compiled = compile(&["keys.scn".into()], &catalog(), &files, &mut Sources::default()).unwrap();
    let errors = compiled.diagnostics.iter().filter(|each| each.severity == Severity::Error);
    let said = |each: &Diagnostic| format!("{}: {}", each.code, each.message);
    compiled.plan.ok_or_else(|| errors.map(said).collect::<Vec<_>>().join("; "))
}

/// An episode as a report shows it.
fn shown(outcome: &Outcome, verdict: Option<&Verdict>) -> String {
    let ending = match outcome.ending {
        Ending::Touch { front, moving, impact_speed, .. } => format!("hit {front} {moving} {impact_speed:.1}"),
        other => format!("{other:?}"),
    };
    let verdict = verdict.map(|verdict| (verdict.label, verdict.foreseeable));
    format!(
        "{ending} {verdict:?} after {} ticks, gap {:.1}, reward {:.3}\n",
        outcome.ticks, outcome.least_gap, outcome.reward
    )
}

/// The results of a campaign as a report shows them, without names.
fn results(campaign: &Campaign) -> String {
    let seed = Seed::root(3);
    let is_of_episodes = |task: &Task| matches!(campaign.jobs[task.job], Job::Evaluation(_));
    let tasks: Vec<Task> = campaign::tasks(campaign).filter(|task| !is_of_episodes(task)).collect();
    let finished = campaign::run_tasks(campaign, &tasks, &seed, &NoStore, &Silent);
    // A report records the versions of programs.
    let mut text: String = campaign.programs().iter().filter_map(|program| program.version.clone()).collect();
    for training in finished.all::<TrainingResult>() {
        match &training.result {
            Ok(trained) => {
                for log in &trained.learning_curve {
                    let figures = [log.approx_kl, log.entropy, log.policy_loss, log.value_loss, log.grad_norm, log.std];
                    let _ = writeln!(text, "{} {:?} {:?} {figures:.3?}", log.steps, log.mean_reward, log.mean_length);
                }
            }
            Err(error) => {
                let _ = writeln!(text, "{error}");
            }
        }
    }
    for evaluation in campaign.all::<Evaluation>() {
        let trained = results::jobs::networks(evaluation, finished.all());
        if evaluation.origin.needs.is_some() && trained.is_none() {
            continue;
        }
        let key = Arc::new(RunKey::of(evaluation));
        let note = &mut |outcome: &Outcome, trace: &Trace| {
            let pair = trace.main_pair(&evaluation.scenario);
            let row = EpisodeRow::new(&key, 0, Judged::new(outcome, &pair), &pair);
            let degrees: String = row.judged.degrees.iter().map(|degree| format!("{degree:?}\n")).collect();
            shown(&row.judged.outcome, row.judged.verdict.as_ref()) + &degrees
        };
        // The episodes of a batch end in any order, and are returned in that of their numbers.
        let all = watch(evaluation, trained, 0..evaluation.episodes, &seed, note, &mut |_| ControlFlow::Continue(()));
        text.push_str(&all.concat());
    }
    for search in finished.all::<SearchResult>() {
        let _ = writeln!(text, "{} episodes from {} starts", search.spent.episodes, search.spent.starts);
        for find in search.failures() {
            let shown = shown(&find.failure.outcome, find.verdict().as_ref());
            let _ = write!(text, "start {}: {shown}", find.failure.start);
        }
        for evaluated in &search.evaluated {
            text.push_str(&shown(&evaluated.outcome, evaluated.verdict.as_ref()));
        }
    }
    for (job, found) in finished.found::<Estimation>() {
        let _ = writeln!(text, "{} {:?} {found:?}", job.title(), job.exposure);
    }
    for (job, found) in finished.found::<Cover>() {
        let _ = writeln!(text, "{} {:?} {found:?}", job.title(), job.picture);
    }
    for (job, found) in finished.found::<Harden>() {
        let _ = writeln!(text, "{} {found:?}", job.title());
    }
    for (job, found) in finished.found::<Pricing>() {
        let _ = writeln!(text, "{} {} starts", job.title(), found.starts);
    }
    text
}

/// The tables of a report whose figures come from the scenario as well as from episodes.
fn tables(text: &str) -> String {
    /// Tasks that two scenarios have in common are done once.
    static CACHE: LazyLock<tempfile::TempDir> = LazyLock::new(|| tempfile::tempdir().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let options = RunOptions {
        input: Input::file("keys.scn"),
        out: folder.path().into(),
        cache: Some(CACHE.path().into()),
        ..RunOptions::default()
    };
    let session = Session::new(catalog()).with_reader(Files(text.to_string()));
    let report = session.run(&options).unwrap();
    let place = report.reports().next().expect("a report was written").folder.clone();
    let read = |name: &str| std::fs::read_to_string(place.join(name)).unwrap_or_default();
    let summary = read("summary.md");
    let published = summary.split("\n## ").find(|section| section.starts_with("Compared with published figures"));
    format!("{}{}{}", published.unwrap_or_default(), read("protocol.csv"), read("requirements.csv"))
}

/// What comes of a scenario: the tables of its report, or its episodes.
fn outcome(text: &str, report: bool) -> Result<String, String> {
    let plan = plan(text)?;
    if report {
        return Ok(tables(text));
    }
    Ok(plan.campaigns.iter().map(results).collect())
}

/// All keys of a form.
fn keys(form: &Form) -> Vec<Key<'_>> {
    let kinds = form.plain.iter().map(|plain| (None, plain)).chain(form.kinds.iter().map(|kind| (Some(kind), kind)));
    let mut keys = Vec::new();
    for (kind, signature) in kinds {
        keys.extend(signature.params.iter().map(|param| Key { form, kind, block: None, param }));
        for block in &signature.children {
            assert!(block.children.is_empty(), "a block in a block");
            keys.extend(block.params.iter().map(|param| Key { form, kind, block: Some(block), param }));
        }
    }
    keys
}

/// What is noted of a value that changes nothing.
const SAME: &str = "the same";

/// Why this key is not known to change an outcome; none if it does.
fn failure(key: &Key<'_>, bases: &mut BTreeMap<String, Result<String, String>>) -> Option<String> {
    static PLAIN: LazyLock<Need> = LazyLock::new(Need::default);
    let need = key.entry(&TABLES.needs, key.param.name).unwrap_or(&PLAIN);
    let report = need.report || key.form.name == "published";
    let base = key.scenario(None, need);
    let before = match bases.entry(base.clone()).or_insert_with(|| outcome(&base, report)) {
        Ok(before) => before.clone(),
        Err(said) => return Some(format!("the scenario without it has errors: {said}\n{base}")),
    };
    let present = key.present(need);
    let offers = need.value.clone().map_or_else(|| values(&key.param.ty, present.as_deref()), |value| vec![value]);
    let mut seen = BTreeSet::new();
    let mut notes = String::new();
    for value in offers.iter().filter(|value| seen.insert(value.as_str())) {
        let said = match outcome(&key.scenario(Some(value), need), report) {
            Ok(after) if after != before => return None,
            Ok(_) => SAME.to_string(),
            Err(said) => said,
        };
        let _ = write!(notes, "\n    {value}: {said}");
    }
    Some(format!("no value changes an outcome{notes}"))
}

fn check(form: &str) {
    let catalog = catalog();
    let form = catalog.forms.iter().find(|each| each.name == form).unwrap();
    let mut bases = BTreeMap::new();
    let mut failures = Vec::new();
    // While a table is written, the keys of one kind are enough: `KEYS=driver cargo test every_key`.
    let only = std::env::var("KEYS").unwrap_or_default();
    for key in keys(form) {
        let name = &key.paths(key.param.name)[0];
        if !name.contains(&only) {
            continue;
        }
        match (failure(&key, &mut bases), key.entry(&TABLES.silent, key.param.name)) {
            (Some(why), None) => failures.push(format!("{name}: {why}")),
            (Some(why), Some(_)) if !why.contains(SAME) => failures.push(format!("{name}: is not tried: {why}")),
            (None, Some(_)) => failures.push(format!("{name}: changes an outcome, and is listed as `silent`")),
            (Some(_), Some(_)) | (None, None) => {}
        }
    }
    assert!(failures.is_empty(), "{} keys:\n{}", failures.len(), failures.join("\n"));
}

/// One test for each form, so that they run side by side.
macro_rules! forms {
    ($($test:ident: $form:literal),* $(,)?) => {
        const TESTED: &[&str] = &[$($form),*];
        $(#[test]
        fn $test() {
            check($form);
        })*
    };
}

forms! {
    keys_of_towns_change_outcomes: "town",
    keys_of_drivers_change_outcomes: "driver",
    keys_of_sensors_change_outcomes: "sensors",
    keys_of_vehicles_change_outcomes: "vehicle",
    keys_of_bodies_change_outcomes: "body",
    keys_of_spawns_change_outcomes: "spawn",
    keys_of_rewards_change_outcomes: "reward",
    keys_of_episodes_change_outcomes: "episode",
    keys_of_trainings_change_outcomes: "training",
    keys_of_pedestrians_change_outcomes: "pedestrian",
    keys_of_methods_change_outcomes: "method",
    keys_of_worlds_change_outcomes: "world",
    keys_of_requirements_change_outcomes: "requirement",
    keys_of_roles_change_outcomes: "role",
    keys_of_published_figures_change_tables: "published",
    keys_of_campaigns_change_outcomes: "campaign",
}

#[test]
fn every_form_is_tested_and_every_entry_names_a_key() {
    let catalog = catalog();
    let forms: Vec<&str> = catalog.forms.iter().map(|form| form.name).collect();
    assert_eq!(forms.iter().collect::<BTreeSet<_>>(), TESTED.iter().collect());
    let all: Vec<Key<'_>> = catalog.forms.iter().flat_map(keys).collect();
    let named = |path: &str, whole: bool| {
        all.iter().any(|key| key.paths(if whole { "" } else { key.param.name }).iter().any(|each| each == path))
    };
    for path in TABLES.needs.keys() {
        assert!(named(path, false), "needs: there is no key {path}");
        // A silent key may need a value that can be tried.
        let has_value = TABLES.needs[path].value.is_some();
        assert!(has_value || !TABLES.silent.contains_key(path), "{path} is in both tables");
    }
    for (path, reason) in &TABLES.silent {
        assert!(named(path, false) && reason.len() > 10, "silent: there is no key {path}");
    }
    for path in TABLES.given.keys() {
        assert!(named(path, true), "given: there is no kind or block {path}");
    }
}
