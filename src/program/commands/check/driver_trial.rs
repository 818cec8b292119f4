//! The conformance test of an external driver: real episodes in a small town, a check that they repeat, and an empty road that it has to follow.

use std::cell::Cell;
use std::io;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Args;

use super::empty_road::{self, told};
use crate::cli::{console, interrupt};
use crate::exit_code::ExitCode;
use crate::session::seconds;
use base::diagnostic::Sources;
use base::seed::Seed;
use compile::{Catalog, Training, compile};
use episode::walker::Random;
use episode::{Outcome, Scenario, Trace, evaluate_observed};
use process::{ProcessOpener, missing_package, used_seconds};
use world::av::Fault;
use world::av::external::{External, Link, Opener, PROTOCOL, Program, Settings};

/// Options of the trial of a driver.
#[derive(Debug, Args)]
pub struct TrialArgs {
    /// Try a driver instead: the program and its arguments, after `--`.
    #[arg(last = true, value_name = "DRIVER", group = "tried")]
    pub driver: Vec<String>,
    /// Try a driver that others wrote, by its name in the Python package: sumo, openpilot_like, pdm_closed, fiss, commonroad.
    #[arg(long = "driver", value_name = "NAME", group = "tried")]
    pub stack: Option<String>,
    /// Try a bridge to another simulator: a name of the Python package, as metadrive, or a command. With files, compare the lanes of their towns.
    #[arg(long, value_name = "WORLD", group = "tried")]
    pub world: Option<String>,
    /// Time limit of the driver's answer to a tick, in seconds.
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
    /// The words of the driver that is to be tried, if one is.
    pub fn words(&self) -> Option<Vec<String>> {
        match &self.stack {
            Some(name) => Some([&PYTHON[..], &[name]].concat().into_iter().map(String::from).collect()),
            None => (!self.driver.is_empty()).then(|| self.driver.clone()),
        }
    }
}

impl TrialArgs {
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
  train { towns: [proving_ground, empty_road] drivers: [placeholder] rewards: [any] }
}
";

/// Number of episodes in each run, and of parallel episodes in the last trial.
const EPISODES: u32 = 8;

/// Number of messages that `--show` prints, and the length of each (bytes).
const SHOWN: usize = 4;
const SHOWN_BYTES: usize = 600;

/// `falsify check -- DRIVER`
pub fn try_driver(options: &TrialArgs, words: Vec<String>) -> ExitCode {
    let program = Program { words, folder: ".".into(), ..Program::default() };
    let settings =
        Settings { timeout: options.timeout, start_timeout: options.start_timeout, worlds: 1, ..Settings::default() };
    console::say(&format!("driver {}", program.words.join(" ")));
    if let Some(Err(reason)) = options.stack.as_deref().map(installed) {
        return failed(&format!("is installed: {reason}"));
    }
    let opener = Arc::new(options.opener());
    interrupt::end_when_asked();
    if let Err(reason) = opener.find(&program) {
        return failed(&format!("could be started: {reason}"));
    }
    let [ground, road] = proving_grounds();
    let drive = |worlds: usize| {
        let program = program.clone();
        let opener = opener.clone();
        let settings = Settings { worlds, ..settings };
        let maker = move || {
            Box::new(External::new(program.clone(), settings, opener.clone())) as Box<dyn world::av::DrivingPolicy>
        };
        let mut scenario = ground.clone();
        scenario.cast.vehicles[0].policy = Arc::new(maker);
        let scenario = Arc::new(scenario);
        let seed = Seed::root(1);
        let began = used_seconds();
        let mut walker = Random::default();
        // One failure is enough; the others would show the same.
        let fell = Cell::new(false);
        let note = &mut |_: u32, outcome: &Outcome, _: &Trace| {
            fell.set(fell.get() || outcome.fault().is_some());
            *outcome
        };
        let go_on = &mut |_| if fell.get() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let outcomes =
            evaluate_observed(&mut walker, &scenario, 0..EPISODES, &seed, &seed.child("walker"), note, go_on);
        let ticks: u32 = outcomes.iter().map(|outcome| outcome.ticks).sum();
        (outcomes, f64::from(ticks) / (used_seconds() - began))
    };

    let (first, alone) = drive(1);
    if let Some(reason) = first_fault(&first) {
        return failed(&format!("drives {EPISODES} episodes to their end: {reason}"));
    }
    passed(&format!("greets as {PROTOCOL} and drives {EPISODES} episodes to their end"));
    let (second, _) = drive(1);
    let again = "drives the same way when the same seeds come again";
    if let Some(reason) = first_difference(&first, &second) {
        return failed(&format!("{again}: {reason}"));
    }
    passed(again);
    let (company, together) = drive(EPISODES as usize);
    let at_once = format!("drives the same way when it is asked about {EPISODES} worlds at once");
    if let Some(reason) = first_difference(&first, &company) {
        return failed(&format!("{at_once}: {reason}"));
    }
    passed(&at_once);
    let mut driver = External::new(program, Settings { worlds: 1, ..settings }, opener);
    if let Err(reason) = empty_road::follow(&road, &mut driver, &Seed::root(1).child("road")) {
        return failed(&format!("follows an empty road with a bend and a turn: {reason}"));
    }
    passed("follows an empty road with a bend and a turn");
    console::say(&format!("        {alone:.0} ticks a CPU second alone, {together:.0} with {EPISODES} worlds at once"));
    ExitCode::Done
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
    let read = |path: &Path| match path.to_str() {
        Some("proving_ground.scn") => Ok([CAMPAIGN, CROSSING, empty_road::TOWN].concat()),
        _ => Err(io::Error::from(io::ErrorKind::NotFound)),
    };
    let files = ["proving_ground.scn".into()];
    let compiled = compile(&files, &Catalog::builtin(), &read, &mut Sources::default());
    let plan = compiled.ok().and_then(|compiled| compiled.plan).expect("the texts above are sound");
    [0, 1].map(|number| (*plan.campaigns[0].nth::<Training>(number).scenario).clone())
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

#[cfg(test)]
mod tests {
    use super::*;
    use world::av::{DrivingMode, DrivingPolicy, Perception};
    use world::sim::Control;

    struct Constant(Control);

    impl DrivingPolicy for Constant {
        fn reset(&mut self, _: &Perception<'_>, _: base::seed::Stream) {}

        fn drive(&mut self, _: &Perception<'_>) -> Control {
            self.0
        }

        fn mode(&self) -> DrivingMode {
            DrivingMode::Cruise
        }
    }

    #[test]
    fn an_empty_road_tells_drivers_that_follow_it_from_others() {
        let [_, road] = proving_grounds();
        let mut follower = (road.cast.ego().policy)();
        assert_eq!(empty_road::follow(&road, &mut *follower, &Seed::root(1)), Ok(()));
        let drive = |throttle: f64, steer: f64| {
            let control = Control { throttle, brake: 0.0, steer };
            empty_road::follow(&road, &mut Constant(control), &Seed::root(1)).unwrap_err()
        };
        let circles = drive(0.3, 0.3);
        assert!(
            circles.starts_with("the car left the road ") || circles.starts_with("the car left its lane "),
            "{circles}"
        );
        assert!(circles.ends_with("m/s: the driver steers constantly 0.30 to the left"), "{circles}");
        assert!(drive(0.3, 0.0).ends_with("the driver does not steer"));
        assert_eq!(drive(0.0, 0.0), "the car stood for 120 s");
    }
}
