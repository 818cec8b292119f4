//! The conformance test of an external driver: real episodes in a small town, a check that they repeat, and an empty road that it has to follow.

use std::cell::Cell;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Args;

use super::empty_road::{self, Mishaps, told};
use crate::cli::{console, interrupt};
use crate::exit_code::ExitCode;
use crate::session::{named, seconds};
use base::diagnostic::Sources;
use base::seed::{Seed, Stream};
use base::suggest::nearest;
use compile::{Catalog, NamedDriver, Plan, Training, compile};
use episode::walker::{Random, WalkPolicy};
use episode::{LeftOut, Outcome, PolicyMaker, Scenario, Scene, Trace, evaluate_observed};
use process::{ProcessOpener, missing_package, used_seconds};
use verdict::LaneDeparture;
use world::av::Fault;
use world::av::external::{External, Link, Opener, PROTOCOL, Program, Settings};
use world::sim::{VehicleState, WalkCommand};

/// Options of the trial of a driver.
#[derive(Debug, Args)]
pub struct TrialArgs {
    /// Try a driver instead: the program and its arguments, after `--`.
    #[arg(last = true, value_name = "DRIVER", group = "tried")]
    pub driver: Vec<String>,
    /// With files, try a driver that they declare, as they declare it; without, one that others wrote, by its name in the Python package: sumo,
    /// openpilot_like, pdm_closed, fiss, commonroad.
    #[arg(long = "driver", value_name = "NAME", group = "tried")]
    pub stack: Option<String>,
    /// Try a bridge to another simulator: a name of the Python package, as metadrive, or a command. With files, compare the lanes of their towns.
    #[arg(long, value_name = "WORLD", group = "tried")]
    pub world: Option<String>,
    /// Time limit of the driver's answer to a tick, in seconds; a declared driver has its own.
    #[arg(long, default_value_t = 1.0, value_name = "SECONDS", value_parser = seconds, requires = "tried")]
    pub timeout: f64,
    /// Time limit of the greeting; of a bridge also of loading a town and of the start of an episode; in seconds.
    #[arg(long, default_value_t = 30.0, value_name = "SECONDS", value_parser = seconds, requires = "tried")]
    pub start_timeout: f64,
    /// Show the driver's first messages.
    #[arg(long, requires = "tried")]
    pub show: bool,
}

impl TrialArgs {
    /// The words of the program that is to be tried, if one is.
    pub fn words(&self) -> Option<Vec<String>> {
        match &self.stack {
            Some(name) => Some([&PYTHON[..], &[name]].concat().into_iter().map(String::from).collect()),
            None => (!self.driver.is_empty()).then(|| self.driver.clone()),
        }
    }

    /// Starts what is tried, and shows its first messages if they are asked for.
    pub(super) fn opener(&self) -> Overhearing {
        let left = if self.show { SHOWN } else { 0 };
        Overhearing { inner: ProcessOpener::of_program(), left: Arc::new(AtomicUsize::new(left)) }
    }
}

/// Starts a driver of the Python package.
const PYTHON: [&str; 3] = ["python3", "-m", "falsify_av.stacks"];

/// Asks the Python package what a driver needs that is not installed.
///
/// # Errors
/// What is missing, and what installs it.
fn installed(name: &str) -> Result<(), String> {
    let [python, arguments @ ..] = PYTHON;
    let asked = Command::new(python).args(arguments).args(["--missing", name]).output();
    let asked = asked.map_err(|error| format!("`{python}` cannot be started: {error}"))?;
    let said = String::from_utf8_lossy(&asked.stderr);
    match asked.status.success() {
        true => Ok(()),
        false if said.contains("No module named") => Err(missing_package(&[PYTHON[2].into(), name.into()])),
        false => Err(said.trim_end().into()),
    }
}

