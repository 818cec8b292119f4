use std::f64::consts::SQRT_2;
use std::path::Path;

use base::diagnostic::{Diagnostic, Sources, Span};
use base::signature::{Form, Param, Signature, Type, Value, short};
use base::units::Dimension;
use lang::diagnostics;
use lang::hir::{Block, Declaration};
use world::geometry::{OrientedBox, Point, Pose, Vector};
use world::road::design::{BuildingRow, Carriageway, DesignError, Node, Street, StreetProfile, TownDesign};
use world::road::{LaneFilter, Road, Shape, SpeedSign, Town, TownParts, crosswalk, opendrive};

use lang::Reader;

/// Points of streets closer than this are one node (m).
const SAME_NODE: f64 = 0.01;
/// Half size of the box in which a speed sign takes effect (m): 0.35 of CARLA's lanes.
const SIGN_HALF_SIZE: f64 = 1.4;
/// An object farther than this from all streets is neither met nor seen (m).
const FAR: f64 = 500.0;
/// The greatest number of trees of a grove.
const MOST_TREES: f64 = 20_000.0;
/// The greatest number of cars of a row.
const MOST_CARS: f64 = 1000.0;
/// Step of the search for lanes under an obstacle (m).
const UNDER_STEP: f64 = 1.0;
/// The greatest number of steps along one side of an obstacle.
const MOST_STEPS: f64 = 1e9;
/// Allowance for the difference between a lane and the straight pieces that the search uses (m).
const UNDER_SLACK: f64 = 5.0;

/// The form `town`.
pub fn form() -> Form {
    Form {
        name: "town",
        doc: "Roads with lanes and sidewalks, junctions, and what stands beside them: written here, or read from a map.",
        plain: Some(designed()),
        multiplies: false,
        kinds: vec![Signature {
            children: obstacles(),
            ..Signature::new(
                "opendrive",
                "A town from an OpenDRIVE map. Such maps hold no buildings; they can be added here.",
                vec![Param::required("file", Type::Path, "The map, relative to the folder of this file.")],
            )
        }],
    }
}

fn designed() -> Signature {
    // As in `road::design`.
    let length = |min, max| Type::Quantity { dimension: Dimension::LENGTH, min, max };
    let street = Signature::new(
        "street",
        "A street with sidewalks along straight lines. Traffic keeps to the right. Where streets share a point they meet: two bend, three make a T-junction, four a crossing. Streets with different lanes meet only in junctions. There cars turn right from the rightmost lane and left from the leftmost one.",
        vec![
            Param::required(
                "through",
                Type::List(Box::new(Type::Point)),
                "The points it leads through, at least two, within 10 km of the origin.",
            ),
            Param::optional("speed_limit", Type::positive(Dimension::SPEED), "Speed limit on the signs at its ends."),
            Param::with_default(
                "lanes",
                Type::Integer { min: 1, max: 4 },
                "1",
                "Number of driving lanes in each direction in which it is driven. Drivers keep the lane in which they start.",
            ),
            Param::with_default(
                "one_way",
                Type::Boolean,
                "false",
                "Whether all its lanes lead in the direction of its points. The points stay the middle of the street.",
            ),
        ],
    );
    let row_houses = Signature::new(
        "row_houses",
        "Houses along both sides of all straight streets.",
        vec![
            Param::with_default("setback", length(0.0, 1000.0), "1 m", "Distance of the fronts from the sidewalk."),
            Param::with_default("depth", length(1.0, 1000.0), "10 m", "Extent away from the street."),
            Param::with_default("length", length(3.0, 1000.0), "16 m", "Extent along the street."),
            Param::with_default("gap", length(0.0, 1000.0), "4 m", "Distance between two houses."),
        ],
    );
    let mut children = vec![street, row_houses];
    children.extend(obstacles());
    Signature {
        children,
        ..Signature::new(
            "town",
            "",
            vec![
                Param::with_default("lane_width", length(2.0, 20.0), "3.5 m", "Width of a driving lane."),
                Param::with_default(
                    "shoulder",
                    length(0.0, 20.0),
                    "0.3 m",
                    "Width of the strip between lane and sidewalk.",
                ),
                Param::with_default("sidewalk", length(0.5, 20.0), "3 m", "Width of the sidewalks."),
                Param::with_default(
                    "bend_radius",
                    length(3.0, 1000.0),
                    "12 m",
                    "Radius of the middle of a street where it bends: 0.5 m more than half the width of the street at least.",
                ),
                Param::with_default(
                    "corner_radius",
                    length(0.5, 100.0),
                    "2 m",
                    "Radius of the sidewalk's outer edge at the corner of a junction.",
                ),
                Param::with_default(
                    "traffic_lights",
                    Type::Boolean,
                    "false",
                    "Whether all junctions have traffic lights.",
                ),
                Param::with_default(
                    "light_turns",
                    Type::Choice(&["each_leg", "opposite_legs"]),
                    "each_leg",
                    "Which approaches of a junction have green at once: one, or those opposite to each other. The `episode` has the durations.",
                ),
            ],
        )
    }
}

