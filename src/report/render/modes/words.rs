use std::fmt::Write;

use crate::analysis::Rule;
use crate::record::CellKey;
use crate::report::failure_modes::{CellModes, MOST_CASES, MOST_FAILURES, MOST_REPEATED, Mode, Target};
use crate::statistics::wilson;

/// Modes of a cell that the summary names.
const NAMED: usize = 3;

/// A share as a percentage.
pub fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// A name for the files of each cell, no longer than it takes to tell them apart.
pub fn file_names(cells: &[CellModes<'_>]) -> Vec<String> {
    let short = |CellModes { key, .. }: &CellModes<'_>| {
        format!("{}-{}-{}-{}", key.controller, key.reward, key.town, key.policy)
    };
    let long = |CellModes { key, .. }: &CellModes<'_>| {
        let CellKey { block, town, policy, vehicle, adversary, controller, reward, train_town, train_policy } = key;
        let from = if key.is_trained() { format!("-from-{train_town}-{train_policy}") } else { String::new() };
        format!("{controller}-{reward}{from}-{town}-{policy}-{vehicle}-{adversary}-{block}")
    };
    let name = |cell: &CellModes<'_>| {
        let alike = cells.iter().filter(|other| short(other) == short(cell)).count();
        if alike > 1 { long(cell) } else { short(cell) }
    };
    cells.iter().map(name).collect()
}

/// What the summary says of the kinds of failure, and of what explains them; nothing without any collision.
pub fn modes_summary(cells: &[CellModes<'_>], names: &[String]) -> String {
    let mut text = String::new();
    if cells.iter().all(|cell| cell.modes.is_empty()) {
        return text;
    }
    text.push_str("\n## FailureModes of failure\n\n");
    text.push_str(
        "A kind is where the car was hit, whether it moved, who would have avoided it, whether the pedestrian came into sight too late, and what \
         the driver was doing at the pedestrian's last decision. Within a kind, modes are clusters of the last seconds before the touch. The \
         examples are medoids: `failure_modes.csv` has all modes, the pictures show them.\n\n",
    );
    text.push_str(
        "| cell | collisions | kinds seen | there may be (95 %) | next one is of a known kind | commonest modes: share, impact speed, example |\n\
         |---|---|---|---|---|---|\n",
    );
    for (cell, name) in cells.iter().zip(names).filter(|(cell, _)| !cell.modes.is_empty()) {
        let mode = |mode: &Mode| {
            let (share, speed) = (percent(mode.mode.share), mode.mode.impact_speed[1]);
            format!("{share} {}, {speed:.1} m/s, `{}`", mode.mode.kind, mode.example_name())
        };
        let modes: Vec<String> = cell.modes.iter().take(NAMED).map(mode).collect();
        let richness = &cell.richness;
        let _ = writeln!(
            text,
            "| [{}](modes/{name}.svg) | {} | {} | {:.0} ({:.0}..{:.0}) | {} | {} |",
            cell.key,
            cell.all.1,
            richness.seen,
            richness.estimate,
            richness.interval.0,
            richness.interval.1,
            format_args!("{:.1} %", 100.0 * richness.coverage),
            modes.join("<br>"),
        );
    }
    let cut = cells.iter().filter(|cell| cell.sampled.0 < cell.all.0).count();
    if cut > 0 {
        let _ = writeln!(
            text,
            "\n**In {cut} of these cells only the first {MOST_FAILURES} collisions or so were looked at**, as many of each run; \
             `mode_counts.csv` says how many."
        );
    }
    let _ = writeln!(
        text,
        "\n\"There may be\" is Chao's estimate, a lower bound for these pedestrians and this driver; another adversary may find other kinds. \
         Clusters are drawn from at most {MOST_REPEATED} collisions of each kind."
    );
    explained(&mut text, cells, names);
    text
}

/// The most and the least dangerous rule of each cell.
fn explained(text: &mut String, cells: &[CellModes<'_>], names: &[String]) {
    if cells.iter().all(|cell| cell.explanations.is_empty()) {
        return;
    }
    text.push_str("\n### Which beginnings fail\n\n");
    text.push_str(
        "| cell | ends in | of all | most often when | least often when | skill |\n|---|---|---|---|---|---|\n",
    );
    for (cell, name) in cells.iter().zip(names) {
        for (target, found) in &cell.explanations {
            let what = match target {
                Target::Collision => "a collision",
                Target::Preventable => "a preventable one",
            };
            let rule = |rule: Option<&Rule>| rule.map_or("–".into(), worded);
            let told = found.rules.len() > 1;
            let _ = writeln!(
                text,
                "| [{}](modes/{name}-why.svg) | {what} | {} | {} | {} | {:.2} |",
                cell.key,
                percent(found.overall.0 as f64 / found.overall.1.max(1) as f64),
                rule(found.rules.first().filter(|_| told)),
                rule(found.rules.last().filter(|_| told)),
                found.skill,
            );
        }
    }
    let _ = writeln!(
        text,
        "\nRules are learnt from the episodes with even numbers, their rates (with Wilson's 95 %) are those of the odd ones; at most {MOST_CASES} \
         episodes of a cell. Skill is the share of the odd episodes' variance that the rules explain: at 0 they say nothing. A rule \
         tells what goes together, not what causes it. `turned away`: angle between where the pedestrian faces at first and the car. All rules: `explanations.csv`."
    );
}

fn worded(rule: &Rule) -> String {
    let (hits, all) = rule.held_out;
    let (low, high) = wilson(hits, all);
    let rate = percent(hits as f64 / all.max(1) as f64);
    format!("{rule}: {rate} ({low:.2}..{high:.2}, n = {all})")
}
