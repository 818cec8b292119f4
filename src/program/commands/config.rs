use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches};

use crate::cli::console;
use crate::cli::settings::{self, FILE, Settings};

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify config                             every setting, its value and where it comes from
  falsify config --seed 7 > falsify.toml     begin a file of settings

A flag comes before the environment, which comes before falsify.toml, in this folder or the nearest one above.";

/// `falsify config`: every setting with its value and where it comes from, in the form of `falsify.toml`.
pub fn config(matches: &ArgMatches, settings: Option<&Settings>) {
    match settings {
        Some(settings) => console::say(&format!("# {}", settings.path.display())),
        None => console::say(&format!("# no {FILE} here or in a folder above")),
    }
    let lines: Vec<(String, String)> = settings::options()
        .iter()
        .map(|option| match value(option, matches) {
            Some(value) => (format!("{} = {value}", option.get_id()), origin(option, matches, settings)),
            None => (format!("# {}", option.get_id()), "not set".into()),
        })
        .collect();
    let width = lines.iter().map(|(line, _)| line.chars().count()).max().unwrap_or(0);
    lines.iter().for_each(|(line, origin)| console::say(&format!("{line:width$}  # {origin}")));
}

/// The value of an option as TOML.
fn value(option: &Arg, matches: &ArgMatches) -> Option<String> {
    let key = option.get_id().as_str();
    let separators = |text: &str| match option.get_value_delimiter() {
        Some(delimiter) => text.split(delimiter).map(written).collect(),
        None => vec![written(text)],
    };
    let values: Vec<String> = matches.get_raw(key)?.flat_map(|value| separators(&value.to_string_lossy())).collect();
    Some(if matches!(option.get_action(), ArgAction::Append) {
        format!("[{}]", values.join(", "))
    } else {
        values.concat()
    })
}

/// A text as TOML; numbers stay numbers.
fn written(text: &str) -> String {
    if text.parse::<f64>().is_ok_and(f64::is_finite) { text.into() } else { toml::Value::from(text).to_string() }
}

fn origin(option: &Arg, matches: &ArgMatches, settings: Option<&Settings>) -> String {
    let key = option.get_id().as_str();
    match matches.value_source(key) {
        Some(ValueSource::CommandLine) => format!("--{}", option.get_long().unwrap_or(key)),
        Some(ValueSource::EnvVariable) => {
            option.get_env().map_or("environment".into(), |name| name.to_string_lossy().into())
        }
        _ => match settings.and_then(|settings| settings.values.get(key)) {
            Some((_, line)) => format!("{FILE}, line {line}"),
            None => "default".into(),
        },
    }
}