/// The obstacles of a town of either kind.
fn obstacles() -> Vec<Signature> {
    let length = || Type::positive(Dimension::LENGTH);
    let corner = || Param::required("corner", Type::Point, "One corner.");
    let opposite = || Param::required("opposite", Type::Point, "The opposite corner.");
    let trunk = || Param::with_default("trunk", length(), "0.4 m", "Its thickness.");
    vec![
        Signature::new("building", "A house: it blocks walkers and sight.", vec![corner(), opposite()]),
        Signature::new(
            "wall",
            "A wall or a fence along a straight line.",
            vec![
                Param::required("from", Type::Point, "One end."),
                Param::required("to", Type::Point, "The other end."),
                Param::with_default("thickness", length(), "0.3 m", "Its thickness."),
            ],
        ),
        Signature::new(
            "tree",
            "A tree, a pole, a lamp post.",
            vec![Param::required("at", Type::Point, "Its place."), trunk()],
        ),
        Signature::new(
            "grove",
            "Trees in rows over a rectangle.",
            vec![
                corner(),
                opposite(),
                Param::with_default(
                    "spacing",
                    Type::Quantity { dimension: Dimension::LENGTH, min: 1.0, max: 1000.0 },
                    "7 m",
                    "Distance between two trees.",
                ),
                trunk(),
            ],
        ),
        Signature::new(
            "parked_car",
            "A car that stands for good.",
            vec![
                Param::required("at", Type::Pose, "Its middle and its heading."),
                Param::with_default("length", length(), "4.5 m", "Its length."),
                Param::with_default("width", length(), "1.9 m", "Its width."),
            ],
        ),
        Signature::new(
            "parked_row",
            "Cars that stand one behind another along a straight line, looking along it. The first touches `from` with its rear; the row has as many cars as there is room for up to `to`.",
            vec![
                Param::required("from", Type::Point, "One end of the row, on the middle of the cars."),
                Param::required("to", Type::Point, "The other end."),
                Param::with_default(
                    "gap",
                    Type::Quantity { dimension: Dimension::LENGTH, min: 0.0, max: 1000.0 },
                    "1 m",
                    "Distance between two cars.",
                ),
                Param::with_default("length", length(), "4.5 m", "Length of a car."),
                Param::with_default("width", length(), "1.9 m", "Width of a car."),
            ],
        ),
        Signature::new(
            "bus",
            "A bus that stands for good, such as at its stop. The default is the greatest size of a bus with two axles before 2002 (Directive 96/53/EC). Like all obstacles it may not stand on a driving lane, since drivers look for road users there.",
            vec![
                Param::required("at", Type::Pose, "Its middle and its heading."),
                Param::with_default("length", length(), "12 m", "Its length."),
                Param::with_default("width", length(), "2.55 m", "Its width."),
            ],
        ),
        Signature::new(
            "crosswalk",
            "A marked crosswalk over the whole carriageway, at a right angle to the street.",
            vec![
                Param::required("at", Type::Point, "Its middle, on a street outside junctions."),
                Param::with_default(
                    "width",
                    Type::Quantity { dimension: Dimension::LENGTH, min: 1.0, max: 20.0 },
                    "4 m",
                    "Its extent along the street.",
                ),
            ],
        ),
        Signature::new(
            "speed_sign",
            "A limit that a car takes over when it passes.",
            vec![
                Param::required(
                    "at",
                    Type::Pose,
                    "The middle of the lane where it takes effect, and the lane's heading.",
                ),
                Param::required("limit", Type::positive(Dimension::SPEED), "The limit."),
            ],
        ),
    ]
}

