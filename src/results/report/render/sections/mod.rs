//! The sections of a report, in their order. Each is a function of what was found; the summary, the page and a terminal show them.

mod names;
mod scale;
mod drivers;
mod protocol;
mod results;
mod published;
mod requirements;
mod estimates;
mod avoidable;
mod kinds;
mod searches;
mod search_pairs;
mod covers;
mod hardened;
mod learnt;
mod comparisons;
mod reference_drivers;
mod trainings;
mod starts;
mod failures;

pub use drivers::{injury, injury_scale};
pub use failures::failures_for_terminal;
pub use names::{distinct, place, who};
pub use scale::{RateOf, Scale};
pub use searches::{failed_starts, who as searcher};

use super::table::Section;
use crate::report::Findings;

/// Makes a section; `None` if the campaign has nothing for it.
type Maker = fn(&Findings<'_>) -> Option<Section>;

/// All sections of a report, in their order.
pub const SECTIONS: [Maker; 16] = [
    drivers::drivers,
    protocol::protocol,
    results::results,
    published::published,
    requirements::requirements,
    estimates::estimates,
    avoidable::avoidable,
    kinds::kinds,
    searches::searches,
    covers::covers,
    hardened::hardened,
    learnt::learnt,
    comparisons::comparisons,
    reference_drivers::reference_drivers,
    trainings::trainings,
    starts::starts,
];

/// The sections of a report.
pub fn sections(found: &Findings<'_>) -> Vec<Section> {
    SECTIONS.iter().filter_map(|make| make(found)).collect()
}
