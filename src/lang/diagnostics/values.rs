//! Wrong values: types, units, bounds; formulas, ranges, distributions, events.

use super::{Offering, cut, one, quoted};
use base::diagnostic::{Diagnostic, Label, Span};
use base::signature::{Param, Type};
use base::units::Dimension;

diagnostics! {
    wrong_type(expected: &Type, found: &str) = error("wrong-type", "expected {}, found {found}", one(expected.describe()));
    axis_range() = error("wrong-type", "a matrix takes a list of values, not a range").help("write `[a, b]`");
    chained(middle: Span) = error("wrong-type", "a comparison has two sides")
        .label(middle, "compared with both")
        .help("compare twice: `low < it and it < high`");
    out_of_range(found: String, bounds: String) = error("out-of-range", "{found} is out of range").here(format!("allowed: {bounds}"));
    not_finite(why: &str) = error("no-value", "this part of a formula has no value").here(why.to_string());
    maybe_nothing(why: &str, help: &str) = error("no-value", "this part of a formula may have no value").here(why).help(help);
    too_much(limit: f64) = error("no-value", "this value may be too large")
        .here(format!("a reward must be between -{limit:e} and {limit:e}"))
        .help("scale it, or limit its parts: `min(…, 100)`");
    nothing_left(distribution: Span, range: Span) = error("nothing-left", "nothing can be drawn from this")
        .label(distribution, "no value of this")
        .label(range, "lies in this range");
    too_many_parts(limit: usize) = error("too-many-parts", "this distribution has more than {limit} parts")
        .help("every `choice` has the parts of all that it names: use fewer, or a range");
    empty_range() = error("empty-range", "this range is empty: its low end lies above its high end");
    not_whole(written: &str) = error("not-whole", "expected a whole number, found {}", cut(written)).help("digits may be grouped by `_`: `100_000`");
    empty_list() = error("empty-list", "this list is empty").help("name at least one member");
    repeated_member(written: &str, first: Span) = error("repeated-member", "`{written}` is in this list twice").label(first, "first here");
    wrong_arity(function: &str, expected: &str, found: usize) = error("wrong-arity", "`{function}` takes {expected}, found {found}");
    not_a(wanted: &str, found: &str) = error("wrong-type", "expected {}, found {}", one(wanted), one(found));
    role_outside() = error("unavailable-variable", "a signal of a role belongs in a requirement")
        .help("declare `requirement name = …` with it; a reward can name `robustness(name)`, and a search can have it as its `goal`");
    robustness_outside() = error("wrong-type", "`robustness` belongs in a reward")
        .help("there it is how far an episode is from violating the requirement: `on lost => -robustness(slow_pass)`");
    temporal_in_formula(word: &str) = error("wrong-type", "`{word}` belongs in a requirement, around conditions")
        .help("declare one: `requirement name = always(gap > 0.5 m)`; a campaign names it in `requirements`");
    wrong_bound(found: usize) = error("wrong-type", "a bound has two times, found {found}")
        .help("from and to, both included, after the present sample: `[0 s, 2 s]`");
    unbounded(written: &str, bounds: &str) = error("unbounded", "this distribution has no bounds")
        .here(format!("allowed: {bounds}"))
        .help(format!("limit it to a range: `truncated({}, low .. high)`", cut(written)));
    foregone(truth: bool) = error("foregone", "this comparison is always {truth}")
        .here("so it is for all values within the bounds of what it names")
        .help("`falsify explain NAME` gives the bounds of a variable");
    only_at_start() = warning("start-only", "this requirement is about the start of an episode only")
        .here("without `always`, `eventually` or `until` only the first sample counts")
        .help("for all samples write `always(…)`");
    duplicate_clause(first: Span) = error("duplicate-clause", "this event already has a clause").label(first, "the first is here");
    unknown_distribution(word: &str, known: &[&str]) = error("unknown-distribution", "unknown distribution `{}`", cut(word)).offering(word, known);
    unknown_choice(word: &str, words: &[&str]) = error("unknown-choice", "`{}` is not among the choices", cut(word)).offering(word, words);
    unknown_function(word: &str, known: &[&str]) = error("unknown-function", "unknown function `{}`", cut(word)).offering(word, known);
    unknown_event(word: &str, known: &[&str]) = error("unknown-event", "unknown event `{}`", cut(word)).offering(word, known);
    unknown_event_word(event: &str, word: &str, known: &[&str]) = error("unknown-event-word", "the event `{event}` has no word `{}`", cut(word))
        .offering(word, known);
    unknown_variable(word: &str, known: &[&str]) = error("unknown-variable", "unknown variable or parameter `{}`", cut(word)).offering(word, known);
}

/// A bare number stands where a unit is needed.
pub fn missing_unit(span: Span, dimension: Dimension, written: &str) -> Diagnostic {
    let units: Vec<String> = dimension.usual_units().iter().map(|unit| format!("{written} {unit}")).collect();
    Diagnostic::error("missing-unit", span, format!("{} needs a unit", one(dimension)))
        .help(format!("with its unit: {}", quoted(units.iter().map(String::as_str))))
}

