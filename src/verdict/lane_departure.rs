use episode::{LanePlace, LaneWatch, Pair};

/// How long the car was outside its lane in an episode, and whether it left the road.
///
/// The centre of the car counts, not its body: the corners of a car leave the lane in any tight turn. It is inside a lane up to half of the lane's
/// width from the centre line, and 0.1 m more.
///
/// - Outside junctions its lane is the driving lane around it, if that leads the way in which the car heads (within 90°). So a lane beside its own
///   with the same direction is its lane, and the lane of the oncoming traffic is not.
/// - In a junction its lane is any of those that lead on from the lane by which it came: its route is one of them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LaneDeparture {
    /// Time outside its lane (s), to a tick.
    pub left_lane: f64,
    /// Whether its centre was outside all driving lanes, at the start or later.
    pub left_road: bool,
}

impl LaneDeparture {
    /// Measures an episode; `None` for a recording from elsewhere, whose roads are unknown.
    pub fn new(pair: &Pair<'_>) -> Option<Self> {
        if !pair.is_on_map() {
            return None;
        }
        let (town, mut watch) = (&pair.scenario.town, LaneWatch::new());
        let mut found = Self::default();
        for (tick, frame) in pair.frames().enumerate() {
            let place = watch.look(town, &frame.ego);
            found.left_road |= place == LanePlace::OffRoad;
            if tick > 0 && place != LanePlace::Inside {
                found.left_lane += pair.dt();
            }
        }
        Some(found)
    }
}
