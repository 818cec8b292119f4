use std::collections::VecDeque;

use super::bridge::{STANDING, millimetres};
use road::geometry::{Vector, wrap_angle};
use world::av::Fault;
use world::sim::{Control, VehicleBlueprint, VehicleState};

/// How far from where its speed and heading lead a car may be after a tick: in m, if the world does not say how far, and beside that as a share of its way.
/// More is a jump. The first tick of MetaDrive's physics lacks a fifth.
const JUMP: f64 = 0.1;
const LAG: f64 = 0.25;
/// How much its way in an episode may differ from what its speeds make: as a share of the longer of both, beside that (m), and beside what a standing car creeps.
const BY_SPEED: f64 = 0.05;
const FREE: f64 = 0.5;
/// How far the motion of a car may differ from its heading (rad), on average over the last metres of its way.
const BESIDE: f64 = 0.3;
const MEMORY: f64 = 3.0;
/// How late a car may follow its control (s), beside what its world says of its pedals.
const LATE: f64 = 0.1;
/// By how much what a car was told and what it did may differ: in m/s, in rad, and beside that as a share of what it was told. The speed and the heading are
/// forgotten after some time (s); what it did while it braked is not, for an episode. MetaDrive's car differs by 0.07 m/s while it brakes, and by 0.033 rad.
const LATELY: f64 = 2.0;
const OFF: [f64; 2] = [0.6, 0.05];
const SHARE: f64 = 0.15;
const BRAKED: f64 = 0.15;
const BRAKED_SHARE: f64 = 0.1;
/// Acceleration that the tyres of any car hold (m/s²), and by which factor another engine may be stronger or weaker.
const HELD: f64 = 7.0;
const ENGINE: f64 = 2.0;

/// What a car was told and what it did.
#[derive(Debug, Default)]
struct Account {
    told: f64,
    done: f64,
    /// The sum of what it was told, whatever the sign.
    size: f64,
}

impl Account {
    /// Adds what a car did in a tick and what it might do, from one number to another, and forgets a share of the past; whether both differ now by more than
    /// a number and a share.
    fn differs(&mut self, done: f64, range: [f64; 2], forget: f64, (off, share): (f64, f64)) -> bool {
        let told = done.clamp(range[0], range[1]);
        for (sum, new) in [(&mut self.told, told), (&mut self.done, done), (&mut self.size, told.abs())] {
            *sum += new - *sum * forget;
        }
        (self.done - self.told).abs() > off + share * self.size
    }

    /// What it was told and did, in another unit.
    fn rounded(&self, factor: f64) -> [i32; 2] {
        [self.told, self.done].map(|sum| (sum * factor).round() as i32)
    }
}

/// What a car might do in the last ticks, the last first.
#[derive(Debug, Default)]
struct Recent(VecDeque<[f64; 2]>);

