use roxmltree::Node;

use super::attributes::{Context, Counted, ROUNDED, child, children, metres};
use super::limits::{self, Limits};
use super::{OpenDriveError, OpenDriveProblem};
use crate::{Cubic, Lane, LaneId, LaneKind, LaneSection, Profile};

/// Larger lane numbers are treated as errors.
const MAX_ID: u32 = 1000;
/// The greatest width of a lane (m).
const WIDEST: f64 = 1000.0;

/// Reads the offset of lane 0; 0 before its first entry.
pub(super) fn offset(context: &mut Context, lanes: Node) -> Profile {
    let mut cubics: Vec<Cubic> = children(lanes, "laneOffset").map(|node| cubic(context, node, "s", 0.0)).collect();
    if cubics.iter().all(|cubic| cubic.start > 0.0) {
        cubics.push(Cubic::default());
    }
    Profile::new(cubics)
}

/// Reads the lane sections of a road of a given length (m), in order; `types` are the limits of the road's types.
pub(super) fn sections(context: &mut Context, lanes: Node, length: f64, types: &Limits) -> Vec<LaneSection> {
    let mut starts: Vec<(f64, Node)> =
        children(lanes, "laneSection").map(|node| (context.number_or_zero(node, "s"), node)).collect();
    if starts.iter().any(|(s, _)| *s < 0.0 || *s >= length) || !starts.is_sorted_by(|a, b| a.0 <= b.0) {
        context.warn(lanes, OpenDriveProblem::SectionOrder);
        starts.iter_mut().for_each(|(s, _)| *s = s.max(0.0));
        starts.retain(|(s, _)| *s < length);
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let first = starts.first().map_or(0.0, |(s, _)| *s);
    let before = if first > ROUNDED {
        context.warn(lanes, OpenDriveProblem::LateSection { from: metres(first) });
        Some(LaneSection { start: 0.0, end: first, lanes: Vec::new() })
    } else {
        None
    };
    // Sections that start at one place (one for each side of the road) end at one place too.
    let end = |start: f64| starts.get(starts.partition_point(|(s, _)| *s <= start)).map_or(length, |(s, _)| *s);
    let own = starts.iter().map(|(start, node)| section(context, *node, (*start, end(*start)), types));
    let own: Vec<LaneSection> = own.collect();
    before.into_iter().chain(with_length(context, lanes, own)).collect()
}

/// Takes away what holds nowhere: of two sections with lanes on one side that start at one place, the first one has no length.
fn with_length(context: &mut Context, node: Node, sections: Vec<LaneSection>) -> Vec<LaneSection> {
    let (mut place, mut sides, mut kept) = (f64::INFINITY, [0; 2], Vec::new());
    for mut section in sections.into_iter().rev() {
        if section.start < place {
            (place, sides) = (section.start, [0; 2]);
        }
        let before = section.lanes.len();
        section.lanes.retain(|lane| lane.id == 0 || !sides.contains(&lane.id.signum()));
        if section.lanes.len() < before {
            context.warn(node, OpenDriveProblem::NoLength { at: metres(place) });
        }
        let has = |side: LaneId| section.lanes.iter().any(|lane| lane.id.signum() == side);
        if before == section.lanes.len() || has(-1) || has(1) {
            [-1, 1].into_iter().zip(&mut sides).filter(|(side, _)| has(*side)).for_each(|(side, own)| *own = side);
            kept.push(section);
        }
    }
    kept.reverse();
    kept
}

fn section(context: &mut Context, node: Node, (start, end): (f64, f64), types: &Limits) -> LaneSection {
    let found = numbered(context, node);
    let mut edges = [Profile::constant(0.0), Profile::constant(0.0)];
    let mut lanes: Vec<Lane> = Vec::with_capacity(found.len());
    let mut inner = [0; 2];
    for (id, node) in found {
        let inner = &mut inner[usize::from(id > 0)];
        if (id - *inner).abs() > 1 {
            context.warn(node, OpenDriveProblem::MissingLane { lane: id, inner: *inner });
        }
        *inner = id;
        let edge = &mut edges[usize::from(id > 0)];
        let width = if id == 0 { Profile::constant(0.0) } else { width(context, node, id, edge, start, end) };
        // A width that is not a number is no width, either.
        let most = width.extremes(start, end).fold(0.0, |most, (_, at)| if at.abs() <= most { most } else { at.abs() });
        let narrowest = width.extremes(start, end).min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((s, width)) = narrowest.filter(|(_, width)| *width < -ROUNDED) {
            context.warn(node, OpenDriveProblem::NegativeWidth { lane: id, width: metres(width), at: metres(s) });
        }
        if (most.is_nan() || most > WIDEST) && context.refused.is_none() {
            let (line, road) = (context.line(node), context.road.clone().unwrap_or_default());
            context.refused = Some(OpenDriveError::TooWide { line, road, lane: id, width: most, most: WIDEST });
        }
        *edge = Profile::sum(&[(edge, 1.0), (&width, 1.0)], start, end);
        let linked = |context: &mut Context, name| {
            child(node, "link").and_then(|link| child(link, name)).and_then(|lane| context.whole(lane, "id"))
        };
        lanes.push(Lane {
            id,
            kind: kind(context, node),
            width,
            limits: limits::of_lane(context, node, (start, end), types),
            predecessor: linked(context, "predecessor"),
            successor: linked(context, "successor"),
        });
    }
    lanes.sort_by_key(|lane| std::cmp::Reverse(lane.id));
    LaneSection { start, end, lanes }
}

/// The lanes of a section with their numbers, from the middle outwards: borders need the lanes nearer to it.
fn numbered<'a, 'x>(context: &mut Context, section: Node<'a, 'x>) -> Vec<(LaneId, Node<'a, 'x>)> {
    let mut found: Vec<(LaneId, Node)> = Vec::new();
    let sides =
        ["left", "center", "right"].into_iter().flat_map(|side| children(section, side).map(move |node| (side, node)));
    for (side, lane) in sides.flat_map(|(side, node)| children(node, "lane").map(move |lane| (side, lane))) {
        let id = context.whole(lane, "id");
        match id.filter(|id| id.unsigned_abs() <= MAX_ID) {
            None => match (lane.attribute("id"), id) {
                (Some(text), Some(_)) => context.bad(lane, "id", text),
                (Some(_), None) => {}
                (None, _) => context
                    .warn(lane, OpenDriveProblem::MissingAttribute { element: "lane".to_owned(), attribute: "id" }),
            },
            Some(id) if found.iter().any(|(other, _)| *other == id) => {
                context.warn(lane, OpenDriveProblem::Duplicate { element: "lane", id: id.to_string() });
            }
            Some(id) => {
                if side != ["right", "center", "left"][(id.signum() + 1) as usize] {
                    context.warn(lane, OpenDriveProblem::OtherSide { lane: id, side });
                }
                found.push((id, lane));
            }
        }
    }
    found.sort_by_key(|(id, _)| id.unsigned_abs());
    found
}

/// The use of a lane. One for driving against the direction of its side, or in both (`direction`, since 1.8), has no cars here; one that denies cars is reserved for others; CARLA's maps are read without such rules, as in CARLA.
fn kind(context: &mut Context, lane: Node) -> LaneKind {
    match LaneKind::from_opendrive(lane.attribute("type").unwrap_or_default()) {
        LaneKind::Driving if lane.attribute("direction").is_some_and(|direction| direction.trim() != "standard") => {
            let direction = lane.attribute("direction").unwrap_or_default().trim();
            let what = format!(
                "lane of type driving whose `direction` is `{}`",
                direction.chars().take(40).collect::<String>()
            );
            context.count(lane, Counted::NotDriven, what);
            LaneKind::Special
        }
        LaneKind::Driving if !context.of_carla && denies_cars(context, lane) => {
            context.count(lane, Counted::NotDriven, "lane of type driving whose `access` denies cars".to_owned());
            LaneKind::Special
        }
        kind => kind,
    }
}

/// The road users of the standard, in lower case and without blanks.
const USERS: [&str; 14] = [
    "simulator",
    "autonomoustraffic",
    "pedestrian",
    "passengercar",
    "bus",
    "delivery",
    "emergency",
    "taxi",
    "throughtraffic",
    "truck",
    "bicycle",
    "motorcycle",
    "none",
    "trucks",
];

/// Whether a lane denies cars, or allows others alone.
///
/// # Source
/// ASAM OpenDRIVE 1.7, "Lane access": a rule that is missing denies, as in 1.4; the road users are in an attribute or, since 1.7, in elements.
fn denies_cars(context: &mut Context, lane: Node) -> bool {
    let (mut denied, mut allowed, mut others) = (false, false, false);
    for access in children(lane, "access") {
        let of = |node: Node, name| node.attribute(name).map(str::trim).map(str::to_owned);
        let listed = children(access, "restriction").filter_map(|user| Some((user, of(user, "type")?)));
        let users: Vec<_> = of(access, "restriction").map(|user| (access, user)).into_iter().chain(listed).collect();
        for (node, user) in &users {
            if !USERS.contains(&word(user).as_str()) {
                let attribute = if *node == access { "restriction" } else { "type" };
                context.unknown(*node, attribute, user, "it is taken for no car");
            }
        }
        let has = |words: &[&str]| users.iter().any(|(_, user)| words.contains(&word(user).as_str()));
        let rule = of(access, "rule");
        let is_car = has(&["passengercar", "autonomoustraffic"]);
        match rule.as_deref() {
            Some("allow") => {
                others = true;
                allowed |= is_car || has(&["simulator", "throughtraffic", "none"]);
                continue;
            }
            None | Some("deny") => {}
            Some(rule) => context.unknown(access, "rule", rule, "`deny` is taken"),
        }
        denied |= is_car;
    }
    denied || others && !allowed
}

/// A word of the standard in lower case and without blanks, which older versions have: `autonomous traffic`.
fn word(text: &str) -> String {
    text.replace(' ', "").to_ascii_lowercase()
}

/// The width of a lane: from its widths, or else from its borders and the edge of the lanes nearer to the middle.
fn width(context: &mut Context, lane: Node, id: LaneId, inner: &Profile, start: f64, end: f64) -> Profile {
    let widths: Vec<Cubic> = children(lane, "width").map(|node| cubic(context, node, "sOffset", start)).collect();
    if let Some(first) = widths.iter().map(|cubic| cubic.start).min_by(f64::total_cmp) {
        if first > start + ROUNDED {
            context.warn(lane, OpenDriveProblem::LateWidth { lane: id, from: metres(first - start) });
        }
        return Profile::new(widths);
    }
    let borders: Vec<Cubic> = children(lane, "border").map(|node| cubic(context, node, "sOffset", start)).collect();
    if borders.is_empty() {
        context.warn(lane, OpenDriveProblem::NoWidth { lane: id });
        return Profile::constant(0.0);
    }
    // Some writers store the borders of right lanes as positive distances.
    let outward = if borders[0].a < 0.0 { -1.0 } else { 1.0 };
    Profile::sum(&[(&Profile::new(borders), outward), (inner, -1.0)], start, end)
}

/// Reads a cubic whose place is relative to an origin (m).
pub(super) fn cubic(context: &mut Context, node: Node, place: &'static str, origin: f64) -> Cubic {
    let start = origin + context.number_or_zero(node, place);
    let [a, b, c, d] = context.coefficients(node, ["a", "b", "c", "d"]);
    Cubic { start, a, b, c, d }
}
