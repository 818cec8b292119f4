use roxmltree::{Document, Error};

use super::attributes::{Context, children};
use super::{
    OpenDriveError, budget, crosswalks, give_way, junctions, limits, obstacles, roads, signals, traffic_lights, unused,
};
use crate::TownParts;
use crate::lane_network::LaneNetwork;

/// Reads the text of an OpenDRIVE file; `name` becomes the town's name.
///
/// # Errors
/// The text is not XML, not OpenDRIVE, has no usable road or a lane wider than a kilometre, or is larger than any town. Every other problem becomes a warning in
/// [`TownParts::warnings`].
///
/// # Example
/// ```
/// use road::{OpenDriveError, opendrive};
/// let error = opendrive::read("<map/>", "nowhere").unwrap_err();
/// assert_eq!(error, OpenDriveError::NotOpenDrive { found: "map".to_owned() });
/// ```
pub fn read(xml: &str, name: &str) -> Result<TownParts, OpenDriveError> {
    budget::check_text(xml)?;
    let document = Document::parse_with_options(xml, budget::parsing(xml)).map_err(|error| {
        let at = error.pos();
        let message = error.to_string();
        let said = message.strip_suffix(&format!(" at {at}")).unwrap_or(&message);
        let (line, column) = match error {
            // Neither has a place: the text ends before an element does.
            Error::UnexpectedEndOfStream | Error::UnclosedRootNode => end_of(xml),
            _ => (at.row, at.col),
        };
        OpenDriveError::NotXml { line, column, message: said.to_owned() }
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "OpenDRIVE" {
        return Err(OpenDriveError::NotOpenDrive { found: root.tag_name().name().to_owned() });
    }
    budget::check_roads(root)?;
    let mut context = Context::new(xml);
    context.only_signs_limit = signals::has_carla_signs(root);
    context.of_carla = signals::is_of_carla(root);
    let mut roads = roads::read(&mut context, root);
    if let Some(error) = context.refused.take() {
        return Err(error);
    }
    if roads.roads.is_empty() {
        let first = context.warnings.into_iter().next();
        return Err(OpenDriveError::NoRoads { found: children(root, "road").count(), first });
    }
    let junctions = junctions::read(&mut context, root, &roads);
    roads.link(&mut context, &junctions.by_id);
    let cross_paths = crosswalks::cross_paths(&mut context, root, &mut roads);
    let network = LaneNetwork::new(&roads.roads, &junctions.junctions);
    let signals = signals::signals(&mut context, &roads, &network);
    let (speed_signs, on_lanes) = signals::speed_signs(&mut context, &roads, &network, &signals);
    limits::follow_signs(&mut roads.roads, &network, on_lanes);
    let crosswalks = crosswalks::crosswalks(&mut context, &roads, &network, cross_paths);
    let traffic_lights = traffic_lights::read(&mut context, root, &roads, &junctions, &network, &signals);
    let give_way_signs = give_way::read(&mut context, &roads, &network, &signals, &traffic_lights);
    let bus_stops = signals::bus_stops(&mut context, &roads, &signals);
    let obstacles = obstacles::read(&mut context, &roads, &network);
    unused::note(&mut context, root);
    Ok(TownParts {
        name: name.to_owned(),
        roads: roads.roads,
        junctions: junctions.junctions,
        speed_signs,
        traffic_lights,
        give_way_signs,
        crosswalks,
        bus_stops,
        obstacles,
        warnings: context.into_warnings(),
        map: Some(xml.into()),
        map_file: None,
    })
}

/// The line and the column at which a text ends, from 1.
fn end_of(text: &str) -> (u32, u32) {
    let last = text.rsplit('\n').next().unwrap_or_default();
    (1 + text.matches('\n').count() as u32, 1 + last.chars().count() as u32)
}
