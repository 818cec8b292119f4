//! Attributes of elements, and the warnings about them.

use roxmltree::Node;

use super::{OpenDriveProblem, OpenDriveWarning};

/// An upper bound of every length, coordinate and coefficient of a town.
const LARGEST: f64 = 1e9;
/// The greatest number of warnings that are stored.
const MOST_WARNINGS: usize = 10_000;

/// What the parts of the reader share: the current road, where lines start, and the warnings.
pub(super) struct Context {
    pub road: Option<String>,
    pub warnings: Vec<OpenDriveWarning>,
    line_starts: Vec<usize>,
}

impl Context {
    /// Starts to read a text.
    pub fn new(xml: &str) -> Self {
        let breaks = xml.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(place, _)| place + 1);
        Self { road: None, warnings: Vec::new(), line_starts: std::iter::once(0).chain(breaks).collect() }
    }

    /// Records a problem with an element.
    pub fn warn(&mut self, node: Node, problem: OpenDriveProblem) {
        if self.warnings.len() >= MOST_WARNINGS {
            return;
        }
        let line = self.line_starts.partition_point(|start| *start <= node.range().start) as u32;
        self.warnings.push(OpenDriveWarning { road: self.road.clone(), line, problem });
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
        let number = text.trim().parse().ok().filter(|number: &f64| number.abs() <= LARGEST);
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

    fn bad(&mut self, node: Node, attribute: &'static str, text: &str) {
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
