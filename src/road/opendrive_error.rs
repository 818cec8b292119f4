use crate::LaneId;

/// Why a file cannot be used as a town at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OpenDriveError {
    #[error("not XML: {message} (line {line}, column {column})")]
    NotXml { line: u32, column: u32, message: String },
    #[error("not OpenDRIVE: the outermost element is `{found}`, not `OpenDRIVE`")]
    NotOpenDrive { found: String },
    #[error("the map is too large: it has more than {most} {what}")]
    TooLarge { what: &'static str, most: f64 },
    #[error("line {line}, road {road}: lane {lane} is {width:.0} m wide at one place; the most is {most} m")]
    TooWide { line: u32, road: String, lane: i32, width: f64, most: f64 },
    #[error("no usable road among {found}{}", first.as_ref().map_or_else(String::new, |first| format!(": {first}")))]
    NoRoads {
        found: usize,
        /// The first thing that is wrong with them.
        first: Option<OpenDriveWarning>,
    },
}

/// Something in a file that was skipped or guessed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OpenDriveWarning {
    /// The `id` of the road that it is about.
    pub road: Option<String>,
    /// The line of the element, from 1.
    pub line: u32,
    pub problem: OpenDriveProblem,
}

impl std::fmt::Display for OpenDriveWarning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "line {}", self.line)?;
        if let Some(road) = &self.road {
            write!(f, ", road {road}")?;
        }
        write!(f, ": {}", self.problem)
    }
}

/// What can be wrong within a file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OpenDriveProblem {
    #[error("`{attribute}` of `{element}` is `{text}`, not a usable number{}; skipped", comma(text))]
    BadNumber { element: String, attribute: &'static str, text: String },
    #[error("`{element}` has no `{attribute}`")]
    MissingAttribute { element: String, attribute: &'static str },
    #[error("`{attribute}` of `{element}` is `{text}`, a word that the standard does not have: {taken}")]
    UnknownWord { element: String, attribute: &'static str, text: String, taken: &'static str },
    #[error("the `value` of the speed sign is `{value}`, not a usable number{}; {}", comma(value),
        subtype.as_ref().map_or("the sign is skipped".to_owned(), |kmh| format!("its `subtype`, {kmh} km/h, is taken")))]
    BadSignValue {
        value: String,
        /// The limit of its subtype (km/h).
        subtype: Option<String>,
    },
    #[error("the unit `{unit}` of a speed limit is none of `m/s`, `km/h`, `mph`; the limit is skipped")]
    UnknownUnit { unit: String },
    #[error("the speed sign stands {apart} m beside its lane; it counts on the lane beside which it stands")]
    SignFarAway { apart: u32 },
    #[error("a geometry of no known form; taken as a line")]
    UnknownShape,
    #[error("a spiral of more than ten full turns; taken as a line")]
    Winding,
    #[error("no usable reference line; the road is left out")]
    NoReferenceLine,
    #[error("no lane section; the road is left out")]
    NoLaneSection,
    #[error("lane {lane} has no width; taken as 0 m wide")]
    NoWidth { lane: i32 },
    #[error(
        "lane {lane} has no width up to {from} m from the start of its section, where the standard wants one; the first one applies there, too"
    )]
    LateWidth { lane: i32, from: String },
    #[error(
        "lane {lane} is {width} m wide at {at} m, less than 0; no car starts there, and the lanes beyond it overlap others"
    )]
    NegativeWidth { lane: i32, width: String, at: String },
    #[error("lane {lane} is in `{side}`; ids are above 0 on the left and below 0 on the right. Its id counts")]
    OtherSide { lane: i32, side: &'static str },
    #[error("lane {lane} follows on lane {inner}, and the ids of a side have no gaps; they lie side by side")]
    MissingLane { lane: i32, inner: i32 },
    #[error("the first lane section begins at {from} m; there are no lanes before it")]
    LateSection { from: String },
    #[error("two lane sections begin at {at} m; the first one has no length, and the second one counts")]
    NoLength { at: String },
    #[error("lane sections out of order or beyond the road's end; put in order")]
    SectionOrder,
    #[error("the road is {length} m long, and its geometry ends at {drawn} m; the shorter one counts")]
    OtherLength { length: String, drawn: String },
    #[error("no geometry between {from} m and {to} m; there are no lanes there")]
    Gap { from: String, to: String },
    #[error("two geometries between {from} m and {to} m; the later one counts")]
    Overlap { from: String, to: String },
    #[error(
        "the reference line jumps by {apart} m at {at} m, where a geometry should begin at the end of the one before; drawn as given"
    )]
    Leap { apart: String, at: String },
    #[error(
        "the reference line turns by {degrees}° at {at} m, where a geometry should begin in the direction in which the one before ends; drawn as given"
    )]
    Kink { degrees: u32, at: String },
    #[error(
        "the bend at {at} m has a radius of {radius} m, and the centre of lane {lane} is farther inside it: cars drive backwards there"
    )]
    TightBend { at: String, radius: String, lane: LaneId },
    #[error("the heading is {heading} rad, more than two full turns: is it in degrees? Drawn as given")]
    ManyTurns { heading: String },
    #[error("`{element}` is at {s} m, and its road is {length} m long; it counts at the nearer end")]
    BeyondRoad { element: &'static str, s: String, length: String },
    #[error("the crosswalk lies {apart} m beside the lanes; no car passes it")]
    CrosswalkAside { apart: u32 },
    #[error("`{element}` should lead to a {wanted}, but there is a {found} {id}, and CARLA takes that")]
    AmbiguousLink { element: &'static str, wanted: &'static str, found: &'static str, id: String },
    #[error("`{element}` {id} is duplicate; the first is used")]
    Duplicate { element: &'static str, id: String },
    #[error("{count} signals have the id `{id}`; each counts where it stands, and references take the last one")]
    RepeatedSignal { id: String, count: usize },
    #[error("`{element}` refers to {id}, which is not there; ignored")]
    UnknownReference { element: String, id: String },
    #[error("a connection without lane links; those of the connecting road's lanes are taken")]
    GuessedLaneLinks,
    #[error("cars do not drive on {count} × {what}")]
    NotDriven { what: String, count: u32 },
    #[error("a limit of {limit} km/h, {count} times: is its unit right?")]
    OddLimit { limit: String, count: u32 },
    #[error("not used: {count} × {what}")]
    NotUsed { what: String, count: u32 },
    #[error("the id `{id}` is not a number below 2^32 that it has alone; the free number {given} stands for it")]
    IdNotNumber { id: String, given: u32 },
}

/// What is said of a number with a decimal comma.
fn comma(text: &str) -> &'static str {
    if text.contains(',') { ": decimals are written with a point" } else { "" }
}

impl OpenDriveProblem {
    /// Whether the file is right, and a part of it has no effect here.
    pub fn is_unused(&self) -> bool {
        matches!(self, Self::NotUsed { .. })
    }
}
