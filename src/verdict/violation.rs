use super::encounter::STANDING;
use super::reference::Model;
use super::trial::{FreeRun, Seen, Watch};
use super::{Encounter, Inquiry, Label, PedestrianMotion, Trial};
use base::choice;
use base::signature::Requirement;
use episode::requirement::Degree;
use episode::{OtherDrive, Pair, is_about_braking, is_about_pedestrian};
use road::geometry::{Point, Pose};
use world::av::reference_drivers::DelayedBrake;

choice! {
    /// Why careful drivers cannot be asked about a requirement.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum NoVerdict {
        /// It does not mention a pedestrian, to whom they would react.
        NoPedestrian = "no_pedestrian",
        /// It mentions how hard the car brakes. They never brake less than the driver did, so they would violate it as well.
        Braking = "braking",
    }
}

impl NoVerdict {
    /// Why violations of a requirement have no verdict; `None` if they have.
    pub fn of(requirement: &Requirement) -> Option<Self> {
        if !requirement.mentions(&is_about_pedestrian) {
            Some(Self::NoPedestrian)
        } else {
            requirement.mentions(&is_about_braking).then_some(Self::Braking)
        }
    }

    /// The reason in words.
    pub fn reason(self) -> &'static str {
        match self {
            Self::NoPedestrian => "it says nothing of a pedestrian",
            Self::Braking => "it says how hard the car brakes, and careful drivers never brake less than the driver",
        }
    }
}

/// Whose fault the violation of a requirement is.
///
/// 1. The episode is rewound from the sample that decides to the start of the danger, as a collision is.
/// 2. From there all careful drivers drive, as for a collision, to the end of the episode: a car that has stopped stands, and one that has passed the
///    pedestrian never gains speed. After a recorded touch the pedestrian walks on for 5 s.
/// 3. The requirement is evaluated on their samples, as if the episode started there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct ViolationVerdict {
    /// Whether all careful drivers satisfy the requirement.
    pub preventable: bool,
    /// Whether the pedestrian moved as people do.
    pub foreseeable: bool,
    /// Whether it counts against the driver: both, and where the touch of a collision decides the collision is a fault.
    pub fault: bool,
    /// The sample at which the danger starts.
    pub danger: u32,
}

impl ViolationVerdict {
    /// Asks the careful drivers about a requirement with this degree in an episode; `None` if it is satisfied, or if they cannot be asked.
    pub fn new(pair: &Pair<'_>, requirement: &Requirement, degree: &Degree) -> Option<Self> {
        if !degree.is_violated() || NoVerdict::of(requirement).is_some() || pair.is_empty() {
            return None;
        }
        let sample = degree.sample as usize;
        let pair = pair.of_sample(sample);
        let preventable;
        let danger;
        {
            let (first, encounter) = Encounter::before(&pair, sample);
            danger = first;
            preventable = CarefulDrivers::new(&pair, requirement, first, encounter).all_satisfy();
        }
        let foreseeable = PedestrianMotion::new(&pair).is_foreseeable();
        let touch = pair.contact.filter(|touch| touch.impact_speed > STANDING && sample + 1 >= pair.len());
        let counts = |_: &_| Inquiry::new(&pair).is_some_and(|mut inquiry| inquiry.class().is_fault());
        let fault = preventable && foreseeable && touch.as_ref().is_none_or(counts);
        Some(Self { preventable, foreseeable, fault, danger: danger as u32 })
    }
}

/// The careful drivers in the place of the driver.
struct CarefulDrivers<'a> {
    pair: &'a Pair<'a>,
    requirement: &'a Requirement,
    first: usize,
    encounter: Encounter<'a>,
}

impl<'a> CarefulDrivers<'a> {
    fn new(pair: &'a Pair<'a>, requirement: &'a Requirement, first: usize, encounter: Encounter<'a>) -> Self {
        Self { pair, requirement, first, encounter }
    }

    fn all_satisfy(mut self) -> bool {
        let mut free = Drive::default();
        let run = FreeRun::watched(&mut self.encounter, &mut free);
        let notice = run.noticed(&self.encounter, &DelayedBrake::careful_human());
        Label::careful().into_iter().all(|careful| {
            let mut drive = free.clone();
            let trial = match careful.model() {
                Model::Delayed(driver) => run.braked_watched(&mut self.encounter, driver, notice, &mut drive),
                Model::Other(mut driver) => {
                    drive = Drive::default();
                    Trial::watched(&mut self.encounter, driver.as_mut(), &mut drive)
                }
            };
            self.is_satisfied(&drive, trial.time)
        })
    }

    /// Whether a drive satisfies the requirement. A touch ends it at this time (s).
    fn is_satisfied(&mut self, drive: &Drive, end: f64) -> bool {
        let mut samples = OtherDrive::new(*self.pair, self.requirement, self.first);
        for (tick, (pose, speed)) in drive.ticks.iter().enumerate() {
            samples.push(*pose, *speed, self.walker(tick as f64), None);
        }
        if let Some((pose, speed)) = drive.touch {
            let ticks = end / self.encounter.dt;
            let at = self.walker(ticks);
            let touch = samples.touch(&pose, speed, at, ticks - (drive.ticks.len() - 1) as f64);
            samples.push(pose, speed, at, Some(&touch));
        }
        !samples.degree().is_violated()
    }

    /// Where the pedestrian is this number of ticks after the start.
    fn walker(&mut self, ticks: f64) -> Point {
        let last = self.encounter.step_count - 1;
        let before = (ticks as usize).min(last);
        let after = (before + 1).min(last);
        self.encounter.has_step(after);
        let (from, to) = (self.encounter.steps[before].position, self.encounter.steps[after].position);
        from + (to - from) * (ticks - before as f64).clamp(0.0, 1.0)
    }
}

/// The car of a careful driver: its poses and speeds (m/s).
#[derive(Debug, Clone, Default)]
struct Drive {
    /// At the start of each tick, and at the end.
    ticks: Vec<(Pose, f64)>,
    /// At the touch that ends it.
    touch: Option<(Pose, f64)>,
}

impl Watch for Drive {
    fn tick(&mut self, seen: &Seen) {
        self.ticks.push((seen.outline.pose, seen.speed));
    }

    fn interferes(&mut self, tick: usize) {
        self.ticks.truncate(tick);
        self.touch = None;
    }

    fn touch(&mut self, seen: &Seen) {
        self.touch = Some((seen.outline.pose, seen.speed));
    }

    fn is_whole(&self) -> bool {
        true
    }
}
