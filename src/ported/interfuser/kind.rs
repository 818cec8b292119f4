use super::{InterFuser, Settings, TrackerMode};
use base::keys;

keys! {
    /// InterFuser, a surrogate. Without `sensors` it sees everybody in its range, through walls too. Made for `mkz_2017` and
    /// ticks of 0.05 s.
    pub struct InterFuserKeys = "interfuser" {
        /// How speeds are corrected over time: as published, where they become about the heading in half turns; as was
        /// meant; or not at all.
        tracker: TrackerMode = "published",
        /// The greatest speed that it wants; it does not know speed limits.
        max_speed: f64 as positive(SPEED) = "5 m/s",
        // The tests of the planner are within an image of 36 m.
        /// Room that is added to half the car's length when its way is tested.
        margin_ahead: f64 as within(LENGTH, 0.0, 36.0) = "2.5 m",
        /// Room that is added to half the car's width when its way is tested.
        margin_aside: f64 as within(LENGTH, 0.0, 36.0) = "1.2 m",
        /// Share of the tested box that an actor must cover to be in the way.
        overlap: f64 as share() = "0.04",
    }
    .made_for(0.05)
    .surrogate(
        "Exact: its published tracker, forecast, planner and controller, mistakes included. Assumed: its network, which is not run; \
         the object map that it is trained to give is drawn from what is perceived. So its rates show the limits of the planner \
         and not the mistakes of the network.",
    )
}

impl InterFuser {
    pub fn from_keys(keys: InterFuserKeys) -> Self {
        let InterFuserKeys { tracker, max_speed, margin_ahead, margin_aside, overlap } = keys;
        let margin = [margin_ahead, margin_aside];
        Self::new(&Settings { tracker, max_speed, margin, overlap, ..Settings::default() })
    }
}
