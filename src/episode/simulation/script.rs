use rand::RngExt;

use crate::scenario::spawn::{Pacing, Release};
use crate::{Scenario, Spawn};
use base::seed::Stream;
use road::geometry::Pose;
use world::sim::{WalkCommand, World};

/// The walk of the first pedestrian that the spawn rule states: that of the target of a test, or along a path.
#[derive(Debug, Clone, Default)]
pub(super) struct Script {
    /// The fraction of its way from which a target starts.
    approach: f64,
    /// The time for which the pedestrian stands at the start of a path (s).
    delay: f64,
    release: Option<Release>,
    pacing: Option<Pacing>,
}

impl Script {
    /// Draws what is random about it. Returns the start of a test, too.
    pub(super) fn draw(scenario: &Scenario, number: u64, stream: &mut Stream) -> (Self, Option<Spawn>) {
        let mut script = Self { approach: 1.0, ..Self::default() };
        let spawn = scenario.spawn.target_walk.as_ref().map(|walk| {
            script.approach = walk.approach.quantile(stream.random());
            walk.spawn(number, script.approach, &scenario.cast.ego().blueprint)
        });
        if let Some(path) = &scenario.spawn.given_path {
            script.delay = path.delay.quantile(stream.random());
        }
        (script, spawn)
    }

    /// Takes the first command, which says how fast and in which direction the walk is. Returns where a target starts.
    pub(super) fn begin(
        &mut self,
        scenario: &Scenario,
        number: u64,
        world: &World,
        command: WalkCommand,
    ) -> Option<Pose> {
        let spawn = &scenario.spawn;
        self.pacing = spawn.given_path.as_ref().map(|path| path.pacing(command, self.delay));
        let ego = world.ego();
        let walk = spawn.target_walk.as_ref()?;
        let release = walk.release(number, self.approach, &ego.state, &ego.blueprint, command, world.dt);
        let start = release.start;
        self.release = Some(release);
        Some(start)
    }

    /// The command in this tick; `None` without a script.
    #[inline]
    pub(super) fn command(&self, scenario: &Scenario, world: &World) -> Option<WalkCommand> {
        if let Some(release) = &self.release {
            return Some(release.command(world.ticks, world.dt));
        }
        let (path, pacing) = scenario.spawn.given_path.as_ref().zip(self.pacing.as_ref())?;
        Some(path.tick_command(pacing, &world.pedestrians[0].state.pose, world.ticks, world.dt))
    }
}
