use super::class::Facts;
use super::encounter::STANDING;
use super::follower::{Braked, Follower, others};
use super::reaction::{MAX_REACTION, share_of_drivers};
use super::reference::Model;
use super::trial::{FreeRun, Notice};
use super::{
    Answer, Class, ContactSide, Encounter, Label, PedestrianMotion, Published, Reference, RestsOn, Sight, Trial,
    Verdict, contact_side,
};
use episode::Pair;
use world::av::reference_drivers::{BrakeProfile, DelayedBrake, Gate, OwnMotion};
use world::sim::Contact;

/// The inquiry into a touch. It runs a reference driver when its result is first asked for, so that a caller pays only for what it needs: a
/// reward that asks for the careful humans pays for two drivers and not for six.
#[derive(Debug, Clone)]
pub struct Inquiry<'a> {
    pair: Pair<'a>,
    contact: Contact,
    encounter: Encounter<'a>,
    free: FreeRun,
    /// When a driver with the gate notices the pedestrian, once that is known.
    noticed: Option<Option<Notice>>,
    trials: [Option<Trial>; Reference::COUNT],
}

impl<'a> Inquiry<'a> {
    /// The time to which the latest reaction is known (s).
    const RESOLUTION: f64 = 0.01;
    /// The deceleration to which the least one is known (m/s²).
    const MILDEST: f64 = 0.05;

    /// Starts an inquiry; `None` if vehicle and pedestrian did not touch.
    pub fn new(pair: &Pair<'a>) -> Option<Self> {
        let mut encounter = Encounter::new(pair)?;
        let free = FreeRun::new(&mut encounter);
        Some(Self {
            pair: *pair,
            contact: *pair.contact?,
            encounter,
            free,
            noticed: None,
            trials: [None; Reference::COUNT],
        })
    }

