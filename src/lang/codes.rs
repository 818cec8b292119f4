//! Every diagnostic of the language, one function a code, so that all wording sits in one file.

use std::io::ErrorKind;

use crate::diagnostic::{Diagnostic, Label, Span};
use crate::signature::{Param, Type};
use crate::units::{Dimension, parse_unit};

use super::suggest::nearest;
use super::{library, reason, shelf};

/// Most words of a list that is shown; a file made to break the program may have any number.
const MOST_SHOWN: usize = 40;

fn quoted<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    let mut words = words.into_iter();
    let mut shown: Vec<String> = words.by_ref().take(MOST_SHOWN).map(|word| format!("`{}`", cut(word))).collect();
    shown.extend(words.next().map(|_| "…".to_string()));
    shown.join(", ")
}

/// A word of the user's as it is shown.
fn cut(word: &str) -> std::borrow::Cow<'_, str> {
    const MOST: usize = 60;
    match word.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &word[..end]).into(),
        None => word.into(),
    }
}

/// A thing with its article; what begins with a quote or `one of` has none.
pub(super) fn one(thing: impl std::fmt::Display) -> String {
    let thing = thing.to_string();
    match thing.chars().next() {
        Some('`') => thing,
        _ if thing.starts_with("one of") || thing.starts_with("text") => thing,
        Some('a' | 'e' | 'i' | 'o') => format!("an {thing}"),
        _ => format!("a {thing}"),
    }
}

/// Points at an unknown word, offers the nearest known one or lists them all; the message is given.
fn unknown<'a>(
    code: &'static str,
    span: Span,
    message: String,
    word: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Diagnostic {
    // As above: comparing every unknown word with every known one would never end.
    const MOST: usize = 200;
    let diagnostic = Diagnostic::error(code, span, message);
    let known: Vec<&str> = known.into_iter().take(MOST).collect();
    match nearest(word, known.iter().copied()) {
        Some(near) => diagnostic.here(format!("did you mean `{near}`?")).fix(near),
        None if known.is_empty() => diagnostic.here("none is known here"),
        None => diagnostic.help(format!("known here: {}", quoted(known))),
    }
}

/// A statement has no shape the grammar knows.
pub fn syntax(span: Span, text: String) -> Diagnostic {
    Diagnostic::error("syntax", span, "this statement cannot be read").here(text)
}

/// A statement holds a sign of another language, or of print.
pub fn slip(span: Span, said: &str, meant: Option<&str>) -> Diagnostic {
    let diagnostic = Diagnostic::error("syntax", span, "this statement cannot be read").here(said);
    match meant {
        Some(meant) => diagnostic.fix(meant),
        None => diagnostic,
    }
}

/// A number is written with a comma.
pub fn decimal_comma(span: Span, written: &str) -> Diagnostic {
    let diagnostic = Diagnostic::error("syntax", span, "this statement cannot be read");
    let thousands = written.split(',').skip(1).all(|part| part.len() == 3) && !written.starts_with('0');
    if written.matches(',').count() > 1 {
        return diagnostic.here("no comma stands in a number").fix(written.replace(',', "_"));
    }
    if thousands {
        return diagnostic
            .here("no comma stands in a number")
            .fix(written.replace(',', "_"))
            .fix(written.replace(',', "."));
    }
    diagnostic.here("the sign before the fraction of a number is a point").fix(written.replace(',', "."))
}

/// Several values stand side by side.
pub fn unbracketed_list(span: Span, written: &str) -> Diagnostic {
    Diagnostic::error("syntax", span, "this statement cannot be read")
        .here("several values stand in brackets")
        .fix(format!("[{written}]"))
}

/// A parameter has no type.
pub fn untyped_param(span: Span, name: &str, ty: Option<&str>) -> Diagnostic {
    let diagnostic = Diagnostic::error("syntax", span, "this statement cannot be read").here("a parameter has a type");
    match ty {
        Some(ty) => diagnostic.fix(format!("{name}: {ty}")),
        None => diagnostic.help("types are the dimensions (`length`, `speed`, …), `number`, `integer`, `boolean`, `text`, `word` and the forms"),
    }
}

/// Two values follow each other inside parentheses or brackets.
pub fn missing_comma(span: Span) -> Diagnostic {
    Diagnostic::error("syntax", span, "this statement cannot be read").here("a comma is missing here").fix(",")
}

