use std::fmt::Write;

use super::{place, spread, training};
use crate::report::Cell;

/// How the table is to be read, for every summary.
const READING: &str = "\
Each collision was run again with other drivers at the brake: same path, same pedestrian at the same places and times, from where the \
danger began; nobody steers, and the pedestrian does not react to the other driver. *Of all episodes* is the rate at which \
this driver has failures that count against it; the columns after it say what the collisions are, as shares that add up to 1:

- **preventable**: a careful human would have avoided it. The driver under test failed: look at these first: `verdict` in `episodes.csv` finds them, `falsify replay RUN_ID:EPISODE` tells what happened, `falsify render` draws it.
- **contested**: some reference drivers avoid it and some do not, so it hangs on whom one asks.
- **by machine**: no human or rule avoids it, but an ideal emergency brake or the physical limit does.
- **unpreventable**: braking at once with 0.85 g does not avoid it.
- **into the side**: the front of the moving car had passed, and the pedestrian walked into its flank or rear.
- **standing**: the car stood (at most 0.1 m/s) when the pedestrian walked into it. It says little against the driver.

*Foreseeable*, beside them: the pedestrian never walked faster than 8 km/h nor sped up by more than 1.65 m/s², as in Euro NCAP's tests. A \
pedestrian without inertia never is foreseeable.

A careful human is that of UN R157, and has to avoid it in both readings: 1.15 s after the pedestrian could be seen in, or moving towards, the \
car's way, and 0.75 s after the time to collision fell to 2 s, each time braking in 0.6 s to 0.774 g. The others are the Fuzzy Safety Model \
(0.75 s, up to 6 m/s²), RSS (ad-rss-lib's parameters, 4 m/s²), an ideal emergency brake (0.35 s, in 0.6 s to 0.85 g) and physics (0.85 g at \
once). R157 is not written for roads with pedestrians: read the labels as a comparison, not as a finding of law.
";

/// Which collisions reference drivers avoid; nothing without any collision.
pub fn avoidable(cells: &[Cell]) -> String {
    let mut text = String::new();
    if cells.iter().all(|cell| cell.collisions == 0) {
        return text;
    }
    text.push_str("\n## Would a careful driver have avoided the collisions?\n\n");
    text.push_str(
        "| pedestrian | reward | trained in, against | town | policy | collisions | preventable, of all episodes (95 %) \
         | preventable (95 %) | contested | by machine | unpreventable | into the side | standing | foreseeable |\n",
    );
    text.push_str("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
    for cell in cells.iter().filter(|cell| cell.collisions > 0) {
        let interval = |(low, high): (f64, f64)| format!("{low:.2}..{high:.2}");
        let [preventable, others @ ..] = cell.labels;
        let share = |count: u32| format!("{:.2}", f64::from(count) / f64::from(cell.collisions));
        let _ = write!(
            text,
            "| {} | {} | {} | {} | {} | {} of {} | {} ({}) | {} ({}) |",
            cell.key.controller,
            cell.key.reward,
            training(cell),
            place(cell, cells),
            cell.key.policy,
            cell.collisions,
            cell.episodes,
            spread(cell.preventable),
            interval(cell.preventable_interval),
            share(preventable),
            interval(cell.preventable_share_interval),
        );
        for count in others.into_iter().chain([cell.foreseeable]) {
            let _ = write!(text, " {} |", share(count));
        }
        text.push('\n');
    }
    let _ = write!(text, "\n{READING}");
    text
}