    /// The encounter from the start of the danger.
    pub fn encounter(&self) -> &Encounter<'a> {
        &self.encounter
    }

    /// The result of a driver.
    pub fn trial(&mut self, reference: Reference) -> Trial {
        if let Some(trial) = self.trials[reference as usize] {
            return trial;
        }
        let trial = match reference.model() {
            Model::Delayed(driver) => self.braked(driver),
            Model::Other(mut driver) => Trial::new(&mut self.encounter, driver.as_mut()),
        };
        *self.trials[reference as usize].insert(trial)
    }

    fn braked(&mut self, driver: DelayedBrake) -> Trial {
        let noticed = if driver.gate == Some(Gate::CAREFUL) {
            *self.noticed.get_or_insert_with(|| self.free.noticed(&self.encounter, &driver))
        } else {
            self.free.noticed(&self.encounter, &driver)
        };
        self.free.braked(&mut self.encounter, driver, noticed)
    }

    /// The reduction of the impact speed by a driver (m/s): all of it when it avoids the touch, negative when it hits harder.
    pub fn reduction(&mut self, reference: Reference) -> f64 {
        self.contact.impact_speed - self.trial(reference).impact_speed.unwrap_or(0.0)
    }

    /// The share of drivers who would have avoided the touch: [`Verdict::preventable_probability`]; 0 for a bump.
    pub fn preventable_probability(&mut self) -> f64 {
        self.latest_reaction().map_or(0.0, share_of_drivers)
    }

    /// The label; runs the drivers that it needs.
    pub fn label(&mut self) -> Label {
        if !self.has_moved() {
            return Label::Bump;
        }
        Label::of_moving(|reference| self.trial(reference).is_avoided())
    }

    /// Whether the car moved and all careful drivers avoid the touch.
    pub fn is_preventable(&mut self) -> bool {
        self.has_moved() && Label::careful().into_iter().all(|driver| self.trial(driver).is_avoided())
    }

    /// Whether the car was faster than 0.1 m/s when it touched the pedestrian.
    fn has_moved(&self) -> bool {
        self.contact.impact_speed > STANDING
    }

    /// How much earlier the episode would have to begin for a verdict (s): the danger was under way at its start, a careful human notices it there and
    /// does not avoid the touch clearly, and nobody knows since when it could be seen. `None` if that is not so.
    ///
    /// It is the time by which the gate had opened before, if both had kept their velocities.
    pub fn begins_late(&mut self) -> Option<f64> {
        let length = (self.pair.len() - 2) as f64 + self.contact.fraction;
        let encounter = &self.encounter;
        let is_whole = (encounter.warning / encounter.dt - length).abs() < 0.5;
        let is_open = |inquiry: &mut Self| matches!(inquiry.class(), Class::NotPreventable | Class::Narrow);
        if !is_whole || encounter.speeds[0] <= STANDING || !is_open(self) {
            return None;
        }
        let human = DelayedBrake::careful_human();
        let notice = self.free.noticed(&self.encounter, &human).filter(|notice| notice.time == 0.0)?;
        debug_assert!(!notice.stands, "the car drives");
        let (encounter, car) = (&self.encounter, self.encounter.car(0, 0.0));
        let own = OwnMotion {
            speed: car.speed,
            acceleration: car.acceleration,
            intended: encounter.intended(0, 0.0),
            length: 2.0 * encounter.half.x,
            brake: encounter.brake,
        };
        let threat = encounter.threat(0, 0.0, car.way)?;
        Some((Gate::CAREFUL.opens(&own) - threat.time_to_collision(&own)).max(encounter.dt))
    }

    /// The longest reaction time (s), counted from the gate, with which a driver who brakes like UN R157's human avoids the touch, at most 5 s.
    /// `None` if such a driver touches the pedestrian even if it brakes at once, and when the car stood.
    ///
    /// It is found by bisection between the reactions of the two careful humans, or from there to the ends. A still slower driver may again be lucky
    /// and pass in front of or behind the pedestrian; such luck does not count.
    pub fn latest_reaction(&mut self) -> Option<f64> {
        if !self.has_moved() {
            return None;
        }
        let avoids = |inquiry: &mut Self, reaction| {
            let driver = DelayedBrake::new(Some(Gate::CAREFUL), BrakeProfile::careful_human(reaction));
            inquiry.braked(driver).is_avoided()
        };
        let [attentive, careful] = Label::humans().map(|human| (human.reaction(), self.trial(human).is_avoided()));
        let (mut low, mut high) = match (attentive, careful) {
            ((_, true), (reaction, true)) => (reaction, MAX_REACTION),
            ((first, true), (second, false)) => (first, second),
            ((first, false), _) => (0.0, first),
        };
        if low == 0.0 && !avoids(self, low) {
            return None;
        }
        if high == MAX_REACTION && avoids(self, high) {
            return Some(high);
        }
        while high - low > Self::RESOLUTION {
            let middle = (low + high) / 2.0;
            *if avoids(self, middle) { &mut low } else { &mut high } = middle;
        }
        Some(low)
    }

    /// On what of the gate it rests that the touch is preventable: what, left out alone, lets one of the careful humans touch. `None` unless it is.
    fn rests_on(&mut self) -> Option<RestsOn> {
        let avoid = |inquiry: &mut Self, gate| {
            let profiles = Label::humans().map(|human| BrakeProfile::careful_human(human.reaction()));
            profiles.into_iter().all(|profile| inquiry.braked(DelayedBrake::new(Some(gate), profile)).is_avoided())
        };
        self.is_preventable().then(|| {
            let in_path = avoid(self, Gate { in_path: true, ..Gate::CAREFUL });
            let late = avoid(self, Gate { in_time: false, ..Gate::CAREFUL });
            match (in_path, late) {
                (false, true) => RestsOn::Anticipation,
                (true, false) => RestsOn::EarlyGate,
                (false, false) => RestsOn::Both,
                (true, true) => RestsOn::Neither,
            }
        })
    }

    /// Whether the touch is preventable, and whether it is a fault.
    pub(super) fn blame(&mut self) -> (bool, bool) {
        (self.is_preventable(), self.class().is_fault())
    }

    /// What the touch counts as.
    pub fn class(&mut self) -> Class {
        let motion = PedestrianMotion::new(&self.pair);
        let (_, walked_into) = self.touched(&motion);
        let moved = self.has_moved();
        let preventable = self.is_preventable();
        let margin = match preventable {
            true => Label::humans().map(|human| self.trial(human).least_gap).into_iter().fold(f64::INFINITY, f64::min),
            false => 0.0,
        };
        let (foreseeable, fast) = (motion.is_foreseeable(), motion.is_fast());
        Class::of(&Facts {
            moved,
            preventable,
            foreseeable,
            fast,
            walked_into,
            speed: self.contact.impact_speed,
            margin,
            followed: self.follower().is_some_and(|follower| follower.touches()),
        })
    }

    /// The car that follows that of a careful human; `None` without one, and if the humans do not avoid the touch.
    fn follower(&mut self) -> Option<Follower> {
        others(&self.pair).next()?;
        if !self.is_preventable() {
            return None;
        }
        let humans = Label::humans().map(|human| {
            let mut braked = Braked::default();
            let driver = self.mildest(human.reaction());
            let notice = self.free.noticed(&self.encounter, &driver);
            braked.stopped = self.free.braked_watched(&mut self.encounter, driver, notice, &mut braked).stopped;
            braked
        });
        Follower::behind(&self.pair, &self.encounter, &humans)
    }

    /// A human with this reaction (s) who brakes from when braking is due, and no harder than it must to avoid the touch. Due it is this long after the
    /// pedestrian is in the way or moves into it, without a gate. If braking that early does not avoid it, the human is that of the verdict.
    fn mildest(&mut self, reaction: f64) -> DelayedBrake {
        let human = BrakeProfile::careful_human(reaction);
        let early = |full| DelayedBrake::new(None, BrakeProfile { full, ..human });
        if !self.braked(early(human.full)).is_avoided() {
            return DelayedBrake::new(Some(Gate::CAREFUL), human);
        }
        let (mut low, mut high) = (0.0, human.full);
        while high - low > Self::MILDEST {
            let middle = (low + high) / 2.0;
            *if self.braked(early(middle)).is_avoided() { &mut high } else { &mut low } = middle;
        }
        early(high)
    }

    /// The side of the touch, and whether the pedestrian walked into the car.
    fn touched(&self, motion: &PedestrianMotion) -> (ContactSide, bool) {
        contact_side::touched(&self.pair, motion).expect("checked: they touched")
    }

    /// What each published driver does from when it can see the pedestrian, and each of ours from the start of the danger.
    pub fn answers(&mut self) -> Vec<Answer> {
        let Some(mut earlier) = Encounter::in_sight(&self.pair) else { return Vec::new() };
        let mut answer = |driver: &'static Published| {
            driver.answer(if driver.is_published() { &mut earlier } else { &mut self.encounter })
        };
        Published::ALL.iter().map(&mut answer).collect()
    }

    pub fn verdict(mut self) -> Verdict {
        let motion = PedestrianMotion::new(&self.pair);
        let (side, walked_into) = self.touched(&motion);
        Verdict {
            label: self.label(),
            side,
            walked_into,
            warning: self.encounter.warning,
            foreseeable: motion.is_foreseeable(),
            fast: motion.is_fast(),
            sight: Sight::new(&self.pair),
            impact_speed: self.contact.impact_speed,
            latest_reaction: self.latest_reaction(),
            rests_on: self.rests_on(),
            follower: self.follower(),
            trials: Reference::ALL.map(|reference| self.trial(reference)),
        }
    }
}

/// Judges an episode of a vehicle and a pedestrian; `None` if they did not touch. It depends on the recording alone.
pub fn judge(pair: &Pair<'_>) -> Option<Verdict> {
    Inquiry::new(pair).map(Inquiry::verdict)
}
