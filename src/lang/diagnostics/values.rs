//! Wrong values: types, units, bounds; formulas, ranges, distributions, events.

use std::f64::consts::TAU;

use super::super::foreign_names::own_unit;
use super::super::suggest::nearest;
use super::{cut, one, quoted, unknown};
use base::diagnostic::{Diagnostic, Fix, Label, Span};
use base::signature::{Param, Type, short};
use base::units::{Dimension, parse_unit};

/// A value has another type than its key.
pub fn wrong_type(span: Span, expected: &Type, found: &str) -> Diagnostic {
    Diagnostic::error("wrong-type", span, format!("expected {}, found {found}", one(expected.describe())))
}

/// A value has another type than its key, and there is advice on how to write it.
pub fn written_otherwise(expected: &Type, found: &str, span: Span, fix: Option<String>, help: &str) -> Diagnostic {
    let diagnostic = wrong_type(span, expected, found);
    let diagnostic = if help.is_empty() { diagnostic } else { diagnostic.help(help) };
    fix.into_iter().fold(diagnostic, Diagnostic::fix)
}

/// A bare number stands where a unit is needed.
pub fn missing_unit(span: Span, dimension: Dimension, written: &str) -> Diagnostic {
    let diagnostic = Diagnostic::error("missing-unit", span, format!("{} needs a unit", one(dimension)));
    let plain = written.trim_start_matches('-').chars().all(|c| c.is_ascii_digit() || matches!(c, '.' | '_'));
    let offer = |unit: &&str| if plain { format!("{written} {unit}") } else { format!("({written}) * 1 {unit}") };
    let mut units = dimension.usual_units().to_vec();
    if likelier_second(dimension, written) {
        units.reverse();
    }
    units.iter().map(offer).fold(diagnostic, Diagnostic::fix)
}

/// Both ends of a range lack their unit.
pub fn missing_unit_of_both(span: Span, dimension: Dimension, written: &str, (low, high): (&str, &str)) -> Diagnostic {
    let diagnostic = missing_unit(span, dimension, written);
    let large = if high.len() >= low.len() { high } else { low };
    let units: Vec<String> = missing_unit(span, dimension, large).fixes.into_iter().map(|fix| fix.text).collect();
    let units = units.iter().filter_map(|text| text.strip_prefix(large)).map(str::trim);
    let fixes = units.map(|unit| Fix { span, text: format!("{low} {unit} .. {high} {unit}") }).collect();
    Diagnostic { fixes, ..diagnostic }
}

/// A range stands where a matrix takes values one by one.
pub fn axis_range(span: Span, [low, high]: [&str; 2]) -> Diagnostic {
    Diagnostic::error("wrong-type", span, "a matrix takes a list of values, not a range")
        .fix(format!("[{low}, {high}]"))
}

/// All numbers of one place, or of several, lack their units.
pub fn missing_units(span: Span, meant: String) -> Diagnostic {
    Diagnostic::error("missing-unit", span, "every number of a place needs a unit").fix(meant)
}

