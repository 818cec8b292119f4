use super::trial::STANDING;
use super::{Encounter, PedestrianMotion, Reference, Sight, Trial};
use crate::env::Pair;
use crate::sim::Contact;

/// The label of a failure, from the results of the reference drivers. The first that applies, in this order:
///
/// | label | when |
/// |---|---|
/// | `standing` | the car was at most 0.1 m/s fast when it was touched |
/// | `walked_into_side` | the front had passed: the middle of the pedestrian was behind the line of the bumper, beside the car, and it walked into the flank at more than 0.1 m/s; or it ran into the rear |
/// | `preventable` | both careful humans avoid it |
/// | `unpreventable` | the physical bound hits the pedestrian too |
/// | `machine_preventable` | of all drivers only the ideal brake or the bound avoid it |
/// | `contested` | the drivers disagree in another way |
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Label {
    /// The car stood.
    Standing,
    /// The pedestrian walked into a car whose front had passed.
    WalkedIntoSide,
    /// A careful human avoids it, for both readings of the rule.
    Preventable,
    /// No driver avoids it by braking.
    Unpreventable,
    /// Only a machine avoids it.
    MachinePreventable,
    /// Reference drivers disagree.
    Contested,
}

impl Label {
    /// All of them, in the order of the tables.
    pub const ALL: [Self; 6] = [
        Self::Preventable,
        Self::Contested,
        Self::MachinePreventable,
        Self::Unpreventable,
        Self::WalkedIntoSide,
        Self::Standing,
    ];

    /// The one with this name in tables.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|label| label.name() == name)
    }

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Standing => "standing",
            Self::WalkedIntoSide => "walked_into_side",
            Self::Preventable => "preventable",
            Self::Unpreventable => "unpreventable",
            Self::MachinePreventable => "machine_preventable",
            Self::Contested => "contested",
        }
    }
}

/// The judgement of a failure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// The label.
    pub label: Label,
    /// Time from the start of the danger to the touch (s).
    pub warning: f64,
    /// Whether the pedestrian moved as people do up to the touch: [`PedestrianMotion::is_foreseeable`].
    pub foreseeable: bool,
    /// Whether the pedestrian could be seen before the touch.
    pub sight: Sight,
    /// The car's speed at the recorded touch (m/s).
    pub impact_speed: f64,
    /// The result of each driver, in the order of [`Reference::ALL`].
    pub trials: [Trial; 6],
}

impl Verdict {
    /// The result of a driver.
    pub fn trial(&self, reference: Reference) -> &Trial {
        &self.trials[reference as usize]
    }

    /// Whether a careful human would have avoided it and the pedestrian moved as people do: the failure counts against the driver.
    pub fn is_attributable(&self) -> bool {
        self.label == Label::Preventable && self.foreseeable
    }

    /// The reduction of the impact speed by a driver (m/s): all of it when it avoids the failure.
    pub fn reduction(&self, reference: Reference) -> f64 {
        self.impact_speed - self.trial(reference).impact_speed.unwrap_or(0.0)
    }
}

/// Judges an episode of a vehicle and a pedestrian; none when they did not touch.
pub fn judge(pair: &Pair<'_>) -> Option<Verdict> {
    let encounter = Encounter::new(pair)?;
    let trials = Reference::ALL.map(|reference| Trial::new(&encounter, reference.driver().as_mut()));
    let contact = pair.contact()?;
    let label = if contact.impact_speed <= STANDING {
        Label::Standing
    } else if has_passed(contact, pair, &encounter) {
        Label::WalkedIntoSide
    } else {
        label(&trials)
    };
    Some(Verdict {
        label,
        warning: encounter.warning,
        foreseeable: PedestrianMotion::new(pair).is_foreseeable(),
        sight: Sight::new(pair),
        impact_speed: contact.impact_speed,
        trials,
    })
}

/// The label of a failure at the front of a moving car.
fn label(trials: &[Trial; 6]) -> Label {
    let avoids = |reference: Reference| trials[reference as usize].is_avoided();
    let others = [Reference::CarefulHuman, Reference::CarefulHumanAtTwoSeconds, Reference::FuzzySafety, Reference::Rss];
    if avoids(Reference::CarefulHuman) && avoids(Reference::CarefulHumanAtTwoSeconds) {
        Label::Preventable
    } else if !avoids(Reference::Bound) {
        Label::Unpreventable
    } else if !others.into_iter().any(avoids) {
        Label::MachinePreventable
    } else {
        Label::Contested
    }
}

/// Whether the pedestrian walked into the flank or the rear of the car after the front had passed it.
fn has_passed(contact: &Contact, pair: &Pair<'_>, encounter: &Encounter) -> bool {
    let half = encounter.half;
    if contact.ahead < -half.x {
        return true;
    }
    let Some(last) = pair.last() else { return false };
    let sideways = last.pedestrian.velocity.dot(&last.ego.pose.left());
    let inward = if contact.aside > 0.0 { -sideways } else { sideways };
    contact.ahead < half.x && contact.aside.abs() > half.y && inward > STANDING
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_follow_who_avoids_it() {
        let trial = |avoids: char| {
            let impact_speed = (avoids != 'a').then_some(1.0);
            Trial { impact_speed, time: 1.0, least_gap: 0.0 }
        };
        // Careful human twice, fuzzy, RSS, ideal, bound: `a` avoids, `h` hits.
        for (who, wanted) in [
            ("aahhaa", Label::Preventable),
            ("aahhah", Label::Preventable),
            ("hhhhhh", Label::Unpreventable),
            ("ahaaah", Label::Unpreventable),
            ("hhhhaa", Label::MachinePreventable),
            ("hhhhha", Label::MachinePreventable),
            ("ahhhaa", Label::Contested),
            ("hhahaa", Label::Contested),
        ] {
            let letters: Vec<char> = who.chars().collect();
            assert_eq!(label(&std::array::from_fn(|i| trial(letters[i]))), wanted, "{who}");
        }
    }
}
