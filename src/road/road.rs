use super::{Lane, LaneId, LaneKind, PlanView, Profile};
use crate::geometry::Pose;

/// The index of a road in [`TownParts::roads`](super::TownParts::roads).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct RoadIndex(pub u32);

/// The index of a junction in [`TownParts::junctions`](super::TownParts::junctions).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct JunctionIndex(pub u32);

/// The two ends of a road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RoadEnd {
    /// `s = 0`.
    Start,
    /// `s = length`.
    End,
}

/// The target of a road's link at one of its ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RoadLink {
    /// Another road, at one of its ends.
    Road(RoadIndex, RoadEnd),
    Junction(JunctionIndex),
}

/// A stretch of a road on which the lanes are the same.
#[derive(Debug, Clone, PartialEq)]
pub struct LaneSection {
    /// Where it starts (m).
    pub start: f64,
    /// Where it ends (m).
    pub end: f64,
    /// Its lanes from left to right (descending numbers), with the centre lane 0 if the file has it.
    pub lanes: Vec<Lane>,
}

impl LaneSection {
    /// Whether the map has limits for a lane.
    pub fn has_limits(&self) -> bool {
        self.lanes.iter().any(|lane| lane.kind == LaneKind::Driving && !lane.limits.is_empty())
    }

    pub fn lane(&self, id: LaneId) -> Option<&Lane> {
        self.lanes.iter().find(|lane| lane.id == id)
    }
}

/// A road: a reference line and lanes beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Road {
    /// Its number in the file; for messages, and for CARLA's comparisons.
    pub id: u32,
    /// Its name, often empty.
    pub name: String,
    /// Its length (m).
    pub length: f64,
    /// The junction it lies in.
    pub junction: Option<JunctionIndex>,
    /// Whether it is driven on the left, so that the right lanes are those against the reference line.
    pub left_hand: bool,
    /// The reference line.
    pub plan_view: PlanView,
    /// Lateral offset of lane 0 from the reference line, positive to the left (m).
    pub lane_offset: Profile,
    /// Lane sections in order; never empty.
    pub sections: Vec<LaneSection>,
    /// The road or junction before `s = 0`.
    pub predecessor: Option<RoadLink>,
    /// The road or junction after `s = length`.
    pub successor: Option<RoadLink>,
}

impl Road {
    /// Whether a lane is driven along the reference line.
    pub fn is_forward(&self, id: LaneId) -> bool {
        (id < 0) != self.left_hand
    }

    /// The section that contains `s` (m).
    pub fn section_at(&self, s: f64) -> usize {
        self.sections.partition_point(|section| section.start <= s).saturating_sub(1)
    }

    /// All sections that contain `s` (m): more than one if the two sides of the road have sections of their own.
    pub fn sections_at(&self, s: f64) -> std::ops::Range<usize> {
        let after = self.sections.partition_point(|section| section.start <= s).max(1).min(self.sections.len());
        let start = self.sections.get(after.saturating_sub(1)).map_or(0.0, |section| section.start);
        self.sections.partition_point(|section| section.start < start)..after
    }

    /// The centre of a lane at `s` (m), heading along its driving direction.
    ///
    /// `None` if the section has no such lane.
    pub fn lane_pose(&self, section: usize, id: LaneId, s: f64) -> Option<Pose> {
        let (t, slope) = self.lane_centre(section, id, s)?;
        let line = self.plan_view.point(s);
        let centre = line.beside(t);
        Some(Pose { x: centre.x, y: centre.y, yaw: line.lane_heading(self.is_forward(id), slope) })
    }

    /// The right and the left edge of a lane: how far to the left of the reference line they are (m).
    pub fn lane_edges(&self, section: usize, id: LaneId, s: f64) -> Option<[f64; 2]> {
        let (centre, _) = self.lane_centre(section, id, s)?;
        let half = self.sections[section].lane(id)?.width.value(s) / 2.0;
        Some([centre - half, centre + half])
    }

    /// Lateral position of a lane's centre, positive to the left (m), and its slope along the road.
    pub fn lane_centre(&self, section: usize, id: LaneId, s: f64) -> Option<(f64, f64)> {
        let lanes = &self.sections.get(section)?.lanes;
        let own = lanes.iter().find(|lane| lane.id == id)?;
        let side = f64::from(id.signum());
        let (mut t, mut slope) = (self.lane_offset.value(s), self.lane_offset.slope(s));
        for lane in lanes.iter().filter(|lane| lane.id.signum() == id.signum() && lane.id.abs() < id.abs()) {
            t += side * lane.width.value(s);
            slope += side * lane.width.slope(s);
        }
        t += side * own.width.value(s) / 2.0;
        slope += side * own.width.slope(s) / 2.0;
        Some((t, slope))
    }
}
