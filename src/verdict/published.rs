//! Drivers that others published, in an encounter beside ours: what each of them takes for a danger, when it brakes, and how it ends.

use super::encounter::Encounter;
use super::trial::{Seen, Watch};
use super::{Reference, Trial};
use road::geometry::Pose;
use world::av::reference_drivers::{
    AlksHuman, BrakeProfile, CutInBrake, DelayedBrake, Gate, OwnMotion, ReferenceDriver, Rss, Threat,
};

/// A driver with its name and where it comes from.
#[derive(Debug, Clone, Copy)]
pub struct Published {
    pub name: &'static str,
    /// Who wrote it down, or `ours`.
    pub source: &'static str,
    /// What it takes for a danger.
    pub trigger: &'static str,
    /// Whether it counts among those who avoid a touch: not ours, not JRC's human, which fails its regulation's clause on pedestrians, and not esmini's, which
    /// ignores who stands.
    pub votes: bool,
    driver: fn() -> Box<dyn ReferenceDriver>,
}

/// The source of those that nobody else published.
const OURS: &str = "ours";
/// A deceleration above this (m/s²) is braking.
const BRAKING: f64 = 0.5;

/// The least that UN R152's table of impact speeds asks of an emergency brake (02 series, 5.2.2.4: cars, running order): with its least deceleration it must begin at this
/// time to collision to avoid a pedestrian at 42 km/h.
const R152: (f64, f64) = (5.0, 42.0 / 3.6 / 10.0);
/// The time in which drivers react to somebody who moves into their path by surprise, and the mean of unalerted drivers (s).
const SURPRISED: f64 = 1.5;
const UNALERTED: f64 = 1.21;

/// A human with this reaction time (s), who brakes like UN R157's from when somebody is in the path.
fn reacting(reaction: f64) -> Box<dyn ReferenceDriver> {
    let in_path = Gate { least: f64::INFINITY, in_path: true, ..Gate::CAREFUL };
    Box::new(DelayedBrake::new(Some(in_path), BrakeProfile::careful_human(reaction)))
}

impl Published {
    /// All of them: those of others first.
    pub const ALL: [Self; 15] = [
        Self::new("r157_cc", "JRC-FSM", "overlap, TTC 2 s", false, || Box::new(CutInBrake::human(0.0))),
        Self::new("r157_cc_lane", "JRC-FSM", "1.135 m, TTC 2 s", false, || Box::new(CutInBrake::human(1.135))),
        Self::new("esmini", "esmini, read", "towards the path", false, || Box::<AlksHuman>::default()),
        Self::new("fsm", "JRC-FSM", "unsafe, on course", true, || Reference::FuzzySafety.driver()),
        Self::new("r157_system", "JRC-FSM", "0.5 m, TTC by speed", true, || Box::new(CutInBrake::regulation())),
        Self::new("rss_lanes", "JRC-FSM", "unsafe distances", true, || Box::new(CutInBrake::lanes())),
        Self::new("rss_free", "ad-rss, CARLA", "no stop apart", true, || Box::new(Rss::free())),
        Self::new("surprised", "Green 2000", "in the path", true, || reacting(SURPRISED)),
        Self::new("unalerted", "Taoka 1989", "in the path", true, || reacting(UNALERTED)),
        Self::new("r152_aeb", "UN R152", "on course, 1.17 s", true, || {
            let gate = Gate { least: R152.1, in_time: false, ..Gate::CAREFUL };
            Box::new(DelayedBrake::new(Some(gate), BrakeProfile { wait: 0.0, ramp: 0.0, full: R152.0 }))
        }),
        Self::new("cc", OURS, "on course, in time", false, || Reference::CarefulHuman.driver()),
        Self::new("cc_attentive", OURS, "on course, in time", false, || Reference::AttentiveHuman.driver()),
        Self::new("rss_straight", OURS, "no stop apart", false, || Reference::Rss.driver()),
        Self::new("ideal", OURS, "on course, in time", false, || Reference::IdealBrake.driver()),
        Self::new("bound", OURS, "towards the path", false, || Reference::Bound.driver()),
    ];

