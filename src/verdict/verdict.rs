use super::class::Facts;
use super::{Class, ContactSide, Follower, Reference, Sight, Trial, reaction, severity};
use base::choice;

choice! {
    /// The label of a failure, from the results of the reference drivers. The first that applies, in this order:
    ///
    /// | label | when |
    /// |---|---|
    /// | `bump` | the car was at most 0.1 m/s fast when it was touched: there is no braking to judge |
    /// | `preventable` | all careful drivers avoid it: both careful humans and the Fuzzy Safety Model |
    /// | `unpreventable` | the physical bound hits the pedestrian too |
    /// | `machine_preventable` | of all drivers only the ideal brake or the bound avoid it |
    /// | `contested` | the drivers disagree in another way |
    ///
    /// Which side of the car was touched does not matter: a pedestrian who walks into the flank of a car that a careful human would have stopped
    /// is a preventable collision. [`Verdict::side`] and [`Verdict::walked_into`] state the side.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
    pub enum Label {
        /// All careful drivers avoid it.
        Preventable = "preventable",
        /// Reference drivers disagree.
        Contested = "contested",
        /// Only a machine avoids it.
        MachinePreventable = "machine_preventable",
        /// No driver avoids it by braking.
        Unpreventable = "unpreventable",
        /// The car stood.
        Bump = "bump",
    }
}

choice! {
    /// On what of our gate it rests that a collision is preventable: the regulation's human perceives cut-ins, within 2 s.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
    pub enum RestsOn {
        /// The humans brake for somebody who is not yet in the path.
        Anticipation = "anticipation",
        /// They brake more than 2 s before.
        EarlyGate = "early_gate",
        /// Without either of the two a human does not avoid it.
        Both = "both",
        /// The humans avoid it without either.
        Neither = "neither",
    }
}

impl Label {
    /// The word for a failure with this label in lists, pictures and exported files. A *fault* is named as such.
    pub fn word(self, is_fault: bool) -> &'static str {
        match self {
            _ if is_fault => "fault",
            Self::MachinePreventable => "machine preventable",
            label => label.name(),
        }
    }

    /// The number of labels.
    pub const COUNT: usize = 5;

    /// The two careful humans, the one that brakes earlier first.
    pub const fn humans() -> [Reference; 2] {
        [Reference::AttentiveHuman, Reference::CarefulHuman]
    }

    /// The careful drivers, who decide whether a collision is preventable: both models of UN R157 for what a careful driver avoids.
    pub const fn careful() -> [Reference; 3] {
        let [attentive, careful] = Self::humans();
        [attentive, careful, Reference::FuzzySafety]
    }

    /// The label of a collision. `avoids` is asked only for the drivers that are needed.
    pub(super) fn of_moving(mut avoids: impl FnMut(Reference) -> bool) -> Self {
        let careful = Self::careful().map(&mut avoids);
        if careful == [true; 3] {
            Self::Preventable
        } else if !avoids(Reference::Bound) {
            Self::Unpreventable
        } else if careful == [false; 3] && !avoids(Reference::Rss) {
            Self::MachinePreventable
        } else {
            Self::Contested
        }
    }
}

/// The judgement of a failure.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Verdict {
    pub label: Label,
    /// The side of the car that was touched.
    pub side: ContactSide,
    /// Whether the pedestrian walked into the flank at more than 0.1 m/s, or ran into the rear, after the front had passed it.
    pub walked_into: bool,
    /// Time from the start of the danger to the touch (s).
    pub warning: f64,
    /// Whether the pedestrian moved as people do in the last three seconds before the touch: [`PedestrianMotion::is_foreseeable`](super::PedestrianMotion::is_foreseeable).
    pub foreseeable: bool,
    /// Whether it was faster than 8 km/h: [`PedestrianMotion::is_fast`](super::PedestrianMotion::is_fast).
    pub fast: bool,
    /// Whether the pedestrian could be seen before the touch.
    pub sight: Sight,
    /// The car's speed at the recorded touch (m/s).
    pub impact_speed: f64,
    /// The longest reaction time with which a careful driver avoids it (s): [`Inquiry::latest_reaction`](super::Inquiry::latest_reaction).
    pub latest_reaction: Option<f64>,
    /// On what it rests; `None` unless it is preventable.
    pub rests_on: Option<RestsOn>,
    /// The car that follows, if careful humans avoid the collision; `None` without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follower: Option<Follower>,
    /// The result of each driver, in the order of [`Reference::ALL`].
    pub trials: [Trial; Reference::COUNT],
}

