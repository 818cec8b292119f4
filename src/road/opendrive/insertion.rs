use std::collections::BTreeMap;

use roxmltree::{Document, Node};

use super::attributes::{child, children};
use super::budget;
use super::roads::{id_of, numbers};

/// Elements that are added to a road of a map, as XML.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Addition {
    /// `object` elements.
    pub objects: String,
    /// `signal` elements.
    pub signals: String,
}

/// The text of a map with elements added to its roads, which are named by the numbers that stand for their ids; every other byte stays as it is.
///
/// `None` if the map is not XML or a road has no such number.
pub fn insert(map: &str, additions: &BTreeMap<u32, Addition>) -> Option<String> {
    let document = Document::parse_with_options(map, budget::parsing(map)).ok()?;
    let mut places: Vec<(usize, usize, String)> = Vec::new();
    let numbers = numbers(children(document.root_element(), "road").map(id_of));
    for (number, addition) in additions {
        let named = |node: &Node| numbers.get(id_of(*node)) == Some(number);
        let road = children(document.root_element(), "road").find(named)?;
        let after_lanes = child(road, "lanes")?.range().end;
        let after_objects = child(road, "objects").map_or(after_lanes, |objects| objects.range().end);
        for (name, content, place) in
            [("objects", &addition.objects, after_lanes), ("signals", &addition.signals, after_objects)]
        {
            if content.is_empty() {
                continue;
            }
            let Some(container) = child(road, name) else {
                places.push((place, place, format!("\n<{name}>\n{content}</{name}>")));
                continue;
            };
            let range = container.range();
            let text = &map[range.clone()];
            // An empty element has no end tag.
            match text.strip_suffix("/>") {
                Some(start) if container.first_child().is_none() => {
                    places.push((range.start, range.end, format!("{start}>\n{content}</{name}>")));
                }
                _ => {
                    let end = range.start + text.rfind("</")?;
                    places.push((end, end, content.clone()));
                }
            }
        }
    }
    // Additions of one place are objects, then signals.
    places.sort_by_key(|(start, _, _)| *start);
    let mut text = String::with_capacity(map.len());
    let mut copied = 0;
    for (start, end, addition) in places {
        text.push_str(&map[copied..start]);
        text.push_str(&addition);
        copied = end;
    }
    text.push_str(&map[copied..]);
    Some(text)
}
