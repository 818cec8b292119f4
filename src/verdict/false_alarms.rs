use super::reference::Model;
use super::trial::FreeRun;
use super::{Encounter, Reference, Trial};
use episode::Pair;

/// The reference drivers that would have braked needlessly in an episode without a touch.
///
/// The episode is cut into the approaches of the pedestrian, each from the start of its danger to five seconds after its end. Each approach is
/// judged as a collision is: same path, same speed until it brakes, frozen pedestrian. A driver braked *needlessly* when it braked in an approach
/// in which the recorded car does not touch the pedestrian. A reference that stops for everybody would avoid all collisions; this is its price.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FalseAlarms {
    braked: [bool; Reference::COUNT],
    stopped: [bool; Reference::COUNT],
}

impl FalseAlarms {
    /// Looks for them; `None` if vehicle and pedestrian touched.
    pub fn new(pair: &Pair<'_>) -> Option<Self> {
        if pair.contact.is_some() {
            return None;
        }
        let mut alarms = Self::default();
        for mut encounter in Encounter::approaches(pair) {
            alarms.add(&mut encounter);
        }
        Some(alarms)
    }

    fn add(&mut self, encounter: &mut Encounter<'_>) {
        let free = FreeRun::new(encounter);
        // A car that stands all the time cannot stop needlessly.
        if free.trial.least_gap <= 0.0 || !free.trial.moved {
            return;
        }
        for reference in Reference::ALL {
            if self.stopped(reference) {
                continue;
            }
            let trial = match reference.model() {
                Model::Delayed(driver) => {
                    let noticed = free.noticed(encounter, &driver);
                    free.braked(encounter, driver, noticed)
                }
                Model::Other(mut driver) => Trial::new(encounter, driver.as_mut()),
            };
            self.braked[reference as usize] |= trial.braked;
            self.stopped[reference as usize] |= trial.stopped;
        }
    }

    /// Whether a driver braked needlessly.
    pub fn braked(&self, reference: Reference) -> bool {
        self.braked[reference as usize]
    }

    /// Whether it braked to a stop needlessly.
    pub fn stopped(&self, reference: Reference) -> bool {
        self.stopped[reference as usize]
    }
}
