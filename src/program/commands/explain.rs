use clap::Args;

use crate::cli::console;
use crate::cli::failure::misused;
use crate::cli::input::language;
use crate::exit_code::{Ended, ExitCode};
use results::report;

pub const EXAMPLES: &str = "\
Examples:
  falsify explain                            list everything
  falsify explain missing-unit               a diagnostic, with a bad and a good example
  falsify explain driver idm                 the keys of a kind, with types, units and defaults
  falsify explain training ppo gamma         one key
  falsify explain matrix                     a word of the language, with an example
  falsify explain fault                      a word of results, a column or a metric
  falsify explain state                      what a pedestrian gets, with units and bounds
  falsify explain std/pedestrians.scn        a file of the standard library";

/// Options of `falsify explain`.
#[derive(Debug, Args)]
pub struct ExplainArgs {
    /// A code; a form, a form and a kind, and a key of it; a word such as `param` or `normal`; an event, a variable; a word, a
    /// column or a metric of results; or `events`, `variables`, `units`, `state`, `action`.
    #[arg(value_name = "WORD")]
    pub words: Vec<String>,
}

pub fn explain(options: &ExplainArgs) -> Ended {
    let language = language().explain(&options.words);
    let word = options.words.join(" ");
    let meaning = meaning(&word);
    let columns = [command(&word).into_iter().collect(), columns(&word)].concat();
    let language = match language {
        Err(reason) if meaning.is_none() && columns.is_empty() => return Err(misused(reason)),
        other => other.ok().map(|text| text.trim_end().to_owned()),
    };
    let parts: Vec<String> = meaning.into_iter().chain(language).chain(columns).collect();
    console::say(console::wrapped(&parts.join("\n\n")).trim_end());
    Ok(ExitCode::Done)
}

/// A command of the program.
fn command(word: &str) -> Option<String> {
    let program = super::command();
    let about = program.find_subcommand(word)?.get_about()?.to_string();
    Some(format!("`falsify {word}` (a command): {about} (`falsify {word} --help`)"))
}

/// The words of results, which the book's glossary has, too.
const WORDS: &str = include_str!("words.md");

/// The meaning of a word of results.
fn meaning(word: &str) -> Option<String> {
    let wanted = word.to_lowercase().replace('_', " ");
    WORDS.lines().skip(2).find_map(|line| {
        let (names, meaning) = line.trim_matches(['|', ' ']).split_once(" | ")?;
        names.split(", ").any(|name| name == wanted).then(|| format!("{names}: {meaning}"))
    })
}

/// The columns and metrics of this name, each meaning once.
fn columns(name: &str) -> Vec<String> {
    let tables = report::catalogue().into_iter().map(|table| (format!("column of `{}`", table.name), table.columns));
    let metrics = (format!("metric of `{}`", report::METRICS), report::metric_references());
    let mut found: Vec<(String, Vec<String>)> = Vec::new();
    for (place, all) in std::iter::once(metrics).chain(tables) {
        for column in all.into_iter().filter(|column| column.name == name) {
            let unit = if column.unit.is_empty() { String::new() } else { format!(" ({})", column.unit) };
            let meaning = format!("{}{unit}", column.doc);
            match found.iter_mut().find(|(known, _)| *known == meaning) {
                Some((_, places)) => places.push(place.clone()),
                None => found.push((meaning, vec![place.clone()])),
            }
        }
    }
    found.into_iter().map(|(meaning, places)| format!("{name}, {}: {meaning}", places.join(", "))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_columns_and_metrics_of_results_are_explained() {
        for word in [
            "fault",
            "Preventable",
            "machine_preventable",
            "verdict",
            "driver",
            "avoidable injury",
            "gate",
            "score",
            "cc_attentive",
        ] {
            assert!(meaning(word).is_some(), "{word}");
        }
        assert_eq!(meaning("nothing"), None);
        assert!(columns("fault_rate")[0].contains("metric of `metrics`"), "{:?}", columns("fault_rate"));
        assert!(columns("min_ttc_s")[0].ends_with("(s)"));
        assert!(command("judge").unwrap().starts_with("`falsify judge` (a command): Judge a collision"));
        assert_eq!(command("nothing"), None);
    }
}