/// A crossing with lights, and pedestrians that walk at random.
const CROSSING: &str = "\
town proving_ground {
  traffic_lights: true
  street along { through: [(0 m, 0 m), (100 m, 0 m), (200 m, 0 m)] }
  street across { through: [(100 m, -100 m), (100 m, 0 m), (100 m, 100 m)] }
  building corner { corner: (110 m, 10 m) opposite: (130 m, 30 m) }
}
";
/// The campaign whose scenarios are driven.
const CAMPAIGN: &str = "\
edition 1
driver placeholder = cruise()
vehicle car = model3()
body walker { }
spawn ahead { }
episode half_a_minute { }
reward any { on touch => 1 }
training none = ppo()
campaign check {
  vehicle: car body: walker spawn: ahead episode: half_a_minute training: none
  train { towns: [proving_ground, empty_road] drivers: [placeholder] rewards: [any] runs: 1 }
}
";

/// Number of episodes in each run, in all towns together, and at most of parallel episodes in the last trial.
const EPISODES: u32 = 8;

/// Number of messages that `--show` prints, and the length of each (bytes).
const SHOWN: usize = 4;
const SHOWN_BYTES: usize = 600;

/// `falsify check -- DRIVER`
pub fn try_driver(options: &TrialArgs, words: Vec<String>) -> ExitCode {
    let program = Program { words, folder: ".".into(), ..Program::default() };
    let (timeout, start_timeout, worlds) = (options.timeout, options.start_timeout, EPISODES as usize);
    let settings = Settings { timeout, start_timeout, worlds, ..Settings::default() };
    console::say(&format!("driver {}", program.words.join(" ")));
    if let Some(Err(reason)) = options.stack.as_deref().map(installed) {
        return failed(&format!("is installed: {reason}"));
    }
    let opener = Arc::new(options.opener());
    interrupt::end_when_asked();
    if let Err(reason) = opener.find(&program) {
        return failed(&format!("could be started: {reason}"));
    }
    let policy: PolicyMaker = Arc::new(move || Box::new(External::new(program.clone(), settings, opener.clone())));
    let [ground, _] = proving_grounds();
    tried(&policy, vec![(String::new(), ground)], &format!("greets as {PROTOCOL} and "))
}

/// `falsify check FILES --driver NAME`: as the files declare it, in the towns and the car of the campaigns that use it.
///
/// # Errors
/// They declare no such driver.
pub fn try_declared(plan: &Plan, name: &str) -> Result<ExitCode, String> {
    let Some(NamedDriver { policy, carries, .. }) = plan.drivers.iter().find(|driver| driver.name == name) else {
        let names: Vec<String> = plan.drivers.iter().map(|driver| driver.name.clone()).collect();
        let near = nearest(name, names.iter().map(String::as_str)).map(|near| format!("did you mean `{near}`?"));
        let help = near.unwrap_or_else(|| format!("they declare {}", named(&names)));
        return Err(format!("the files declare no driver `{name}`; {help}"));
    };
    let users = plan.campaigns.iter().filter(|campaign| campaign.drivers.iter().any(|driver| driver.name == name));
    let places = users.flat_map(|campaign| campaign.starts());
    let mut places: Vec<(String, Scenario)> =
        places.map(|(town, scenario)| (format!(" in {town}"), (**scenario).clone())).collect();
    console::say(format!("driver {name} {}", carries.as_deref().unwrap_or_default()).trim_end());
    if places.is_empty() {
        console::say("        no campaign of the files uses it: it drives a Model 3 on a crossing");
        let [ground, _] = proving_grounds();
        places.push((String::new(), ground));
    }
    interrupt::end_when_asked();
    Ok(tried(policy, places, ""))
}

/// Walks at random, in one world at a time.
#[derive(Default)]
struct Alone(Random);

impl WalkPolicy for Alone {
    fn begin(&mut self, stream: Stream) {
        self.0.begin(stream);
    }

    fn choose(&mut self, scene: &Scene<'_>, commands: &mut [WalkCommand]) {
        self.0.choose(scene, commands);
    }
}

/// What a driver did in some episodes.
#[derive(Default)]
pub(super) struct Driven {
    pub outcomes: Vec<Outcome>,
    /// How far the cars got from their starts (m).
    pub ways: f64,
    /// In how many episodes the centre left its lane, and a part of the body the road.
    left: [u32; 2],
    /// Time of the processor (s).
    seconds: f64,
}

