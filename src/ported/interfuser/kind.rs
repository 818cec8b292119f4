use super::InterFuser;
use base::keys;

keys! {
    /// InterFuser, a surrogate. Without `sensors` it sees everybody in its range, through walls too. Made for `mkz_2017` and
    /// ticks of 0.05 s.
    pub struct InterFuserKeys = "interfuser" {}
    .made_for(0.05)
    .surrogate(
        "Exact: its published tracker, forecast, planner and controller, mistakes included. Assumed: its network, which is not run; \
         the object map that it is trained to give is drawn from what is perceived. So its rates show the limits of the planner \
         and not the mistakes of the network.",
    )
}

impl InterFuser {
    pub fn from_keys(_: InterFuserKeys) -> Self {
        Self::new()
    }
}