/// Builds a town and reports what is wrong with it. A map given here replaces its own roads and signs.
pub fn lower(
    declaration: &Declaration,
    map: Option<&Path>,
    sources: &Sources,
    read: &dyn Reader,
    said: &mut Vec<Diagnostic>,
) -> Option<Town> {
    let block = &declaration.block;
    let own = match declaration.kind {
        "opendrive" if map.is_some() => TownParts::default(),
        "opendrive" => {
            let folder = sources.get(declaration.source).path.parent().unwrap_or(Path::new("")).to_path_buf();
            let path = block.arguments.text("file");
            read_map(declaration, &folder.join(path), (path, "the folder of the file that names them"), read, said)?
        }
        _ => match design(declaration).build() {
            Ok(parts) => parts,
            Err(faults) => {
                said.extend(faults.iter().map(|fault| unbuildable(fault, block)));
                return None;
            }
        },
    };
    let mut parts = match map {
        None => own,
        Some(map) => {
            let path = map.display().to_string();
            let real = read_map(declaration, map, (&path, "the folder that you are in"), read, said)?;
            let obstacles = own.obstacles.into_iter().chain(real.obstacles.iter().copied()).collect();
            TownParts { obstacles, ..real }
        }
    };
    let before = said.len();
    if let Some(second) = block.nested("row_houses").nth(1) {
        said.push(diagnostics::contradiction(second.head, "this town has `row_houses` already".into()));
    }
    let standing = standing(block, said);
    // Rows of houses leave out houses that would stand where an obstacle is placed by hand.
    parts.obstacles.retain(|row| !standing.iter().any(|(_, own)| own.overlaps(row)));
    parts.obstacles.extend(standing.iter().map(|(_, own)| *own));
    // A real map has signs of its own.
    for sign in block.nested("speed_sign").filter(|_| map.is_none()) {
        let half = SIGN_HALF_SIZE;
        let trigger = OrientedBox::new(pose(sign.arguments.value("at")), half, half);
        parts.speed_signs.push(SpeedSign { limit: sign.arguments.number("limit"), trigger });
    }
    if map.is_some() {
        // An obstacle beside the outline of a street may reach into the street of the map.
        let roads = Town::new(TownParts { obstacles: Vec::new(), ..parts.clone() });
        parts.obstacles.retain(|own| road_under(&roads, own).is_none());
        return Some(Town::new(parts));
    }
    let mut town = Town::new(parts);
    let mut crosswalks = Vec::new();
    for walk in block.nested("crosswalk") {
        let (x, y) = walk.arguments.point("at");
        match crosswalk::across(&town, Point::new(x, y), walk.arguments.number("width")) {
            Ok(corners) => crosswalks.push(corners),
            Err(error) => {
                said.push(diagnostics::unbuildable_town(walk.head, &format!("no crosswalk fits here: {error}")));
            }
        }
    }
    town.crosswalks.extend(crosswalks);
    let drawn = declaration.kind != "opendrive";
    // The first look-up of a lane is expensive, and in a described town most objects stand far from every street.
    let reach = UNDER_SLACK + if drawn { half_width(block) } else { f64::INFINITY };
    let near = |own: &OrientedBox| town.roads.iter().any(|road| comes_near(road, own, reach));
    // One message for a row or a grove.
    let mut reported = None;
    for (place, own) in standing.iter().filter(|(_, own)| near(own)) {
        if let Some(road) = road_under(&town, own).filter(|_| reported != Some(*place)) {
            reported = Some(*place);
            let whose = match road.name.as_str() {
                "" => format!("road {}", road.id),
                name => format!("`{name}`"),
            };
            said.push(diagnostics::unbuildable_town(*place, &format!("this stands on a driving lane of {whose}")));
        }
    }
    let whole = said.len() == before;
    said.extend(idle(&town, block, &standing));
    whole.then_some(town)
}

