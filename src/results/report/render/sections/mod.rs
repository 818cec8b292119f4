//! The sections of a report, in their order. Each is a function of what was found; the summary, the page and a terminal show them.

mod names;
mod drivers;
mod front;
mod worlds;
mod protocol;
mod results;
mod published;
mod requirements;
mod avoidable;
mod cast;
mod distinct_failures;
mod searches;
mod search_pairs;
mod learnt;
mod comparisons;
mod reference_drivers;
mod starts;
mod failures;

pub use cast::share_of_two;
pub use drivers::injury;
pub use failures::failures_for_terminal;
pub use names::{place, who};
pub use searches::{failed_starts, who as searcher};

pub(crate) use searches::searches as search_section;

use super::table::Section;
use crate::jobs::KINDS;
use crate::report::Findings;

/// What a fault is.
pub const FAULT: &str = "A *fault* is a collision that a careful human clearly avoids, at 1 m/s or more, with a pedestrian who moves as people do and does not walk into the car.";

/// Makes a section; `None` if the campaign has nothing for it.
pub type SectionMaker = fn(&Findings<'_>) -> Option<Section>;

/// A group of sections in a report. Those of kinds of jobs follow the others of their group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    /// How often drivers fail.
    Rates,
    /// Which failures there are, and what was done about them.
    Failures,
    /// What differs, and whether that is sure.
    Comparisons,
    /// Where episodes start.
    Starts,
}

/// The groups in their order, with the sections that are of no kind of job.
const GROUPS: [(Group, &[SectionMaker]); 4] = [
    (
        Group::Rates,
        &[
            drivers::drivers,
            worlds::worlds,
            protocol::protocol,
            results::results,
            published::published,
            requirements::requirements,
        ],
    ),
    (Group::Failures, &[avoidable::avoidable, distinct_failures::distinct_failures, cast::cast]),
    (Group::Comparisons, &[learnt::learnt, comparisons::comparisons, reference_drivers::reference_drivers]),
    (Group::Starts, &[starts::starts]),
];

/// The sections of a report.
pub fn sections(found: &Findings<'_>) -> Vec<Section> {
    let of_kinds = |group| KINDS.iter().filter_map(|kind| kind.section).filter(move |(place, _)| *place == group);
    let makers =
        GROUPS.iter().flat_map(|(group, own)| own.iter().copied().chain(of_kinds(*group).map(|(_, make)| make)));
    makers.filter_map(|make| make(found)).collect()
}
