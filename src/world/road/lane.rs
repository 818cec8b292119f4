use super::Profile;

/// The number of a lane as in OpenDRIVE: negative to the right of the reference line, positive to its left, 0 the line.
pub type LaneId = i32;

/// The use of a lane; the types of OpenDRIVE that matter here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LaneKind {
    /// Cars drive on it.
    Driving,
    /// People walk on it.
    Sidewalk,
    /// Beside the carriageway.
    Shoulder,
    /// Between carriageway and shoulder or kerb.
    Border,
    /// For bicycles.
    Biking,
    Parking,
    /// Between two carriageways.
    Median,
    /// A hard shoulder.
    Stop,
    /// Turning in both directions.
    Bidirectional,
    /// Reserved lanes of all sorts: `special1`, `entry`, `exit`, `onRamp`, `offRamp`, `tram`, `rail`, …
    Special,
    /// Nothing.
    None,
}

impl LaneKind {
    /// Reads a type as written in OpenDRIVE, whatever its case; unknown ones become [`LaneKind::None`].
    ///
    /// # Source
    /// CARLA `opendrive/parser/RoadParser.cpp`, `StringToLaneType`, which knows OpenDRIVE 1.4. It maps later types (`curb`,
    /// `bus`, `taxi`, `HOV`, …) to none. We add `walking`, the name of sidewalks since 1.8.
    pub fn from_opendrive(text: &str) -> Self {
        match text.to_ascii_lowercase().as_str() {
            "driving" => Self::Driving,
            "sidewalk" | "walking" => Self::Sidewalk,
            "shoulder" => Self::Shoulder,
            "border" => Self::Border,
            "biking" => Self::Biking,
            "parking" => Self::Parking,
            "median" => Self::Median,
            "stop" => Self::Stop,
            "bidirectional" => Self::Bidirectional,
            "special1" | "special2" | "special3" | "roadworks" | "tram" | "rail" | "entry" | "exit" | "offramp"
            | "onramp" | "restricted" => Self::Special,
            _ => Self::None,
        }
    }

    /// The type as written in OpenDRIVE. Of the types that are [`LaneKind::Special`] it is the most general one.
    pub fn opendrive(self) -> &'static str {
        match self {
            Self::Driving => "driving",
            Self::Sidewalk => "sidewalk",
            Self::Shoulder => "shoulder",
            Self::Border => "border",
            Self::Biking => "biking",
            Self::Parking => "parking",
            Self::Median => "median",
            Self::Stop => "stop",
            Self::Bidirectional => "bidirectional",
            Self::Special => "restricted",
            Self::None => "none",
        }
    }
}

/// A lane of a lane section.
#[derive(Debug, Clone, PartialEq)]
pub struct Lane {
    pub id: LaneId,
    /// Its use.
    pub kind: LaneKind,
    /// Its width (m) over the distance from the start of the road (not of the section).
    pub width: Profile,
    /// The lane of the section (or road) before, if the file says so.
    pub predecessor: Option<LaneId>,
    /// The lane of the section (or road) after, if the file says so.
    pub successor: Option<LaneId>,
}