/// A bracket is never closed.
pub fn unclosed_bracket(span: Span, bracket: char, unended: Option<Span>, commented: Option<Span>) -> Diagnostic {
    let diagnostic =
        Diagnostic::error("unclosed-bracket", span, format!("`{bracket}` is never closed")).here("opened here");
    match (unended, commented) {
        (Some(text), _) => diagnostic.label(text, "this text is not closed on its line"),
        (None, Some(comment)) => diagnostic.label(comment, "from here on this line is a comment"),
        (None, None) => diagnostic,
    }
}

/// A closing bracket has no partner.
pub fn stray_bracket(span: Span) -> Diagnostic {
    Diagnostic::error("stray-bracket", span, "this bracket closes nothing")
        .help("remove it, or add its opening partner")
}

/// What is said of the opening bracket that another one closes.
pub(super) const OPENED: &str = "opened here";

/// A closing bracket meets another kind of opening one.
pub fn mismatched_bracket(span: Span, opening: Span, bracket: char) -> Diagnostic {
    Diagnostic::error("mismatched-bracket", span, format!("this does not close `{bracket}`")).label(opening, OPENED)
}

/// Brackets nest too deep.
pub fn too_deep(span: Span, limit: usize) -> Diagnostic {
    Diagnostic::error("too-deep", span, format!("brackets nest deeper than {limit} levels"))
}

/// An expression is too long.
pub fn too_long(span: Span, limit: usize) -> Diagnostic {
    Diagnostic::error("too-long", span, format!("this expression has more than {limit} terms and signs"))
}

/// A name is too long for the files that are named after it.
pub fn long_name(span: Span, limit: usize) -> Diagnostic {
    Diagnostic::error("too-long", span, format!("this name has more than {limit} letters"))
        .help("files of the report are named after it")
}

/// The name of a combination is too long for the files that are named after it.
pub fn long_combination(span: Span, name: &str, limit: usize) -> Diagnostic {
    Diagnostic::error(
        "too-long",
        span,
        format!("a combination's name would have more than {limit} letters: `{}`", cut(name)),
    )
    .help("give its parameters shorter names, or fewer of them")
}

/// A comment is never closed.
pub fn unclosed_comment(span: Span) -> Diagnostic {
    Diagnostic::error("unclosed-comment", span, "this comment is never closed").help("close it with `*/`")
}

/// A file is too large.
pub fn too_large(span: Span, bytes: usize, limit: usize) -> Diagnostic {
    Diagnostic::error("too-large", span, format!("the file has {bytes} bytes; at most {limit} are read"))
}

/// The file does not say which edition of the language it is written in.
pub fn missing_edition(span: Span) -> Diagnostic {
    Diagnostic::error("missing-edition", span, "the file does not name its edition")
        .here("write `edition 1` before all else, so that later versions of the language read it as you meant it")
        .fix("edition 1\n")
}

/// The edition is not one this program reads.
pub fn unknown_edition(span: Span, edition: f64) -> Diagnostic {
    Diagnostic::error("unknown-edition", span, format!("edition {edition} is not known"))
        .here("this program reads edition 1")
        .fix("1")
}

/// The edition is named again, or late.
pub fn misplaced_edition(span: Span, first: Option<Span>) -> Diagnostic {
    let diagnostic = Diagnostic::error("misplaced-edition", span, "the edition stands once, and first in the file");
    match first {
        Some(first) => diagnostic.label(first, "first named here"),
        None => diagnostic.help("move it to the beginning of the file"),
    }
}

/// An import leads to no file that can be read.
pub fn import_not_found(span: Span, path: &str, error: &std::io::Error) -> Diagnostic {
    let diagnostic = Diagnostic::error("import-not-found", span, format!("cannot import `{path}`: {}", reason(error)));
    let library: Vec<String> = library::names().map(|name| format!("std/{name}")).collect();
    if path.starts_with("std/") {
        let whole = format!("{path}.scn");
        if library.contains(&whole) {
            return diagnostic.here(format!("did you mean `{whole}`?")).fix(format!("\"{whole}\""));
        }
        return match nearest(path, library.iter().map(String::as_str)) {
            Some(near) => diagnostic.here(format!("did you mean `{near}`?")).fix(format!("\"{near}\"")),
            None => diagnostic,
        };
    }
    match error.kind() {
        ErrorKind::NotFound => match library.iter().find(|file| file.ends_with(&format!("/{path}"))) {
            Some(file) => diagnostic.here("the standard library has it").fix(format!("\"{file}\"")),
            None => diagnostic.help("paths are relative to the folder of the file that imports"),
        },
        ErrorKind::InvalidData => diagnostic.help("save it as UTF-8"),
        _ => diagnostic,
    }
}