impl Recent {
    /// Adds what it might do in a tick, from one number to the other; returns what it might do if it is late by some time (s). Before an episode it did
    /// nothing.
    fn add(&mut self, range: [f64; 2], late: f64, dt: f64) -> [f64; 2] {
        let count = 1 + (late / dt + 1e-9) as usize;
        self.0.push_front(range);
        self.0.truncate(count);
        let nothing = (self.0.len() < count).then_some([0.0; 2]);
        let all = || self.0.iter().chain(&nothing).flatten().copied();
        [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
    }
}

/// Compares the motion of a car of another simulator with the speeds and headings that it states, and with its control, tick by tick for an episode.
#[derive(Debug, Default)]
pub(super) struct Odometer {
    /// The way of the car, and the one that its speeds make (m).
    way: f64,
    by_speed: f64,
    /// The time of both (s).
    time: f64,
    /// The angle between motion and heading, on average over the last metres (rad).
    beside: f64,
    /// Speeds, those of ticks in which it brakes (m/s), and headings (rad).
    speeds: Account,
    brakes: Account,
    headings: Account,
    /// Changes of speed (m/s) and of heading (rad).
    pedals: Recent,
    wheels: Recent,
    /// That the car did not follow its control in the tick before.
    disobeyed: Option<Fault>,
}

impl Odometer {
    /// Adds a tick of a car, which leads our car to the state `next`. `control` is that of a driver of ours, `tolerance` how far from where it is told the world
    /// may place an actor (m), and `pedal_delay` how late its car may follow the pedals (s).
    ///
    /// # Errors
    /// The car is not where its speed and its heading lead, or does not follow its control.
    pub fn add(
        &mut self,
        [before, next, after]: [&VehicleState; 3],
        (car, control): (&VehicleBlueprint, Option<Control>),
        (dt, tolerance, pedal_delay): (f64, f64, f64),
    ) -> Result<(), Fault> {
        let speed = (before.speed + after.speed) / 2.0;
        // Ahead, also of a car that reverses.
        let moved = (after.pose.position() - before.pose.position()) * speed.signum();
        let (way, by_speed) = (moved.norm(), speed.abs() * dt);
        (self.way, self.by_speed, self.time) = (self.way + way, self.by_speed + by_speed, self.time + dt);
        let turned = wrap_angle(after.pose.yaw - before.pose.yaw);
        // A car turns about a point beside its rear axle, so its middle slips; that of a car on rails does not.
        let slip = libm::asin((turned * car.wheelbase / 2.0 / way.max(1e-9)).clamp(-1.0, 1.0));
        let headings = [0.0, slip].map(|slip| before.pose.yaw + turned / 2.0 + slip);
        let off = headings.map(|heading| {
            let (sin, cos) = libm::sincos(heading);
            (moved - Vector::new(cos, sin) * by_speed).norm()
        });
        let off = off[0].min(off[1]);
        if off > tolerance.max(JUMP) + LAG * by_speed {
            return Err(Fault::Jumped { millimetres: millimetres(off) });
        }
        if (self.way - self.by_speed).abs() > BY_SPEED * self.way.max(self.by_speed) + FREE + STANDING * self.time {
            let [way, by_speed] = [self.way, self.by_speed].map(|way| (way * 10.0) as u32);
            return Err(Fault::Way { way, by_speed });
        }
        let direction = libm::atan2(moved.y, moved.x);
        let beside = headings.map(|heading| wrap_angle(direction - heading).abs());
        self.beside += (beside[0].min(beside[1]) - self.beside) * (way / MEMORY).min(1.0);
        if self.beside > BESIDE {
            return Err(Fault::Beside { degrees: self.beside.to_degrees() as u32 });
        }
        // Somebody whom it touches may push it; that ends the episode first.
        if let Some(fault) = self.disobeyed {
            return Err(fault);
        }
        let Some(control) = control else { return Ok(()) };
        let (done, told, held) = (after.speed - before.speed, next.speed - before.speed, HELD * dt);
        let range = if control.brake > 0.0 { [told, told.max(-held)] } else { [told / ENGINE, told * ENGINE] };
        let range = self.pedals.add(range, LATE + pedal_delay, dt);
        let forget = (dt / LATELY).min(1.0);
        // Another car may be in gear sooner than ours.
        let in_gear = before.age >= car.start_up_pause || before.speed > 0.0;
        if in_gear && self.speeds.differs(done, range, forget, (OFF[0], SHARE)) {
            let [told, done] = self.speeds.rounded(10.0);
            self.disobeyed = Some(Fault::Pedals { told, done });
        }
        let is_braking = control.brake > 0.0 && before.speed > 0.0;
        if is_braking && self.brakes.differs(done, range, 0.0, (BRAKED, BRAKED_SHARE)) {
            let [told, done] = self.brakes.rounded(-10.0);
            self.disobeyed = Some(Fault::Brake { told, done });
        }
        let (told, held) = (wrap_angle(next.pose.yaw - before.pose.yaw), held / before.speed.abs());
        let range = self.wheels.add([told, told.clamp(-held, held)], LATE, dt);
        if self.headings.differs(turned, range, forget, (OFF[1], SHARE)) {
            let [told, done] = self.headings.rounded(1_f64.to_degrees());
            self.disobeyed = Some(Fault::Wheel { told, done });
        }
        Ok(())
    }
}