/// Whether a bare number is more likely in the second of the usual units: a speed that would be too high for a town in m/s, or a
/// few degrees with a fraction.
fn likelier_second(dimension: Dimension, written: &str) -> bool {
    let number = written.replace('_', "").parse::<f64>().unwrap_or(0.0).abs();
    match dimension {
        Dimension::SPEED => number >= 15.0,
        Dimension::ANGLE => number <= TAU && number.fract() != 0.0,
        _ => false,
    }
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

/// A time (s) stands for a number of ticks of this length (s).
pub fn time_for_ticks(span: Span, key: &str, time: f64, tick: f64) -> Diagnostic {
    let count = (time / tick).round().max(1.0);
    Diagnostic::error("wrong-unit", span, format!("`{key}` is a number of ticks, not a time"))
        .here(format!("{} s are {count} ticks of {} s", short(time), short(tick)))
        .fix(count.to_string())
}

/// A time stands for a number of ticks whose length another declaration gives.
pub fn time_for_budget(span: Span, key: &str) -> Diagnostic {
    Diagnostic::error("wrong-unit", span, format!("`{key}` is a number of simulator ticks, not a time"))
        .here("write a plain number, such as `200_000`")
        .help("a tick is 0.05 s of simulated time unless `tick` of the `episode` is another")
}

/// A quantity is counted in units of something else.
pub fn wrong_count(unit: Span, measured: Dimension, quantity: Span, found: Dimension) -> Diagnostic {
    let diagnostic =
        Diagnostic::error("wrong-unit", unit, format!("{} is not counted in units of {measured}", one(found)))
            .label(quantity, format!("this is {}", one(found)));
    match found {
        Dimension::RATIO => diagnostic.here("remove this unit"),
        _ => found.usual_units().iter().copied().fold(diagnostic, Diagnostic::fix),
    }
}

/// A plain number is expected, and the quantity is no number whose unit could be removed.
pub fn uncounted(span: Span, found: Dimension) -> Diagnostic {
    let diagnostic = Diagnostic::error("wrong-unit", span, format!("expected a plain number, found {}", one(found)));
    match found.usual_units().first() {
        Some(unit) => diagnostic.help(format!("convert it to a plain number: `… in {unit}`")),
        None => diagnostic.help("divide it by a quantity of the same dimension"),
    }
}

/// A unit is not known.
pub fn unknown_unit(span: Span, written: &str, part: Option<&str>, units: &[&str]) -> Diagnostic {
    let Some(part) = part else {
        return Diagnostic::error("unknown-unit", span, format!("`{written}` is not a unit"))
            .help("a power is a whole number from -9 to 9, as in `m/s^2`");
    };
    let diagnostic = Diagnostic::error("unknown-unit", span, format!("`{part}` is not a unit"));
    if written == "m/h" {
        return diagnostic.here("a car is faster than some metres per hour").fix("mph").fix("km/h");
    }
    if ["ft", "feet", "foot", "yd", "inch"].contains(&part) {
        return diagnostic.help("lengths are metric: 1 ft is 0.3048 m");
    }
    // A thousandth is another unit, not a typo.
    if ["us", "ns", "um", "nm"].contains(&part) {
        return diagnostic.help("the smallest units are `ms` and `mm`; write a fraction");
    }
    if ["k", "K"].contains(&written) {
        return diagnostic.help("numbers are written in full: `100_000`, `1e5`");
    }
    if let Some(whole) = own_unit(written).filter(|_| part != written) {
        return diagnostic.here(format!("did you mean `{whole}`?")).fix(whole);
    }
    let lower = written.to_lowercase();
    if parse_unit(&lower).is_ok() {
        return diagnostic.here(format!("did you mean `{lower}`?")).fix(lower);
    }
    // A single letter allows no guess.
    let like = |word: &&str| word.len() > 1 && part.len() > 1;
    let diagnostic = match own_unit(part).or_else(|| nearest(part, units.iter().copied().filter(like))) {
        Some(near) if part == written => diagnostic.here(format!("did you mean `{near}`?")).fix(near),
        Some(near) if !part.ends_with(|last: char| last.is_ascii_digit()) => {
            diagnostic.here(format!("did you mean `{near}`?")).fix(written.replace(part, near))
        }
        _ => match part.split_at(part.len() - 1) {
            // `m/s2` is `m/s^2`.
            (base, power @ ("2" | "3")) if units.contains(&base) => {
                let meant = format!("{base}^{power}");
                diagnostic.here(format!("did you mean `{meant}`?")).fix(written.replace(part, &meant))
            }
            _ => diagnostic.help(format!("units: {}", quoted(units.iter().copied()))),
        },
    };
    if part == written {
        diagnostic.help("the word after a number is its unit; separate any other word by a comma or a new line")
    } else {
        diagnostic.help(format!("to divide or multiply by something named `{part}`, put spaces around the sign"))
    }
}

/// A number is followed by the name of a quantity.
pub fn missing_sign(span: Span, word: &str) -> Diagnostic {
    Diagnostic::error("unknown-unit", span, format!("`{word}` is not a unit"))
        .here("to multiply, write `*`")
        .fix(format!("* {word}"))
}

/// Whether a diagnostic reports a missing sign.
pub fn lacks_sign(said: &Diagnostic) -> bool {
    said.code == "unknown-unit" && said.fixes.iter().any(|fix| fix.text.starts_with("* "))
}

/// Offers a comma instead of the sign.
pub fn or_comma(said: &mut Diagnostic) {
    said.primary.text = "a comma is missing, or a sign".into();
    let with_comma = |fix: &Fix| Fix { text: fix.text.replacen("* ", ", ", 1), span: fix.span };
    said.fixes = said.fixes.iter().map(with_comma).chain(said.fixes.iter().cloned()).collect();
}

/// Two comparisons share a quantity.
pub fn chained(span: Span, middle: Span) -> Diagnostic {
    Diagnostic::error("wrong-type", span, "a comparison has two sides")
        .label(middle, "compared with both")
        .help("compare twice: `low < it and it < high`")
}

/// A value lies outside its bounds.
pub fn out_of_range(span: Span, found: String, bounds: String) -> Diagnostic {
    Diagnostic::error("out-of-range", span, format!("{found} is out of range")).here(format!("allowed: {bounds}"))
}

/// A part of a formula never has a value.
pub fn not_finite(span: Span, why: &str) -> Diagnostic {
    Diagnostic::error("no-value", span, "this part of a formula has no value").here(why.to_string())
}

/// A part of a formula may have no value.
pub fn maybe_nothing(span: Span, why: &str, help: &str) -> Diagnostic {
    Diagnostic::error("no-value", span, "this part of a formula may have no value").here(why).help(help)
}

/// A reward is beyond the range of the learners' numbers.
pub fn too_much(span: Span, limit: f64) -> Diagnostic {
    Diagnostic::error("no-value", span, "this value may be too large")
        .here(format!("a reward must be between -{limit:e} and {limit:e}"))
        .help("scale it, or limit its parts: `min(…, 100)`")
}

/// A distribution reaches beyond the bounds of its key.
pub fn unbounded(span: Span, written: &str, bounds: &str) -> Diagnostic {
    let diagnostic =
        Diagnostic::error("unbounded", span, "this distribution has no bounds").here(format!("allowed: {bounds}"));
    match bounds.split_once(" to ") {
        Some((low, high)) => diagnostic.fix(format!("truncated({written}, {low} .. {high})")),
        None => diagnostic.help(format!("limit it to a range: `truncated({written}, low .. high)`")),
    }
}

/// A function that makes distributions is not known.
pub fn unknown_distribution(span: Span, word: &str, known: &[&str]) -> Diagnostic {
    if word == "TruncatedNormal" {
        return Diagnostic::error("unknown-distribution", span, format!("unknown distribution `{word}`"))
            .help("write `truncated(normal(mean, deviation), low .. high)`");
    }
    if ["degrees", "deg", "radians", "rad", "meters", "metres", "seconds", "kmh"].contains(&word) {
        return Diagnostic::error("unknown-distribution", span, format!("unknown distribution `{word}`"))
            .help("a unit follows its number: `90 deg`");
    }
    // In other places `range` may be a key.
    let own = if word == "range" { "Range" } else { word };
    let said = unknown(
        "unknown-distribution",
        span,
        format!("unknown distribution `{}`", cut(word)),
        own,
        known.iter().copied(),
    );
    let uniform = said.fixes.iter().any(|fix| fix.text == "uniform");
    if uniform { said.help("all values of a range: `low .. high`") } else { said }
}

/// Nothing of a distribution lies within a range.
pub fn nothing_left(span: Span, distribution: Span, range: Span) -> Diagnostic {
    Diagnostic::error("nothing-left", span, "nothing can be drawn from this")
        .label(distribution, "no value of this")
        .label(range, "lies in this range")
}

/// A distribution has more parts than are kept.
pub fn too_many_parts(span: Span, most: usize) -> Diagnostic {
    Diagnostic::error("too-many-parts", span, format!("this distribution has more than {most} parts"))
        .help("every `choice` has the parts of all that it names: use fewer, or a range")
}

/// A range's low end is above its high end; the author may have meant the range through ±180°.
pub fn empty_range(span: Span, swapped: String, around: Option<String>) -> Diagnostic {
    let said = Diagnostic::error("empty-range", span, "this range is empty: its low end lies above its high end");
    around.into_iter().fold(said.fix(swapped), Diagnostic::fix)
}

/// A whole number has a fraction.
pub fn not_whole(span: Span, value: f64) -> Diagnostic {
    Diagnostic::error("not-whole", span, format!("expected a whole number, found {value}"))
}

/// A whole number is written with a point, which some countries use between thousands.
pub fn pointed(span: Span, written: &str) -> Diagnostic {
    let diagnostic = Diagnostic::error("not-whole", span, "a whole number has no point");
    let (whole, part) = written.split_once('.').unwrap_or((written, ""));
    let plain = diagnostic.fix(whole);
    if part.len() % 3 == 0 { plain.fix(format!("{whole}_{}", part.replace('.', "_"))) } else { plain }
}

/// A difference of two quantities is written where a range may be, and a range is probably meant; `value` is the difference.
pub fn difference(span: Span, value: &str, range: &str) -> Diagnostic {
    Diagnostic::warning("difference", span, format!("this is {value}: `-` subtracts"))
        .here("a range is written `low .. high`")
        .fix(range)
        .fix(value)
}

/// A list has no members.
pub fn empty_list(span: Span) -> Diagnostic {
    Diagnostic::error("empty-list", span, "this list is empty").help("name at least one member")
}

/// A list names something twice.
pub fn repeated_member(span: Span, written: &str, first: Span) -> Diagnostic {
    Diagnostic::error("repeated-member", span, format!("`{written}` is in this list twice")).label(first, "first here")
}

/// A word is not among the choices.
pub fn unknown_choice(span: Span, word: &str, words: &[&str]) -> Diagnostic {
    let message = format!("`{}` is not among the choices", cut(word));
    // No release or version is a typo of another.
    let stem = |word: &str| word.trim_end_matches(|last: char| last.is_ascii_digit() || last == '.').to_string();
    if words.iter().any(|known| stem(known) == stem(word) && known.ends_with(|last: char| last.is_ascii_digit())) {
        return Diagnostic::error("unknown-choice", span, message)
            .help(format!("known here: {}", quoted(words.iter().copied())));
    }
    unknown("unknown-choice", span, message, word, words.iter().copied())
}

/// A formula names an unknown variable.
pub fn unknown_variable<'a>(span: Span, word: &str, known: impl IntoIterator<Item = &'a str>) -> Diagnostic {
    if matches!(word, "return" | "if" | "else" | "then") {
        return Diagnostic::error("unknown-variable", span, format!("there is no `{word}` in formulas"))
            .help("weigh with `min` and `max`: `max(0, v_c in m/s - 3)` pays from 3 m/s on");
    }
    let special = match word {
        "visible" | "hidden" => "write `sight: visible` or `sight: hidden` in the `spawn`",
        "collision" | "hit" => "an episode ends at a collision without a condition",
        _ => "",
    };
    if !special.is_empty() {
        return Diagnostic::error("unknown-variable", span, format!("unknown variable or parameter `{word}`"))
            .help(special);
    }
    if parse_unit(word).is_ok() {
        return Diagnostic::error("unknown-variable", span, format!("unknown variable or parameter `{}`", cut(word)))
            .here("a unit follows a number")
            .fix(format!("1 {word}"));
    }
    unknown("unknown-variable", span, format!("unknown variable or parameter `{}`", cut(word)), word, known)
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

/// A formula calls an unknown function.
pub fn unknown_function(span: Span, word: &str, known: &[&str]) -> Diagnostic {
    let said =
        unknown("unknown-function", span, format!("unknown function `{}`", cut(word)), word, known.iter().copied());
    if matches!(word, "clip" | "clamp") { said.help("write `max(low, min(x, high))`") } else { said }
}

/// A function has the wrong number of arguments.
pub fn wrong_arity(span: Span, function: &str, expected: &str, found: usize) -> Diagnostic {
    Diagnostic::error("wrong-arity", span, format!("`{function}` takes {expected}, found {found}"))
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

/// A condition stands where a quantity is wanted, or the other way round.
pub fn not_a(span: Span, wanted: &str, found: &str) -> Diagnostic {
    Diagnostic::error("wrong-type", span, format!("expected {}, found {}", one(wanted), one(found)))
}

/// A clause names an unknown event; `of` is the event of which it is a word.
pub fn unknown_event(span: Span, word: &str, known: &[&str], of: Option<&str>) -> Diagnostic {
    if let Some(event) = of {
        return Diagnostic::error("unknown-event", span, format!("unknown event `{}`", cut(word)))
            .here(format!("this is a word of the event `{event}`"))
            .fix(format!("{event}({word})"));
    }
    unknown("unknown-event", span, format!("unknown event `{}`", cut(word)), word, known.iter().copied())
}

pub fn unknown_event_word(span: Span, event: &str, word: &str, known: &[&str]) -> Diagnostic {
    unknown(
        "unknown-event-word",
        span,
        format!("the event `{event}` has no word `{}`", cut(word)),
        word,
        known.iter().copied(),
    )
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

/// The robustness of a requirement is used outside of rewards.
pub fn robustness_outside(span: Span) -> Diagnostic {
    Diagnostic::error("wrong-type", span, "`robustness` belongs in a reward")
        .help("there it is how far an episode is from violating the requirement: `on lost => -robustness(slow_pass)`")
}

/// A temporal operator stands inside a formula of quantities.
pub fn temporal_in_formula(span: Span, word: &str) -> Diagnostic {
    Diagnostic::error("wrong-type", span, format!("`{word}` belongs in a requirement, around conditions"))
        .help("declare one: `requirement name = always(gap > 0.5 m)`; a campaign names it in `requirements`")
}

/// A bound has not two ends.
pub fn wrong_bound(span: Span, found: usize) -> Diagnostic {
    Diagnostic::error("wrong-type", span, format!("a bound has two times, found {found}"))
        .help("from and to, both included, after the present sample: `[0 s, 2 s]`")
}

/// A comparison has the same result for all values of its variables.
pub fn foregone(span: Span, truth: bool) -> Diagnostic {
    Diagnostic::error("foregone", span, format!("this comparison is always {truth}"))
        .here("so it is for all values within the bounds of what it names")
        .help("`falsify explain NAME` gives the bounds of a variable")
}

/// A requirement without a temporal operator.
pub fn only_at_start(span: Span, written: &str) -> Diagnostic {
    Diagnostic::warning("start-only", span, "this requirement is about the start of an episode only")
        .here("without `always`, `eventually` or `until` only the first sample counts")
        .fix(format!("always({written})"))
}

/// Two clauses name the same event.
pub fn duplicate_clause(span: Span, first: Span) -> Diagnostic {
    Diagnostic::error("duplicate-clause", span, "this event already has a clause").label(first, "the first is here")
}
