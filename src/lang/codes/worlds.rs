//! What is wrong with what a file describes: maps, towns, beginnings, drivers from outside, values that contradict each other.

use crate::diagnostic::{Diagnostic, Span};

/// A map file cannot be used.
pub fn unusable_map(span: Span, path: &str, reason: &str) -> Diagnostic {
    Diagnostic::error("unusable-map", span, format!("cannot use the map `{path}`: {reason}"))
}

/// A town written in the language cannot be built.
pub fn unbuildable_town(span: Span, reason: &str) -> Diagnostic {
    Diagnostic::error("unbuildable-town", span, format!("this town cannot be built: {reason}"))
}

/// Values that are fine alone contradict each other.
pub fn contradiction(span: Span, message: String) -> Diagnostic {
    Diagnostic::error("contradiction", span, message)
}

/// Trained pedestrians are to be tried where none are trained.
pub fn nobody_trained(span: Span) -> Diagnostic {
    contradiction(span, "this campaign has no `train` block, so there are no trained pedestrians to try".into())
        .help("without one there are `random`, `homing` and `intercept`: `pedestrians: [random]`")
}

/// Published figures, which are those of rewards, are to stand beside a campaign that trains nobody for one.
pub fn beside_nobody(span: Span) -> Diagnostic {
    Diagnostic::warning("unused", span, "these figures stand beside nothing")
        .here("they are those of rewards, and this campaign trains nobody for one")
}

/// A value lies above one that it must not exceed.
pub fn not_rising(span: Span, low: &str, high: &str, other: Option<Span>) -> Diagnostic {
    let diagnostic = contradiction(span, format!("`{low}` is more than `{high}`"));
    match other {
        Some(other) => diagnostic.label(other, format!("`{low}` is given here")),
        None => diagnostic,
    }
}

/// A driver is made for ticks of another length.
pub fn other_tick(span: Span, policy: &str, made_for: f64, tick: f64, episode: Span) -> Diagnostic {
    Diagnostic::warning("other-tick", span, format!("`{policy}` is made for ticks of {made_for} s"))
        .label(episode, format!("these last {tick} s"))
        .help("its own counts of ticks stay as they are, so it thinks and acts at another pace than its original")
}

/// Parts of a map were skipped or guessed.
pub fn map_warning(span: Span, path: &str, warnings: &[String]) -> Diagnostic {
    let parts = if warnings.len() == 1 { "one part".to_string() } else { format!("{} parts", warnings.len()) };
    let mut diagnostic =
        Diagnostic::warning("map-warning", span, format!("{parts} of the map `{path}` were skipped or guessed"));
    for warning in warnings.iter().take(3) {
        diagnostic = diagnostic.help(warning.clone());
    }
    diagnostic.help(format!("`falsify map {path}` lists them all"))
}

/// Nobody can be placed where an episode should begin.
pub fn unplaceable(span: Span, town: &str, reason: &str) -> Diagnostic {
    Diagnostic::error("unplaceable", span, format!("nobody can be placed in `{town}`: {reason}"))
        .help("`falsify check --sample 1000` draws what is left of each constraint")
}

/// Few beginnings satisfy all constraints.
pub fn rare_beginnings(span: Span, town: &str, found: &str) -> Diagnostic {
    Diagnostic::warning("rare-beginnings", span, format!("beginnings in `{town}` are rare: {found}"))
        .help("what bounds `bearing`, `distance` or `ego_speed` alone, as `distance > 10 m` does, is drawn directly")
        .help("drawing one takes long; `falsify check --sample 1000` shows what each constraint leaves")
}

/// Something stands so far away (m) that nobody meets it.
pub fn far_from_streets(span: Span, far: f64) -> Diagnostic {
    Diagnostic::warning("out-of-reach", span, format!("this stands more than {far} m from every street"))
        .here("nobody meets it there, nor sees it")
}

/// A sign stands where no car drives.
pub fn sign_off_lanes(span: Span) -> Diagnostic {
    Diagnostic::warning("out-of-reach", span, "this sign stands on no driving lane")
        .here("no car passes it")
        .help("`at` is the middle of the lane where the limit begins")
}

/// Whether a diagnostic says that nobody can be placed.
pub fn is_unplaceable(diagnostic: &Diagnostic) -> bool {
    diagnostic.code == "unplaceable"
}

/// A scenario names a program to be started, and the user has not allowed that.
pub fn external_not_allowed(span: Span, command: &str) -> Diagnostic {
    Diagnostic::error("external-not-allowed", span, format!("this scenario wants to start the program `{command}`"))
        .help("`--allow-external` lets scenarios start programs; give it only with files that you trust")
}

/// A command cannot be split into a program and its arguments.
pub fn unusable_command(span: Span, command: &str, reason: &str) -> Diagnostic {
    Diagnostic::error("unusable-command", span, format!("cannot use the command `{command}`: {reason}"))
        .help("it is split at blanks, and single quotes hold blanks together; there is no shell")
}

/// A model of a learnt driver cannot be used.
pub fn unusable_model(span: Span, path: &str, reason: &str) -> Diagnostic {
    Diagnostic::error("unusable-model", span, format!("cannot use the model `{path}`: {reason}"))
        .help("paths are relative to the folder of the file that names them")
}