/// Files import each other in a circle; they are given in their order, from the one that is imported here again.
pub fn import_cycle(span: Span, path: &str, circle: &[String]) -> Diagnostic {
    const MOST: usize = 8;
    let diagnostic = Diagnostic::error("import-cycle", span, format!("`{path}` imports this file in turn"));
    let diagnostic = match circle {
        [] | [_] => diagnostic.here("a file need not import itself"),
        files => {
            let mut shown: Vec<&str> = files.iter().take(MOST).map(String::as_str).collect();
            shown.extend((files.len() > MOST).then_some("…"));
            shown.push(&files[0]);
            diagnostic.help(format!("the circle: {}", shown.join(" → ")))
        }
    };
    diagnostic.help("move what both need into a third file")
}

/// An import names something that the file does not declare.
pub fn unknown_import<'a>(span: Span, word: &str, path: &str, known: impl IntoIterator<Item = &'a str>) -> Diagnostic {
    unknown("unknown-import", span, format!("`{path}` declares no `{}`", cut(word)), word, known)
}

/// A parameter is defined by itself.
pub fn param_cycle(span: Span, name: &str) -> Diagnostic {
    Diagnostic::error("param-cycle", span, format!("the parameter `{name}` is defined by itself"))
        .help("give one of the parameters of the circle a value of its own")
}

/// A parameter bears the name of a variable of formulas.
pub fn reserved_name(span: Span, name: &str) -> Diagnostic {
    Diagnostic::error("reserved-name", span, format!("`{name}` is a variable of formulas already"))
        .help("give the parameter another name")
}

/// A parameter that stands for a word is named like one.
pub fn reserved_word(span: Span, name: &str) -> Diagnostic {
    Diagnostic::error("reserved-name", span, format!("`{name}` is a word of the language already"))
        .help("give the parameter another name: it would stand in place of the word wherever that is written")
}

/// The type of a parameter is not known.
pub fn unknown_type(span: Span, word: &str, known: &[&str]) -> Diagnostic {
    let message = format!("unknown type `{}`", cut(word));
    match elsewhere(word).filter(|own| known.contains(own)) {
        Some(own) => {
            Diagnostic::error("unknown-type", span, message).here(format!("here it is called `{own}`")).fix(own)
        }
        None => unknown("unknown-type", span, message, word, known.iter().copied()),
    }
}

/// A setting is not written as `name=value`.
pub fn bad_setting(span: Span, reason: &str) -> Diagnostic {
    Diagnostic::error("bad-setting", span, format!("this setting cannot be read: {reason}"))
        .help("write `name=value` for a parameter, or `declaration.key=value`")
}

/// Two settings are for the same.
pub fn repeated_setting(span: Span, path: &str, first: Span) -> Diagnostic {
    Diagnostic::error("bad-setting", span, format!("`{path}` is set twice")).label(first, "first set here")
}

/// A matrix speaks of the key of a declaration.
pub fn dotted_key(span: Span, path: &str) -> Diagnostic {
    let key = path.rsplit('.').next().unwrap_or(path);
    Diagnostic::error("syntax", span, "this statement cannot be read").here("a key has no points").help(format!(
        "a `matrix` sets parameters: declare one, as in `param {key}: number = …`, name it where `{path}` stands, and here"
    ))
}

/// A matrix sets what its campaign does not hang on.
pub fn idle_axis(span: Span, name: &str, campaign: &str) -> Diagnostic {
    Diagnostic::warning("unused", span, format!("nothing in `{campaign}` hangs on `{name}`"))
        .here("its combinations are the same but for their names")
}

/// A setting names nothing.
pub fn unknown_setting<'a>(span: Span, word: &str, known: impl IntoIterator<Item = &'a str>) -> Diagnostic {
    unknown("unknown-setting", span, format!("unknown parameter or declaration `{}`", cut(word)), word, known)
}

