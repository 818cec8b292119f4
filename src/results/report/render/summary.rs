use std::collections::BTreeSet;
use std::fmt::Write;

use super::table::{Depth, Section};
use crate::report::{Findings, Manifest, answer};
use compile::{Campaign, Driver};

/// The limits of the simulator, for every summary.
pub const LEFT_OUT: &str = "\
The simulator is flat, without kerbs and weather. Beside one car and one pedestrian it has the actors of a `cast`, and no other traffic. There are parked cars and trees \
only where the scenario puts them. The car is a kinematic bicycle whose pedals are fitted to published figures of CARLA. Its driver \
perceives without error and without delay, unless the scenario gives it sensors. The pedestrian is a disc. Maps from OpenDRIVE have \
no buildings unless the scenario adds them.";

/// The text to read first: the sections, the origin of the report, and its limits.
pub fn summary(found: &Findings<'_>, sections: &[Section], manifest: &Manifest) -> String {
    let Findings { campaign, doubts, .. } = found;
    let mut page = format!("# {}\n\n", campaign.name);
    for line in &campaign.docs {
        let _ = writeln!(page, "{line}");
    }
    if !campaign.docs.is_empty() {
        page.push('\n');
    }
    if manifest.smoke {
        let _ = writeln!(page, "**{SMOKE}**\n");
    }
    if !manifest.complete {
        let _ = writeln!(page, "**{INCOMPLETE}**\n");
    }
    for sentence in answer(found) {
        let _ = writeln!(page, "**{sentence}.**\n");
    }
    for caution in &found.cautions {
        let _ = writeln!(page, "**{caution}.**\n");
    }
    if !doubts.is_empty() {
        let _ = writeln!(page, "**{DOUBTFUL}**\n");
    }
    let (deep, shown): (Vec<&Section>, Vec<&Section>) =
        sections.iter().partition(|section| section.depth == Depth::Page);
    shown.iter().for_each(|section| page.push_str(&section.to_markdown()));
    if !deep.is_empty() {
        let titles: Vec<String> = deep.iter().map(|section| format!("*{}*", section.title)).collect();
        let _ = writeln!(page, "\n`report.html` has the rest: {}.", titles.join(", "));
    }
    page.push_str(&drivers(&campaign.drivers));
    let _ = write!(
        page,
        "\nSeed {}, falsify {}.\n\n{}## What the simulator leaves out\n\n{LEFT_OUT}\n",
        manifest.seed,
        manifest.version,
        words(campaign)
    );
    without_html(&page)
}

/// Markdown whose texts, which come from a scenario, are neither HTML nor links to scripts. The only tag of tables is `<br>`.
fn without_html(page: &str) -> String {
    let mut safe = String::with_capacity(page.len());
    for (place, letter) in page.char_indices() {
        let rest = &page[place + letter.len_utf8()..];
        let next = rest.chars().next().unwrap_or(' ');
        match letter {
            // A renderer would load an image.
            '!' if next == '[' => safe.push_str("\\!"),
            '<' if !rest.starts_with("br>") && (next.is_ascii_alphabetic() || "/!?".contains(next)) => {
                safe.push_str("&lt;");
            }
            // Markdown reads entities, also in the addresses of links.
            '&' if next == '#' || next.is_ascii_alphabetic() => safe.push_str("&amp;"),
            ':' if !next.is_whitespace() && SCRIPTS.iter().any(|scheme| ends_with_ignoring_case(&safe, scheme)) => {
                safe.push_str(" :");
            }
            other => safe.push(other),
        }
    }
    safe
}

/// The ends of schemes of addresses that a browser runs.
const SCRIPTS: [&str; 2] = ["script", "data"];

fn ends_with_ignoring_case(text: &str, end: &str) -> bool {
    text.len() >= end.len() && text.as_bytes()[text.len() - end.len()..].eq_ignore_ascii_case(end.as_bytes())
}

/// A notice for readers of a smoke run.
pub const SMOKE: &str = "A smoke run: it shows that everything works. Its numbers have no meaning.";
/// A notice for readers of an incomplete report.
pub const INCOMPLETE: &str = "Incomplete: the run was stopped, something failed or reached its limit, or a reward was not a number. \
The manifest says which.";

/// A notice for readers of a report with doubtful trainings.
pub const DOUBTFUL: &str = "Some trainings are doubtful: see \"Do the trainings beat untrained pedestrians?\". A low rate of their rows \
says little about the driver.";

/// The first sentence of the scenario's documentation of each of its names.
fn words(campaign: &Campaign) -> String {
    let mut text = String::new();
    if campaign.words.is_empty() {
        return text;
    }
    text.push_str("## Names of the scenario\n\n");
    for word in &campaign.words {
        let _ = writeln!(text, "- {} **{}**: {}", word.form, word.name, word.first_sentence());
    }
    text.push('\n');
    text
}

/// The drivers, and which of them are surrogates.
fn drivers(drivers: &[Driver]) -> String {
    let mut text = String::from("\n## Drivers\n\n");
    for driver in drivers {
        let sensors = match &driver.sensors {
            Some(name) => format!("with the sensors `{name}`"),
            None => "without sensors: it perceives exactly and without delay".into(),
        };
        let surrogate = if driver.surrogate.is_empty() { "" } else { ". **A surrogate**" };
        let _ = writeln!(text, "- `{}` (`{}`), {sensors}{surrogate}", driver.name, driver.kind);
    }
    let mut seen = BTreeSet::new();
    for driver in drivers.iter().filter(|driver| !driver.surrogate.is_empty()) {
        if seen.is_empty() {
            text.push_str("\n### Surrogates\n\n");
        }
        if seen.insert(driver.kind) {
            let _ = writeln!(text, "- `{}`: {}", driver.kind, driver.surrogate);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_a_scenario_are_no_html_and_no_scripts() {
        assert_eq!(without_html("<script>alert(1)</script>"), "&lt;script>alert(1)&lt;/script>");
        assert_eq!(without_html("[x](JavaScript:alert(1))"), "[x](JavaScript :alert(1))");
        assert_eq!(without_html("[x](javascript&#58;alert(1))"), "[x](javascript&amp;#58;alert(1))");
        assert_eq!(without_html("[x](data:text/html,a)"), "[x](data :text/html,a)");
        let plain = "| a < b | c<br>d | `x <= y` & so on | https://x.org/a | the data: 5 |\n";
        assert_eq!(without_html(plain), plain);
    }
}