/// Shows the dimension of the key of a value with a wrong unit, or without one.
pub fn show_key(said: &mut Diagnostic, key: Span, param: &Param) {
    if matches!(said.code, "missing-unit" | "wrong-unit") && said.labels.is_empty() {
        let text = format!("`{}` is {}", param.name, one(param.ty.describe()));
        said.labels.push(Label { span: key, text });
    }
}

/// A quantity has another dimension than its key.
pub fn wrong_unit(span: Span, expected: Dimension, found: Dimension) -> Diagnostic {
    let diagnostic = Diagnostic::error("wrong-unit", span, format!("expected {}, found {}", one(expected), one(found)));
    match expected.usual_units() {
        [] if expected == Dimension::RATIO => diagnostic.help("write the number without a unit"),
        [] => diagnostic,
        units => diagnostic.help(format!("units of {expected}: {}", quoted(units.iter().copied()))),
    }
}

/// A quantity is counted in units of something else.
pub fn wrong_count(unit: Span, measured: Dimension, quantity: Span, found: Dimension) -> Diagnostic {
    let diagnostic =
        Diagnostic::error("wrong-unit", unit, format!("{} is not counted in units of {measured}", one(found)))
            .label(quantity, format!("this is {}", one(found)));
    match found {
        Dimension::RATIO => diagnostic.here("remove this unit"),
        _ => diagnostic.help(format!("units of {found}: {}", quoted(found.usual_units().iter().copied()))),
    }
}

/// A plain number is expected, and the quantity is not a number whose unit could be removed.
pub fn uncounted(span: Span, found: Dimension) -> Diagnostic {
    let diagnostic = Diagnostic::error("wrong-unit", span, format!("expected a plain number, found {}", one(found)));
    match found.usual_units().first() {
        Some(unit) => diagnostic.help(format!("convert it to a plain number: `… in {unit}`")),
        None => diagnostic.help("divide it by a quantity of the same dimension"),
    }
}

/// A unit is not known; `part` is the part of it that is not, `None` for its power.
pub fn unknown_unit(span: Span, written: &str, part: Option<&str>, units: &[&str]) -> Diagnostic {
    let Some(part) = part else {
        return Diagnostic::error("unknown-unit", span, format!("`{written}` is not a unit"))
            .help("a power is a whole number from -9 to 9, as in `m/s^2`");
    };
    // Other units that are spelled nearly so are of another size, or measure something else.
    let meant = match written.to_lowercase().as_str() {
        "kmh" | "kmph" | "km/hr" => Some("km/h"),
        "mps" => Some("m/s"),
        "mps2" | "m/s2" => Some("m/s^2"),
        _ => None,
    };
    if let Some(meant) = meant {
        return Diagnostic::error("unknown-unit", span, format!("`{}` is not a unit", cut(written)))
            .here(format!("did you mean `{meant}`?"))
            .fix(meant);
    }
    let start = span.start + written.find(part).unwrap_or(0);
    let place = Span { start, end: start + part.len(), ..span };
    Diagnostic::error("unknown-unit", place, format!("`{}` is not a unit", cut(part)))
        .help(format!("known here: {}", quoted(units.iter().copied())))
        .help("the word after a number is its unit; any other word follows a sign, a comma or a new line")
}

/// A formula names a variable that has no value at this event.
pub fn unavailable_variable(span: Span, word: &str, event: &str, known: &[&str]) -> Diagnostic {
    if event == "begin" {
        return Diagnostic::error(
            "unavailable-variable",
            span,
            format!("`{word}` has no value before an episode begins"),
        )
        .help(format!("available: {}", quoted(known.iter().copied())));
    }
    Diagnostic::error("unavailable-variable", span, format!("`{word}` has no value at `{event}`"))
        .help(format!("available at `{event}`: {}", quoted(known.iter().copied())))
}

/// A plain number is compared with a quantity, or added to one.
pub fn bare_number(span: Span, dimension: Dimension, written: &str, other: Span) -> Diagnostic {
    missing_unit(span, dimension, written).label(other, format!("this is {}", one(dimension)))
}

/// Two sides of an operator, or two arguments, have different dimensions.
pub fn mixed_dimensions(left: Span, first: Dimension, right: Span, second: Dimension) -> Diagnostic {
    let diagnostic =
        Diagnostic::error("mixed-dimensions", right, format!("{} and {} do not mix", one(first), one(second)))
            .here(format!("this is {}", one(second)))
            .label(left, format!("this is {}", one(first)));
    let quantity = if first == Dimension::RATIO { second } else { first };
    match quantity.usual_units().first() {
        Some(unit) if first == Dimension::RATIO || second == Dimension::RATIO => {
            diagnostic.help(format!("to convert {} to a plain number, write `… in {unit}`", one(quantity)))
        }
        _ => diagnostic,
    }
}

/// An event needs the name of a declaration in parentheses.
pub fn nameless_event<'a>(span: Span, event: &str, form: &str, known: impl Iterator<Item = &'a str>) -> Diagnostic {
    let known: Vec<&str> = known.collect();
    let said = Diagnostic::error("unknown-event-word", span, format!("the event `{event}` needs the name of a {form}"));
    match known.first() {
        Some(first) => said.help(format!("write `on {event}({first})`; known here: `{}`", known.join("`, `"))),
        None => said.help(format!("declare a {form}, and write its name in parentheses: `on {event}(name)`")),
    }
}
