//! What the fuzz targets call: each reader of bytes from outside, as a function of any bytes. The tests compile it, too, and run it on damaged seeds.

use std::io;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::path::Path;
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use base::diagnostic::{Colour, Sources, render};
use base::seed::Seed;
use compile::{Catalog, Evaluation, compile};
use episode::walker::Random;
use episode::{Outcome, Scenario, evaluate};
use learn::{ActorCritic, Trained};
use results::report::Gate;
use results::{record, store};
use road::{Town, opendrive};
use world::av::external::{Link, Opener, Program};
use world::av::{Exit, Fault, onnx};

/// A scenario: the whole front end, its messages and the layout.
pub fn front_end(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let root = Path::new("fuzz.scn");
    let read = |path: &Path| if path == root { Ok(text.clone()) } else { Err(absent()) };
    let mut sources = Sources::default();
    let Ok(compiled) = compile(&[root.to_path_buf()], &Catalog::builtin(), &read, &mut sources) else { return };
    for each in compiled.diagnostics.iter().take(20) {
        render(each, &sources, Colour::Never);
    }
    let _ = lang::format(sources.add("", text.as_str()), &text);
}

/// An OpenDRIVE map: the reader, and the town made of it.
pub fn map(bytes: &[u8]) {
    if let Ok(parts) = opendrive::read(&String::from_utf8_lossy(bytes), "fuzz") {
        Town::new(parts);
    }
}

/// What an external driver answers: its greeting, then lines of JSON or binary messages, in one short episode. Returns how the
/// episode ended.
pub fn driver(bytes: &[u8]) -> Outcome {
    static SCENARIO: LazyLock<Arc<Scenario>> = LazyLock::new(scenario);
    ANSWERS.lock().unwrap_or_else(PoisonError::into_inner).clone_from(&bytes.to_vec());
    let seed = Seed::root(1);
    let mut outcomes =
        evaluate(
            &mut Random::default(),
            &SCENARIO,
            1,
            &seed,
            &seed.child("walker"),
            &mut |_| ControlFlow::Continue(()),
        );
    let outcome = outcomes.remove(0);
    assert!(outcome.reward.is_finite(), "{outcome:?}");
    outcome
}

/// A trained pedestrian or a training in hand (safetensors).
pub fn policy(bytes: &[u8]) {
    let trained = Trained::from_safetensors(bytes);
    if let Ok((actor_critic, metadata)) = ActorCritic::from_safetensors(bytes) {
        actor_critic.to_safetensors(&metadata);
    }
    if let Ok(trained) = trained {
        let again = trained.to_safetensors();
        assert!(Trained::from_safetensors(&again).is_ok(), "what was read is written and read again");
    }
}

/// A driver's network (ONNX).
pub fn network(bytes: &[u8]) {
    quietly(|| onnx::Model::read(bytes.to_vec(), None).is_ok());
}

/// The settings of a folder (`falsify.toml`), and each line as a condition of `--fail-if`.
pub fn settings(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    program::cli::settings_are_read(&text);
    for line in text.lines().take(100) {
        let _ = Gate::parse(line);
    }
}

/// A file of the store, with a checksum that fits, and the episodes in it.
pub fn stored(bytes: &[u8]) {
    let Some((mut header, start)) = store::head(bytes) else { return };
    let length = usize::try_from(header.length).unwrap_or(usize::MAX);
    let contents = &bytes[start..bytes.len().min(start.saturating_add(length))];
    header.length = contents.len() as u64;
    let file = store::encode(&header, contents);
    assert!(store::decode(file).is_some_and(|(_, read)| read == contents), "what was written is read again");
    policy(contents);
    // The Parquet reader panics on some damaged files; in the store the checksum is before it.
    quietly(|| record::decode(contents).is_ok());
}

/// The answers that are still to come.
static ANSWERS: Mutex<Vec<u8>> = Mutex::new(Vec::new());

/// Reads the answers.
struct Answers;

impl Link for Answers {
    fn send(&mut self, _: &[u8], _: f64) -> Result<(), Fault> {
        Ok(())
    }

    fn line(&mut self, line: &mut Vec<u8>, longest: usize) -> Result<(), Fault> {
        let mut answers = ANSWERS.lock().unwrap_or_else(PoisonError::into_inner);
        let end = answers.iter().position(|byte| *byte == b'\n').ok_or(Fault::Ended(Exit::Unknown))?;
        if end > longest {
            return Err(Fault::Answer("a line that does not end"));
        }
        line.extend(answers.drain(..=end).take(end));
        Ok(())
    }

    fn exact(&mut self, bytes: &mut [u8]) -> Result<(), Fault> {
        let mut answers = ANSWERS.lock().unwrap_or_else(PoisonError::into_inner);
        if answers.len() < bytes.len() {
            return Err(Fault::Ended(Exit::Unknown));
        }
        bytes.copy_from_slice(&answers[..bytes.len()]);
        answers.drain(..bytes.len());
        Ok(())
    }
}

