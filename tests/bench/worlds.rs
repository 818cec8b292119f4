//! `cargo bench --bench worlds -- SCENARIO WORLDS SECONDS ACTIONS`: environments of the library stepped in a plain loop.
//!
//! ACTIONS is a file of 32-bit floats, low byte first: the action of each world, the same in every decision. World *i* has the episodes of
//! seed 1 + *i*. Prints one JSON object: decisions, ticks of a decision, CPU seconds of all threads. `python/benches/speed.py` compares the
//! interfaces of the Python package with it.

#![expect(clippy::print_stdout, reason = "its output is its result")]

use std::path::Path;
use std::time::{Duration, Instant};

use base::seed::Seed;
use compile::{Catalog, compile, episodes_seed};
use learn::Env;
use rayon::prelude::*;
use search::PedestrianEnv;

/// CPU seconds of the process; wall seconds where the system has no such count.
#[cfg(unix)]
fn spent(_: Instant) -> f64 {
    use nix::sys::resource::{UsageWho, getrusage};
    let usage = getrusage(UsageWho::RUSAGE_SELF).expect("a process may ask for its own usage");
    let seconds = |time: nix::sys::time::TimeVal| time.tv_sec() as f64 + time.tv_usec() as f64 * 1e-6;
    seconds(usage.user_time()) + seconds(usage.system_time())
}

#[cfg(not(unix))]
fn spent(begun: Instant) -> f64 {
    begun.elapsed().as_secs_f64()
}

struct World {
    env: PedestrianEnv,
    action: Vec<f64>,
    state: Vec<f64>,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let [scenario, worlds, seconds, actions] = arguments.as_slice() else {
        println!("give SCENARIO WORLDS SECONDS ACTIONS, as python/benches/speed.py does");
        return;
    };
    let (worlds, seconds): (u64, f64) = (worlds.parse().expect("a count"), seconds.parse().expect("seconds"));
    let read = |path: &Path| std::fs::read_to_string(path);
    let compiled = compile(&[scenario.into()], &Catalog::builtin(), &read, &mut Default::default()).expect("a file");
    let plan = compiled.plan.expect("a scenario without errors");
    let training = &plan.campaigns[0].nth::<compile::Training>(0);
    let scenario = &training.scenario;
    let (states, width) = (scenario.cast.obs_dim(), scenario.cast.action_bounds().len());
    let bytes = std::fs::read(actions).expect("a file of actions");
    let numbers: Vec<f64> = bytes.as_chunks().0.iter().map(|number| f64::from(f32::from_le_bytes(*number))).collect();
    assert_eq!(numbers.len(), worlds as usize * width, "an action for each world");
    let world = |number: u64| {
        let seed = episodes_seed(&Seed::root(1 + number), &training.key.town);
        let action = numbers[number as usize * width..][..width].to_vec();
        let mut world =
            World { env: PedestrianEnv::new(scenario.simulation(), seed), action, state: vec![0.0; states] };
        world.env.reset(&mut world.state);
        world
    };
    let mut all: Vec<World> = (0..worlds).map(world).collect();
    let mut step = || {
        all.par_iter_mut().for_each(|World { env, action, state }| {
            if env.step(action, state).done() {
                env.reset(state);
            }
        });
    };
    step();
    let (begun, limit) = (Instant::now(), Duration::from_secs_f64(seconds));
    let before = spent(begun);
    let mut decisions = 0;
    while begun.elapsed() < limit {
        step();
        decisions += worlds;
    }
    let used = spent(begun) - before;
    println!("{{\"decisions\": {decisions}, \"hold\": {}, \"cpu_s\": {used:.4}}}", scenario.episode.hold);
}
