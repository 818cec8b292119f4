use base::keys;

keys! {
    /// Probable mistakes of CARLA's agent. Each can be switched off; all are on by default, as in CARLA.
    ///
    /// Where a release does not have one of them, its switch does nothing.
    ///
    /// | | on | off |
    /// |---|---|---|
    /// | Q1 | distances begin at the bumper, and are shortened by half the ego | not shortened: it brakes half a car later |
    /// | Q2 | an obstacle outside the ego's lane, by the nearest centre line, is invisible | all in reach and in the cone count |
    /// | Q3 | in junctions the route is a zig-zag and the obstacle a bow-tie, both with holes | a corridor and a box |
    /// | Q4 | without a walker near by, the walker step tests all vehicles with its wider cone | it finds nothing |
    /// | Q5 | the first obstacle found counts | the nearest one |
    /// | Q6 | an emergency stop straightens the wheels and freezes the planner | the planner steers on |
    /// | Q7 | an obstacle exactly dead ahead is not seen | it is |
    /// | Q8 | an emergency stop uses half of the brake | all of it |
    /// | Q10 | an obstacle is measured at its back, the far side of one that faces the car | at its centre |
    #[derive(Copy, Eq)]
    pub struct Quirks {
        /// Half the ego's length is subtracted from distances that begin at the bumper (Q1).
        half_length_twice: bool = "true",
        /// Actors outside the ego's lane are invisible (Q2).
        lane_blind: bool = "true",
        /// In junctions the route is compared as a zig-zag with holes (Q3).
        zigzag: bool = "true",
        /// Without a walker near by, the walker step looks at vehicles (Q4).
        vehicles_for_walkers: bool = "true",
        /// The first obstacle found counts, not the nearest (Q5).
        first_hit: bool = "true",
        /// An emergency stop straightens the wheels and freezes the planner (Q6).
        frozen_stop: bool = "true",
        /// An actor exactly dead ahead is not seen (Q7).
        blind_dead_ahead: bool = "true",
        /// An emergency stop uses half of the brake (Q8).
        weak_brake: bool = "true",
        /// An obstacle is measured at its back (Q10).
        rear_point: bool = "true",
    }
}

impl Quirks {
    /// As CARLA drives.
    pub const ALL: Self = Self::uniform(true);
    /// As its authors probably meant it to drive.
    pub const NONE: Self = Self::uniform(false);

    const fn uniform(on: bool) -> Self {
        Self {
            half_length_twice: on,
            lane_blind: on,
            zigzag: on,
            vehicles_for_walkers: on,
            first_hit: on,
            frozen_stop: on,
            blind_dead_ahead: on,
            weak_brake: on,
            rear_point: on,
        }
    }
}

impl Default for Quirks {
    fn default() -> Self {
        Self::ALL
    }
}
