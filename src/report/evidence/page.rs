use std::fmt::Write;

use super::super::Cell;
use super::super::render::{place, training};
use super::{CellEvidence, Change, Evidence, Figure, Quantiles, Test};
use crate::judge::Reference;
use crate::record::CellKey;
use crate::statistics::wilson;

/// The sections of a summary that say how far its numbers can be trusted, and what they are to be compared with.
pub fn page(cells: &[Cell], evidence: &Evidence) -> String {
    let mut page = String::new();
    let both: Vec<(&Cell, &CellEvidence)> = cells.iter().zip(&evidence.cells).collect();
    let who = |cell: &Cell| {
        let names = [cell.key.controller.clone(), cell.key.reward.clone(), training(cell)];
        format!("| {} | {} | {} |", names.join(" | "), place(cell, cells), cell.key.policy)
    };
    trainings(&mut page, &both, &who);
    compared(&mut page, evidence);
    transferred(&mut page, evidence);
    severity(&mut page, &both, &who);
    ceiling(&mut page, &both, &who);
    page
}

/// What names a cell at the beginning of a row.
const WHO: &str = "| pedestrian | reward | trained in, against | town | policy |";

type Who<'a> = &'a dyn Fn(&Cell) -> String;

/// Heads a table: the columns after those that name a cell.
fn head(page: &mut String, first: &str, columns: &str) {
    let _ = writeln!(page, "{first}{columns}");
    let count = format!("{first}{columns}").matches('|').count() - 1;
    let _ = writeln!(page, "|{}", "---|".repeat(count));
}

fn range(interval: Option<(f64, f64)>) -> String {
    interval.map_or("–".into(), |(low, high)| format!("{low:.2}..{high:.2}"))
}

fn number(value: Option<f64>) -> String {
    value.map_or("–".into(), |value| format!("{value:.2}"))
}

/// The collision rate of each training.
fn trainings(page: &mut String, cells: &[(&Cell, &CellEvidence)], who: Who) {
    if cells.iter().all(|(cell, _)| cell.key.train_town.is_empty() && cell.runs == 1) {
        return;
    }
    page.push_str("\n## Would other trainings show the same?\n\n");
    head(page, WHO, " collision rate of each run | middle half | bootstrap 95 % | Student 95 % |");
    for (cell, found) in cells {
        let between = found.between(Figure::Collision);
        let each: Vec<String> = between.by_run.iter().map(|value| number(*value)).collect();
        let (iqm, bootstrap, student) = (number(between.iqm), range(between.bootstrap), range(between.student));
        let _ = writeln!(page, "{} {} | {iqm} | {bootstrap} | {student} |", who(cell), each.join(" "));
    }
    page.push_str(
        "\nMiddle half: the mean without the best and the worst quarter of the runs. Both intervals are about *further trainings*: the \
         bootstrap draws runs and then episodes again, Student's is what \"±\" implies. ",
    );
    let runs = cells.iter().filter(|(cell, _)| !cell.key.train_town.is_empty()).map(|(cell, _)| cell.runs).min();
    match runs {
        Some(1) => page.push_str("**With one training the bootstrap is about its episodes alone.** "),
        Some(runs @ 2..5) => {
            let held = [50, 75, 80][runs as usize - 2];
            let _ = write!(
                page,
                "**With {runs} trainings the bootstrap is rough:** too narrow, it holds the truth in about {held} of 100 campaigns; \
                 Student's holds it in 95 and is wide for that reason. "
            );
        }
        _ => {}
    }
    page.push_str("`cells.csv` has the same for the other figures.\n");
}

/// Pedestrians on common beginnings.
fn compared(page: &mut String, evidence: &Evidence) {
    if evidence.comparisons.is_empty() {
        return;
    }
    page.push_str("\n## Better than others from the same beginnings?\n\n");
    head(page, WHO, " less | collisions (95 %) | p | with a moving car (95 %) | p | preventable (95 %) | p |");
    let mut rows: Vec<(String, String)> = Vec::new();
    for found in &evidence.comparisons {
        let other = if found.second.reward == found.first.reward {
            found.second.controller.clone()
        } else {
            format!("{} {}", found.second.controller, found.second.reward)
        };
        let label = format!("{} {other} |", start(&found.first, &found.first.policy));
        let interval = range(found.student.or(Some(found.bootstrap)));
        let mark = if found.test == Test::McNemar { "¹" } else { "" };
        let p = found.holm.map_or("–".into(), |p| if p < 0.001 { "<0.001".into() } else { format!("{p:.3}") });
        let text = format!(" {:+.2} ({interval}) | {p}{mark} |", found.difference);
        match rows.last_mut() {
            Some((last, row)) if *last == label => row.push_str(&text),
            _ => rows.push((label, text)),
        }
    }
    for (label, text) in rows {
        let _ = writeln!(page, "{label}{text}");
    }
    page.push_str(
        "\nDifferences of rates, each pedestrian against another that met the same beginnings; p says how probable such a difference \
         is by chance, after Holm's correction for all tests of this campaign, and above 0.05 call it a tie. Intervals and p are Student's over trainings and common \
         episodes (¹ McNemar's exact test: one run each, so about these two pedestrians alone, with a bootstrap interval over episodes). `comparisons.csv` has raw p, Benjamini and Hochberg's, and bootstrap intervals.\n",
    );
}