/// A setting names several things.
pub fn ambiguous_setting(span: Span, word: &str, forms: &[&str]) -> Diagnostic {
    let ambiguous =
        Diagnostic::error("ambiguous-setting", span, format!("there are several declarations named `{word}`"));
    if forms.iter().all(|form| Some(form) == forms.first()) {
        return ambiguous
            .help("two files declare it; give the files one after the other, or rename one of the declarations");
    }
    let offers: Vec<String> = forms.iter().map(|form| format!("{form}.{word}.…")).collect();
    ambiguous.help(format!("put the form first: {}", quoted(offers.iter().map(String::as_str))))
}

/// A matrix multiplies beyond reason.
pub fn too_many_combinations(span: Span, found: usize, limit: usize) -> Diagnostic {
    Diagnostic::error(
        "too-many-combinations",
        span,
        format!("this makes {found} combinations; at most {limit} are run"),
    )
}

/// The first word of a declaration is no form.
pub fn unknown_form(span: Span, word: &str, forms: &[&str]) -> Diagnostic {
    if matches!(word, "param" | "let" | "def" | "const" | "var" | "val") {
        return Diagnostic::error("unknown-form", span, "this statement cannot be read")
            .help("a value with a name has a type: `param far: length = 30 m`");
    }
    unknown("unknown-form", span, format!("unknown declaration `{}`", cut(word)), word, forms.iter().copied())
}

/// The word after `=` is no kind of this form.
pub fn unknown_kind(span: Span, form: &str, word: &str, kinds: &[&str]) -> Diagnostic {
    unknown("unknown-kind", span, format!("unknown kind `{}` of {form}", cut(word)), word, kinds.iter().copied())
}

/// A form needs a kind and has none.
pub fn missing_kind(span: Span, form: &str, kinds: &[&str]) -> Diagnostic {
    Diagnostic::error("missing-kind", span, format!("{} needs a kind", one(form)))
        .help(format!("write `{form} name = kind(…)`; the kinds are {}", quoted(kinds.iter().copied())))
}

/// A declaration has no name.
pub fn missing_name(span: Span, form: &str) -> Diagnostic {
    Diagnostic::error("missing-name", span, format!("this {form} has no name")).help(format!("write `{form} name …`"))
}

/// What a word of other languages and libraries is called here: of stable-baselines3, Scenic, OpenSCENARIO, Python, C.
pub(super) fn elsewhere(word: &str) -> Option<&'static str> {
    Some(match word {
        "n_steps" => "steps_per_update",
        "total_timesteps" | "timesteps" => "steps",
        "n_epochs" => "epochs",
        "n_envs" | "num_envs" => "environments",
        "batch" | "minibatch_size" => "batch_size",
        "lr" | "step_size" => "learning_rate",
        "clip_range" | "clip_param" => "clip",
        "clip_range_vf" => "value_clip",
        "ent_coef" => "entropy_coefficient",
        "vf_coef" => "value_coefficient",
        "max_grad_norm" => "max_gradient_norm",
        "normalize_advantage" => "normalize_advantages",
        "stats_window_size" => "statistics_window",
        "lam" | "lambda" => "gae_lambda",
        "discount" => "gamma",
        "max_speed" | "speeds" => "speed",
        "dt" | "timestep" | "delta" => "tick",
        "max_steps" | "max_ticks" => "ticks",
        "angle" => "bearing",
        "radius" | "range" => "distance",
        "float" | "double" | "real" | "f64" => "number",
        "int" | "uint" | "i64" => "integer",
        "bool" => "boolean",
        "string" | "str" => "text",
        "collision" | "crash" | "collide" => "hit",
        "Range" | "Uniform" => "uniform",
        "Normal" | "Gaussian" | "gaussian" => "normal",
        "TruncatedNormal" => "truncated",
        "Options" | "Choice" | "uniform_choice" => "choice",
        "Discrete" => "weighted",
        "True" | "yes" | "TRUE" => "true",
        "False" | "no" | "FALSE" => "false",
        _ => return None,
    })
}

