use super::{LaneKind, LaneSection, Road, SpeedSign};

/// Speed limit of a vehicle before its first sign (m/s).
///
/// # Source
/// CARLA `Vehicle/WheeledVehicleAIController.h`: 30 km/h until the first sign.
pub const FIRST_LIMIT: f64 = 30.0 / 3.6;

/// On how much of a map's driving lanes a speed limit is assumed: the 30 km/h at which CARLA's vehicles begin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AssumedLimit {
    /// The length of driving lanes without a limit (m).
    pub without: f64,
    /// The length of all driving lanes (m).
    pub all: f64,
}

impl AssumedLimit {
    /// `None` for a map whose lanes all have a limit, and for one in which signs alone give limits.
    pub fn of(roads: &[Road], signs: &[SpeedSign]) -> Option<Self> {
        let sections = || roads.iter().flat_map(|road| &road.sections);
        if !signs.is_empty() && !sections().any(LaneSection::has_limits) {
            return None;
        }
        let mut found = Self { without: 0.0, all: 0.0 };
        for section in sections() {
            for lane in section.lanes.iter().filter(|lane| lane.id != 0 && lane.kind == LaneKind::Driving) {
                let ends = lane.limits.iter().skip(1).map(|(begin, _)| *begin).chain([section.end]);
                let known = lane.limits.iter().zip(ends).filter(|((_, limit), _)| limit.is_some());
                let length = section.end - section.start;
                found.without += length - known.map(|((begin, _), end)| end - begin).sum::<f64>();
                found.all += length;
            }
        }
        (found.without > 0.5).then_some(found)
    }
}

impl std::fmt::Display for AssumedLimit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "30 km/h assumed on {:.0} of {:.0} m of driving lanes, which have no speed limit",
            self.without, self.all
        )
    }
}
