//! The greatest sizes of a map, so that no file takes all memory or all time.
//!
//! Each is several times that of the largest towns: a city of 100 km² has some thousand kilometres of lanes.

use roxmltree::{Node, ParsingOptions};

use super::OpenDriveError;
use super::attributes::{child, children};

/// The greatest size of a file (bytes).
const BYTES: usize = 128 << 20;
/// Maximum number of elements, comments and texts of a file.
const NODES: u32 = 4_000_000;
/// Maximum number of attributes of a file.
const ATTRIBUTES: usize = 6_000_000;
/// Maximum number of attributes of an element; the parser compares each with each.
const ATTRIBUTES_OF_ELEMENT: usize = 256;
/// The greatest length of all lanes together (m).
const LANES: f64 = 1e7;
/// Maximum number of places in the tables of cubic curves.
const PLACES: f64 = 4e6;
/// Maximum number of terms in the sums of widths that lead from a reference line to the centres of lanes.
const TERMS: f64 = 2e7;
/// The longest road, and the longest piece of a reference line (m).
pub(super) const MAX_LENGTH: f64 = 1e6;
/// The distance between two places of a cubic curve (m), and the most places of one.
const SPACING: (f64, f64) = (0.3, 20_001.0);

/// The options of the XML parser. A document type without entities cannot make a small file expand.
pub(super) fn parsing(xml: &str) -> ParsingOptions<'_> {
    ParsingOptions { allow_dtd: !xml.contains("<!ENTITY"), nodes_limit: NODES, ..ParsingOptions::default() }
}

/// Checks a text before it is parsed.
///
/// # Errors
/// It is too long, or has too many attributes.
pub(super) fn check_text(xml: &str) -> Result<(), OpenDriveError> {
    let too_large = |what, most| Err(OpenDriveError::TooLarge { what, most });
    if xml.len() > BYTES {
        return too_large("bytes", BYTES as f64);
    }
    let bytes = xml.as_bytes();
    let after = |from: usize, end: &str| xml[from..].find(end).map_or(bytes.len(), |found| from + found + end.len());
    let (mut at, mut all) = (0, 0);
    while let Some(open) = bytes[at..].iter().position(|byte| *byte == b'<') {
        at += open;
        if bytes[at..].starts_with(b"<!--") {
            at = after(at, "-->");
            continue;
        }
        if bytes[at..].starts_with(b"<![CDATA[") {
            at = after(at, "]]>");
            continue;
        }
        let (mut of_element, mut quote) = (0, None);
        while at < bytes.len() {
            match (bytes[at], quote) {
                (b'>', None) => break,
                (mark @ (b'"' | b'\''), None) => quote = Some(mark),
                (mark, Some(open)) if mark == open => {
                    quote = None;
                    of_element += 1;
                }
                _ => {}
            }
            at += 1;
        }
        all += of_element;
        if of_element > ATTRIBUTES_OF_ELEMENT {
            return too_large("attributes of one element", ATTRIBUTES_OF_ELEMENT as f64);
        }
        if all > ATTRIBUTES {
            return too_large("attributes", ATTRIBUTES as f64);
        }
    }
    Ok(())
}

/// Checks the roads before they are read.
///
/// # Errors
/// Their lanes are too long, or they have too many curves or widths.
pub(super) fn check_roads(root: Node) -> Result<(), OpenDriveError> {
    let (mut lanes, mut places, mut terms) = (0.0, 0.0, 0.0);
    for road in children(root, "road") {
        let mut drawn = 0.0_f64;
        for piece in child(road, "planView").into_iter().flat_map(|view| children(view, "geometry")) {
            let Some(length) = number(piece, "length").filter(|length| *length <= MAX_LENGTH) else { continue };
            drawn = drawn.max(number(piece, "s").unwrap_or(0.0) + length);
            if ["poly3", "paramPoly3"].iter().any(|form| child(piece, form).is_some()) {
                places += (length / SPACING.0).min(SPACING.1) + 6.0;
            }
        }
        let length = number(road, "length").filter(|length| *length > 0.0).unwrap_or(drawn);
        let Some(sections) = child(road, "lanes").filter(|_| length <= MAX_LENGTH) else { continue };
        let offsets = children(sections, "laneOffset").count() as f64;
        let mut starts: Vec<(f64, Node)> = children(sections, "laneSection")
            .map(|section| (number(section, "s").unwrap_or(0.0).clamp(0.0, length), section))
            .collect();
        starts.sort_by(|one, other| one.0.total_cmp(&other.0));
        for (index, (start, section)) in starts.iter().enumerate() {
            let end = starts.get(index + 1).map_or(length, |(next, _)| *next);
            for side in section.children().filter(|side| matches!(side.tag_name().name(), "left" | "right")) {
                // Each centre is a sum over the lanes nearer to the reference line, with a new term at each of their widths.
                let (mut inner, mut widths) = (1.0, offsets);
                for lane in children(side, "lane") {
                    lanes += end - start;
                    inner += 1.0;
                    widths += 1.0
                        + lane.children().filter(|part| matches!(part.tag_name().name(), "width" | "border")).count()
                            as f64;
                    terms += inner * widths;
                }
            }
        }
        for (what, size, most) in [
            ("metres of lanes", lanes, LANES),
            ("places on curves", places, PLACES),
            ("terms of lane widths", terms, TERMS),
        ] {
            if size > most {
                return Err(OpenDriveError::TooLarge { what, most });
            }
        }
    }
    Ok(())
}

fn number(node: Node, attribute: &str) -> Option<f64> {
    node.attribute(attribute)?.trim().parse().ok().filter(|number: &f64| number.is_finite())
}
