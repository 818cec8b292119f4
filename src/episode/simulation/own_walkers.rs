use crate::walker::WalkPolicy;
use crate::{Actions, Cast, Controller, Scenario, Scene};
use base::seed::Seed;
use world::av::Fault;
use world::sim::{WalkCommand, World};

/// The pedestrians that their own controllers move, within the simulation.
pub(super) struct OwnWalkers {
    walkers: Vec<(usize, Box<dyn WalkPolicy>)>,
    /// The commands of the present decision, of all pedestrians.
    commands: Vec<WalkCommand>,
}

impl OwnWalkers {
    pub(super) fn new(cast: &Cast) -> Self {
        let own = cast.pedestrians.iter().enumerate().filter_map(|(number, role)| match &role.controller {
            Controller::Own(controller) => Some((number, controller.walk_policy())),
            Controller::External | Controller::Fixed(_) => None,
        });
        Self { walkers: own.collect(), commands: vec![WalkCommand::default(); cast.pedestrians.len()] }
    }

    /// Begins an episode. What a pedestrian draws depends on its number alone.
    pub(super) fn begin(&mut self, seed: &Seed) {
        for (number, walker) in &mut self.walkers {
            walker.begin(of_walker(seed, *number).stream());
        }
    }

    /// Lets them draw from below another seed from now on.
    pub(super) fn reseed(&mut self, seed: &Seed) {
        for (number, walker) in &mut self.walkers {
            walker.reseed(of_walker(seed, *number).stream());
        }
    }

    /// Completes a decision by the commands of these pedestrians.
    ///
    /// # Errors
    /// The fault of a controller that failed as a program.
    pub(super) fn decide(
        &mut self,
        scenario: &Scenario,
        world: &World,
        actions: &Actions,
        commands: &[WalkCommand],
    ) -> Result<&[WalkCommand], Fault> {
        self.commands.copy_from_slice(commands);
        for (number, walker) in &mut self.walkers {
            let scene = Scene { only: Some(*number), ..Scene::new(scenario, world, actions) };
            walker.choose(&scene, &mut self.commands);
            if let Some(fault) = walker.fault() {
                return Err(fault);
            }
        }
        Ok(&self.commands)
    }

    /// A copy in their present state; `None` if one of them cannot be copied.
    pub(super) fn snapshot(&self) -> Option<Self> {
        let walkers = self.walkers.iter().map(|(number, walker)| Some((*number, walker.snapshot()?)));
        Some(Self { walkers: walkers.collect::<Option<_>>()?, commands: self.commands.clone() })
    }
}

fn of_walker(seed: &Seed, number: usize) -> Seed {
    seed.child("walker").index(number as u64)
}