/// A key is not in the signature.
pub fn unknown_key(span: Span, owner: &str, word: &str, keys: &[&str]) -> Diagnostic {
    let message = format!("`{owner}` has no key `{}`", cut(word));
    match elsewhere(word).filter(|own| keys.contains(own)) {
        Some(own) => {
            Diagnostic::error("unknown-key", span, message).here(format!("here it is called `{own}`")).fix(own)
        }
        None => unknown("unknown-key", span, message, word, keys.iter().copied()),
    }
}

/// A key stands twice.
pub fn duplicate_key(span: Span, word: &str, first: Span) -> Diagnostic {
    Diagnostic::error("duplicate-key", span, format!("`{word}` is given twice")).label(first, "first given here")
}

/// A key without default is not given.
pub fn missing_key(span: Span, owner: &str, param: &Param) -> Diagnostic {
    Diagnostic::error("missing-key", span, format!("`{owner}` needs the key `{}`", param.name)).help(format!(
        "`{}` is {}: {}",
        param.name,
        one(param.ty.describe()),
        param.doc
    ))
}

/// A value in parentheses has no key.
pub fn bare_argument(span: Span, keys: &[&str]) -> Diagnostic {
    let diagnostic = Diagnostic::error("bare-argument", span, "this value has no key");
    match keys.first() {
        Some(first) => diagnostic.help(format!("write `{first}: …`; the keys are {}", quoted(keys.iter().copied()))),
        None => diagnostic.help("this kind takes no keys"),
    }
}

/// A function's argument has a key.
pub fn named_argument(span: Span, word: &str) -> Diagnostic {
    Diagnostic::error("named-argument", span, format!("functions take no keys such as `{word}`"))
}

/// A block may not stand here.
pub fn unknown_block(span: Span, owner: &str, word: &str, blocks: &[&str], keys: &[&str]) -> Diagnostic {
    if keys.contains(&word) {
        return Diagnostic::error("unknown-block", span, format!("`{word}` is a key of `{owner}`, not a block"))
            .help(format!("write `{word}: …`"));
    }
    if blocks.is_empty() {
        return Diagnostic::error("unknown-block", span, format!("`{owner}` has no blocks such as `{}`", cut(word)));
    }
    unknown("unknown-block", span, format!("`{owner}` has no block `{}`", cut(word)), word, blocks.iter().copied())
}

/// An `on` clause may not stand here.
pub fn unexpected_clause(span: Span, owner: &str) -> Diagnostic {
    Diagnostic::error("unexpected-clause", span, format!("`on` clauses have no place inside `{owner}`"))
        .help("they belong inside a `reward`")
}

/// Two declarations of a form share a name.
pub fn duplicate_declaration(span: Span, form: &str, name: &str, first: Span) -> Diagnostic {
    Diagnostic::error("duplicate-declaration", span, format!("there are two declarations of {form} `{name}`"))
        .label(first, "the other is here")
}

/// A reference leads to no declaration.
pub fn unknown_name<'a>(span: Span, form: &str, word: &str, known: impl IntoIterator<Item = &'a str>) -> Diagnostic {
    let message = format!("unknown {form} `{}`", cut(word));
    match shelf::home(form, word) {
        Some(file) => Diagnostic::error("unknown-name", span, message)
            .here("not among what this file sees")
            .help(format!("the standard library has it: `import \"std/{file}\"`")),
        None => unknown("unknown-name", span, message, word, known),
    }
}

/// A reference names something of another form.
pub fn other_form<'a>(
    span: Span,
    form: &str,
    word: &str,
    other: &str,
    known: impl IntoIterator<Item = &'a str>,
) -> Diagnostic {
    let diagnostic = Diagnostic::error("unknown-name", span, format!("unknown {form} `{}`", cut(word)))
        .here(format!("this is {}", one(other)));
    let known: Vec<&str> = known.into_iter().collect();
    if known.is_empty() { diagnostic } else { diagnostic.help(format!("known here: {}", quoted(known))) }
}

/// A reference names a kind.
pub fn kind_for_name(span: Span, form: &str, word: &str) -> Diagnostic {
    if shelf::home(form, word).is_some() {
        return unknown_name(span, form, word, []);
    }
    Diagnostic::error("unknown-name", span, format!("unknown {form} `{word}`"))
        .here(format!("this is a kind of {form}, not the name of one"))
        .help(format!("declare one, and name it here: `{form} mine = {word}()`"))
}