/// Lets the driver of a scenario drive from seeds that are always the same.
pub(super) fn driven(walker: &mut dyn WalkPolicy, scenario: &Arc<Scenario>, episodes: u32) -> Driven {
    let (seed, began, mut found) = (Seed::root(1), used_seconds(), Driven::default());
    // One failure is enough; the others would show the same.
    let fell = Cell::new(false);
    let note = &mut |_: u32, outcome: &Outcome, trace: &Trace| {
        fell.set(fell.get() || outcome.fault().is_some());
        let departure = LaneDeparture::new(&trace.main_pair(scenario));
        let (town, blueprint) = (&scenario.town, &scenario.cast.ego().blueprint);
        let is_off = |car: &VehicleState| town.inside_road(&car.outline(blueprint), car.ground) < 0.0;
        // Past the end of the map there is neither.
        if outcome.left_out != Some(LeftOut::RoadEnd) {
            found.left[0] += u32::from(departure.is_some_and(|departure| departure.left_lane > 0.0));
            found.left[1] += u32::from(trace.vehicle(0).iter().any(|frame| is_off(&frame.state)));
        }
        if let [first, .., last] = trace.vehicle(0) {
            found.ways += (last.state.pose.position() - first.state.pose.position()).norm();
        }
        *outcome
    };
    let go_on = &mut |_| if fell.get() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let outcomes = evaluate_observed(walker, scenario, 0..episodes, &seed, &seed.child("walker"), note, go_on);
    Driven { outcomes, seconds: used_seconds() - began, ..found }
}

/// Lets a driver drive in some places, and on an empty road in the car of the first. `greets` is what a program has done before.
fn tried(policy: &PolicyMaker, places: Vec<(String, Scenario)>, greets: &str) -> ExitCode {
    let [_, mut road] = proving_grounds();
    road.cast.vehicles[0].blueprint = places[0].1.cast.ego().blueprint.clone();
    let episodes = (EPISODES / places.len() as u32).max(2);
    let worlds = policy().batch_size().min(episodes as usize);
    let (mut ticks, mut alone, mut together) = (0.0, 0.0, 0.0);
    for (town, mut scenario) in places {
        scenario.cast.vehicles[0].policy = policy.clone();
        let scenario = Arc::new(scenario);
        let first = driven(&mut Alone::default(), &scenario, episodes);
        if let Some(reason) = first_fault(&first.outcomes) {
            return failed(&format!("drives {episodes} episodes{town} to their end: {reason}"));
        }
        passed(&format!("{greets}drives {episodes} episodes{town} to their end"));
        let [lane, off] = first.left;
        console::say(&format!("        its centre left its lane in {lane} of them, its body the road in {off}"));
        let again = format!("drives the same way{town} when the same seeds come again");
        let second = driven(&mut Alone::default(), &scenario, episodes);
        if let Some(reason) = first_difference(&first.outcomes, &second.outcomes) {
            return failed(&format!("{again}: {reason}"));
        }
        passed(&again);
        if worlds > 1 {
            let at_once = format!("drives the same way{town} when it is asked about {worlds} worlds at once");
            let company = driven(&mut Random::default(), &scenario, episodes);
            if let Some(reason) = first_difference(&first.outcomes, &company.outcomes) {
                return failed(&format!("{at_once}: {reason}; `worlds: 1` in a scenario asks it about one"));
            }
            passed(&at_once);
            together += company.seconds;
        }
        ticks += first.outcomes.iter().map(|outcome| f64::from(outcome.ticks)).sum::<f64>();
        alone += first.seconds;
    }
    let Mishaps { off_road, off_lane } = empty_road::follow(&road, &mut *policy(), &Seed::root(1).child("road"));
    let mut ended = ExitCode::Done;
    for (what, mishap) in
        [("stays on an empty road with a bend and a turn", off_road), ("follows its lane there to the end", off_lane)]
    {
        match mishap {
            Some(reason) => ended = failed(&format!("{what}: {reason}")),
            None => passed(what),
        }
    }
    let at_once = |text| if worlds > 1 { text } else { String::new() };
    let company = at_once(format!(", {:.0} with {worlds} worlds at once", ticks / together));
    console::say(&format!("        {:.0} ticks a CPU second alone{company}", ticks / alone));
    ended
}

