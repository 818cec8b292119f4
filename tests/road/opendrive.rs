//! Maps in OpenDRIVE.

use proptest::prelude::*;
use road::geometry::{Point, wrap_angle};
use road::opendrive::read;
use road::{Geometry, LaneFilter, LaneKind, OpenDriveError, OpenDriveProblem, RoadIndex, Shape, Town, Waypoint};

mod limits_and_signs;
mod other_tools;
mod signals_reference;

/// A road to the east, a bend to the left through a junction, and a road to the north; a sign and a light.
const BEND: &str = r#"<?xml version="1.0"?>
<OpenDRIVE xmlns="http://code.asam.net/simulation/standard/opendrive_schema">
<road name="east" length="100" id="1" junction="-1">
<link><successor elementType="junction" elementId="9"/></link>
<planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>
<lanes><laneSection s="0">
<left><lane id="1" type="driving"><link/><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>
<lane id="2" type="sidewalk"><width sOffset="0" a="2"/></lane></left>
<center><lane id="0" type="none"/></center>
<right><lane id="-1" type="driving"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right>
</laneSection></lanes>
<objects><object id="3" name="Speed_30" s="50" t="-5" orientation="-"/></objects>
</road>
<road name="" length="31.41592653589793" id="2" junction="9">
<link><predecessor elementType="road" elementId="1" contactPoint="end"/><successor elementType="road" elementId="3" contactPoint="start"/></link>
<planView><geometry s="0" x="100" y="0" hdg="0" length="31.41592653589793"><arc curvature="0.05"/></geometry></planView>
<lanes><laneSection s="0">
<left><lane id="1" type="driving"><link><predecessor id="1"/><successor id="1"/></link><width sOffset="0" a="3.5"/></lane></left>
<right><lane id="-1" type="driving"><link><predecessor id="-1"/><successor id="-1"/></link><width sOffset="0" a="3.5"/></lane></right>
</laneSection></lanes>
<signals><signalReference id="7" s="0" t="0" orientation="-"><validity fromLane="-1" toLane="-1"/></signalReference></signals>
</road>
<road name="north" length="50" id="3" junction="-1">
<link><predecessor elementType="junction" elementId="9"/></link>
<planView><geometry s="0" x="120" y="20" hdg="1.5707963267948966" length="50"><line/></geometry></planView>
<lanes><laneSection s="0">
<left><lane id="1" type="driving"><width sOffset="0" a="3.5"/></lane></left>
<right><lane id="-1" type="driving"><width sOffset="0" a="3.5"/></lane></right>
</laneSection></lanes>
<signals><signal id="7" type="1000001" dynamic="yes" s="5" t="-4" orientation="-"><validity fromLane="0" toLane="0"/></signal></signals>
</road>
<controller id="5" sequence="0"><control signalId="7"/></controller>
<junction id="9" name="bend">
<connection id="0" incomingRoad="1" connectingRoad="2" contactPoint="start"><laneLink from="-1" to="-1"/></connection>
<connection id="1" incomingRoad="3" connectingRoad="2" contactPoint="end"><laneLink from="1" to="1"/></connection>
<controller id="5" type="0" sequence="0"/>
</junction>
</OpenDRIVE>"#;

fn town(xml: &str) -> Town {
    Town::new(read(xml, "bend").unwrap())
}

fn eastbound(s: f64) -> Waypoint {
    Waypoint { road: RoadIndex(0), section: 0, lane: -1, s }
}

fn ahead(town: &Town, from: Waypoint, distance: f64) -> Vec<Waypoint> {
    let mut ways = Vec::new();
    town.next(from, distance, &mut ways);
    ways
}

