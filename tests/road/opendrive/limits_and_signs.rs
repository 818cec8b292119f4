//! Speed limits, stop and yield signs, and lanes that are too wide.

use super::{BEND, eastbound, town};
use road::AssumedLimit;
use road::opendrive::read;

/// A straight road of 100 m with one lane to the east, these types of the road and these parts of the lane.
fn straight(types: &str, lane: &str, signals: &str) -> String {
    format!(
        r#"<OpenDRIVE><road id="1" length="100" junction="-1">{types}<planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView><lanes><laneSection s="0"><right><lane id="-1" type="driving"><width a="3.5"/>{lane}</lane></right></laneSection></lanes><signals>{signals}</signals></road></OpenDRIVE>"#
    )
}

fn limits_kmh(map: &str, places: &[f64]) -> Vec<Option<f64>> {
    let town = town(map);
    let kmh = |limit: f64| (limit * 36.0).round() / 10.0;
    places.iter().map(|s| town.limit(eastbound(*s)).map(kmh)).collect()
}

#[test]
fn limits_of_lanes_overrule_those_of_road_types() {
    let of = |types: &str, lane: &str| limits_kmh(&straight(types, lane, ""), &[1.0, 30.0, 70.0]);
    let town_then_road = r#"<type s="0" type="town"><speed max="50" unit="km/h"/></type><type s="60" type="rural"><speed max="no limit"/></type>"#;
    assert_eq!(of("", ""), [None, None, None]);
    assert_eq!(of(town_then_road, ""), [Some(50.0), Some(50.0), Some(130.0)]);
    let own = r#"<speed sOffset="20" max="10"/><speed sOffset="50" max="20" unit="mph"/>"#;
    assert_eq!(of(town_then_road, own), [Some(50.0), Some(36.0), Some(32.2)]);
    assert_eq!(of(town_then_road, r#"<speed sOffset="20" max="undefined"/>"#), [Some(50.0), Some(50.0), Some(130.0)]);
    assert_eq!(of("", r#"<speed max="8.33"/>"#), [Some(30.0); 3]);
    for bad in [r#"max="fast""#, r#"max="0""#, r#"max="-3""#, r#"max="1e9""#, r#"max="5" unit="knots""#] {
        let map = straight("", &format!("<speed {bad}/>"), "");
        assert_eq!(limits_kmh(&map, &[1.0]), [None], "{bad}");
        let warnings = read(&map, "bad").unwrap().warnings;
        assert!(warnings.len() == 1 && warnings[0].line == 1, "{warnings:?}");
    }
}

#[test]
fn a_speed_sign_overrules_the_limit_of_its_lane_up_to_the_end_of_the_road() {
    let sign = |s: u32, limit: u32| {
        format!(r#"<signal id="{s}" s="{s}" t="-3" type="274" subtype="{limit}" orientation="+"/>"#)
    };
    let fifty = r#"<type s="0" type="town"><speed max="50" unit="km/h"/></type>"#;
    let places = [10.0, 30.0, 70.0];
    let of = |types: &str, signs: &str| limits_kmh(&straight(types, "", signs), &places);
    assert_eq!(of(fifty, &sign(20, 30)), [Some(50.0), Some(30.0), Some(30.0)]);
    assert_eq!(of(fifty, &(sign(60, 70) + &sign(20, 30))), [Some(50.0), Some(30.0), Some(70.0)]);
    // Without limits of lanes and types a car keeps the limit of the last sign that it passed.
    assert_eq!(of("", &sign(20, 30)), [None; 3]);
    assert_eq!(town(&straight("", "", &sign(20, 30))).speed_signs.len(), 1);
}

#[test]
fn the_length_without_a_limit_is_known() {
    let assumed = |types: &str, signal: &str| {
        let town = town(&straight(types, "", signal));
        AssumedLimit::of(&town.roads, &town.speed_signs).map(|assumed| assumed.to_string())
    };
    let nothing = "30 km/h assumed on 100 of 100 m of driving lanes, which have no speed limit";
    assert_eq!(assumed("", "").as_deref(), Some(nothing));
    assert_eq!(assumed("", r#"<signal id="1" s="5" type="274" subtype="50"/>"#), None, "signs give the limits");
    let later = r#"<type s="60" type="town"><speed max="50" unit="km/h"/></type>"#;
    assert_eq!(assumed(later, "").as_deref(), Some(nothing.replace("on 100", "on 60").as_str()));
    assert_eq!(assumed(&later.replace("60", "0"), ""), None);
}

#[test]
fn stop_and_yield_signs_have_a_line_on_each_lane_that_they_apply_to() {
    let map =
        |signs: &str| BEND.replace("</objects>\n</road>", &format!("</objects><signals>{signs}</signals></road>"));
    let lines = |map: &str| {
        let signs = &town(map).give_way_signs;
        let each = signs.iter().map(|sign| (sign.kind.name(), sign.line.road.0, sign.line.lane, sign.line.s.round()));
        each.collect::<Vec<_>>()
    };
    // Whatever the orientation, a sign applies to the lanes on its side.
    for orientation in ["", r#"orientation="+""#, r#"orientation="-""#] {
        let right = map(&format!(r#"<signal id="20" s="80" t="-4" type="206" {orientation}/>"#));
        assert_eq!(lines(&right), [("stop", 0, -1, 80.0)]);
    }
    assert_eq!(lines(&map(r#"<signal id="20" s="10" t="6" type="205"/>"#)), [("yield", 0, 1, 10.0)]);
    // Of several signs on a lane the last one and the stricter demand count.
    let two = r#"<signal id="20" s="80" t="-4" type="206"/><signal id="21" s="90" t="-4" type="205"/>"#;
    assert_eq!(lines(&map(two)), [("stop", 0, -1, 90.0)]);
    // A sign inside a junction holds cars before it. The light of that lane counts while it works.
    let inside = BEND.replace(r#"type="1000001" dynamic="yes""#, r#"type="206""#);
    assert_eq!(lines(&inside), [("stop", 0, -1, 100.0)]);
    assert!(!town(&inside).give_way_signs[0].has_light);
    assert!(town(&map(r#"<signal id="20" s="99" t="-4" type="206"/>"#)).give_way_signs[0].has_light);
}

#[test]
fn a_lane_wider_than_a_kilometre_is_refused_with_its_line() {
    let wide = |width: &str| {
        let map = straight("", "", "").replace("<lanes>", "\n<lanes>");
        read(&map.replace(r#"<width a="3.5"/>"#, &format!("<width {width}/>")), "wide")
    };
    for width in [r#"d="1e9""#, r#"sOffset="-1e5" a="3" d="1""#, r#"a="-1001""#, r#"b="50" c="-0.5""#] {
        let error = wide(width).unwrap_err().to_string();
        assert!(error.starts_with("line 2, road 1: lane -1 is ") && error.ends_with("; the most is 1000 m"), "{error}");
    }
    // Great terms that cancel are a narrow lane.
    for width in [r#"a="3.5""#, r#"a="999""#, r#"b="0.3" c="-0.003""#, r#"a="3" c="3e-4" d="-2e-6""#] {
        assert!(wide(width).is_ok(), "{width}");
    }
}
