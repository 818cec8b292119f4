//! `falsify.toml`: settings of a folder and of all below it.
//!
//! The value of an option is the first of these: the flag, the variable of the environment, the key of the same name in the file, the
//! program's default.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use clap::error::{ContextKind, ContextValue};
use clap::{Arg, ArgAction, Args, Command, ValueHint};
use toml::de::{DeTable, DeValue};

use super::console;
use crate::commands::RunArgs;
use crate::exit_code::ExitCode;
use base::diagnostic::{Diagnostic, SourceId, Sources, Span};
use base::suggest::nearest;
use lang::reason;

pub const FILE: &str = "falsify.toml";

/// The settings, with the variables of the environment that also set them. Each is the option of `falsify run` with the same name, which
/// documents its meaning and its values.
const KEYS: [(&str, Option<&str>); 10] = [
    ("out", Some("FALSIFY_OUT")),
    ("cache", Some("FALSIFY_CACHE")),
    ("seed", Some("FALSIFY_SEED")),
    ("threads", Some("FALSIFY_THREADS")),
    ("formats", Some("FALSIFY_FORMATS")),
    ("format", Some("FALSIFY_FORMAT")),
    ("progress", Some("FALSIFY_PROGRESS")),
    ("checkpoint", None),
    ("task_time", None),
    ("max_ticks", None),
];

/// The settings of a file: the values of each key in the form that an option takes.
pub type Settings = BTreeMap<&'static str, Vec<String>>;

/// Whether a command has settings. The command must be the chosen one, so that its options exist.
pub fn concern(command: &Command, name: &str) -> bool {
    let options = command.find_subcommand(name).into_iter().flat_map(Command::get_arguments);
    options.into_iter().any(|option| setting(option).is_some())
}

/// The setting of a command's option: the setting whose variable the option reads, or the setting of its name if there is no variable.
fn setting(option: &Arg) -> Option<&'static str> {
    let variable = option.get_env().map(|variable| variable.to_string_lossy());
    let stands_for = |(key, listened): &(&str, Option<&str>)| match (&variable, listened) {
        (Some(one), Some(other)) => one == other,
        (None, None) => option.get_id() == key,
        _ => false,
    };
    KEYS.into_iter().find(stands_for).map(|(key, _)| key)
}

/// The options of `falsify run` that correspond to the settings, in their order.
fn options() -> Vec<Arg> {
    let run = RunArgs::augment_args(Command::new("run"));
    let option = |key: &str| run.get_arguments().find(|option| option.get_id() == key).cloned();
    KEYS.into_iter().map(|(key, _)| option(key).expect("each setting is an option of `run`")).collect()
}

/// Finds the file in a folder or the nearest one above it, and reads it; `None` if there is no such file.
///
/// # Errors
/// The exit code, after all errors have been printed.
pub fn find(folder: &Path) -> Result<Option<Settings>, ExitCode> {
    let Some(path) = folder.ancestors().map(|folder| folder.join(FILE)).find(|path| path.is_file()) else {
        return Ok(None);
    };
    let text = base::files::text(&path).map_err(|error| {
        console::fail(&format!("cannot read `{}`: {}", path.display(), reason(&error)));
        ExitCode::Usage
    })?;
    let mut sources = Sources::default();
    let source = sources.add(&path, text.as_str());
    read(&path, &text, source).map(Some).map_err(|diagnostics| {
        console::show(&diagnostics, &sources);
        ExitCode::Usage
    })
}

/// Makes the settings the defaults of their options.
pub fn apply(command: Command, settings: &Settings) -> Command {
    let with_default = |option: Arg| match setting(&option).and_then(|key| settings.get(key)) {
        Some(values) => option.default_values(values),
        None => option,
    };
    command.mut_subcommands(|subcommand| subcommand.mut_args(with_default))
}