/// A declaration is never used.
pub fn unused(span: Span, form: &str, name: &str) -> Diagnostic {
    Diagnostic::warning("unused", span, format!("{form} `{name}` is never used"))
}

/// A value has another type than its key.
pub fn wrong_type(span: Span, expected: &Type, found: &str) -> Diagnostic {
    Diagnostic::error("wrong-type", span, format!("expected {}, found {found}", one(expected.describe())))
}

/// A value has another type than its key, and there is something to be said about how it is written.
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
    dimension.usual_units().iter().map(offer).fold(diagnostic, Diagnostic::fix)
}

/// Shows what the key of a value with a wrong unit, or with none, measures.
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

/// The unit that a word in full stands for, or an abbreviation that other languages have.
fn abbreviated(word: &str) -> Option<&'static str> {
    let lower = word.to_lowercase();
    match lower.as_str() {
        "mps" => return Some("m/s"),
        "mi/h" | "mile/h" | "miles/h" | "miles/hour" => return Some("mph"),
        _ => {}
    }
    Some(match lower.strip_suffix('s').filter(|rest| rest.len() > 1).unwrap_or(&lower) {
        "meter" | "metre" => "m",
        "kilometer" | "kilometre" => "km",
        "centimeter" | "centimetre" => "cm",
        "millimeter" | "millimetre" => "mm",
        "second" | "sec" => "s",
        "millisecond" | "msec" => "ms",
        "minute" => "min",
        "hour" | "hr" => "h",
        "degree" => "deg",
        "radian" => "rad",
        "hertz" => "Hz",
        "kilogram" => "kg",
        "kmh" | "kmph" => "km/h",
        _ => return None,
    })
}

/// A unit is not known.
pub fn unknown_unit(span: Span, written: &str, part: Option<&str>, units: &[&str]) -> Diagnostic {
    let Some(part) = part else {
        return Diagnostic::error("unknown-unit", span, format!("`{written}` is no unit"))
            .help("a power is a whole number from -9 to 9, as in `m/s^2`");
    };
    let diagnostic = Diagnostic::error("unknown-unit", span, format!("`{part}` is no unit"));
    if let Some(whole) = abbreviated(written).filter(|_| part != written) {
        return diagnostic.here(format!("did you mean `{whole}`?")).fix(whole);
    }
    // Of one letter nothing can be guessed.
    let like = |word: &&str| word.len() > 1 && part.len() > 1;
    let diagnostic = match abbreviated(part).or_else(|| nearest(part, units.iter().copied().filter(like))) {
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
        diagnostic.help("the word behind a number is its unit; put a comma or a line end before one that is not")
    } else {
        diagnostic.help(format!("to divide or multiply by something named `{part}`, put spaces round the sign"))
    }
}

