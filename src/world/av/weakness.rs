use base::choice;

choice! {
    /// What a driver lacks that would have kept it from a failure.
    #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
    pub enum Weakness {
        /// It reacts to no pedestrian at all.
        Ignores = "ignores",
        /// An obstacle hides the pedestrian.
        Hidden = "hidden",
        /// It does not see pedestrians on that side.
        BlindSide = "blind_side",
        /// It sees pedestrians only nearby.
        Range = "range",
        /// It loses pedestrians that it saw.
        Dropouts = "dropouts",
        /// It mistakes where pedestrians are or what they are.
        Errors = "errors",
        /// It reacts late.
        Delay = "delay",
        /// It brakes too weakly.
        WeakBrake = "weak_brake",
        /// It lets go of the brake.
        LetsGo = "lets_go",
        /// It brakes for somebody in its way at too short a distance.
        Distance = "distance",
        /// It does not expect where the pedestrian will be.
        Anticipation = "anticipation",
        /// It takes its speed for less than it is.
        Speed = "speed",
        /// The corridor that it watches is too narrow.
        Corridor = "corridor",
        /// What it does for the pedestrian leads into them.
        Reaction = "reaction",
        /// No change that was tried explains it.
        #[default]
        NotFound = "not_found",
    }
}