fn read(path: &Path, text: &str, source: SourceId) -> Result<Settings, Vec<Diagnostic>> {
    let span = |range: Range<usize>| Span { source, start: range.start, end: range.end };
    let table = DeTable::parse(text).map_err(|error| {
        let place = span(error.span().unwrap_or(0..0));
        vec![Diagnostic::error("syntax", place, "this is not TOML").here(error.message().trim_end().to_string())]
    })?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut values = BTreeMap::new();
    let mut wrong = Vec::new();
    let options = options();
    for (key, value) in table.get_ref() {
        let same = |((known, _), _): &((&str, _), _)| *known == key.get_ref().as_ref();
        let Some(((known, _), option)) = KEYS.into_iter().zip(&options).find(same) else {
            wrong.push(unknown(span(key.span()), key.get_ref()));
            continue;
        };
        match take(option, value.get_ref(), folder) {
            Ok(taken) => {
                values.insert(known, taken);
            }
            Err((code, why)) => {
                let message = format!("`{known}` cannot be set to this");
                wrong.push(Diagnostic::error(code, span(value.span()), message).here(why));
            }
        }
    }
    wrong.sort_by_key(|diagnostic| diagnostic.primary.span);
    if wrong.is_empty() { Ok(values) } else { Err(wrong) }
}

/// Whether a text is one of settings.
pub fn is_read(text: &str) -> bool {
    let mut sources = Sources::default();
    let source = sources.add(FILE, text);
    read(Path::new(FILE), text, source).is_ok()
}

fn unknown(span: Span, word: &str) -> Diagnostic {
    let diagnostic = Diagnostic::error("unknown-key", span, format!("there is no setting `{word}`"));
    let known = KEYS.map(|(key, _)| key);
    match nearest(word, known) {
        Some(near) => diagnostic.here(format!("did you mean `{near}`?")).fix(near),
        None => diagnostic.help(format!("the settings are `{}`", known.join("`, `"))),
    }
}

/// Checks a value as its option would; the error is a code and a message for the value.
fn take(option: &Arg, value: &DeValue<'_>, folder: &Path) -> Result<Vec<String>, (&'static str, String)> {
    let list = matches!(option.get_action(), ArgAction::Append);
    let texts = match value {
        DeValue::Array(members) if list => {
            members.iter().map(|member| plain(member.get_ref())).collect::<Option<Vec<String>>>()
        }
        single => plain(single).map(|text| vec![text]),
    };
    let mut texts =
        texts.ok_or_else(|| ("wrong-type", if list { "write a list of texts" } else { "write one value" }.into()))?;
    if texts.is_empty() {
        return Err(("empty-list", "name at least one".into()));
    }
    // A path is relative to the folder of the file, not to the current folder.
    if matches!(option.get_value_hint(), ValueHint::AnyPath) {
        texts = texts.iter().map(|text| folder.join(text).display().to_string()).collect();
    }
    let trial = Command::new("trial").no_binary_name(true).arg(option.clone());
    let name = option.get_long().expect("settings are long options");
    match trial.try_get_matches_from(texts.iter().map(|text| format!("--{name}={text}"))) {
        Ok(_) => Ok(texts),
        Err(error) => Err(("out-of-range", refusal(&error))),
    }
}

/// A text or a number in the form that an option takes.
fn plain(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::String(text) => Some(text.to_string()),
        DeValue::Integer(number) if number.radix() == 10 => Some(number.as_str().replace('_', "")),
        DeValue::Float(number) => Some(number.as_str().replace('_', "")),
        _ => None,
    }
}

/// Why an option refuses a value, without its name.
fn refusal(error: &clap::Error) -> String {
    if let Some(ContextValue::Strings(valid)) = error.get(ContextKind::ValidValue)
        && !valid.is_empty()
    {
        return format!("this can be `{}`", valid.join("`, `"));
    }
    std::error::Error::source(error).map_or_else(|| "this is not what it takes".into(), ToString::to_string)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_option_of_run_stands_for_its_own_setting() {
        for (option, (key, variable)) in options().iter().zip(KEYS) {
            assert_eq!(option.get_env().map(|name| name.to_string_lossy()), variable.map(Into::into), "{key}");
            assert_eq!(setting(option), Some(key));
        }
    }
}