/// Reports objects that have no effect where they stand.
fn idle(town: &Town, block: &Block, standing: &[(Span, OrientedBox)]) -> Vec<Diagnostic> {
    let far = |own: &OrientedBox| !town.roads.iter().any(|road| comes_near(road, own, FAR));
    let lost = standing.iter().filter(|(_, own)| far(own)).map(|(place, _)| diagnostics::far_from_streets(*place, FAR));
    let unseen = |sign: &&Block| {
        let at = pose(sign.arguments.value("at")).position();
        town.nearest_lane(at, LaneFilter::Driving).is_none_or(|lane| {
            let reach = town.lane_width(lane) / 2.0 + SIGN_HALF_SIZE * SQRT_2;
            town.pose(lane).to_local(at).norm() > reach
        })
    };
    let passed_by_none = block.nested("speed_sign").filter(unseen).map(|sign| diagnostics::sign_off_lanes(sign.head));
    lost.chain(passed_by_none).collect()
}

/// Reports a fault of a design at its street, its corner or its measure.
fn unbuildable(fault: &DesignError, block: &Block) -> Diagnostic {
    if let DesignError::Measure { what, .. } = fault {
        // `setback of buildings` is the key `setback` of `row_houses`, `lane width` that of the town.
        let row = block.nested("row_houses").next();
        let (owner, key) = match (what.split_once(' '), row) {
            (Some((key, "of buildings" | "between buildings")), Some(row)) => (row, key.to_string()),
            _ => (block, what.replace(' ', "_")),
        };
        return diagnostics::unbuildable_town(owner.place(&key), &fault.to_string());
    }
    let mut places: Vec<Span> = Vec::new();
    for name in fault.names() {
        let streets = || block.nested("street").zip(1..);
        let corners =
            || streets().flat_map(|(street, _)| street.arguments.list("through").iter().zip(street.members("through")));
        let street =
            streets().find(|(street, number)| street_name(street, *number) == name).map(|(street, _)| street.head);
        let corner = || corners().find(|(point, _)| matches!(point, Value::Point(x, y) if node_name(*x, *y) == name));
        let place = street.or_else(|| corner().map(|(_, span)| *span));
        places.extend(place.filter(|place| !places.contains(place)));
    }
    let mut diagnostic =
        diagnostics::unbuildable_town(places.first().copied().unwrap_or(block.head), &fault.to_string());
    let others = if places.len() > 2 { "this is one of them" } else { "the other is here" };
    for place in places.into_iter().skip(1) {
        diagnostic = diagnostic.label(place, others);
    }
    match fault {
        DesignError::Crossing { first, second, x, y } if first != second => {
            let round = |number: &f64| (number * 100.0).round() / 100.0;
            let point = node_name(round(x), round(y));
            diagnostic.help(format!("they meet where both go `through` the same point: give both `{point}`"))
        }
        _ => diagnostic,
    }
}

/// The name of a street in messages.
fn street_name(street: &Block, number: usize) -> String {
    street.name.clone().unwrap_or_else(|| format!("number {number}"))
}

/// The name of a node in messages.
fn node_name(x: f64, y: f64) -> String {
    format!("({} m, {} m)", short(x), short(y))
}

/// Reads a map; `shown` is its path in messages, and what that is relative to.
fn read_map(
    declaration: &Declaration,
    file: &Path,
    (shown, relative_to): (&str, &str),
    read: &dyn Reader,
    said: &mut Vec<Diagnostic>,
) -> Option<TownParts> {
    let place = declaration.block.place("file");
    let mut missing = false;
    let text = read.text(file).map_err(|error| {
        missing = error.kind() == std::io::ErrorKind::NotFound;
        lang::reason(&error)
    });
    match text.and_then(|text| opendrive::read(&text, &declaration.name).map_err(|error| error.to_string())) {
        Ok(parts) => {
            // What has no effect is listed by `falsify preview`; it is no mistake of the file.
            let mistakes = parts.warnings.iter().filter(|warning| !warning.problem.is_unused());
            let warnings: Vec<String> = mistakes.map(ToString::to_string).collect();
            if !warnings.is_empty() {
                said.push(diagnostics::map_warning(place, shown, &warnings));
            }
            Some(parts)
        }
        Err(reason) => {
            let unusable = diagnostics::unusable_map(place, shown, &reason);
            let help = || format!("paths are relative to {relative_to}");
            said.push(if missing { unusable.help(help()) } else { unusable });
            None
        }
    }
}

