use crate::failure::{Failure, FailureClass};
use crate::report::{FailureChange, SideCollision, SideEnd};
use episode::Criterion;
use verdict::cause::Incident;
use verdict::{Blame, Judged, severe_injury_risk};

/// How an encounter ended for one driver.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RerunOutcome {
    /// Speed of the car at the collision (m/s); `None` without one.
    pub impact_speed: Option<f64>,
    /// Whether the touch counts against the driver.
    pub fault: bool,
    /// Whether the driver or the controller failed as a program.
    pub error: bool,
    /// Whether nobody was touched, and nobody would be if the driver saw no pedestrian: its own way and speed let them miss each other. The end of an episode
    /// that is left out, since the car left the road or the map, says nothing of a touch either.
    pub is_missed: bool,
}

/// Encounters of two drivers. One in which a driver failed as a program says nothing.
#[derive(Debug, Clone, Default)]
pub struct Encounters(pub Vec<Encounter>);

/// An encounter of two drivers with the same pedestrian from the same start.
#[derive(Debug, Clone)]
pub struct Encounter {
    /// The name of the failure in its report, `RUN:EPISODE`; empty on the fixed list.
    pub name: String,
    pub start: u64,
    /// The number of the crossing on the fixed list; 0 for a failure of a report.
    pub crossing: u64,
    /// How it ended for the old driver; `None` if that cannot be run any more.
    pub before: Option<RerunOutcome>,
    /// How it ended for the new driver.
    pub after: RerunOutcome,
    /// What repeats it with the new driver, if that has a fault in this simulator.
    pub incident: Option<Incident>,
}

impl RerunOutcome {
    /// The end of an episode.
    pub fn new(judged: &Judged) -> Self {
        let outcome = &judged.outcome;
        let error = outcome.fault().is_some();
        if error || outcome.left_out.is_some() {
            return Self { error, is_missed: !error, ..Self::default() };
        }
        Self {
            impact_speed: outcome.impact_speed().filter(|_| outcome.is_collision()),
            fault: judged.is(Criterion::Collision, Blame::Fault),
            ..Self::default()
        }
    }

    /// The end of a failure, or of a near miss, as its report has it.
    pub fn stored(failure: &Failure) -> Self {
        let impact_speed = failure.impact.map(|_| failure.impact_speed);
        Self { impact_speed, fault: failure.fault, ..Self::default() }
    }

    /// An encounter that was not run, since its driver failed as a program over and over.
    pub fn error() -> Self {
        Self { error: true, ..Self::default() }
    }

    pub fn is_collision(&self) -> bool {
        self.impact_speed.is_some()
    }

    /// Its collision, if it ends in one.
    pub fn collision(&self) -> Option<SideCollision> {
        let class = if self.fault { FailureClass::Fault } else { FailureClass::Unjudged };
        let verdict = if self.fault { "fault" } else { "no fault" };
        let impact_speed = self.impact_speed?;
        Some(SideCollision { class, verdict, fault: self.fault, kind: String::new(), impact_speed })
    }

    /// The probability of a severe injury; 0 without a collision.
    pub fn injury(&self) -> f64 {
        self.impact_speed.map_or(0.0, severe_injury_risk)
    }

    /// The probability of a severe injury that another driver would have spared the pedestrian; 0 unless it is a fault.
    pub fn avoidable_injury(&self) -> f64 {
        if self.fault { self.injury() } else { 0.0 }
    }
}

impl Encounter {
    /// Its ends for both drivers; `None` if the old driver cannot be run, or neither has a collision.
    pub fn change(&self, place: String) -> Option<FailureChange> {
        let name = self.own_name();
        let end =
            |met: RerunOutcome| SideEnd { name: name.clone(), collision: met.collision(), is_missed: met.is_missed };
        let sides = [self.before?, self.after].map(end);
        sides.iter().any(|side| side.collision.is_some()).then_some(FailureChange { place, sides })
    }

    fn own_name(&self) -> String {
        match self.name.as_str() {
            "" => format!("start {}, walk {}", self.start, self.crossing),
            name => name.to_owned(),
        }
    }

    /// Its name beside others: that of the failure, or on the fixed list with the title of its row.
    pub fn in_row(&self, title: &str) -> String {
        let name = self.own_name();
        if self.name.is_empty() { format!("{name}, {title}") } else { name }
    }

    /// Whether a driver failed as a program, so that the encounter says nothing.
    pub fn is_error(&self) -> bool {
        self.after.error || self.before.is_some_and(|before| before.error)
    }
}

impl Encounters {
    /// The number of encounters in which a driver failed as a program.
    pub fn errors(&self) -> u64 {
        (self.0.len() - self.valid().count()) as u64
    }

    /// The encounters that no driver failed in as a program.
    pub fn valid(&self) -> impl Iterator<Item = &Encounter> {
        self.0.iter().filter(|encounter| !encounter.is_error())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::tests::row;
    use episode::{Ending, LeftOut};

    #[test]
    fn an_episode_that_is_left_out_is_not_met() {
        let hit = Ending::Touch { pedestrian: 0, front: true, moving: true, impact_speed: 4.0, bearing: 0.0 };
        for ending in [hit, Ending::Timeout] {
            let mut judged = row(0, ending).judged;
            let met = RerunOutcome::new(&judged);
            assert_eq!((met.is_collision(), met.is_missed), (judged.outcome.is_collision(), false));
            judged.outcome.left_out = Some(LeftOut::OffRoad);
            let met = RerunOutcome::new(&judged);
            assert_eq!((met.is_collision(), met.fault, met.error, met.is_missed), (false, false, false, true));
        }
    }
}
