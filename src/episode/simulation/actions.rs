use super::trace::Driven;
use crate::{Cast, Controller};
use road::geometry::{Pose, wrap_angle};
use world::av::DrivingMode;
use world::sim::{ActorStart, Contact, Control, Vehicle, VehicleState, WalkCommand};

/// What the actors of an episode do: the command of each pedestrian, what each driver did in the last tick, and the touch in it.
#[derive(Debug, Clone)]
pub struct Actions {
    /// The bounds of a joint action.
    pub(super) bounds: Vec<(f64, f64)>,
    /// The bounds of the action of each pedestrian, one after another.
    pub(super) each_bounds: Vec<(f64, f64)>,
    /// Where the ego is at the start.
    pub(super) ego: Pose,
    /// Where each pedestrian starts.
    pub starts: Vec<ActorStart>,
    /// The command that each pedestrian carries out.
    pub commands: Vec<WalkCommand>,
    /// The angle from the previous command to each command (rad).
    pub(super) turns: Vec<f64>,
    /// The pedals and the wheel of each vehicle in the last tick.
    pub controls: Vec<Control>,
    /// What each driver did in it.
    pub modes: Vec<DrivingMode>,
    /// The first touch in it.
    pub contact: Option<Contact>,
}

impl Actions {
    /// Those of a cast before its first episode.
    pub fn new(cast: &Cast) -> Self {
        let (vehicles, pedestrians) = (cast.vehicles.len(), cast.pedestrians.len());
        Self {
            bounds: cast.action_bounds(),
            each_bounds: cast.pedestrians.iter().flat_map(|role| role.action.bounds()).collect(),
            ego: Pose::default(),
            starts: vec![ActorStart::default(); pedestrians],
            commands: vec![WalkCommand::default(); pedestrians],
            turns: vec![0.0; pedestrians],
            controls: vec![Control::default(); vehicles],
            modes: vec![DrivingMode::default(); vehicles],
            contact: None,
        }
    }

    /// The pedestrians appear at their starts and stand; the ego is here.
    pub fn begin(&mut self, ego: Pose) {
        self.ego = ego;
        for (command, start) in self.commands.iter_mut().zip(&self.starts) {
            *command = WalkCommand { heading: start.pose.yaw, speed: 0.0 };
        }
        self.turns.fill(0.0);
    }

    /// Takes a decision. Pedestrians with a fixed command keep it.
    pub fn decide(&mut self, cast: &Cast, commands: &[WalkCommand]) {
        let last = self.commands.iter_mut().zip(&mut self.turns);
        for (((last, turn), command), role) in last.zip(commands).zip(cast.pedestrians.iter()) {
            let command = match role.controller {
                Controller::External | Controller::Own(_) => *command,
                Controller::Fixed(fixed) => fixed,
            };
            *turn = wrap_angle(command.heading - last.heading);
            *last = command;
        }
    }

    /// Notes what another simulator's own driver did in a tick: the pedals that would move our car as its car has moved.
    pub(super) fn observe(&mut self, before: &Vehicle, after: &VehicleState, dt: f64) {
        let speed = before.state.speed;
        self.controls[0] = before.blueprint.pedals_for((after.speed - speed) / dt, speed);
        self.modes[0] = DrivingMode::Unknown;
    }

    /// What the driver of a vehicle did in the last tick.
    #[inline]
    pub fn driven(&self, vehicle: usize) -> Driven {
        Driven { mode: self.modes[vehicle], control: self.controls[vehicle] }
    }
}
