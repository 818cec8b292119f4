//! Attributes of elements, and the warnings about them.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::{OpenDriveError, OpenDriveProblem, OpenDriveWarning};

/// An upper bound of every length, coordinate and coefficient of a town.
const MAX_NUMBER: f64 = 1e9;
/// Maximum number of warnings that are stored.
const MAX_WARNINGS: usize = 10_000;

/// Lengths and places may differ by this much, as they are rounded (m).
pub(super) const ROUNDED: f64 = 0.1;

/// The number of bytes after which line ends are counted anew.
const BLOCK: usize = 1 << 12;

/// A length to the centimetre, without zeros at its end.
pub(super) fn metres(length: f64) -> String {
    ((length * 100.0).round() / 100.0).to_string()
}

fn line_ends(bytes: &[u8]) -> u32 {
    bytes.iter().filter(|byte| **byte == b'\n').count() as u32
}

/// What the parts of the reader share: the current road, the lines of the text, and the warnings.
pub(super) struct Context<'x> {
    pub road: Option<String>,
    pub warnings: Vec<OpenDriveWarning>,
    xml: &'x str,
    /// The number of line ends before each block of the text.
    lines_before: Vec<u32>,
    /// Whether limits of lanes and road types have no effect, as in CARLA's maps.
    pub only_signs_limit: bool,
    /// Whether the map is read as CARLA reads its own.
    pub of_carla: bool,
    /// Why the file cannot be used.
    pub refused: Option<OpenDriveError>,
    /// What is counted: the line of the first one, and their number.
    counted: BTreeMap<(Counted, String), (u32, u32)>,
}

/// What is counted instead of being listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Counted {
    /// Lanes for cars on which no car drives here.
    NotDriven,
    /// Limits below [`LOW_LIMIT`](super::limits::LOW_LIMIT), and above that of a road without one.
    OddLimit,
    /// What has no effect.
    NotUsed,
}

impl<'x> Context<'x> {
    /// Starts to read a text.
    pub fn new(xml: &'x str) -> Self {
        let mut before = 0;
        let lines_before = xml.as_bytes().chunks(BLOCK).map(|block| {
            let here = before;
            before += line_ends(block);
            here
        });
        Self {
            road: None,
            warnings: Vec::new(),
            xml,
            lines_before: lines_before.collect(),
            only_signs_limit: false,
            of_carla: false,
            refused: None,
            counted: BTreeMap::new(),
        }
    }

    /// Records a problem with an element.
    pub fn warn(&mut self, node: Node, problem: OpenDriveProblem) {
        if self.warnings.len() >= MAX_WARNINGS {
            return;
        }
        let line = self.line(node);
        self.warnings.push(OpenDriveWarning { road: self.road.clone(), line, problem });
    }

    /// The line of an element.
    pub fn line(&self, node: Node) -> u32 {
        let start = node.range().start;
        let block = start / BLOCK;
        self.lines_before
            .get(block)
            .map_or(1, |before| 1 + before + line_ends(&self.xml.as_bytes()[block * BLOCK..start]))
    }

    /// Counts an element that has no effect, under what it is.
    pub fn not_used(&mut self, node: Node, what: String) {
        self.count(node, Counted::NotUsed, what);
    }

    /// Counts an element under what it is.
    pub fn count(&mut self, node: Node, counted: Counted, what: String) {
        let (line, key) = (self.line(node), (counted, what));
        if self.counted.len() < MAX_WARNINGS || self.counted.contains_key(&key) {
            self.counted.entry(key).or_insert((line, 0)).1 += 1;
        }
    }

    /// All warnings, the last ones about what is not used.
    pub fn into_warnings(self) -> Vec<OpenDriveWarning> {
        let counted = self.counted.into_iter().map(|((counted, what), (line, count))| OpenDriveWarning {
            road: None,
            line,
            problem: match counted {
                Counted::NotDriven => OpenDriveProblem::NotDriven { what, count },
                Counted::OddLimit => OpenDriveProblem::OddLimit { limit: what, count },
                Counted::NotUsed => OpenDriveProblem::NotUsed { what, count },
            },
        });
        self.warnings.into_iter().chain(counted).collect()
    }

    /// A number, or none after a warning.
    pub fn number(&mut self, node: Node, attribute: &'static str) -> Option<f64> {
        if node.attribute(attribute).is_none() {
            let element = node.tag_name().name().to_owned();
            self.warn(node, OpenDriveProblem::MissingAttribute { element, attribute });
        }
        self.optional(node, attribute)
    }

    /// A number; 0 if it is missing, and 0 with a warning if it is not a number.
    pub fn number_or_zero(&mut self, node: Node, attribute: &'static str) -> f64 {
        self.optional(node, attribute).unwrap_or(0.0)
    }

    /// A number, if the attribute is present and is one.
    pub fn optional(&mut self, node: Node, attribute: &'static str) -> Option<f64> {
        let text = node.attribute(attribute)?;
        let number = text.trim().parse().ok().filter(|number: &f64| number.abs() <= MAX_NUMBER);
        if number.is_none() {
            self.bad(node, attribute, text);
        }
        number
    }

    /// A whole number, if the attribute is present and is one.
    pub fn whole(&mut self, node: Node, attribute: &'static str) -> Option<i32> {
        let text = node.attribute(attribute)?;
        let number = text.trim().parse().ok();
        if number.is_none() {
            self.bad(node, attribute, text);
        }
        number
    }

    /// The four coefficients of a cubic, in order; missing ones are 0.
    pub fn coefficients(&mut self, node: Node, names: [&'static str; 4]) -> [f64; 4] {
        names.map(|name| self.number_or_zero(node, name))
    }

    /// Records that an attribute is none of the standard's words, and what is taken instead.
    pub fn unknown(&mut self, node: Node, attribute: &'static str, text: &str, taken: &'static str) {
        let element = node.tag_name().name().to_owned();
        let text = text.chars().take(40).collect();
        self.warn(node, OpenDriveProblem::UnknownWord { element, attribute, text, taken });
    }

    /// Records that an attribute is not a number that can be used.
    pub fn bad(&mut self, node: Node, attribute: &'static str, text: &str) {
        let element = node.tag_name().name().to_owned();
        let text = text.chars().take(40).collect();
        self.warn(node, OpenDriveProblem::BadNumber { element, attribute, text });
    }
}

/// The child elements of a name, whatever their namespace.
pub(super) fn children<'a, 'x: 'a>(node: Node<'a, 'x>, name: &'static str) -> impl Iterator<Item = Node<'a, 'x>> {
    node.children().filter(move |child| child.is_element() && child.tag_name().name() == name)
}

/// The first child element of a name.
pub(super) fn child<'a, 'x: 'a>(node: Node<'a, 'x>, name: &'static str) -> Option<Node<'a, 'x>> {
    children(node, name).next()
}
