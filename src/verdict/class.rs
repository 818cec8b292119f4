use base::choice;

/// A car at this speed (m/s) or more drives into a pedestrian; a slower one pushes. Signals give pedestrians 1.0 to 1.2 m/s.
pub const WALKING_PACE: f64 = 1.0;

/// A careful human who passes the pedestrian with less than this to spare (m) avoids the collision only narrowly. Our choice: a disc for the
/// pedestrian, a box for the car and a path sampled 20 times a second are not more exact.
pub const CLEAR: f64 = 0.1;

choice! {
    /// What a touch counts as. The first that applies, in this order:
    ///
    /// | class | when |
    /// |---|---|
    /// | `bump` | the car was at most 0.1 m/s fast |
    /// | `not_preventable` | not every careful driver avoids it |
    /// | `unforeseeable` | the pedestrian did not move as people do |
    /// | `flank` | the pedestrian walked into the flank after the front had passed it, or ran into the rear. One that kept its velocity and is touched within half a metre and 0.1 s behind the bumper did not |
    /// | `slow` | the car was slower than [`WALKING_PACE`] |
    /// | `narrow` | a careful human has less than [`CLEAR`] to spare |
    /// | `followed` | a car behind runs into that of a careful human who brakes: [`Follower`](super::Follower) |
    /// | `runner` | none of these, and somebody faster than 8 km/h was hit, such as a jogger or a cyclist: it counts against the driver |
    /// | `fault` | none of these: the collision counts against the driver |
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
    pub enum Class {
        /// The car stood.
        Bump = "bump",
        /// Not every careful driver avoids it.
        NotPreventable = "not_preventable",
        /// The pedestrian did not move as people do.
        Unforeseeable = "unforeseeable",
        /// The pedestrian walked into the flank or the rear.
        Flank = "flank",
        /// The car was slower than walking pace.
        Slow = "slow",
        /// A careful human has less than 0.1 m to spare.
        Narrow = "narrow",
        /// A car behind runs into that of a careful human.
        Followed = "followed",
        /// It counts against the driver, who hit somebody faster than a pedestrian.
        Runner = "runner",
        /// It counts against the driver.
        Fault = "fault",
    }
}

/// What decides about the class of a touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Facts {
    /// Whether the car moved.
    pub moved: bool,
    /// Whether all careful drivers avoid it.
    pub preventable: bool,
    /// Whether the pedestrian moved as people do.
    pub foreseeable: bool,
    /// Whether it was faster than 8 km/h.
    pub fast: bool,
    /// Whether the pedestrian walked into the flank or the rear.
    pub walked_into: bool,
    /// The car's speed (m/s).
    pub speed: f64,
    /// What the careful human with less to spare has to spare (m).
    pub margin: f64,
    /// Whether a car behind runs into that of a careful human.
    pub followed: bool,
}

impl Class {
    pub(super) fn of(facts: &Facts) -> Self {
        match facts {
            Facts { moved: false, .. } => Self::Bump,
            Facts { preventable: false, .. } => Self::NotPreventable,
            Facts { foreseeable: false, .. } => Self::Unforeseeable,
            Facts { walked_into: true, .. } => Self::Flank,
            Facts { speed, .. } if *speed < WALKING_PACE => Self::Slow,
            Facts { margin, .. } if *margin < CLEAR => Self::Narrow,
            Facts { followed: true, .. } => Self::Followed,
            Facts { fast: true, .. } => Self::Runner,
            _ => Self::Fault,
        }
    }

    /// Whether it counts against the driver: whether it is a fault.
    pub fn is_fault(self) -> bool {
        matches!(self, Self::Runner | Self::Fault)
    }

    /// Why it counts against the driver, or why not: the end of a sentence.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Bump => "the car stood",
            Self::NotPreventable => "not every careful driver avoids it",
            Self::Unforeseeable => "the pedestrian did not move as people do",
            Self::Flank => "the pedestrian walked into the flank or the rear after the front had passed",
            Self::Slow => "the car was slower than 1 m/s",
            Self::Narrow => "a careful human has less than 0.1 m to spare",
            Self::Followed => "a car behind runs into that of a careful human who brakes",
            Self::Runner => {
                "every careful driver avoids it; the person was faster than 8 km/h and moved as runners and cyclists do"
            }
            Self::Fault => {
                "every careful driver avoids it clearly, and the pedestrian moved as people do, not into the car"
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_fact_is_enough_to_take_a_fault_away() {
        let fault = Facts {
            moved: true,
            preventable: true,
            foreseeable: true,
            fast: false,
            walked_into: false,
            speed: 1.0,
            margin: CLEAR,
            followed: false,
        };
        for (facts, class) in [
            (fault, Class::Fault),
            (Facts { fast: true, ..fault }, Class::Runner),
            (Facts { followed: true, ..fault }, Class::Followed),
            (Facts { margin: 0.09, ..fault }, Class::Narrow),
            (Facts { speed: 0.99, ..fault }, Class::Slow),
            (Facts { walked_into: true, ..fault }, Class::Flank),
            (Facts { foreseeable: false, ..fault }, Class::Unforeseeable),
            (Facts { preventable: false, ..fault }, Class::NotPreventable),
            (Facts { moved: false, ..fault }, Class::Bump),
        ] {
            assert_eq!(Class::of(&facts), class);
        }
    }
}
