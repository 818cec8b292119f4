//! A town from above, with where episodes began and how they ended.

use std::fmt::Write;

use crate::campaign::EpisodeRow;
use crate::env::Ending;
use crate::geometry::Point;
use crate::road::{LaneKind, Road, Town};

/// Spacing of the points of a lane's outline (m).
const STEP: f64 = 2.0;

/// Draws a town, and a dot for every episode where its pedestrian began: filled when it hit a moving car, ringed when
/// it hit a standing one, faint when it did not.
pub fn town_map(town: &Town, rows: &[&EpisodeRow]) -> String {
    let (low, high) = town.bounds();
    let margin = 12.0;
    let (width, height) = (high.x - low.x + 2.0 * margin, high.y - low.y + 2.0 * margin);
    let mut page = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{:.1} {:.1} {width:.1} {height:.1}\" width=\"1000\" font-family=\"sans-serif\">\n\
         <title>{}</title>\n\
         <style>.ground{{fill:#e8ebe4}}.sidewalk{{fill:#cfd1d4}}.lane{{fill:#8b9096}}.building{{fill:#b9a68c;stroke:#8f7c63;stroke-width:.3}}\
         .moving{{fill:#b2182b;fill-opacity:.8}}.standing{{fill:none;stroke:#2166ac;stroke-width:.5}}.miss{{fill:#333;fill-opacity:.25}}</style>\n",
        low.x - margin,
        -high.y - margin,
        escape(&town.name),
    );
    let _ = writeln!(
        page,
        "<rect class=\"ground\" x=\"{:.1}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>",
        low.x - margin,
        -high.y - margin
    );
    for (class, wanted) in [("sidewalk", false), ("lane", true)] {
        for road in &town.roads {
            outline(&mut page, road, class, &|kind| (kind == LaneKind::Driving) == wanted && kind != LaneKind::None);
        }
    }
    for building in &town.obstacles {
        polygon(&mut page, "building", &building.corners());
    }
    for row in rows {
        let place = row.outcome.spawn.pedestrian;
        let (class, radius) = match row.outcome.ending {
            Ending::Collision { moving: true, .. } => ("moving", 1.0),
            Ending::Collision { .. } => ("standing", 1.0),
            _ => ("miss", 0.6),
        };
        let _ =
            writeln!(page, "<circle class=\"{class}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius}\"/>", place.x, -place.y);
    }
    page.push_str("</svg>\n");
    page
}

fn outline(page: &mut String, road: &Road, class: &str, wanted: &dyn Fn(LaneKind) -> bool) {
    for (index, section) in road.sections.iter().enumerate() {
        let steps = ((section.end - section.start) / STEP).ceil().max(1.0);
        for lane in section.lanes.iter().filter(|lane| lane.id != 0 && wanted(lane.kind)) {
            let edge = |side: f64| {
                (0..=steps as u32).filter_map(move |i| {
                    let s = section.start + (section.end - section.start) * f64::from(i) / steps;
                    let (t, _) = road.lane_centre(index, lane.id, s)?;
                    let line = road.plan_view.pose(s);
                    Some(line.position() + line.left() * (t + side * lane.width.value(s) / 2.0))
                })
            };
            let mut corners: Vec<Point> = edge(1.0).collect();
            let right: Vec<Point> = edge(-1.0).collect();
            corners.extend(right.iter().rev());
            polygon(page, class, &corners);
        }
    }
}

fn polygon(page: &mut String, class: &str, corners: &[Point]) {
    let _ = write!(page, "<polygon class=\"{class}\" points=\"");
    for corner in corners {
        let _ = write!(page, "{:.2},{:.2} ", corner.x, -corner.y);
    }
    page.push_str("\"/>\n");
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