/// A number is followed by the name of a quantity.
pub fn missing_sign(span: Span, word: &str) -> Diagnostic {
    Diagnostic::error("unknown-unit", span, format!("`{word}` is no unit"))
        .here("to multiply, write `*`")
        .fix(format!("* {word}"))
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

/// A part of a formula has no value, whatever happens.
pub fn not_finite(span: Span, why: &str) -> Diagnostic {
    Diagnostic::error("no-value", span, "this part of a formula has no value").here(why.to_string())
}

/// A part of a formula may have no value.
pub fn maybe_nothing(span: Span, why: &str, help: &str) -> Diagnostic {
    Diagnostic::error("no-value", span, "this part of a formula may have no value").here(why).help(help)
}

/// What is paid is beyond what learners count with.
pub fn too_much(span: Span, limit: f64) -> Diagnostic {
    Diagnostic::error("no-value", span, "this may be more than can be counted with")
        .here(format!("a reward lies within -{limit:e} and {limit:e}"))
        .help("scale it, or hold what it is made of: `min(…, 100)`")
}

/// A distribution reaches beyond the bounds of its key.
pub fn unbounded(span: Span, written: &str, bounds: &str) -> Diagnostic {
    Diagnostic::error("unbounded", span, "this distribution knows no bounds")
        .here(format!("allowed: {bounds}"))
        .help(format!("hold it between two values: `truncated({written}, low .. high)`"))
}

/// A function that makes distributions is not known.
pub fn unknown_distribution(span: Span, word: &str, known: &[&str]) -> Diagnostic {
    let message = format!("unknown distribution `{}`", cut(word));
    let low_to_high = "all values of a range: `low .. high`";
    match elsewhere(word).or_else(|| (word == "range").then_some("uniform")).filter(|own| known.contains(own)) {
        Some(own) => {
            let said =
                Diagnostic::error("unknown-distribution", span, message).here(format!("here it is called `{own}`"));
            let said = if own == "uniform" { said.help(low_to_high) } else { said };
            said.fix(own)
        }
        None => unknown("unknown-distribution", span, message, word, known.iter().copied()),
    }
}

/// Nothing of a distribution lies within a range.
pub fn nothing_left(span: Span, distribution: Span, range: Span) -> Diagnostic {
    Diagnostic::error("nothing-left", span, "nothing can be drawn from this")
        .label(distribution, "no value of this")
        .label(range, "lies in this range")
}

/// A range's low end lies above its high end; it may have been meant to go round the back.
pub fn empty_range(span: Span, swapped: String, around: Option<String>) -> Diagnostic {
    let said = Diagnostic::error("empty-range", span, "this range is empty: its low end lies above its high end");
    around.into_iter().fold(said.fix(swapped), Diagnostic::fix)
}

/// A whole number has a fraction.
pub fn not_whole(span: Span, value: f64) -> Diagnostic {
    Diagnostic::error("not-whole", span, format!("expected a whole number, found {value}"))
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
    // Of releases and versions none is meant for another.
    let stem = |word: &str| word.trim_end_matches(|last: char| last.is_ascii_digit() || last == '.').to_string();
    if words.iter().any(|known| stem(known) == stem(word) && known.ends_with(|last: char| last.is_ascii_digit())) {
        return Diagnostic::error("unknown-choice", span, message)
            .help(format!("known here: {}", quoted(words.iter().copied())));
    }
    unknown("unknown-choice", span, message, word, words.iter().copied())
}

/// A formula names an unknown variable.
pub fn unknown_variable<'a>(span: Span, word: &str, known: impl IntoIterator<Item = &'a str>) -> Diagnostic {
    if parse_unit(word).is_ok() {
        return Diagnostic::error("unknown-variable", span, format!("unknown variable or parameter `{}`", cut(word)))
            .here("a unit stands behind a number")
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
        .help(format!("there are {}", quoted(known.iter().copied())));
    }
    Diagnostic::error("unavailable-variable", span, format!("`{word}` has no value at `{event}`"))
        .help(format!("at `{event}` there are {}", quoted(known.iter().copied())))
}

/// A formula calls an unknown function.
pub fn unknown_function(span: Span, word: &str, known: &[&str]) -> Diagnostic {
    unknown("unknown-function", span, format!("unknown function `{}`", cut(word)), word, known.iter().copied())
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
            diagnostic.help(format!("to count {} in {unit} on purpose, write `… in {unit}`", one(quantity)))
        }
        _ => diagnostic,
    }
}

/// A condition stands where a quantity is wanted, or the other way round.
pub fn not_a(span: Span, wanted: &str, found: &str) -> Diagnostic {
    Diagnostic::error("wrong-type", span, format!("expected {}, found {}", one(wanted), one(found)))
}

/// A clause answers to an unknown event.
pub fn unknown_event(span: Span, word: &str, known: &[&str]) -> Diagnostic {
    let message = format!("unknown event `{}`", cut(word));
    match elsewhere(word).filter(|own| known.contains(own)) {
        Some(own) => {
            Diagnostic::error("unknown-event", span, message).here(format!("here it is called `{own}`")).fix(own)
        }
        None => unknown("unknown-event", span, message, word, known.iter().copied()),
    }
}

/// An event's word is unknown.
pub fn unknown_event_word(span: Span, event: &str, word: &str, known: &[&str]) -> Diagnostic {
    unknown(
        "unknown-event-word",
        span,
        format!("the event `{event}` has no word `{}`", cut(word)),
        word,
        known.iter().copied(),
    )
}

/// Two clauses answer to the same event.
pub fn duplicate_clause(span: Span, first: Span) -> Diagnostic {
    Diagnostic::error("duplicate-clause", span, "this event has a clause already").label(first, "the first is here")
}

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