/// All objects of the town, each with the place of its declaration.
fn standing(block: &Block, said: &mut Vec<Diagnostic>) -> Vec<(Span, OrientedBox)> {
    let mut all = Vec::new();
    for child in &block.children {
        let arguments = &child.arguments;
        let point = |key: &str| {
            let (x, y) = arguments.point(key);
            Point::new(x, y)
        };
        let tree = |at: Point| {
            let half = arguments.number("trunk") / 2.0;
            OrientedBox::new(Pose::new(at.x, at.y, 0.0), half, half)
        };
        match child.word {
            "building" => {
                let own = OrientedBox::spanning(point("corner"), point("opposite"));
                if own.half.min() < 0.05 {
                    said.push(diagnostics::unbuildable_town(child.head, "this building is thinner than 0.1 m"));
                    continue;
                }
                all.push((child.head, own));
            }
            "wall" => {
                let (from, to) = (point("from"), point("to"));
                let (middle, along) = (nalgebra::center(&from, &to), to - from);
                let heading = libm::atan2(along.y, along.x);
                let half = (along.norm() / 2.0, arguments.number("thickness") / 2.0);
                all.push((child.head, OrientedBox::new(Pose::new(middle.x, middle.y, heading), half.0, half.1)));
            }
            "tree" => all.push((child.head, tree(point("at")))),
            "grove" => {
                let (a, b) = (point("corner"), point("opposite"));
                let (low, high) = (a.inf(&b), a.sup(&b));
                let spacing = arguments.number("spacing");
                let count = |extent: f64| (extent / spacing).floor() + 1.0;
                let (columns, rows) = (count(high.x - low.x), count(high.y - low.y));
                if columns * rows > MOST_TREES {
                    let reason = format!("this grove has {} trees; at most {MOST_TREES} grow", columns * rows);
                    said.push(diagnostics::unbuildable_town(child.head, &reason));
                    continue;
                }
                for index in 0..(columns * rows) as u32 {
                    let (column, row) = (f64::from(index) % columns, (f64::from(index) / columns).floor());
                    all.push((child.head, tree(Point::new(low.x + column * spacing, low.y + row * spacing))));
                }
            }
            "parked_row" => {
                let (from, along) = (point("from"), point("to") - point("from"));
                let (length, width) = (arguments.number("length"), arguments.number("width"));
                let pitch = length + arguments.number("gap");
                let count = ((along.norm() - length) / pitch + 1.0 + 1e-9).floor();
                if !(1.0..=MOST_CARS).contains(&count) {
                    let reason = match count < 1.0 {
                        true => format!("this row of {:.1} m has no room for a car of {length} m", along.norm()),
                        false => format!("this row has {count} cars; at most {MOST_CARS} stand in one"),
                    };
                    said.push(diagnostics::unbuildable_town(child.head, &reason));
                    continue;
                }
                let direction = along / along.norm();
                let heading = libm::atan2(along.y, along.x);
                for index in 0..count as u32 {
                    let middle = from + direction * (length / 2.0 + f64::from(index) * pitch);
                    let place = Pose::new(middle.x, middle.y, heading);
                    all.push((child.head, OrientedBox::new(place, length / 2.0, width / 2.0)));
                }
            }
            "parked_car" | "bus" => {
                let half = (arguments.number("length") / 2.0, arguments.number("width") / 2.0);
                all.push((child.head, OrientedBox::new(pose(arguments.value("at")), half.0, half.1)));
            }
            "street" | "row_houses" | "crosswalk" | "speed_sign" => {}
            other => unreachable!("checked: `{other}` is no part of a town"),
        }
    }
    all
}

/// Whether the middle of a road may be this near to a box (m); true if that cannot be decided quickly.
fn comes_near(road: &Road, own: &OrientedBox, reach: f64) -> bool {
    road.plan_view.pieces().iter().any(|piece| {
        // How far the piece deviates from the straight line between its ends.
        let sag = match piece.shape {
            Shape::Line => 0.0,
            Shape::Arc(curvature) => curvature.abs() * piece.length * piece.length / 8.0,
            _ => piece.length,
        };
        let around = OrientedBox::new(own.pose, own.half.x + reach + sag, own.half.y + reach + sag);
        around.is_crossed_by(piece.start.position(), piece.pose(piece.length).position())
    })
}