impl Verdict {
    /// The result of a driver.
    pub fn trial(&self, reference: Reference) -> &Trial {
        &self.trials[reference as usize]
    }

    /// Whether the car moved and all careful drivers avoid it.
    pub fn is_preventable(&self) -> bool {
        self.label == Label::Preventable
    }

    /// What it counts as.
    pub fn class(&self) -> Class {
        Class::of(&Facts {
            moved: !self.is_bump(),
            preventable: self.is_preventable(),
            foreseeable: self.foreseeable,
            fast: self.fast,
            walked_into: self.walked_into,
            speed: self.impact_speed,
            margin: Label::humans().map(|human| self.margin(human)).into_iter().fold(f64::INFINITY, f64::min),
            followed: self.follower.is_some_and(|follower| follower.touches()),
        })
    }

    /// What it is called in lists, pictures and exported files.
    pub fn word(&self) -> &'static str {
        self.label.word(self.is_fault())
    }

    /// Whether it counts against the driver.
    pub fn is_fault(&self) -> bool {
        self.class().is_fault()
    }

    /// The risk of a severe injury that the driver would have spared the pedestrian by driving as a careful human does: that of the impact for
    /// a fault, otherwise 0.
    pub fn avoidable_injury(&self) -> f64 {
        if self.is_fault() { severity::severe_injury_risk(self.impact_speed) } else { 0.0 }
    }

    /// Whether the car was at most 0.1 m/s fast when it was touched.
    pub fn is_bump(&self) -> bool {
        self.label == Label::Bump
    }

    /// The reduction of the impact speed by a driver (m/s): all of it when it avoids the failure, negative when it hits harder.
    pub fn reduction(&self, reference: Reference) -> f64 {
        self.impact_speed - self.trial(reference).impact_speed.unwrap_or(0.0)
    }

    /// The probability that a driver who is drawn at random avoids it: the share of drivers who react in time
    /// ([`share_of_drivers`](reaction::share_of_drivers)). All of them notice the pedestrian at the gate and brake like UN R157's human.
    pub fn preventable_probability(&self) -> f64 {
        self.latest_reaction.map_or(0.0, reaction::share_of_drivers)
    }

    /// The least gap of a driver's car to the pedestrian (m); 0 when it touches it.
    pub fn margin(&self, reference: Reference) -> f64 {
        self.trial(reference).least_gap
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_follow_who_avoids_it() {
        // Careful human, attentive human, fuzzy, RSS, ideal, bound: `a` avoids, `h` hits.
        for (who, wanted) in [
            ("aaahaa", Label::Preventable),
            ("aaahah", Label::Preventable),
            ("aahhaa", Label::Contested),
            ("aahhah", Label::Unpreventable),
            ("hhhhhh", Label::Unpreventable),
            ("haaaah", Label::Unpreventable),
            ("hhhhaa", Label::MachinePreventable),
            ("hhhhha", Label::MachinePreventable),
            ("hahhaa", Label::Contested),
            ("ahhhaa", Label::Contested),
            ("hhahaa", Label::Contested),
            ("hhhaaa", Label::Contested),
        ] {
            let avoids = |reference| {
                use Reference::{AttentiveHuman, Bound, CarefulHuman, FuzzySafety, IdealBrake, Rss};
                let asked = [CarefulHuman, AttentiveHuman, FuzzySafety, Rss, IdealBrake, Bound];
                let place = asked.iter().position(|each| *each == reference).expect("no other is asked");
                who.as_bytes()[place] == b'a'
            };
            assert_eq!(Label::of_moving(avoids), wanted, "{who}");
        }
    }

    #[test]
    fn a_preventable_collision_needs_no_other_driver() {
        let mut asked = Vec::new();
        Label::of_moving(|reference| {
            asked.push(reference);
            true
        });
        assert_eq!(asked, Label::careful());
    }
}
