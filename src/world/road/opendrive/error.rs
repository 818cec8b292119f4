/// Why a file cannot be used as a town at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OpenDriveError {
    /// The text is not well-formed XML.
    #[error("not XML: {message} (line {line}, column {column})")]
    NotXml {
        /// Where the XML breaks, from 1.
        line: u32,
        /// The column there, from 1.
        column: u32,
        /// The message of the XML parser.
        message: String,
    },
    /// The outermost element has another name.
    #[error("not OpenDRIVE: the outermost element is `{found}`, not `OpenDRIVE`")]
    NotOpenDrive {
        /// The outermost element.
        found: String,
    },
    /// It is larger than any town.
    #[error("the map is too large: it has more than {most} {what}")]
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// The limit.
        most: f64,
    },
    /// There is no road, or none with a reference line and lanes.
    #[error("no usable road among {found}")]
    NoRoads {
        /// How many roads the file has.
        found: usize,
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
    /// An attribute is not a usable number.
    #[error("`{attribute}` of `{element}` is `{text}`, not a usable number; skipped")]
    BadNumber { element: String, attribute: &'static str, text: String },
    /// An attribute is missing.
    #[error("`{element}` has no `{attribute}`")]
    MissingAttribute { element: String, attribute: &'static str },
    /// A piece of a reference line has an unknown form.
    #[error("a geometry of no known form; taken as a line")]
    UnknownShape,
    /// A spiral turns more often than any road.
    #[error("a spiral of more than ten full turns; taken as a line")]
    Winding,
    /// A road has no usable reference line.
    #[error("no usable reference line; the road is left out")]
    NoReferenceLine,
    /// A road has no lanes.
    #[error("no lane section; the road is left out")]
    NoLaneSection,
    /// A lane has neither widths nor borders.
    #[error("lane {lane} has no width; taken as 0 m wide")]
    NoWidth {
        /// The lane's number.
        lane: i32,
    },
    /// Lane sections are not in order, or start beyond the road's end.
    #[error("lane sections out of order or beyond the road's end; put in order")]
    SectionOrder,
    /// A link names a junction by a number that a road has too, or a road by a number that a junction has too.
    #[error("`{element}` should lead to a {wanted}, but there is a {found} {id}, and CARLA takes that")]
    AmbiguousLink {
        element: &'static str,
        /// The target in the file.
        wanted: &'static str,
        /// What CARLA takes it for.
        found: &'static str,
        /// The number of both.
        id: String,
    },
    /// A number names two things.
    #[error("`{element}` {id} is there twice; the first one counts")]
    Duplicate { element: &'static str, id: String },
    /// A link leads to something that does not exist.
    #[error("`{element}` refers to {id}, which is not there; ignored")]
    UnknownReference {
        element: String,
        /// The missing number.
        id: String,
    },
    /// A connection has no lane links; they were taken from the links of the connecting road's lanes.
    #[error("a connection without lane links; those of the connecting road's lanes are taken")]
    GuessedLaneLinks,
    /// Elements that are read correctly but have no effect here.
    #[error("not used: {count} × {what}")]
    NotUsed {
        /// What they are.
        what: String,
        count: u32,
    },
    /// The number of a road or junction is not one.
    #[error("the id `{id}` is not a whole number; {given} stands for it")]
    IdNotNumber {
        /// The text in the file.
        id: String,
        /// The number that is used in its place.
        given: u32,
    },
}

impl OpenDriveProblem {
    /// Whether the file is right, and a part of it has no effect here.
    pub fn is_unused(&self) -> bool {
        matches!(self, Self::NotUsed { .. })
    }
}
