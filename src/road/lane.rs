use super::Profile;
use base::choice;

/// The number of a lane as in OpenDRIVE: negative to the right of the reference line, positive to its left, 0 the line.
pub type LaneId = i32;

choice! {
    /// The use of a lane; the types of OpenDRIVE that matter here, with the words that mean them, in lower case.
    ///
    /// # Source
    /// CARLA `opendrive/parser/RoadParser.cpp`, `StringToLaneType`, which knows OpenDRIVE 1.4. It maps later types (`curb`,
    /// `bus`, `taxi`, `HOV`, …) to none. We add `walking`, the name of sidewalks since 1.8.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    #[non_exhaustive]
    pub enum LaneKind {
        /// Cars drive on it.
        Driving = "driving",
        /// People walk on it.
        Sidewalk = "walking" | "sidewalk",
        /// Beside the carriageway.
        Shoulder = "shoulder",
        /// Between carriageway and shoulder or kerb.
        Border = "border",
        /// For bicycles.
        Biking = "biking",
        Parking = "parking",
        /// Between two carriageways.
        Median = "median",
        /// A hard shoulder.
        Stop = "stop",
        /// Turning in both directions.
        Bidirectional = "bidirectional",
        /// Reserved lanes of all sorts. The last word is the most general one.
        Special = "special1" | "special2" | "special3" | "roadworks" | "tram" | "rail" | "entry" | "exit" | "offramp"
            | "onramp" | "restricted",
        /// Nothing.
        None = "none",
    }
}

impl LaneKind {
    /// Reads a type as written in OpenDRIVE, whatever its case; unknown ones become [`LaneKind::None`].
    pub fn from_opendrive(text: &str) -> Self {
        Self::named(&text.to_ascii_lowercase()).unwrap_or(Self::None)
    }
}

/// Which lanes a look-up considers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LaneFilter {
    /// Those cars drive on.
    Driving,
    /// Those people walk on.
    Sidewalk,
    /// All but those of kind [`LaneKind::None`].
    Any,
}

impl LaneFilter {
    /// Whether the filter admits lanes of a kind.
    pub fn admits(self, kind: LaneKind) -> bool {
        match self {
            Self::Driving => kind == LaneKind::Driving,
            Self::Sidewalk => kind == LaneKind::Sidewalk,
            Self::Any => kind != LaneKind::None,
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
    /// Its own speed limits along the road, in order: where each begins (m) and what it is (m/s); `None` if the map does not say.
    pub limits: Vec<(f64, Option<f64>)>,
    /// The lane of the section (or road) before, if the file says so.
    pub predecessor: Option<LaneId>,
    /// The lane of the section (or road) after, if the file says so.
    pub successor: Option<LaneId>,
}