/// Opens [`Answers`].
struct Answering;

impl Opener for Answering {
    fn open(&self, _: &Program) -> Result<Box<dyn Link>, Fault> {
        Ok(Box::new(Answers))
    }
}

/// The error of a file that is not there; the standard library is inside the program.
fn absent() -> io::Error {
    io::ErrorKind::NotFound.into()
}

/// Ten ticks against an external driver.
fn scenario() -> Arc<Scenario> {
    let text = "edition 1
import \"std/paper.scn\"
import \"std/drivers.scn\"
import \"std/towns.scn\"
driver mine = external(command: \"driver\", worlds: 1)
episode brief { ticks: 10 }
campaign fuzz {
  vehicle: model3 body: suicidal spawn: ahead episode: brief
  evaluate { towns: [harbour] drivers: [mine] pedestrians: [random] episodes: 1 }
}
";
    let read = |path: &Path| if path == Path::new("fuzz.scn") { Ok(text.to_string()) } else { Err(absent()) };
    let catalog = Catalog::builtin().with_opener(Arc::new(Answering));
    let compiled = compile(&["fuzz.scn".into()], &catalog, &read, &mut Sources::default()).expect("it is read");
    let plan = compiled.plan.unwrap_or_else(|| panic!("{:?}", compiled.diagnostics));
    plan.campaigns[0].nth::<Evaluation>(0).scenario.clone()
}

/// What a function returns, or none if it panics; libFuzzer's hook would end the process before the panic can be caught.
fn quietly<T>(read: impl FnOnce() -> T) -> Option<T> {
    if !cfg!(fuzzing) {
        return catch_unwind(AssertUnwindSafe(read)).ok();
    }
    let hook = take_hook();
    set_hook(Box::new(|_| {}));
    let result = catch_unwind(AssertUnwindSafe(read));
    set_hook(hook);
    result.ok()
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;
    use results::campaign::State;
    use results::store::Header;

    /// Runs a target with a seed and with a hundred damaged ones.
    fn damage(target: fn(&[u8]), seed: &[u8]) {
        target(seed);
        let mut stream = Seed::root(7).stream();
        for _ in 0..100 {
            let mut damaged = seed.to_vec();
            for _ in 0..4 {
                let place = stream.random_range(0..seed.len());
                damaged[place] = stream.random();
            }
            target(&damaged);
            target(&seed[..stream.random_range(0..seed.len())]);
        }
    }

    #[test]
    fn seeds_and_damaged_seeds_are_read_or_refused() {
        damage(map, include_bytes!("../suite/files/odd.xodr"));
        let pedestrian = include_bytes!("../reference/sb3_update/before.safetensors");
        assert!(ActorCritic::from_safetensors(pedestrian).is_ok());
        damage(policy, pedestrian);
        damage(front_end, b"edition 1\nreward r { on touch => max(3, 1.5 * v_c) }\n");
        let model = include_bytes!("../reference/onnx/follow.onnx");
        assert!(onnx::Model::read(model.to_vec(), None).is_ok());
        damage(network, model);
        let settings_of_a_folder = include_bytes!("seeds/settings/falsify.toml");
        assert!(program::cli::settings_are_read(std::str::from_utf8(settings_of_a_folder).unwrap()));
        damage(settings, settings_of_a_folder);
        let gates = include_bytes!("seeds/settings/gates");
        assert!(std::str::from_utf8(gates).unwrap().lines().all(|line| Gate::parse(line).is_ok()));
        damage(settings, gates);
        for seed in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fuzz/seeds/map")).unwrap() {
            damage(map, &std::fs::read(seed.unwrap().path()).unwrap());
        }
        let (episodes, count) = record::encode(None, &[]).unwrap();
        let length = episodes.len() as u64;
        let (what, error) = ("no episodes".to_string(), String::new());
        let header =
            Header { task: String::new(), what, state: State::Finished, done: count, error, seconds: 0.5, length };
        damage(stored, &store::encode(&header, &episodes));
    }

    #[test]
    fn the_seeds_of_a_driver_drive_and_other_bytes_are_a_fault() {
        let seeds = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fuzz/seeds/driver");
        for seed in std::fs::read_dir(seeds).unwrap() {
            let path = seed.unwrap().path();
            let bytes = std::fs::read(&path).unwrap();
            assert_eq!(driver(&bytes).fault(), None, "{}", path.display());
            assert_eq!(
                driver(&bytes[..bytes.len() - 1]).fault(),
                Some(Fault::Ended(Exit::Unknown)),
                "{}",
                path.display()
            );
        }
    }
}
