use std::slice::ChunksExact;
use std::sync::Arc;

use crate::walker::WalkPolicy;
use crate::{Draw, Outcome, Scenario, Scene, Trace, place, play};
use base::seed::Seed;
use world::av::{Exit, Fault};
use world::sim::WalkCommand;

/// Gives recorded commands, one for each pedestrian in every decision.
pub struct Recorded<'a> {
    decisions: ChunksExact<'a, WalkCommand>,
    /// The last command, if it is kept when no more are left.
    kept: Option<&'a [WalkCommand]>,
    keeps_last: bool,
    fault: Option<Fault>,
}

impl<'a> Recorded<'a> {
    /// From these commands; those of the last decision are kept when no more are left, if `keeps_last`.
    pub fn new(pedestrians: usize, commands: &'a [WalkCommand], keeps_last: bool) -> Self {
        Self { decisions: commands.chunks_exact(pedestrians), kept: None, keeps_last, fault: None }
    }

    /// Runs an episode with these commands; `None` if they do not end it.
    fn play(&mut self, scenario: &Arc<Scenario>, draw: Draw) -> Option<(Outcome, Trace)> {
        let (mut simulation, mut trace) = (scenario.simulation(), Trace::new(scenario));
        place(&mut *simulation, draw, &mut trace);
        let outcome = play(&mut *simulation, self, &mut trace)?;
        self.fault.is_none().then_some((outcome, trace))
    }
}

impl WalkPolicy for Recorded<'_> {
    fn choose(&mut self, _: &Scene<'_>, commands: &mut [WalkCommand]) {
        let next = self.decisions.next().or(self.kept);
        self.kept = next.filter(|_| self.keeps_last);
        match next {
            Some(next) => commands.copy_from_slice(next),
            None => self.fault = Some(Fault::Ended(Exit::Unknown)),
        }
    }

    fn fault(&self) -> Option<Fault> {
        self.fault
    }
}

/// Repeats an episode from a start under the seed of a search with these commands; `None` if they do not end it.
pub fn follow(scenario: &Arc<Scenario>, seed: Seed, start: u64, commands: &[WalkCommand]) -> Option<(Outcome, Trace)> {
    let mut recorded = Recorded::new(scenario.cast.pedestrians.len(), commands, false);
    let played = recorded.play(scenario, Draw::new(&seed, start))?;
    let decisions = recorded.decisions;
    (decisions.len() == 0 && decisions.remainder().is_empty()).then_some(played)
}

/// Repeats the commands of an episode against a driver that may drive otherwise: the last command is kept until the episode ends. `None`
/// without a command.
pub fn walk_again(
    scenario: &Arc<Scenario>,
    seed: Seed,
    start: u64,
    commands: &[WalkCommand],
) -> Option<(Outcome, Trace)> {
    Recorded::new(scenario.cast.pedestrians.len(), commands, true).play(scenario, Draw::new(&seed, start))
}

/// The commands of an episode: one for each pedestrian in every decision.
pub fn recorded_commands(trace: &Trace) -> Vec<WalkCommand> {
    let of_decision =
        |decision| (0..trace.pedestrian_count()).map(move |pedestrian| trace.decisions(pedestrian)[decision]);
    (0..trace.decisions(0).len()).flat_map(of_decision).collect()
}
