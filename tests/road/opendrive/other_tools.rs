//! What maps of other tools mean by the standard, and what is named because it cannot be used.

use super::{BEND, eastbound, town};
use road::geometry::Point;
use road::opendrive::{Addition, insert, read};
use road::{Crosswalk, LaneKind, TownParts};

/// A lane of each direction, 3.5 m wide.
const LANES: &str = r#"<left><lane id="1" type="driving"><width a="3.5"/></lane></left><right><lane id="-1" type="driving"><width a="3.5"/></lane></right>"#;

/// A straight road of 300 m to the east from the origin, with these attributes, lanes, and parts after the lanes.
fn road(attributes: &str, lanes: &str, parts: &str) -> String {
    format!(
        r#"<road {attributes} junction="-1"><planView><geometry s="0" x="0" y="0" hdg="0" length="300"><line/></geometry></planView><lanes><laneSection s="0">{lanes}</laneSection></lanes>{parts}</road>"#
    )
}

fn map(roads: &str) -> String {
    format!(r#"<OpenDRIVE><header revMajor="1" revMinor="6"/>{roads}</OpenDRIVE>"#)
}

fn parts(map: &str) -> TownParts {
    read(map, "map").unwrap()
}

fn warnings(map: &str) -> Vec<String> {
    parts(map).warnings.iter().map(|warning| warning.problem.to_string()).collect()
}

fn with_signals(attributes: &str, signals: &str) -> String {
    map(&road(&format!(r#"id="1" length="300" {attributes}"#), LANES, &format!("<signals>{signals}</signals>")))
}

/// The places at which lights stop cars, to the metre: x, y, and whether eastbound cars.
fn stops(map: &str) -> Vec<(f64, f64, bool)> {
    let lights = parts(map).traffic_lights;
    let each = lights.iter().map(|light| (light.stop.x.round(), light.stop.y, light.stop.yaw.abs() < 1.0));
    each.collect()
}

#[test]
fn an_orientation_without_a_validity_is_the_direction_of_traffic() {
    let light = |attributes: &str, s: u32, orientation: &str| {
        let signal = format!(r#"<signal id="7" type="1000001" dynamic="yes" s="{s}" t="-4" {orientation}/>"#);
        stops(&with_signals(attributes, &signal))
    };
    let (plus, minus) = (r#"orientation="+""#, r#"orientation="-""#);
    assert_eq!(light("", 297, plus), [(297.0, -1.75, true)]);
    assert_eq!(light("", 3, minus), [(3.0, 1.75, false)]);
    assert_eq!(light("", 297, "").len(), 2);
    assert_eq!(light("", 297, r#"orientation="none""#).len(), 2);
    // Traffic on the left drives along the reference line on the left lanes.
    assert_eq!(light(r#"rule="LHT""#, 297, plus), [(297.0, 1.75, true)]);
    assert_eq!(light(r#"rule="LHT""#, 3, minus), [(3.0, -1.75, false)]);
    // One far before the end of its lane stops cars where it stands.
    assert_eq!(light("", 120, plus), [(120.0, -1.75, true)]);
    assert_eq!(light("", 120, minus), [(120.0, 1.75, false)]);
}

#[test]
fn an_orientation_is_the_side_of_the_lanes_in_maps_of_carlas_editor() {
    let light = r#"<signal id="7" type="1000001" dynamic="yes" s="120" t="-4" orientation="-"/>"#;
    let of_carla = with_signals("", light).replace("<header", r#"<header vendor="VectorZero""#);
    assert_eq!(stops(&of_carla), [(297.0, -1.75, true)]);
    // A validity says it in both.
    let valid = with_signals("", &light.replace("/>", r#"><validity fromLane="1" toLane="1"/></signal>"#));
    assert_eq!(stops(&valid), [(120.0, 1.75, false)]);
}

#[test]
fn signs_follow_their_orientation() {
    let sign = |kind: &str, t: i32, orientation: &str| {
        with_signals("", &format!(r#"<signal id="7" type="{kind}" value="50" s="100" t="{t}" {orientation}/>"#))
    };
    let lanes = |map: &str| parts(map).give_way_signs.iter().map(|sign| sign.line.lane).collect::<Vec<_>>();
    for kind in ["205", "206"] {
        assert_eq!(lanes(&sign(kind, -4, r#"orientation="+""#)), [-1]);
        assert_eq!(lanes(&sign(kind, 4, r#"orientation="+""#)), [-1], "a sign across the road");
        assert_eq!(lanes(&sign(kind, 4, r#"orientation="-""#)), [1]);
        assert_eq!(lanes(&sign(kind, 4, "")), [1], "without an orientation its side counts");
    }
    let limit = |orientation: &str| parts(&sign("274", -4, orientation)).speed_signs[0].trigger.pose.y;
    assert_eq!((limit(r#"orientation="+""#), limit(r#"orientation="-""#)), (-1.75, 1.75));
}

#[test]
fn signals_with_one_id_count_where_they_stand() {
    let signals = r#"<signal id="0" s="120" t="-5" orientation="+" type="274" value="60" unit="km/h"/>
        <signal id="0" s="290" t="-5" orientation="+" type="1000001" dynamic="yes"/><signal id="0" s="200" t="-5" orientation="+" type="206"/>
        <signal s="3" t="5" orientation="-" type="1000001" dynamic="yes"/><signalReference id="9" s="5" t="0" orientation="+"/>"#;
    let found = parts(&with_signals("", signals));
    let [sign] = &found.speed_signs[..] else { panic!("{:?}", found.speed_signs) };
    assert!((sign.limit * 3.6 - 60.0).abs() < 1e-9 && sign.trigger.pose.y == -1.75);
    assert_eq!((found.traffic_lights.len(), found.give_way_signs.len()), (2, 1));
    let said = warnings(&with_signals("", signals));
    let repeated = "3 signals have the id `0`; each counts where it stands, and references take the last one";
    assert!(said.iter().any(|warning| warning == repeated), "{said:?}");
    assert!(said.iter().any(|warning| warning.contains("`signalReference` refers to 9")), "{said:?}");
}

#[test]
fn the_value_and_unit_of_a_speed_sign_come_before_its_subtype() {
    let kmh = |sign: &str| {
        let signal = format!(r#"<signal id="7" type="274" s="50" t="-5" orientation="+" {sign}/>"#);
        parts(&with_signals("", &signal)).speed_signs.first().map(|sign| (sign.limit * 36.0).round() / 10.0)
    };
    for (sign, limit) in [
        (r#"subtype="57" value="70" unit="km/h""#, Some(70.0)),
        (r#"subtype="57" value="-1""#, Some(70.0)),
        (r#"subtype="50" value="-1.0e+0""#, Some(50.0)),
        (r#"subtype="-1" value="30" unit="mph""#, Some(48.3)),
        (r#"subtype="50" value="13.89" unit="m/s""#, Some(50.0)),
        (r#"value="60""#, Some(60.0)),
        (r#"value="60" unit="""#, Some(60.0)),
        (r#"subtype="30" value="60" unit="knots""#, None),
        (r#"subtype="-1""#, None),
    ] {
        assert_eq!(kmh(sign), limit, "{sign}");
    }
    let said = |sign: &str| {
        let signal = format!(r#"<signal id="7" type="274" s="50" t="-5" orientation="+" {sign}/>"#);
        (kmh(sign), warnings(&with_signals("", &signal)).into_iter().next().unwrap_or_default())
    };
    let bad =
        |value: &str, rest: &str| format!("the `value` of the speed sign is `{value}`, not a usable number{rest}");
    let comma = bad("30,0", ": decimals are written with a point; its `subtype`, 70 km/h, is taken");
    assert_eq!(said(r#"subtype="57" value="30,0" unit="km/h""#), (Some(70.0), comma));
    for value in ["30 km/h", "0", "-30", "nan", "1e9"] {
        let (with, without) = (format!(r#"subtype="50" value="{value}""#), format!(r#"subtype="-1" value="{value}""#));
        assert_eq!(said(&with), (Some(50.0), bad(value, "; its `subtype`, 50 km/h, is taken")));
        assert_eq!(said(&without), (None, bad(value, "; the sign is skipped")));
    }
    assert_eq!(said(r#"subtype="50" value="-1""#), (Some(50.0), String::new()));
    let knots = with_signals("", r#"<signal id="7" type="274" s="50" t="-5" value="60" unit="knots"/>"#);
    assert!(warnings(&knots)[0].starts_with("the unit `knots` of a speed limit"), "{:?}", warnings(&knots));
}

#[test]
fn limits_below_ten_kilometres_an_hour_are_named() {
    let low = |limit: &str, count: u32| format!("a limit of {limit} km/h, {count} times: is its unit right?");
    let lane = |speed: &str| {
        let lanes = LANES.replace("</lane>", &format!("<speed {speed}/></lane>"));
        warnings(&map(&road(r#"id="1" length="300""#, &lanes, "")))
    };
    assert_eq!(lane(r#"max="8.33" unit="km/h""#), [low("8.3", 2)]);
    assert_eq!(lane(r#"max="2.5""#), [low("9.0", 2)]);
    assert_eq!(lane(r#"max="5" unit="mph""#), [low("8.0", 2)]);
    assert_eq!(lane(r#"max="10" unit="km/h""#), [""; 0]);
    let of_type = r#"<type s="0" type="town"><speed max="5" unit="km/h"/></type><planView>"#;
    assert_eq!(warnings(&with_signals("", "").replace("<planView>", of_type)), [low("5.0", 1)]);
    let sign = with_signals("", r#"<signal id="7" type="274" s="50" t="-5" value="5" unit="km/h"/>"#);
    assert_eq!(warnings(&sign), [low("5.0", 1)]);
}

#[test]
fn a_road_ends_where_its_geometry_ends() {
    let of_length = |length: &str| map(&road(&format!(r#"id="1" length="{length}""#), LANES, ""));
    let long = parts(&of_length("800"));
    assert_eq!((long.roads[0].length, long.roads[0].sections[0].end), (300.0, 300.0));
    let said = |length: &str| warnings(&of_length(length));
    assert_eq!(said("800"), ["the road is 800 m long, and its geometry ends at 300 m; the shorter one counts"]);
    assert_eq!(said("250"), ["the road is 250 m long, and its geometry ends at 300 m; the shorter one counts"]);
    assert_eq!(parts(&of_length("250")).roads[0].length, 250.0);
    // A rounded length is kept.
    assert_eq!((said("300.05").len(), parts(&of_length("300.05")).roads[0].length), (0, 300.05));
    let gap = of_length("300")
        .replace(r#"s="0" x="0""#, r#"s="40" x="40""#)
        .replace(r#"length="300"><line"#, r#"length="260"><line"#);
    assert_eq!(warnings(&gap), ["no geometry between 0 m and 40 m; there are no lanes there"]);
}

#[test]
fn a_crosswalk_without_an_outline_is_a_box() {
    let corners = |object: &str| {
        let objects = format!(r#"<objects><object id="1" type="crosswalk" s="150" {object}/></objects>"#);
        parts(&map(&road(r#"id="1" length="300""#, LANES, &objects))).crosswalks
    };
    let near = |found: &[Crosswalk], wanted: [(f64, f64); 4]| {
        assert_eq!(found.len(), 1);
        for (corner, (x, y)) in found[0].iter().zip(wanted) {
            assert!((corner - Point::new(x, y)).norm() < 1e-6, "{found:?}");
        }
    };
    near(&corners(r#"t="0" length="4" width="7" hdg="0""#), [(148.0, -3.5), (152.0, -3.5), (152.0, 3.5), (148.0, 3.5)]);
    let turned = corners(r#"t="1" length="7" width="4" hdg="1.5707963267948966""#);
    near(&turned, [(152.0, -2.5), (152.0, 4.5), (148.0, 4.5), (148.0, -2.5)]);
    let sizeless = r#"<objects><object id="1" type="crosswalk" s="9" t="0"/></objects>"#;
    let said = warnings(&map(&road(r#"id="1" length="300""#, LANES, sizeless)));
    assert_eq!(said, ["not used: 1 × crosswalk without an outline, or less than 1 m long or wide"]);
}

/// A junction of this type in which a road of 11 m with a lane for walking crosses that of the town; `parts` are in its road.
fn crossed(kind: &str, crossing: &str, parts: &str) -> String {
    let lanes = r#"<left><lane id="1" type="driving"><width a="3.5"/></lane><lane id="2" type="sidewalk"><width a="2"/></lane></left><right><lane id="-1" type="driving"><width a="3.5"/></lane><lane id="-2" type="walking"><width a="2"/></lane></right>"#;
    let path = format!(
        r#"<road id="7" length="11" junction="9"><planView><geometry s="0" x="110" y="-5.5" hdg="1.5707963267948966" length="11"><line/></geometry></planView><lanes><laneSection s="0"><right><lane id="-1" type="{crossing}"><width a="4"/></lane></right></laneSection></lanes></road>"#
    );
    let junction = format!(
        r#"<junction id="9" {kind}><crossPath id="1" crossingRoad="7" roadAtStart="1" roadAtEnd="1"><startLaneLink s="110" from="-2" to="-1"/><endLaneLink s="110" from="2" to="-1"/></crossPath></junction>"#
    );
    map(&format!("{}{path}{junction}", road(r#"id="1" length="300""#, lanes, parts)))
}

#[test]
fn a_crossing_road_is_a_crosswalk_between_the_sidewalks() {
    for kind in ["", r#"type="default""#, r#"type="virtual" mainRoad="1" sStart="105" sEnd="120""#] {
        let found = parts(&crossed(kind, "walking", ""));
        assert_eq!(found.warnings, [], "{kind}");
        let [walk] = &found.crosswalks[..] else { panic!("{:?}", found.crosswalks) };
        let (low, high) = walk.iter().fold((walk[0], walk[0]), |(low, high), at| (low.inf(at), high.sup(at)));
        assert!((low - Point::new(110.0, -3.5)).norm() < 1e-6 && (high - Point::new(114.0, 3.5)).norm() < 1e-6);
        // Its lane is no sidewalk.
        assert_eq!(found.roads[1].sections[0].lanes[0].kind, LaneKind::None);
    }
    // An object that marks the same crosswalk does not make a second one.
    let marked = r#"<objects><object id="1" type="crosswalk" s="112" t="0" length="4" width="7" hdg="0"/></objects>"#;
    assert_eq!(parts(&crossed("", "walking", marked)).crosswalks.len(), 1);
    let said = warnings(&crossed("", "biking", ""));
    assert_eq!(said, ["not used: 1 × crossPath of a road without a lane of type walking"]);
}

#[test]
fn of_two_lane_sections_at_one_place_the_first_holds_nowhere() {
    let section = |s: u32, lanes: &str| format!(r#"<laneSection s="{s}">{lanes}</laneSection>"#);
    let read = |sections: &str| {
        let whole = map(&road(r#"id="1" length="300""#, LANES, ""));
        parts(&whole.replace(&section(0, LANES), sections))
    };
    let (left, right) = LANES.split_once("<right>").unwrap();
    let (left, right) = (section(0, left), section(0, &format!("<right>{right}")));
    let lanes = |sections: &str| {
        let found = read(sections);
        let all = found.roads[0]
            .sections
            .iter()
            .flat_map(|each| each.lanes.iter().map(move |lane| (lane.id, each.end - each.start)));
        (all.collect::<Vec<_>>(), found.warnings.len())
    };
    let both = (vec![(1, 300.0), (-1, 300.0)], 0);
    assert_eq!(lanes(&section(0, LANES)), both);
    // The sides of a road may have sections of their own.
    assert_eq!(lanes(&format!("{left}{right}")), both);
    assert_eq!(lanes(&section(0, LANES).repeat(2)), (both.0.clone(), 1));
    assert_eq!(lanes(&format!("{}{right}", section(0, LANES))), (both.0, 1));
    let said = read(&section(0, LANES).repeat(2)).warnings[0].problem.to_string();
    assert_eq!(said, "two lane sections begin at 0 m; the first one has no length, and the second one counts");
}

#[test]
fn lanes_for_cars_that_no_car_uses_are_named() {
    let of_type = |kind: &str| {
        let lanes = format!(r#"{LANES}<right><lane id="-2" type="{kind}"><width a="3.5"/></lane></right>"#);
        parts(&map(&road(r#"id="1" length="300""#, &lanes, "")))
    };
    for kind in
        ["bidirectional", "entry", "exit", "mwyEntry", "mwyExit", "onRamp", "offRamp", "connectingRamp", "slipLane"]
    {
        let found = of_type(kind);
        let said: Vec<String> = found.warnings.iter().map(|warning| warning.problem.to_string()).collect();
        assert_eq!(said, [format!("cars do not drive on 1 × lane of type {kind}")]);
        assert!(!found.warnings[0].problem.is_unused(), "`check` names it");
    }
    assert!(of_type("shoulder").warnings.is_empty());
}

#[test]
fn lanes_that_deny_cars_are_not_driven() {
    let kind = |access: &str| {
        let lanes =
            LANES.replace(r#"<width a="3.5"/></lane></right>"#, &format!(r#"<width a="3.5"/>{access}</lane></right>"#));
        let found = parts(&map(&road(r#"id="1" length="300""#, &lanes, "")));
        let lane = found.roads[0].sections[0].lane(-1).unwrap().kind;
        assert_eq!(found.warnings.len(), usize::from(lane != LaneKind::Driving), "{:?}", found.warnings);
        lane
    };
    let (driving, reserved) = (LaneKind::Driving, LaneKind::Special);
    for (access, wanted) in [
        (r#"<access sOffset="0" restriction="passengerCar"/>"#, reserved),
        (r#"<access sOffset="0" rule="deny" restriction="passengerCar"/>"#, reserved),
        (r#"<access sOffset="0" rule="deny" restriction="autonomousTraffic"/>"#, reserved),
        (r#"<access sOffset="0" rule="allow" restriction="bus"/>"#, reserved),
        (r#"<access rule="deny"><restriction type="bus"/><restriction type="passengerCar"/></access>"#, reserved),
        (r#"<access rule="allow" restriction="bus"/><access rule="allow" restriction="passengerCar"/>"#, driving),
        (r#"<access sOffset="0" rule="deny" restriction="truck"/>"#, driving),
        (r#"<access sOffset="0" restriction="pedestrian"/>"#, driving),
        ("", driving),
    ] {
        assert_eq!(kind(access), wanted, "{access}");
    }
}

/// Each sentence says what is wrong and what is taken; the last column is what counts.
#[test]
fn words_that_the_standard_does_not_have_are_named() {
    let lane = |access: &str| {
        let lanes =
            LANES.replace(r#"<width a="3.5"/></lane></right>"#, &format!(r#"<width a="3.5"/>{access}</lane></right>"#));
        map(&road(r#"id="1" length="300""#, &lanes, ""))
    };
    let unknown = |what: &str, taken: &str| format!("{what}, a word that the standard does not have: {taken}");
    for (access, said, driven) in [
        (
            r#"<access rule="deny" restriction="cars"/>"#,
            ("`restriction` of `access` is `cars`", "it is taken for no car"),
            true,
        ),
        (
            r#"<access rule="allow"><restriction type="auto"/></access>"#,
            ("`type` of `restriction` is `auto`", "it is taken for no car"),
            false,
        ),
        (
            r#"<access rule="forbid" restriction="passengerCar"/>"#,
            ("`rule` of `access` is `forbid`", "`deny` is taken"),
            false,
        ),
    ] {
        let map = lane(access);
        assert!(warnings(&map).contains(&unknown(said.0, said.1)), "{access}: {:?}", warnings(&map));
        let kind = parts(&map).roads[0].sections[0].lane(-1).unwrap().kind;
        assert_eq!(kind == LaneKind::Driving, driven, "{access}");
    }
    let deny = r#"<access rule="deny" restriction="autonomous traffic"/>"#;
    assert_eq!(warnings(&lane(deny)), ["cars do not drive on 1 × lane of type driving whose `access` denies cars"]);
    for rule in ["left", "links", ""] {
        let found = parts(&with_signals(&format!(r#"rule="{rule}""#), ""));
        assert!(!found.roads[0].left_hand);
        let said = unknown(&format!("`rule` of `road` is `{rule}`"), "traffic keeps to the right, as by `RHT`");
        assert_eq!(found.warnings[0].problem.to_string(), said);
    }
    assert!(parts(&with_signals(r#"rule="lht""#, "")).roads[0].left_hand);
    let light = r#"<signal id="7" type="1000001" dynamic="yes" s="297" t="-4" orientation="1"/>"#;
    assert_eq!(stops(&with_signals("", light)).len(), 2);
    let said = unknown("`orientation` of `signal` is `1`", "it counts in both directions");
    assert_eq!(warnings(&with_signals("", light)), [said]);
}

/// A light that stops no car is named, whatever the reason, unless a reference puts it where it does.
#[test]
fn a_light_beside_no_driving_lane_is_named() {
    let one_way = LANES.split("</left>").nth(1).unwrap();
    let walk = r#"<right><lane id="-1" type="driving"><width a="3.5"/></lane><lane id="-2" type="sidewalk"><width a="2"/></lane></right>"#;
    let light = |lanes: &str, at: &str, more: &str| {
        let signals = format!(
            r#"<signals><signal id="L7" type="1000001" dynamic="yes" s="290" t="-4" {at}</signal>{more}</signals>"#
        );
        let map = map(&road(r#"id="1" length="300""#, lanes, &signals));
        (parts(&map).traffic_lights.len(), warnings(&map))
    };
    let lost = (0, vec!["not used: 1 × traffic light L7 beside no driving lane".to_owned()]);
    assert_eq!(light(one_way, r#"orientation="-">"#, ""), lost);
    assert_eq!(light(one_way, r#"orientation="+">"#, ""), (1, vec![]));
    assert_eq!(light(LANES, r#"orientation="+"><validity fromLane="3" toLane="5"/>"#, ""), lost);
    assert_eq!(light(LANES, r#"orientation="+"><validity fromLane="0" toLane="0"/>"#, ""), lost);
    assert_eq!(light(walk, r#"orientation="+"><validity fromLane="-2" toLane="-2"/>"#, ""), lost);
    let reference = r#"<signalReference id="L7" s="290" t="0" orientation="+"/>"#;
    assert_eq!(light(LANES, r#"orientation="+"><validity fromLane="0" toLane="0"/>"#, reference), (1, vec![]));
}

#[test]
fn a_road_without_lanes_at_its_start_says_so() {
    let late = map(&road(r#"id="1" length="300""#, LANES, "")).replace(r#"laneSection s="0""#, r#"laneSection s="50""#);
    assert_eq!(warnings(&late), ["the first lane section begins at 50 m; there are no lanes before it"]);
    let found = parts(&late);
    let drawn: Vec<_> = found.roads[0].sections.iter().map(|part| (part.start, part.end, part.lanes.len())).collect();
    assert_eq!(drawn, [(0.0, 50.0, 0), (50.0, 300.0, 2)]);
    let town = town(&late);
    let driving = |x: f64| town.nearest_lane(Point::new(x, -1.75), road::LaneFilter::Driving).unwrap().s;
    assert_eq!((driving(20.0), driving(120.0)), (50.0, 120.0));
}

/// A text that is cut short has its end as the place of the error.
#[test]
fn a_cut_file_says_where_it_ends() {
    for cut in [5, BEND.len() / 2, BEND.len() - 12, BEND.len() - 4] {
        let text = &BEND[..cut];
        let error = read(text, "map").unwrap_err().to_string();
        let column = 1 + text.rsplit('\n').next().unwrap().len();
        let place = format!("(line {}, column {column})", 1 + text.matches('\n').count());
        assert!(error.ends_with(&place), "{cut}: {error}");
    }
}

#[test]
fn other_ids_get_free_numbers() {
    let roads = |ids: &[&str]| {
        let roads: String = ids.iter().map(|id| road(&format!(r#"id="{id}" length="300""#), LANES, "")).collect();
        map(&roads)
    };
    let numbers = |ids: &[&str]| parts(&roads(ids)).roads.iter().map(|road| road.id).collect::<Vec<_>>();
    assert_eq!(numbers(&["West", "Ost", "0"]), [1, 2, 0]);
    assert_eq!(numbers(&["12345678901234567890", "1", "01", "-3", "0"]), [2, 1, 3, 4, 0]);
    assert_eq!(numbers(&["01", "1", " 1"]), [0, 1, 2], "the one that is written as the number has it");
    assert_eq!(numbers(&["01", "7"]), [1, 7]);
    let said = warnings(&roads(&["West", "0"]));
    assert_eq!(said, ["the id `West` is not a number below 2^32 that it has alone; the free number 1 stands for it"]);
    let inside = |id: &str| {
        road(&format!(r#"id="{id}" length="300""#), LANES, "")
            .replace(r#"junction="-1""#, &format!(r#"junction="{id}""#))
    };
    let junctions = format!(r#"{}{}<junction id="north"/><junction id="0"/>"#, inside("0"), inside("north"));
    let found: Vec<u32> = parts(&map(&junctions)).junctions.iter().map(|junction| junction.id).collect();
    assert_eq!(found, [1, 0]);
    // What is added to a road of a text id stands on that road.
    let added = Addition { objects: "<object id=\"new\"/>\n".to_owned(), signals: String::new() };
    let text = insert(&roads(&["West", "0"]), &std::iter::once((1, added)).collect()).unwrap();
    assert!(text.find("new").unwrap() < text.find(r#"<road id="0""#).unwrap());
}

#[test]
fn the_smallest_whole_number_is_no_id_of_a_lane() {
    for id in ["-2147483648", "2147483647", "99999999999"] {
        let found = parts(&BEND.replace(r#"<lane id="2""#, &format!(r#"<lane id="{id}""#)));
        assert_eq!(found.roads[0].sections[0].lanes.len(), 3, "{id}");
        let said = format!("`id` of `lane` is `{id}`, not a usable number; skipped");
        assert!(found.warnings.iter().any(|warning| warning.problem.to_string() == said), "{:?}", found.warnings);
    }
    let town = town(&BEND.replace(r#"<predecessor id="-1"/>"#, r#"<predecessor id="-2147483648"/>"#));
    assert!(town.nearest_lane(Point::new(30.0, -2.0), road::LaneFilter::Driving) == Some(eastbound(30.0)));
}

#[test]
fn a_map_without_a_usable_road_says_why() {
    let error = |map: &str| read(map, "map").unwrap_err().to_string();
    let comma = map(&road(r#"id="1" length="300,0""#, LANES, "")).replace(r#"length="300">"#, r#"length="300,0">"#);
    assert_eq!(
        error(&comma),
        "no usable road among 1: line 1, road 1: `length` of `geometry` is `300,0`, not a usable number: decimals are written with a point; skipped"
    );
    let bare = map(&road(r#"id="1" length="300""#, LANES, "")).replace("laneSection", "section");
    assert_eq!(error(&bare), "no usable road among 1: line 1, road 1: no lane section; the road is left out");
    assert_eq!(error("<OpenDRIVE/>"), "no usable road among 0");
}

/// A road whose geometries are those of a list: s, x and length.
fn drawn(geometries: &[(f64, f64, f64)]) -> String {
    let pieces: String = geometries
        .iter()
        .map(|(s, x, length)| {
            format!(r#"<geometry s="{s}" x="{x}" y="0" hdg="0" length="{length}"><line/></geometry>"#)
        })
        .collect();
    map(&format!(
        r#"<road id="1" length="300" junction="-1"><planView>{pieces}</planView><lanes><laneSection s="0">{LANES}</laneSection></lanes></road>"#
    ))
}

#[test]
fn leaps_overlaps_and_gaps_of_geometries_are_named() {
    assert_eq!(warnings(&drawn(&[(0.0, 0.0, 100.0), (100.0, 100.05, 200.0)])), [""; 0]);
    assert_eq!(
        warnings(&drawn(&[(0.0, 0.0, 100.0), (100.0, 150.0, 200.0)])),
        [
            "the reference line jumps by 50 m at 100 m, where a geometry should begin at the end of the one before; drawn as given"
        ]
    );
    assert_eq!(
        warnings(&drawn(&[(0.0, 0.0, 150.0), (100.0, 100.0, 200.0)])),
        ["two geometries between 100 m and 150 m; the later one counts"]
    );
    let turned = |heading: &str| {
        let map = drawn(&[(0.0, 0.0, 100.0), (100.0, 100.0, 200.0)]);
        warnings(&map.replace(r#"x="100" y="0" hdg="0""#, &format!(r#"x="100" y="0" hdg="{heading}""#)))
    };
    assert_eq!(turned("0.3"), [""; 0], "a polyline of a bend");
    assert_eq!(
        turned("0.6"),
        [
            "the reference line turns by 34° at 100 m, where a geometry should begin in the direction in which the one before ends; drawn as given"
        ]
    );
    assert!(turned("90")[0].starts_with("the heading is 90 rad, more than two full turns: is it in degrees?"));
    let arc = |curvature: &str| {
        let arc = format!(r#"length="10"><arc curvature="{curvature}"/>"#);
        warnings(&drawn(&[(0.0, 0.0, 290.0), (290.0, 290.0, 10.0)]).replace(r#"length="10"><line/>"#, &arc))
    };
    assert_eq!(arc("0.5"), [""; 0], "a radius of 2 m is more than half a lane");
    assert_eq!(
        arc("1"),
        [
            "the bend at 290 m has a radius of 1 m, and the centre of lane 1 is farther inside it: cars drive backwards there"
        ]
    );
    let gap = drawn(&[(0.0, 0.0, 100.0), (200.0, 200.0, 100.0)]);
    assert_eq!(warnings(&gap), ["no geometry between 100 m and 200 m; there are no lanes there"]);
    // A car starts on one of the two parts that are drawn, and the first one ends at the gap.
    let town = town(&gap);
    let length: f64 = town.driving_lanes().iter().map(|stretch| stretch.length).sum();
    assert!((length - 400.0).abs() < 1e-9, "{length} m");
    assert!(town.successors(eastbound(90.0)).next().is_none());
}

#[test]
fn lanes_that_break_the_rules_of_the_standard_are_named() {
    let of_lanes = |lanes: &str| warnings(&map(&road(r#"id="1" length="300""#, lanes, "")));
    let right = |lanes: &str| of_lanes(&format!("<right>{lanes}</right>"));
    let lane = |id: i32, rest: &str| format!(r#"<lane id="{id}" type="driving" {rest}<width a="3.5"/></lane>"#);
    assert_eq!(right(&(lane(-1, ">") + &lane(-2, r#"direction="standard">"#))), [""; 0]);
    for direction in ["reversed", "both"] {
        let rest = format!(r#"direction="{direction}">"#);
        assert_eq!(
            right(&(lane(-1, ">") + &lane(-2, &rest))),
            [format!("cars do not drive on 1 × lane of type driving whose `direction` is `{direction}`")]
        );
    }
    assert_eq!(
        right(r#"<lane id="-1" type="driving"><width sOffset="20" a="3.5"/></lane>"#),
        [
            "lane -1 has no width up to 20 m from the start of its section, where the standard wants one; the first one applies there, too"
        ]
    );
    assert_eq!(
        right(r#"<lane id="-1" type="driving"><width a="3.5" b="-0.02"/></lane>"#),
        ["lane -1 is -2.5 m wide at 300 m, less than 0; no car starts there, and the lanes beyond it overlap others"]
    );
    assert_eq!(
        right(&(lane(-1, ">") + &lane(-3, ">"))),
        ["lane -3 follows on lane -1, and the ids of a side have no gaps; they lie side by side"]
    );
    assert_eq!(
        right(&(lane(-1, ">") + &lane(1, ">"))),
        ["lane 1 is in `right`; ids are above 0 on the left and below 0 on the right. Its id counts"]
    );
}

#[test]
fn crosswalks_beyond_the_road_are_named_and_repeated_ones_are_repeated() {
    let with = |object: &str| map(&road(r#"id="1" length="300""#, LANES, &format!("<objects>{object}</objects>")));
    let crosswalk = |rest: &str, parts: &str| {
        with(&format!(r#"<object id="1" type="crosswalk" length="4" width="7" {rest}>{parts}</object>"#))
    };
    assert_eq!(
        warnings(&crosswalk(r#"s="500" t="0""#, "")),
        ["`object` is at 500 m, and its road is 300 m long; it counts at the nearer end"]
    );
    assert_eq!(
        warnings(&crosswalk(r#"s="50" t="40""#, "")),
        ["the crosswalk lies 38 m beside the lanes; no car passes it"]
    );
    let repeat = r#"<repeat s="100" length="100" distance="50" tStart="0" tEnd="2" zOffsetStart="0" zOffsetEnd="0"/>"#;
    let repeated = crosswalk(r#"s="10" t="0""#, repeat);
    assert_eq!(warnings(&repeated), [""; 0]);
    let middles: Vec<(f64, f64)> = parts(&repeated)
        .crosswalks
        .iter()
        .map(|corners| ((corners[0].x + corners[2].x) / 2.0, (corners[0].y + corners[2].y) / 2.0))
        .collect();
    assert_eq!(middles, [(100.0, 0.0), (150.0, 1.0), (200.0, 2.0)]);
}