pub(super) fn passed(what: &str) {
    console::say(&format!("  ok    {what}"));
}

pub(super) fn failed(what: &str) -> ExitCode {
    console::say(&format!("  FAIL  {what}"));
    ExitCode::RunFailed
}

/// The first episode in which the driver failed, in words.
pub(super) fn first_fault(outcomes: &[Outcome]) -> Option<String> {
    let mut faults = outcomes.iter().enumerate().filter_map(|(episode, outcome)| Some((episode, outcome.fault()?)));
    faults.next().map(|(episode, fault)| format!("in episode {episode} {}", told(fault)))
}

/// The first episode that is another one, in words; an episode in error is not another one.
pub(super) fn first_difference(left: &[Outcome], right: &[Outcome]) -> Option<String> {
    let other = || left.iter().zip(right).position(|(left, right)| left != right);
    first_fault(right).or_else(|| other().map(|episode| format!("episode {episode} became another one")))
}

/// The crossing and the empty road.
pub(super) fn proving_grounds() -> [Scenario; 2] {
    let plan = plan_of(&[CAMPAIGN, CROSSING, empty_road::TOWN].concat());
    [0, 1].map(|number| (*plan.campaigns[0].nth::<Training>(number).scenario).clone())
}

/// The plan of a text that is sound and imports nothing.
pub(super) fn plan_of(text: &str) -> Plan {
    let read = |_: &Path| Ok(text.to_owned());
    let compiled = compile(&["text.scn".into()], &Catalog::builtin(), &read, &mut Sources::default());
    compiled.ok().and_then(|compiled| compiled.plan).expect("the text is sound")
}

/// Shows the messages on the links that it opens.
pub(super) struct Overhearing {
    inner: ProcessOpener,
    left: Arc<AtomicUsize>,
}

struct Overheard {
    inner: Box<dyn Link>,
    left: Arc<AtomicUsize>,
}

impl Opener for Overhearing {
    fn find(&self, program: &Program) -> Result<(), String> {
        self.inner.find(program)
    }

    fn greets_as_before(&self, program: &Program, greeting: &str) -> bool {
        self.inner.greets_as_before(program, greeting)
    }

    fn asks(&self) -> bool {
        true
    }

    fn open(&self, program: &Program) -> Result<Box<dyn Link>, Fault> {
        let inner = self.inner.open(program)?;
        Ok(Box::new(Overheard { inner, left: self.left.clone() }))
    }
}

impl Overheard {
    fn show(&self, arrow: &str, message: &[u8]) {
        if self.left.load(Ordering::Relaxed) == 0 {
            return;
        }
        self.left.fetch_sub(1, Ordering::Relaxed);
        if !message.starts_with(b"{") {
            console::say(&format!("  {arrow} {} bytes", message.len()));
            return;
        }
        let text = String::from_utf8_lossy(&message[..message.len().min(SHOWN_BYTES)]);
        let dots = if message.len() > SHOWN_BYTES { "…" } else { "" };
        console::say(&format!("  {arrow} {}{dots}", text.trim_end().replace(char::is_control, " ")));
    }
}

impl Link for Overheard {
    fn send(&mut self, message: &[u8], limit: f64) -> Result<(), Fault> {
        self.show("->", message);
        self.inner.send(message, limit)
    }

    fn line(&mut self, line: &mut Vec<u8>, longest: usize) -> Result<(), Fault> {
        self.inner.line(line, longest)?;
        self.show("<-", line);
        Ok(())
    }

    fn exact(&mut self, bytes: &mut [u8]) -> Result<(), Fault> {
        self.inner.exact(bytes)
    }

    fn note(&self, text: &str) {
        self.inner.note(text);
    }
}
