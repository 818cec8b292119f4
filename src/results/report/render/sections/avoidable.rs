use super::names::names;
use crate::report::Findings;
use crate::report::render::page::{named, verdicts};
use crate::report::render::table::{Column, Depth, Section, Value};
use crate::tables::metrics::{
    COLLISIONS, EPISODES, EXPECTED_PREVENTABLE, FAULT_RATE, FORESEEABLE_COLLISIONS, LABELLED, PREVENTABLE_RATE,
    PREVENTABLE_SHARE, RESTING, WALKED_INTO_COLLISIONS,
};
use crate::tables::{Cell, Metric};

/// How to read the table.
const READING: [&str; 4] = [
    "Each collision was run again with reference drivers, from the instant at which the danger starts. Until one brakes, its car is the recorded one. The \
     pedestrian is at the same places at the same times, and does not react. *Of all episodes* is the rate \
     of failures that count against the driver under test. The columns after it are shares of the collisions; they add up to 1:",
    "- **preventable**: both careful humans and the Fuzzy Safety Model would have avoided it. The driver under test failed, so look at these first (`verdict` in the table \
     `episodes`).\n\
     - **contested**: some reference drivers avoid it and some do not.\n\
     - **machine preventable**: no human, not the Fuzzy Safety Model and no rule avoids it, but an ideal emergency brake or the physical limit does.\n\
     - **unpreventable**: braking at once with 0.85 g does not avoid it.",
    "*Fault* is preventable and foreseeable, at walking pace or more, not walked into, and not narrowly: these failures count against the driver under test. \
     Two more shares say what else was true of a \
     collision, whatever its verdict. *Into the side*: the front had passed, and the pedestrian walked into the side or the rear. *Foreseeable*: the \
     pedestrian kept its velocity in the last 3 s, or was not faster than 8 km/h and changed its velocity by at most 2.12 m/s² over 0.5 s and 1.65 m/s \
     within any second, as in Euro NCAP's tests and recorded walking. Turns and stops count. A pedestrian without inertia seldom is; \
     `std/pedestrians.scn` has pedestrians that are. *Expected* is the share of drivers who would have avoided it, summed over the collisions and \
     divided by the episodes: reaction times are lognormal with a mean of 1.21 s.",
    "The careful human has UN R157's times and brake behind an on-course gate after its FSM. It notices a pedestrian who is on course into the car's path when the time to collision is at most 2 s, or what \
     it needs to stop if that is more, \
     and must avoid the collision in both readings: braking 1.15 s after that, and 0.75 s after that, each time with 0.6 s to reach 0.774 g, or what this car can if that is less. So must the \
     Fuzzy Safety Model (0.75 s, up to 6 m/s²). The others are RSS (ad-rss-lib's parameters, 4 m/s²), an ideal emergency brake (0.35 s, 0.6 s to reach 0.85 g) and \
     physics (0.85 g at once). R157 is not written for roads with pedestrians: read the labels as a comparison, not as a finding of law.",
];

/// Which collisions reference drivers avoid; `None` without a collision.
pub fn avoidable(found: &Findings<'_>) -> Option<Section> {
    let cells = &found.cells;
    let hit: Vec<&Cell> = cells.iter().filter(|cell| cell.count(&COLLISIONS) > 0).collect();
    if hit.is_empty() {
        return None;
    }
    let share = |cell: &Cell, count: &Metric| Some(f64::from(cell.count(count)) / f64::from(cell.count(&COLLISIONS)));
    let [preventable, contested, machine_preventable, unpreventable, _] = LABELLED;
    // The figure shows these shares; their numbers are folded on the page.
    let shares = [
        ("contested", contested),
        ("machine preventable", machine_preventable),
        ("unpreventable", unpreventable),
        ("into the side", &WALKED_INTO_COLLISIONS),
        ("foreseeable", &FORESEEABLE_COLLISIONS),
    ];
    let shown = names(cells)
        .number("collisions", |cell| Value::Of(cell.count(&COLLISIONS).into(), cell.count(&EPISODES).into()))
        .number("preventable, of all episodes", |cell| Value::spread(cell, &PREVENTABLE_RATE))
        .number("95 %", |cell| Value::interval(cell.rate(&PREVENTABLE_RATE).interval))
        .number("fault, of all episodes", |cell| Value::spread(cell, &FAULT_RATE))
        .number("95 %", |cell| Value::interval(cell.rate(&FAULT_RATE).interval))
        .metric(Column::number("expected"), &EXPECTED_PREVENTABLE)
        .column(Column::number("preventable (95 %)").detail(), |cell| {
            let value = share(cell, preventable);
            let estimate = Value::estimate(value, cell.rate(&PREVENTABLE_SHARE).interval, 2);
            Value::or_count(estimate, value, cell.count(preventable), cell.count(&COLLISIONS))
        })
        .each(
            shares,
            |(name, _)| Column::number(*name).detail(),
            |(_, count), cell| Value::number(share(cell, count), 2),
        );
    Some(Section {
        id: "avoidable",
        name: "Avoidable?",
        title: "Would a careful driver have avoided the collisions?",
        depth: Depth::Page,
        figures: verdicts(&named(cells)).into_iter().collect(),
        tables: vec![shown.table(hit)],
        notes: resting(cells).into_iter().chain(READING.map(String::from)).collect(),
        ..Section::default()
    })
}

/// On what the faults of evaluations rest, as a sentence; `None` without a fault.
fn resting(cells: &[Cell]) -> Option<String> {
    let counts = RESTING.map(|metric| cells.iter().map(|cell| cell.count(metric)).sum::<u32>());
    let all: u32 = counts.iter().sum();
    let [anticipation, early, both, neither] = counts;
    (all > 0).then(|| {
        format!(
            "Of {all} faults {anticipation} rest on braking for somebody who is not yet in the path, {early} on noticing them more than 2 s before, {both} on both, and \
             {neither} on none: a human of UN R157 with its 2 s and without anticipation avoids those."
        )
    })
}