#[test]
fn lanes_lead_through_the_bend() {
    let town = town(BEND);
    assert!(town.warnings.is_empty(), "{:?}", town.warnings);
    // Two connections lead over the road in the junction, so CARLA has each way twice.
    let [inside, again] = ahead(&town, eastbound(99.0), 1.0 + 31.41592653589793 / 2.0)[..] else { panic!() };
    assert_eq!(inside, again);
    assert!(town.is_junction(inside));
    let pose = town.pose(inside);
    let radius = 20.0 + 1.75;
    assert!(
        (pose.position() - Point::new(100.0 + radius * 0.5_f64.sqrt(), 20.0 - radius * 0.5_f64.sqrt())).norm() < 1e-9
    );
    assert!(wrap_angle(pose.yaw - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
    let [north] = ahead(&town, inside, 20.0)[..] else { panic!() };
    assert_eq!((north.road, north.lane), (RoadIndex(2), -1));
    assert!(ahead(&town, north, 60.0).is_empty());
}

#[test]
fn questions_about_a_place_are_answered_by_its_lane() {
    let town = town(BEND);
    let at = |lane| Waypoint { lane, ..eastbound(30.0) };
    assert_eq!((town.lane_width(at(2)), town.lane_kind(at(2))), (2.0, LaneKind::Sidewalk));
    assert_eq!(
        (town.left_lane(at(-1)), town.right_lane(at(1)), town.right_lane(at(2))),
        (Some(at(1)), Some(at(2)), None)
    );
    // The middle between the centres of lane 1 (1.75 m) and of the sidewalk (4.5 m) is 3.125 m.
    let nearest = |y, filter| town.nearest_lane(Point::new(30.0, y), filter).unwrap().lane;
    assert_eq!(
        (nearest(3.1, LaneFilter::Any), nearest(3.2, LaneFilter::Any), nearest(9.0, LaneFilter::Driving)),
        (1, 2, 1)
    );
    assert_eq!(town.nearest_lane(Point::new(f64::NAN, 0.0), LaneFilter::Any), None);
    assert_eq!(town.driving_lanes().len(), 4);
    let stretch = town.driving_lanes().iter().find(|stretch| stretch.start.lane == 1).unwrap();
    assert_eq!(town.along(stretch, 10.0).s, 90.0);
    let (low, high) = town.bounds();
    assert!(
        (low - Point::new(0.0, -3.5)).norm() < 1e-9 && (high - Point::new(123.5, 70.0)).norm() < 1e-9,
        "{low} {high}"
    );
}

#[test]
fn signs_and_lights_stand_before_what_they_hold_for() {
    let parts = read(BEND, "bend").unwrap();
    let [sign] = &parts.speed_signs[..] else { panic!() };
    assert!((sign.limit - 30.0 / 3.6).abs() < 1e-12);
    assert!((sign.trigger.pose.position() - Point::new(50.0 - 0.35 * 3.5, -1.75)).norm() < 1e-9);
    let [light] = &parts.traffic_lights[..] else { panic!() };
    assert_eq!((light.group, light.turn, light.turns, light.road), (0, 0, 1, RoadIndex(0)));
    assert!((light.stop.position() - Point::new(97.0, -1.75)).norm() < 1e-9);
    assert!((light.trigger.half.x, light.trigger.half.y) == (1.5, 0.875));
}

#[test]
fn without_lane_links_those_of_the_connecting_road_are_taken() {
    let xml = BEND.replace(r#"<laneLink from="-1" to="-1"/>"#, "");
    let town = town(&xml);
    assert_eq!(town.warnings.len(), 1);
    assert_eq!(town.warnings[0].problem, OpenDriveProblem::GuessedLaneLinks);
    assert_eq!(ahead(&town, eastbound(99.0), 2.0)[0].road, RoadIndex(1));
}

#[test]
fn borders_stand_in_for_widths() {
    let borders = BEND.replace(r#"<width sOffset="0" a="2"/>"#, r#"<border sOffset="0" a="5.5"/>"#);
    let right = borders.replace(
        r#"<lane id="-1" type="driving"><width sOffset="0" a="3.5" b="0""#,
        r#"<lane id="-1" type="driving"><border sOffset="0" a="-3.5" b="0""#,
    );
    assert_ne!(borders, right);
    let (ours, original) = (read(&right, "bend").unwrap(), read(BEND, "bend").unwrap());
    for lane in 0..4 {
        let width = |parts: &road::TownParts| parts.roads[0].sections[0].lanes[lane].width.value(20.0);
        assert_eq!(width(&ours), width(&original));
    }
}

#[test]
fn what_is_wrong_is_said_with_road_and_line() {
    let parts = read(&BEND.replace(r#"a="2""#, r#"a="two""#), "bend").unwrap();
    assert_eq!(parts.warnings[0].to_string(), "line 8, road 1: `a` of `width` is `two`, not a usable number; skipped");
    let parts = read(&BEND.replace(r#"elementId="3""#, r#"elementId="30""#), "bend").unwrap();
    assert_eq!(parts.warnings[0].to_string(), "line 15, road 2: `successor` refers to 30, which is not there; ignored");
}

/// A street on the ground and a bridge over it.
const BRIDGE: &str = r#"<OpenDRIVE>
<road length="100" id="1" junction="-1">
<planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>
<lanes><laneSection s="0"><right><lane id="-1" type="driving"><width a="4"/></lane></right></laneSection></lanes>
</road>
<road length="100" id="2" junction="-1">
<planView><geometry s="0" x="52" y="-50" hdg="1.5707963267948966" length="100"><line/></geometry></planView>
<elevationProfile><elevation s="0" a="0" b="0.4" c="-0.004" d="0"/></elevationProfile>
<lanes><laneSection s="0"><left><lane id="1" type="driving"><width a="4"/></lane></left></laneSection></lanes>
</road>
</OpenDRIVE>"#;

#[test]
fn a_bridge_rises() {
    let town = town(BRIDGE);
    assert!(town.warnings.is_empty(), "{:?}", town.warnings);
    let uphill = Waypoint { road: RoadIndex(1), section: 0, lane: 1, s: 60.0 };
    assert!((town.elevation(uphill) - 9.6).abs() < 1e-12 && town.elevation(eastbound(5.0)) == 0.0);
}

#[test]
fn other_ways_to_write_the_same_are_read() {
    let original = town(BEND);
    let same = |xml: &str| {
        let other = town(xml);
        assert_eq!((&other.roads, &other.warnings), (&original.roads, &original.warnings));
        assert_eq!(other.topology(), original.topology());
    };
    same(&format!("\u{feff}{BEND}"));
    same(&BEND.replace("?>\n", "?>\n<!DOCTYPE OpenDRIVE SYSTEM \"x.dtd\">\n<!-- a comment -->\n"));
    same(
        &BEND
            .replace("<OpenDRIVE xmlns=", "<OpenDRIVE xmlns:x=")
            .replace("<road name", "<userData><![CDATA[<road id='1'/>]]></userData><road name"),
    );
    same(&BEND.replace("<planView>", "<type s='0' type='town'><speed max='no limit' unit='km/h'/></type><planView>"));
    same(
        &BEND
            .replace("type=\"driving\"", "level=\"false\" type=\"Driving\"")
            .replace("type=\"sidewalk\"", "type=\"walking\""),
    );
    let bomb = BEND.replace("?>\n", "?>\n<!DOCTYPE OpenDRIVE [<!ENTITY a \"aaaaaaaaaa\">]>\n");
    assert!(matches!(read(&bomb, "bomb"), Err(OpenDriveError::NotXml { .. })));
}

#[test]
fn ambiguous_links_are_said() {
    // As in CARLA, the number of a road wins over that of a junction.
    let xml = BEND.replace("elementId=\"9\"", "elementId=\"3\"").replace("junction id=\"9\"", "junction id=\"3\"");
    let town = town(&xml.replace("junction=\"9\"", "junction=\"3\""));
    let said = "line 4, road 1: `successor` should lead to a junction, but there is a road 3, and CARLA takes that";
    assert_eq!(town.warnings[0].to_string(), said);
    assert!(ahead(&town, eastbound(99.0), 2.0).is_empty());
}

#[test]
fn left_hand_traffic_is_driven_on_the_left() {
    let xml = BEND.replace("<road name", "<road rule=\"LHT\" name");
    let town = town(&xml);
    assert!(town.warnings.is_empty(), "{:?}", town.warnings);
    let north = Waypoint { road: RoadIndex(2), lane: -1, ..eastbound(1.0) };
    // The right lanes lead back through the bend, and the left ones ahead.
    assert!(wrap_angle(town.pose(north).yaw + std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!(ahead(&town, north, 2.0)[0].road, RoadIndex(1));
    let east = Waypoint { lane: 1, ..eastbound(99.0) };
    assert!(town.pose(east).yaw.abs() < 1e-12);
    assert_eq!((ahead(&town, east, 2.0)[0].road, ahead(&town, east, 2.0)[0].lane), (RoadIndex(1), 1));
    assert_eq!(
        (town.right_lane(east), town.left_lane(east)),
        (Some(eastbound(99.0)), Some(Waypoint { lane: 2, ..east }))
    );
    let stretch = town
        .driving_lanes()
        .iter()
        .find(|stretch| stretch.start.lane == 1 && stretch.start.road == RoadIndex(0))
        .unwrap();
    assert_eq!((town.along(stretch, 10.0).s, town.moved(east, -9.0).s), (10.0, 90.0));
}

/// Three sections of a road, written in the wrong order: two lanes, the outer one starts in the second section and continues as
/// the only one; the sides of the first section are written separately.
const SECTIONS: &str = r#"<OpenDRIVE>
<road length="90" id="1" junction="-1">
<link><predecessor elementType="road" elementId="1" contactPoint="end"/><successor elementType="road" elementId="1" contactPoint="start"/></link>
<planView><geometry s="0" x="0" y="0" hdg="0" length="90"><line/></geometry></planView>
<lanes>
<laneSection s="30"><right>
<lane id="-1" type="driving"><link><successor id="0"/></link><width a="3"/></lane>
<lane id="-2" type="driving"><link><successor id="-1"/></link><width a="0" b="0.1"/></lane></right></laneSection>
<laneSection s="0"><right><lane id="-1" type="driving"><link><successor id="-1"/></link><width a="3"/></lane></right></laneSection>
<laneSection s="0"><left><lane id="1" type="driving"><link><predecessor id="-1"/></link><width a="3"/></lane></left></laneSection>
<laneSection s="60"><right><lane id="-1" type="driving"><link><successor id="-1"/></link><width a="3"/></lane></right></laneSection>
</lanes></road></OpenDRIVE>"#;

#[test]
fn lanes_begin_end_and_change_their_numbers() {
    let town = town(SECTIONS);
    let sections: Vec<(f64, f64)> = town.roads[0].sections.iter().map(|section| (section.start, section.end)).collect();
    assert_eq!(sections, [(0.0, 30.0), (0.0, 30.0), (30.0, 60.0), (60.0, 90.0)]);
    let at = |section, lane, s| Waypoint { section, lane, ..eastbound(s) };
    let after = |from| ahead(&town, from, 20.0).iter().map(|w| (w.section, w.lane)).collect::<Vec<_>>();
    assert_eq!(after(at(0, -1, 20.0)), [(2, -1)]);
    assert_eq!(after(at(2, -2, 50.0)), [(3, -1)]);
    assert_eq!(after(at(2, -1, 50.0)), []);
    // The road leads to itself.
    assert_eq!(after(at(3, -1, 80.0)), [(0, -1)]);
    assert_eq!(after(at(1, 1, 10.0)), [(0, -1)]);
    assert_eq!(town.lane_width(at(2, -2, 40.0)), 1.0);
    assert!((town.pose(at(2, -2, 40.0)).y + 3.5).abs() < 1e-12);
    assert_eq!(town.generate_waypoints(20.0).iter().filter(|w| w.lane == 1).count(), 2);
    assert_eq!(town.nearest_lane(Point::new(5.0, 1.0), LaneFilter::Driving).unwrap().lane, 1);
}

#[test]
fn what_cannot_be_used_is_an_error() {
    let broken = read("<OpenDRIVE>\n  <road></lane></OpenDRIVE>", "x").unwrap_err();
    assert_eq!(broken.to_string(), "not XML: expected 'road' tag, not 'lane' (line 2, column 9)");
    let deep = format!("<OpenDRIVE>{}", "<a>".repeat(200_000));
    assert!(matches!(read(&deep, "x"), Err(OpenDriveError::NotXml { .. })));
    let bare = read("<OpenDRIVE><road id='1'/></OpenDRIVE>", "x");
    assert!(matches!(bare, Err(OpenDriveError::NoRoads { found: 1, first: Some(_) })));
}

#[test]
fn a_lost_road_far_away_does_not_hurt() {
    let town = town(&BEND.replace(r#"x="120""#, r#"x="900000000""#));
    let near = town.nearest_lane(Point::new(30.0, 2.0), LaneFilter::Any).unwrap();
    assert_eq!((near.road, near.lane), (RoadIndex(0), 1));
}

/// Pieces of all forms, borders, an offset and a direct junction.
const FORMS: &str = r#"<OpenDRIVE>
<header revMajor="1" revMinor="8"/>
<road name="a" length="60" id="a" junction="-1">
<link><successor elementType="junction" elementId="7"/></link>
<planView>
<geometry s="0" x="0" y="0" hdg="0" length="20"><poly3 a="0" b="0.1" c="0.01" d="-0.001"/></geometry>
<geometry s="20" x="20" y="1" hdg="0.2" length="20"><spiral curvStart="0" curvEnd="0.05"/></geometry>
<geometry s="40" x="40" y="6" hdg="0.7" length="20"><paramPoly3 pRange="normalized" aU="0" bU="20" cU="0" dU="0" aV="0" bV="0" cV="2" dV="-1"/></geometry>
</planView>
<elevationProfile><elevation s="0" a="1" b="0.1" c="-0.001" d="0.00001"/></elevationProfile>
<lateralProfile><superelevation s="0" a="0.1" b="0" c="0" d="0"/></lateralProfile>
<lanes><laneOffset s="0" a="0" b="0" c="0" d="0"/><laneOffset s="30" a="0" b="0.1" c="0.01" d="0"/>
<laneSection s="0"><right>
<lane id="-1" type="driving"><border sOffset="0" a="-3" b="0" c="0" d="0"/></lane>
<lane id="-2" type="HOV"><border sOffset="0" a="-5" b="0.01" c="0" d="0"/></lane>
</right></laneSection></lanes></road>
<road name="b" length="30" id="b" junction="-1">
<link><predecessor elementType="junction" elementId="7"/></link>
<planView><geometry s="0" x="55" y="20" hdg="1" length="30"><arc curvature="-0.02"/></geometry></planView>
<lanes><laneSection s="0"><right><lane id="-1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane></right></laneSection></lanes>
</road>
<junction id="7" type="direct"><connection id="0" incomingRoad="a" linkedRoad="b" contactPoint="start"><laneLink from="-1" to="-1"/></connection></junction>
</OpenDRIVE>"#;

#[test]
fn all_forms_are_read() {
    let town = town(FORMS);
    let problems: Vec<String> = town.warnings.iter().map(|warning| warning.problem.to_string()).collect();
    assert_eq!(
        problems,
        [
            "the reference line jumps by 2.68 m at 20 m, where a geometry should begin at the end of the one before; drawn as given",
            "the reference line jumps by 2.59 m at 40 m, where a geometry should begin at the end of the one before; drawn as given",
            "the id `a` is not a number below 2^32 that it has alone; the free number 0 stands for it",
            "the id `b` is not a number below 2^32 that it has alone; the free number 1 stands for it",
            "not used: 1 × lane of type HOV",
            "not used: 1 × superelevation",
        ]
    );
    assert_eq!(ahead(&town, eastbound(59.0), 2.0)[0].road, RoadIndex(1));
    assert_eq!(town.lane_width(Waypoint { lane: -2, ..eastbound(0.0) }), 2.0);
    assert_eq!(town.lane_kind(Waypoint { lane: -2, ..eastbound(0.0) }), LaneKind::None);
}

/// The maps that the tests distort.
const MAPS: [&str; 4] = [BEND, BRIDGE, SECTIONS, FORMS];

/// Runs every query on a map; only the absence of panics matters.
fn exercise(xml: &str) {
    let Ok(parts) = read(xml, "mutant") else { return };
    let town = Town::new(parts);
    let mut ways = Vec::new();
    for (entry, _) in town.topology() {
        town.next(entry, 150.0, &mut ways);
        ways.truncate(100);
    }
    ways.iter().for_each(|way| {
        let pose = town.pose(*way);
        assert!(town.lane_width(*way) > -1e300 && pose.yaw.abs() <= 4.0);
        assert!(town.elevation(*way).abs() <= 1e300);
    });
    town.generate_waypoints(25.0);
    for filter in [LaneFilter::Any, LaneFilter::Driving, LaneFilter::Sidewalk] {
        town.nearest_lane(Point::new(40.0, 3.0), filter);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn other_values_never_panic(
        map in prop::sample::select(&MAPS[..]),
        edits in prop::collection::vec((0usize..400, prop::sample::select(vec![
            "", "nan", "inf", "1e308", "-1", "0", "1", "2", "3", "9", "0.5", "-1e9", "999999999", "1e6", "start", "end", "driving", "road", "junction", "é",
        ])), 1..6),
    ) {
        let mut parts: Vec<&str> = map.split('"').collect();
        let values = parts.len() / 2;
        for (place, value) in edits {
            parts[2 * (place % values) + 1] = value;
        }
        exercise(&parts.join("\""));
    }

    #[test]
    fn missing_and_doubled_lines_never_panic(map in prop::sample::select(&MAPS[..]), edits in prop::collection::vec((0usize..100, 0usize..100, any::<bool>()), 1..6)) {
        let mut lines: Vec<&str> = map.lines().collect();
        for (from, to, keep) in edits {
            let (from, to) = (from % lines.len(), to % lines.len());
            let line = lines[from];
            if keep {
                lines.insert(to, line);
            } else {
                lines.remove(from);
            }
        }
        exercise(&lines.join("\n"));
    }

    #[test]
    fn other_bytes_never_panic(map in prop::sample::select(&MAPS[..]), edits in prop::collection::vec((0usize..10_000, any::<char>()), 1..4)) {
        let mut text: Vec<char> = map.chars().collect();
        for (place, letter) in edits {
            let place = place % text.len();
            text[place] = letter;
        }
        exercise(&text.into_iter().collect::<String>());
    }
}

#[test]
fn crosswalks_are_polygons_in_the_world() {
    let corners =
        "<outline><cornerLocal u='-2' v='-1'/><cornerLocal u='2' v='-1'/><cornerLocal u='2' v='1'/></outline>";
    let along = "<outline><cornerRoad s='10' t='0'/><cornerRoad s='12' t='0'/><cornerRoad s='12' t='3'/></outline>";
    let xml = format!(
        "<OpenDRIVE><road id='1' length='100' junction='-1'><planView><geometry s='0' x='5' y='0' hdg='0' length='100'><line/>\
         </geometry></planView><lanes><laneSection s='0'><right><lane id='-1' type='driving'><width sOffset='0' a='3.5' b='0' \
         c='0' d='0'/></lane></right></laneSection></lanes><objects><object id='1' type='crosswalk' s='20' t='1' \
         hdg='1.5707963267948966'>{corners}</object><object id='2' name='Crosswalk_2' s='0' t='0'>{along}</object>\
         <object id='3' type='crosswalk' s='0'/></objects></road></OpenDRIVE>"
    );
    let parts = road::opendrive::read(&xml, "x").unwrap();
    assert_eq!(parts.crosswalks.len(), 2);
    let near =
        |corner: &road::geometry::Point, x: f64, y: f64| (corner - road::geometry::Point::new(x, y)).norm() < 1e-9;
    assert!(near(&parts.crosswalks[0][0], 26.0, -1.0) && near(&parts.crosswalks[0][1], 26.0, 3.0));
    assert!(near(&parts.crosswalks[1][2], 17.0, 3.0));
}

/// Lanes of changing widths on both sides of a line, an arc, a spiral and a cubic, with an offset and a slope.
const WIDTHS: &str = r#"<OpenDRIVE>
<road length="160" id="1" junction="-1">
<planView>
<geometry s="0" x="0" y="0" hdg="0.4" length="40"><line/></geometry>
<geometry s="40" x="36.842439760115404" y="15.576733692346022" hdg="0.4" length="40"><arc curvature="0.01"/></geometry>
<geometry s="80" x="69.37478024" y="38.6174106" hdg="0.8" length="40"><spiral curvStart="0.01" curvEnd="-0.01"/></geometry>
<geometry s="120" x="96" y="68" hdg="0.8" length="40"><paramPoly3 pRange="arcLength" aU="0" bU="1" cU="0" dU="0" aV="0" bV="0" cV="-0.002" dV="0"/></geometry>
</planView>
<elevationProfile><elevation s="0" a="1" b="0.02" c="0" d="0"/></elevationProfile>
<lanes><laneOffset s="0" a="0.5" b="0.01" c="0.0005" d="0"/>
<laneSection s="0">
<left><lane id="2" type="sidewalk"><link><successor id="2"/></link><width sOffset="0" a="2" b="-0.01" c="0" d="0"/></lane>
<lane id="1" type="driving"><link><successor id="1"/></link><width sOffset="0" a="3" b="0.02" c="0.0004" d="-0.000004"/></lane></left>
<right><lane id="-1" type="driving"><link><successor id="-1"/></link><width sOffset="0" a="3.5" b="0" c="0.001" d="-0.00001"/></lane>
<lane id="-2" type="driving"><link><successor id="-2"/></link><width sOffset="10" a="3" b="0.03" c="0" d="0"/></lane></right>
</laneSection>
<laneSection s="75">
<left><lane id="2" type="sidewalk"><link><predecessor id="2"/></link><border sOffset="0" a="6" b="0.02" c="0" d="0"/></lane>
<lane id="1" type="driving"><link><predecessor id="1"/></link><border sOffset="0" a="3" b="0.05" c="0" d="0"/></lane></left>
<right><lane id="-1" type="driving"><link><predecessor id="-1"/></link><width sOffset="0" a="3.5" b="-0.04" c="0" d="0"/></lane>
<lane id="-2" type="driving"><link><predecessor id="-2"/></link><width sOffset="0" a="3" b="0.05" c="0" d="0"/></lane></right>
</laneSection></lanes></road></OpenDRIVE>"#;

/// All lanes of a town, each with a place on it; `share` is the share of its length.
fn everywhere(town: &Town, share: f64) -> Vec<Waypoint> {
    let mut all = Vec::new();
    for (road, index) in town.roads.iter().zip(0..) {
        for (section, number) in road.sections.iter().zip(0..) {
            let s = section.start + share * (section.end - section.start);
            let lanes = section.lanes.iter().filter(|lane| lane.id != 0);
            all.extend(lanes.map(|lane| Waypoint { road: RoadIndex(index), section: number, lane: lane.id, s }));
        }
    }
    all
}

proptest! {
    /// CARLA adds the slope m of a centre to the heading of the reference line as if it were the angle, and ignores that a lane beside a
    /// bend is shorter or longer than the reference line. Both differ from the exact heading by a bounded amount.
    #[test]
    fn a_heading_is_that_of_the_centre_line(map in prop::sample::select(vec![BEND, BRIDGE, SECTIONS, FORMS, WIDTHS]), share in 0.01..0.99) {
        const STEP: f64 = 1e-4;
        let town = town(map);
        for at in everywhere(&town, share) {
            let forth = if at.lane < 0 { STEP } else { -STEP };
            let place = |s: f64| town.pose(Waypoint { s, ..at }).position();
            let along = place(at.s + forth) - place(at.s - forth);
            let line = &town.roads[at.road.0 as usize].plan_view;
            let turned = wrap_angle(line.pose(at.s + STEP).yaw - line.pose(at.s - STEP).yaw) / (2.0 * STEP);
            let off = (place(at.s) - line.pose(at.s).position()).norm();
            let (_, slope) = town.roads[at.road.0 as usize].lane_centre(at.section as usize, at.lane, at.s).unwrap();
            // Cubics are drawn with chords of about half a metre, which have the heading of their middle.
            let cubic = |piece: &Geometry| matches!(piece.shape, Shape::Poly3(_) | Shape::ParamPoly3 { .. });
            let drawn = if line.piece_at(at.s).is_some_and(cubic) { 0.4 * turned.abs() + 1e-3 } else { 1e-6 };
            let allowed = slope.abs().powi(3) + 2.0 * (slope * turned * off).abs() + drawn;
            let error = wrap_angle(town.pose(at).yaw - libm::atan2(along.y, along.x)).abs();
            prop_assert!(error <= allowed, "{at:?}: {error} rad, {allowed} are allowed");
        }
    }

    #[test]
    fn neighbours_are_mutual(map in prop::sample::select(vec![BEND, BRIDGE, SECTIONS, FORMS, WIDTHS]), share in 0.0..1.0) {
        let town = town(map);
        for at in everywhere(&town, share) {
            let same_way = |other: &Waypoint| other.lane.signum() == at.lane.signum();
            if let Some(right) = town.right_lane(at) {
                prop_assert_eq!(town.left_lane(right), Some(at));
            }
            if let Some(left) = town.left_lane(at) {
                let back = if same_way(&left) { town.right_lane(left) } else { town.left_lane(left) };
                prop_assert_eq!(back, Some(at));
            }
        }
    }

}

#[test]
fn the_order_at_a_fork_is_that_of_the_numbers_of_the_connections() {
    let connection = |id: u32, to: u32| {
        format!(
            r#"<connection id="{id}" incomingRoad="1" connectingRoad="{to}" contactPoint="start"><laneLink from="-1" to="-1"/></connection>"#
        )
    };
    let road = |id: u32, link: &str, junction: i32| {
        format!(
            r#"<road length="10" id="{id}" junction="{junction}">{link}<planView><geometry s="0" x="0" y="{id}" hdg="0" length="10"><line/></geometry></planView>
            <lanes><laneSection s="0"><right><lane id="-1" type="driving"><width a="3"/></lane></right></laneSection></lanes></road>"#
        )
    };
    let order = |numbers: [u32; 3]| {
        let link = r#"<link><successor elementType="junction" elementId="9"/></link>"#;
        let roads: String = (2..5).map(|id| road(id, "", 9)).collect();
        let connections: String = numbers.iter().zip(2..).map(|(number, to)| connection(*number, to)).collect();
        let town = town(&format!(
            r#"<OpenDRIVE>{}{roads}<junction id="9">{connections}</junction></OpenDRIVE>"#,
            road(1, link, -1)
        ));
        ahead(&town, eastbound(9.0), 2.0).iter().map(|to| town.roads[to.road.0 as usize].id).collect::<Vec<_>>()
    };
    assert_eq!(order([0, 1, 2]), [4, 3, 2]);
    // 0, 13 and 26 share a bucket of a table of 13.
    assert_eq!(order([0, 13, 1]), [4, 3, 2]);
    assert_eq!(order([1, 14, 0]), [4, 3, 2]);
    assert_eq!(order([13, 1, 0]), [3, 4, 2]);
    assert_eq!(order([13, 1, 26]), [3, 4, 2]);
    // Two of the same number: their places count.
    assert_eq!(order([7, 7, 1]), [4, 3, 2]);
}

#[test]
fn a_right_lane_without_a_link_goes_on_in_the_next_section_and_a_left_one_ends() {
    let town = town(&SECTIONS.replace(
        r#"<lane id="-1" type="driving"><link><successor id="0"/></link>"#,
        r#"<lane id="-1" type="driving">"#,
    ));
    let after = |section, lane, s| ahead(&town, Waypoint { section, lane, ..eastbound(s) }, 20.0);
    assert_eq!(after(2, -1, 50.0).iter().map(|way| (way.section, way.lane)).collect::<Vec<_>>(), [(3, -1)]);
    let left = SECTIONS.replace(
        r#"<laneSection s="30"><right>"#,
        r#"<laneSection s="30"><left><lane id="1" type="driving"><width a="3"/></lane></left><right>"#,
    );
    let town = self::town(&left);
    let way = Waypoint { section: 2, lane: 1, ..eastbound(35.0) };
    assert!(ahead(&town, way, 10.0).is_empty());
}

#[test]
fn junctions_are_linked_by_their_lanes_as_in_carla() {
    // The incoming roads and the lane links of the connections lead nowhere; the links of the connecting road's lanes count.
    let xml = BEND.replace(r#"incomingRoad="1" connectingRoad="2""#, r#"incomingRoad="3" connectingRoad="2""#);
    let town = town(&xml.replace(r#"<laneLink from="-1" to="-1"/>"#, r#"<laneLink from="-7" to="-7"/>"#));
    let ways = ahead(&town, eastbound(99.0), 2.0);
    assert!(ways.len() == 2 && ways.iter().all(|way| (way.road, way.lane) == (RoadIndex(1), -1)), "{ways:?}");
}

#[test]
fn what_has_no_effect_is_counted() {
    let signs = r#"<signals><signal id="1" s="5" t="-3" type="294"/><signal id="2" s="6" t="-3" type="294"/><signal id="3" s="6" type="1000002"/>
        <signal id="4" s="9" t="-3" type="206"><validity fromLane="0" toLane="0"/></signal>
        <signal id="8" s="7" orientation="+" type="274" value="50"><validity fromLane="9" toLane="9"/></signal></signals></road>"#;
    let map = BEND.replace("<planView>", r#"<type s="0" type="town"><speed max="50" unit="km/h"/></type><planView>"#);
    let map = map.replace("</objects>\n</road>", &format!("</objects>{signs}"));
    let parts = read(&map, "signs").unwrap();
    let said: Vec<String> = parts.warnings.iter().map(|warning| warning.problem.to_string()).collect();
    assert!(said.contains(&"not used: 2 × stop line (signal type 294)".to_owned()), "{said:?}");
    assert!(said.contains(&"not used: 1 × light for pedestrians (signal type 1000002)".to_owned()), "{said:?}");
    assert!(said.contains(&"not used: 1 × speed sign beside no driving lane".to_owned()), "{said:?}");
    assert!(said.contains(&"not used: 1 × stop sign beside no driving lane".to_owned()), "{said:?}");
    assert!(
        said.contains(&"not used: 3 × speed limit of a road type, since CARLA's signs count".to_owned()),
        "CARLA's maps are driven by their `Speed_NN` objects: {said:?}"
    );
    assert!(parts.warnings.iter().all(|warning| warning.problem.is_unused()));
}

#[test]
fn references_repeat_the_last_signal_of_a_number() {
    let map = |name: &str| read(&BEND.replace("Speed_30", name), "signs").unwrap().speed_signs.len();
    assert_eq!((map("speed_30"), map("Speed_30"), map("SPEED_30")), (1, 1, 0));
    let signals = r#"<signals><signal id="1" s="5" orientation="-" type="274" subtype="30"/><signal id="1" s="60" orientation="-" type="274" subtype="60"/></signals></road>"#;
    let map = BEND.replace("</objects>\n</road>", &format!("</objects>{signals}"));
    let map =
        map.replacen("</signals>\n</road>", r#"<signalReference id="1" s="3" orientation="+"/></signals></road>"#, 1);
    let limits: Vec<f64> =
        read(&map, "signs").unwrap().speed_signs.iter().map(|sign| (sign.limit * 3.6).round()).collect();
    assert_eq!(limits, [30.0, 30.0, 60.0, 60.0]);
}