/// The road on one of whose driving lanes a box stands. It checks places less than a metre apart, after whole parts of the
/// box that lie far from all lanes have been excluded.
fn road_under<'a>(town: &'a Town, own: &OrientedBox) -> Option<&'a Road> {
    let steps = (own.half * 2.0 / UNDER_STEP).map(|steps| steps.ceil().clamp(1.0, MOST_STEPS));
    let far = town.widest_driving_lane() / 2.0 + UNDER_SLACK;
    let mut open = vec![(Vector::zeros(), steps)];
    while let Some((first, last)) = open.pop() {
        let place =
            |step: Vector| own.pose.to_world(own.half.component_mul(&(step * 2.0).component_div(&steps)) - own.half);
        let middle = place((first + last) / 2.0);
        let lane = town.nearest_lane(middle, LaneFilter::Driving)?;
        let beside = town.pose(lane).to_local(middle);
        if first == last {
            if beside.y.abs() < town.lane_width(lane) / 2.0 && beside.x.abs() < UNDER_STEP {
                return town.roads.get(lane.road.0 as usize);
            }
        } else if beside.norm() <= far + (place(last) - middle).norm() && beside.norm().is_finite() {
            let (side, extent) = (last - first).argmax();
            let (mut end, mut begin) = (last, first);
            end[side] = first[side] + (extent / 2.0).floor();
            begin[side] = end[side] + 1.0;
            open.extend([(begin, last), (first, end)]);
        }
    }
    None
}

fn pose(value: &Value) -> Pose {
    match value {
        Value::Pose(x, y, yaw) => Pose::new(*x, *y, *yaw),
        other => panic!("checked: a pose, not {other:?}"),
    }
}

fn profile(block: &Block) -> StreetProfile {
    let number = |key: &str| block.arguments.number(key);
    StreetProfile { lane_width: number("lane_width"), shoulder: number("shoulder"), sidewalk: number("sidewalk") }
}

fn carriageway(street: &Block) -> Carriageway {
    let lanes = street.arguments.integer("lanes") as u32;
    Carriageway { forward: lanes, backward: if street.arguments.boolean("one_way") { 0 } else { lanes } }
}

/// Half of the width of the widest street (m).
fn half_width(town: &Block) -> f64 {
    let profile = profile(town);
    let widths = town.nested("street").map(|street| carriageway(street).street_half_width(&profile));
    widths.fold(0.0, f64::max)
}

fn design(declaration: &Declaration) -> TownDesign {
    let block = &declaration.block;
    let number = |key: &str| block.arguments.number(key);
    let lights = block.arguments.boolean("traffic_lights");
    let mut nodes: Vec<Node> = Vec::new();
    let mut node_at = |place: Point| {
        let known = nodes.iter().position(|node| (node.position - place).norm() < SAME_NODE);
        known.unwrap_or_else(|| {
            nodes.push(Node { name: node_name(place.x, place.y), position: place, lights: false });
            nodes.len() - 1
        })
    };
    let mut streets = Vec::new();
    for (index, street) in block.nested("street").enumerate() {
        let points = street.arguments.list("through").iter().map(|value| match value {
            Value::Point(x, y) => Point::new(*x, *y),
            other => panic!("checked: a point, not {other:?}"),
        });
        streets.push(Street {
            name: street_name(street, index + 1),
            nodes: points.map(&mut node_at).collect(),
            speed_limit: street.arguments.has("speed_limit").then(|| street.arguments.number("speed_limit")),
            carriageway: carriageway(street),
        });
    }
    if lights {
        for (index, node) in nodes.iter_mut().enumerate() {
            node.lights = legs(&streets, index) > 2;
        }
    }
    let row = block.nested("row_houses").next().map(|row| BuildingRow {
        setback: row.arguments.number("setback"),
        depth: row.arguments.number("depth"),
        length: row.arguments.number("length"),
        gap: row.arguments.number("gap"),
    });
    TownDesign {
        name: declaration.name.clone(),
        nodes,
        streets,
        profile: profile(block),
        bend_radius: number("bend_radius"),
        corner_radius: number("corner_radius"),
        block_buildings: row,
        opposite_lights: block.arguments.choice("light_turns") == "opposite_legs",
        ..TownDesign::default()
    }
}

/// The number of pieces of street that meet at a node.
fn legs(streets: &[Street], node: usize) -> usize {
    let pieces = streets.iter().flat_map(|street| street.nodes.windows(2));
    pieces.map(|ends| ends.iter().filter(|end| **end == node).count()).sum()
}
