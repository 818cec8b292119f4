use super::walker::WalkPolicy;
use crate::{Draw, Observer, Outcome, Phase, Simulation, carry_out, tick};
use world::sim::WalkCommand;

/// Starts an episode: at its run-up, if it has one.
pub fn place(simulation: &mut dyn Simulation, draw: Draw, observer: &mut dyn Observer) {
    simulation.place(draw);
    if simulation.phase() != Phase::RunUp {
        observer.begin(&simulation.scene());
    }
}

/// Takes the decision that an episode waits for, or simulates a tick. `commands` is memory for the commands of a decision.
pub fn advance(
    simulation: &mut dyn Simulation,
    walker: &mut dyn WalkPolicy,
    commands: &mut [WalkCommand],
    observer: &mut dyn Observer,
) {
    match simulation.phase() {
        Phase::RunUp => {
            simulation.tick();
            if simulation.phase() != Phase::RunUp {
                observer.begin(&simulation.scene());
            }
        }
        Phase::Decision => {
            if choose(simulation, walker, commands) {
                simulation.decide(commands);
                observer.decide(&simulation.scene());
            }
        }
        Phase::Tick => {
            tick(simulation, observer);
        }
        Phase::Over => {}
    }
}

/// Runs an episode that has begun to its end: the one loop over an episode. Returns `None` if the simulation gave it up before.
pub fn play(
    simulation: &mut dyn Simulation,
    walker: &mut dyn WalkPolicy,
    observer: &mut dyn Observer,
) -> Option<Outcome> {
    let mut commands = vec![WalkCommand::default(); simulation.scenario().cast.pedestrians.len()];
    loop {
        match simulation.phase() {
            Phase::Over => return simulation.outcome().copied(),
            Phase::Decision => {
                if choose(simulation, walker, &mut commands) {
                    carry_out(simulation, &commands, observer);
                }
            }
            Phase::RunUp | Phase::Tick => advance(simulation, walker, &mut commands, observer),
        }
    }
}

/// Lets the walk policy choose. Returns false and ends the episode if it fails as a program.
fn choose(simulation: &mut dyn Simulation, walker: &mut dyn WalkPolicy, commands: &mut [WalkCommand]) -> bool {
    walker.choose(&simulation.scene(), commands);
    match walker.fault() {
        Some(fault) => simulation.abandon(fault),
        None => return true,
    }
    false
}