    const fn new(
        name: &'static str,
        source: &'static str,
        trigger: &'static str,
        votes: bool,
        driver: fn() -> Box<dyn ReferenceDriver>,
    ) -> Self {
        Self { name, source, trigger, votes, driver }
    }

    /// Whether others published it.
    pub fn is_published(&self) -> bool {
        self.source != OURS
    }

    /// Drives an encounter with it.
    pub(super) fn answer(&'static self, encounter: &mut Encounter<'_>) -> Answer {
        let mut timed = Timed { driver: (self.driver)(), clock: 0.0, trigger: None, brake: None };
        let mut way = Way::default();
        let trial = Trial::watched(encounter, &mut timed, &mut way);
        let to_touch = |time: f64| encounter.warning - time;
        let (trigger, ttc) = timed.trigger.unzip();
        let (trigger, brake) = (trigger.map(to_touch), timed.brake.map(to_touch));
        Answer { driver: self, trigger, ttc, brake, trial, begins: encounter.warning, poses: way.0 }
    }
}

/// What a driver does in an encounter.
#[derive(Debug, Clone)]
pub struct Answer {
    pub driver: &'static Published,
    /// The time from its trigger to the recorded touch (s); `None` if it notices nothing.
    pub trigger: Option<f64>,
    /// The time to collision at its trigger (s), infinite if the two are not closing.
    pub ttc: Option<f64>,
    /// The time to the recorded touch from when it brakes with more than 0.5 m/s² (s).
    pub brake: Option<f64>,
    /// The time to the recorded touch from when it drives (s).
    pub begins: f64,
    pub trial: Trial,
    /// The car from then on, tick by tick, and its speed (m/s).
    pub poses: Vec<(Pose, f64)>,
}

impl Answer {
    /// The time of what comes `before` a touch at this time (s); 0 if it comes before the recording.
    pub fn time(before: Option<f64>, touch: f64) -> Option<f64> {
        before.map(|before| (touch - before).max(0.0))
    }

    /// An object, with times of a recording whose touch is at this one (s); what does not apply is null.
    pub fn to_json(&self, touch: f64) -> serde_json::Value {
        serde_json::json!({
            "driver": self.driver.name,
            "source": self.driver.source,
            "published": self.driver.is_published(),
            "votes": self.driver.votes,
            "trigger": self.driver.trigger,
            "trigger_s": Self::time(self.trigger, touch),
            "ttc_at_trigger_s": self.ttc.filter(|ttc| ttc.is_finite()),
            "brake_s": Self::time(self.brake, touch),
            "avoids": self.trial.is_avoided(),
            "impact_mps": self.trial.impact_speed,
            "spare_m": self.trial.is_avoided().then_some(self.trial.least_gap),
        })
    }
}

/// A driver with a clock.
struct Timed {
    driver: Box<dyn ReferenceDriver>,
    clock: f64,
    trigger: Option<(f64, f64)>,
    brake: Option<f64>,
}

impl ReferenceDriver for Timed {
    fn begin(&mut self) {
        self.driver.begin();
    }

    fn noticed_for(&self) -> f64 {
        self.driver.noticed_for()
    }

    fn has_noticed(&self) -> bool {
        self.driver.has_noticed()
    }

    fn brake(&mut self, own: &OwnMotion, threat: Option<&Threat>, dt: f64) -> Option<f64> {
        let braking = self.driver.brake(own, threat, dt);
        if self.trigger.is_none() && self.driver.has_noticed() {
            let ttc = threat.map_or(f64::INFINITY, |threat| threat.time_to_collision(own));
            self.trigger = Some((self.clock, ttc));
        }
        if self.brake.is_none() && braking.is_some_and(|braking| braking > BRAKING) {
            self.brake = Some(self.clock);
        }
        self.clock += dt;
        braking
    }
}

/// The car of a trial, tick by tick.
#[derive(Default)]
struct Way(Vec<(Pose, f64)>);

impl Watch for Way {
    fn tick(&mut self, seen: &Seen) {
        self.0.push((seen.outline.pose, seen.speed));
    }

    fn touch(&mut self, seen: &Seen) {
        self.0.push((seen.outline.pose, seen.speed));
    }
}
