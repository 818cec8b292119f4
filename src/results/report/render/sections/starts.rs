use crate::report::Findings;
use crate::report::render::page::{named, spawns};
use crate::report::render::table::{Depth, Section};

/// Where the episodes of trained pedestrians start, and how often they collide from there; `None` without a training.
pub fn starts(found: &Findings<'_>) -> Option<Section> {
    let figure = spawns(&found.gathered.tally, &named(&found.cells))?;
    Some(Section {
        id: "places",
        name: "Starts",
        title: "Where episodes start",
        depth: Depth::Page,
        figures: vec![figure],
        ..Section::default()
    })
}