/// The columns that name a cell, from its key.
fn start(key: &CellKey, policy: &str) -> String {
    let trained = format!("{}, {}", key.train_town, key.train_policy);
    format!("| {} | {} | {trained} | {} | {policy} |", key.controller, key.reward, key.town)
}

/// What gets lost in another town or against another driver.
fn transferred(page: &mut String, evidence: &Evidence) {
    if evidence.transfers.is_empty() {
        return;
    }
    page.push_str("\n## Does it transfer?\n\n");
    head(
        page,
        "| pedestrian | reward | trained in, against | tried in | against |",
        " gap of collisions (95 %) | with a moving car (95 %) | preventable (95 %) |",
    );
    let mut rows: Vec<(String, String)> = Vec::new();
    for found in &evidence.transfers {
        let (home, away) = (&found.home, &found.away);
        let arrow = |here: &str, there: &str| format!("{here} → {there}");
        let (town, policy) = match found.change {
            Change::Town => (arrow(&home.town, &away.town), home.policy.clone()),
            Change::Policy => (home.town.clone(), arrow(&home.policy, &away.policy)),
        };
        let label = format!(
            "| {} | {} | {}, {} | {town} | {policy} |",
            home.controller, home.reward, home.train_town, home.train_policy
        );
        let text = format!(" {:+.2} ({}) |", found.gap, range(found.student.or(Some(found.bootstrap))));
        match rows.last_mut() {
            Some((last, row)) if *last == label => row.push_str(&text),
            _ => rows.push((label, text)),
        }
    }
    for (label, text) in rows {
        let _ = writeln!(page, "{label}{text}");
    }
    page.push_str(
        "\nThe rate where it was trained less that of the same trainings elsewhere: above 0 what does not transfer. The interval is \
         Student's over the gaps of the trainings (with one training, a bootstrap over episodes); beginnings differ between towns and drivers.\n",
    );
}

/// Speeds of impacts, and near misses.
fn severity(page: &mut String, cells: &[(&Cell, &CellEvidence)], who: Who) {
    page.push_str("\n## How hard, and how near?\n\n");
    head(
        page,
        WHO,
        " impact speed: median, P90, P99 (m/s) | of | least TTC: P1, P10, median (s) | of | PET: P1, P10, median (s) | of |",
    );
    let three = |quantiles: &Quantiles| quantiles.at.map(number).join(", ");
    for (cell, found) in cells {
        let _ = writeln!(
            page,
            "{} {} | {} | {} | {} | {} | {} |",
            who(cell),
            three(&found.impact_speed),
            found.impact_speed.n,
            three(&found.min_ttc),
            found.min_ttc.n,
            three(&found.pet),
            found.pet.n,
        );
    }
    page.push_str(
        "\nThe speed of the car at collisions; then how near the *other* episodes came: the least time to collision at \
         constant velocities while the car moves, and the time between one leaving a place and the other taking it. The smaller, \
         the nearer; episodes without either are not counted.\n",
    );
}

/// Collision rates with reference drivers at the brake.
fn ceiling(page: &mut String, cells: &[(&Cell, &CellEvidence)], who: Who) {
    if cells.iter().all(|(_, found)| found.collisions == 0) {
        return;
    }
    page.push_str("\n## What would other drivers have left over?\n\n");
    let names: String = Reference::ALL.iter().map(|reference| format!(" `{}` |", reference.name())).collect();
    head(page, WHO, &format!(" collision rate |{names}"));
    for (cell, found) in cells.iter().filter(|(_, found)| found.episodes > 0) {
        let rate = |count: u64| {
            let share = count as f64 / found.episodes as f64;
            format!("{share:.2} ({})", range(Some(wilson(count, found.episodes))))
        };
        let _ = write!(page, "{} {} |", who(cell), rate(found.collisions));
        for reference in Reference::ALL {
            let _ = write!(page, " {} |", rate(found.split(reference).1));
        }
        page.push('\n');
    }
    page.push_str(
        "\nThe collision rate if a reference driver had braked in the same episodes from where the danger began: what is left over no driver of that \
         kind avoids, and the gap to the driver under test is what could be won. Wilson's 95 % over all episodes; a \
         collision with a car that has come to stand counts as avoided.\n",
    );
}
