//! Wrong names: forms, kinds, keys, declarations, parameters, settings.

use super::super::foreign_names::{counts_pedestrians, own_words};
use super::super::suggest::nearest;
use super::{cut, one, quoted, unknown};
use crate::ast::Name;
use base::diagnostic::{Diagnostic, Span};
use base::signature::Param;

/// An import names something that the file does not declare.
pub fn unknown_import<'a>(span: Span, word: &str, path: &str, known: impl IntoIterator<Item = &'a str>) -> Diagnostic {
    unknown("unknown-import", span, format!("`{path}` declares no `{}`", cut(word)), word, known)
}

/// A parameter depends on itself.
pub fn param_cycle(span: Span, name: &str) -> Diagnostic {
    Diagnostic::error("param-cycle", span, format!("the parameter `{name}` depends on itself"))
        .help("give one parameter of the cycle a value that names none of the others")
}

/// A parameter has the name of a variable of formulas.
pub fn reserved_name(span: Span, name: &str) -> Diagnostic {
    Diagnostic::error("reserved-name", span, format!("`{name}` is already a variable of formulas"))
        .help("give the parameter another name")
}

/// A parameter whose value is a word has the name of a word.
pub fn reserved_word(span: Span, name: &str) -> Diagnostic {
    Diagnostic::error("reserved-name", span, format!("`{name}` is already a word of the language"))
        .help("give the parameter another name: it would replace the word wherever that is written")
}

/// The type of a parameter is not known; its value may suggest another one.
pub fn unknown_type(span: Span, word: &str, of_value: Option<&str>, known: &[&str]) -> Diagnostic {
    if let Some(own) = of_value.filter(|own| *own != "number" && own_words(word) == ["number"]) {
        return Diagnostic::error("unknown-type", span, format!("unknown type `{}`", cut(word)))
            .here(format!("its value is {}", one(own)))
            .fix(own);
    }
    unknown("unknown-type", span, format!("unknown type `{}`", cut(word)), word, known.iter().copied())
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

/// A matrix names the key of a declaration.
pub fn dotted_key(span: Span, path: &str) -> Diagnostic {
    let name = path.replace('.', "_");
    Diagnostic::error("syntax", span, "this statement cannot be read").here("a key contains no points").help(format!(
        "a `matrix` sets parameters: declare one, as in `param {name}: length = …`, name it where `{path}` stands, and here"
    ))
}

/// A matrix varies a parameter without effect on its campaign.
pub fn idle_axis(span: Span, name: &str, campaign: &str) -> Diagnostic {
    Diagnostic::warning("unused", span, format!("`{name}` has no effect on campaign `{campaign}`"))
        .here("all its combinations give the same results")
}

/// A setting names nothing.
pub fn unknown_setting<'a>(span: Span, word: &str, known: impl IntoIterator<Item = &'a str>) -> Diagnostic {
    let mut known = known.into_iter().peekable();
    let none = known.peek().is_none();
    let said =
        unknown("unknown-setting", span, format!("unknown parameter or declaration `{}`", cut(word)), word, known);
    if none { said.help(format!("declare it, as in `param {}: length = 20 m`", cut(word))) } else { said }
}

/// A setting names several things.
pub fn ambiguous_setting(span: Span, word: &str, forms: &[&str]) -> Diagnostic {
    let ambiguous =
        Diagnostic::error("ambiguous-setting", span, format!("there are several declarations named `{word}`"));
    if forms.iter().all(|form| Some(form) == forms.first()) {
        return ambiguous.help("two files declare it: run the files one at a time, or rename one of the declarations");
    }
    let offers: Vec<String> = forms.iter().map(|form| format!("{form}.{word}.…")).collect();
    ambiguous.help(format!("put the form first: {}", quoted(offers.iter().map(String::as_str))))
}

/// A matrix gives too many combinations.
pub fn too_many_combinations(span: Span, found: usize, limit: usize) -> Diagnostic {
    Diagnostic::error(
        "too-many-combinations",
        span,
        format!("this makes {found} combinations; at most {limit} are run"),
    )
}

/// A declaration starts with its name; its kind is one of this form.
pub fn missing_form(span: Span, word: &str, form: &str) -> Diagnostic {
    Diagnostic::error("unknown-form", span, format!("unknown declaration `{}`", cut(word)))
        .here(format!("is this the name of {}?", one(form)))
        .fix(format!("{form} {word}"))
}

/// The first word of a declaration is no form.
pub fn unknown_form(span: Span, word: &str, forms: &[&str]) -> Diagnostic {
    if matches!(word, "param" | "let" | "def" | "const" | "var" | "val") {
        return Diagnostic::error("unknown-form", span, "this statement cannot be read")
            .help("a parameter needs a type: `param far: length = 30 m`");
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

/// Where a key belongs that is not in the signature.
#[derive(Clone, Copy)]
pub enum KeyOf<'a> {
    /// In a block of the same owner.
    Block(&'a str),
    /// In another form.
    Form(&'a str),
}

/// A key is not in the signature; the given keys are those of the signature without a value, the blocks those that it may hold.
pub fn unknown_key(
    span: Span,
    owner: &str,
    word: &str,
    keys: &[&str],
    blocks: &[&str],
    elsewhere: Option<KeyOf>,
) -> Diagnostic {
    let message = format!("`{owner}` has no key `{}`", cut(word));
    let error = || Diagnostic::error("unknown-key", span, message.clone());
    let is_key = |of: &str| format!("`{word}` is a key of `{of}`");
    // A word of another language for a key of its own goes before a block's key of that name.
    let is_own = own_words(word).iter().any(|own| keys.contains(own));
    if let Some(KeyOf::Block(block)) = elsewhere.filter(|_| !is_own) {
        return nearest(word, keys.iter().copied()).into_iter().fold(error().help(is_key(block)), Diagnostic::fix);
    }
    let block = own_words(word).iter().copied().find(|own| blocks.contains(own));
    if let Some(block) = block.or_else(|| nearest(word, blocks.iter().copied())) {
        return error()
            .here(format!("did you mean the block `{block}`?"))
            .help(format!("write `{block} name {{ … }}`"));
    }
    if owner == "town" && own_words(word).contains(&"file") {
        return error().here("a map has a kind of its own").help("write `town name = opendrive(file: \"my.xodr\")`");
    }
    let diagnostic = unknown("unknown-key", span, message.clone(), word, keys.iter().copied());
    match elsewhere {
        _ if !diagnostic.fixes.is_empty() => diagnostic,
        _ if counts_pedestrians(word) => error().here("an episode has one pedestrian").help(
            "its body is the `adversary` of the campaign, and the `falsifiers` of `search` or the `pedestrians` of `evaluate` move it",
        ),
        Some(KeyOf::Form(form)) => diagnostic.help(is_key(form)),
        _ if word == "seed" => diagnostic.help("the seed is given when it is run: `falsify run --seed 7 …`"),
        _ => diagnostic,
    }
}

/// An event is written in place of a key.
pub fn event_for_key(span: Span, owner: &str, word: &str) -> Diagnostic {
    Diagnostic::error("unknown-key", span, format!("`{owner}` has no key `{word}`"))
        .here("this is an event")
        .help(format!("write the reward of an event as `on {word} => …`"))
}

/// A key is given twice.
pub fn duplicate_key(span: Span, word: &str, first: Span) -> Diagnostic {
    Diagnostic::error("duplicate-key", span, format!("`{word}` is given twice")).label(first, "first given here")
}

/// Keys without default are not given; there is at least one.
pub fn missing_keys(span: Span, owner: &str, params: &[&Param]) -> Diagnostic {
    let of = |param: &Param| format!("`{}`: {} It is {}.", param.name, param.doc, one(param.ty.describe()));
    let several = if params.len() == 1 { "key" } else { "keys" };
    let names = quoted(params.iter().map(|param| param.name));
    let missing = Diagnostic::error("missing-key", span, format!("`{owner}` needs the {several} {names}"));
    params.iter().fold(missing, |missing, param| missing.help(of(param)))
}

/// A campaign has no settings for the pedestrians that it, or a falsifier of it, trains.
pub fn no_training(campaign: Span, trains: Span) -> Diagnostic {
    Diagnostic::error("missing-key", campaign, "`campaign` needs the key `training`")
        .label(trains, "pedestrians are trained here")
        .help("`training` is the name of a training, and says how they are trained")
}

/// A value in parentheses has no key; these keys may be meant.
pub fn bare_argument(span: Span, written: &str, keys: &[&str]) -> Diagnostic {
    let diagnostic = Diagnostic::error("bare-argument", span, "this value has no key");
    match keys {
        [] => diagnostic.help("no key here takes such a value"),
        [only] => diagnostic.fix(format!("{only}: {written}")),
        keys => diagnostic.help(format!("write `key: {}`, with one of {}", cut(written), quoted(keys.iter().copied()))),
    }
}

/// Arguments of a function have keys; `call` is the call without them.
pub fn named_argument(keys: &[&Name], place: Span, call: &str) -> Diagnostic {
    let (first, others) = keys.split_first().expect("a key is named");
    let message = format!("functions take no keys such as `{}`", first.text);
    let diagnostic = Diagnostic::error("named-argument", first.span, message);
    // The order of arguments, by the names that other libraries have for them; some functions accept any order.
    const ORDER: [&[&str]; 3] = [
        &["x", "value", "low", "lo", "lower", "least", "min", "from", "start", "begin", "mean", "mu", "loc"],
        &[
            "mean", "mu", "loc", "high", "hi", "upper", "most", "max", "to", "end", "stop", "sd", "std", "stddev",
            "sigma", "scale",
        ],
        &["sd", "std", "stddev", "sigma", "scale"],
    ];
    let any = call.starts_with("min(") || call.starts_with("max(") || others.is_empty();
    let in_order = keys.len() < 4 && keys.iter().zip(ORDER).all(|(key, known)| known.contains(&key.text.as_str()));
    let plain = !call.contains(':') && !call.contains("//") && !call.contains("/*");
    let turned = !plain || !any && !in_order;
    let diagnostic = others.iter().fold(diagnostic, |said, key| said.label(key.span, "nor this"));
    if turned { diagnostic.help("write the arguments in order, without keys") } else { diagnostic.fix_at(place, call) }
}

/// A block may not stand here.
pub fn unknown_block(span: Span, owner: &str, word: &str, blocks: &[&str], keys: &[&str]) -> Diagnostic {
    if let Some(block) = blocks.iter().find(|block| word.starts_with(**block) && keys.contains(&word)) {
        return Diagnostic::error("unknown-block", span, format!("`{word}` is a key of `{owner}`, not a block"))
            .here(format!("did you mean `{block}`?"))
            .fix(*block);
    }
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
    Diagnostic::error("unexpected-clause", span, format!("`on` clauses are not allowed inside `{owner}`"))
        .help("they belong inside a `reward`")
}

/// Two declarations of a form share a name.
pub fn duplicate_declaration(span: Span, form: &str, name: &str, first: Span) -> Diagnostic {
    Diagnostic::error("duplicate-declaration", span, format!("there are two declarations of {form} `{name}`"))
        .label(first, "the other is here")
}

/// A reference leads to no declaration.
pub fn unknown_name<'a>(span: Span, form: &str, word: &str, known: impl IntoIterator<Item = &'a str>) -> Diagnostic {
    unknown("unknown-name", span, format!("unknown {form} `{}`", cut(word)), word, known)
}

/// A reference names a declaration of the standard library that the file does not import; `added` is the import that is missing,
/// and its place.
pub fn not_imported(span: Span, form: &str, word: &str, file: &str, added: Option<(Span, String)>) -> Diagnostic {
    let diagnostic = Diagnostic::error("unknown-name", span, format!("unknown {form} `{}`", cut(word)))
        .here("this file does not import it");
    match added {
        None => diagnostic.help(format!("the standard library has it: `import \"std/{file}\"`")),
        Some((place, text)) => {
            diagnostic.help(format!("the standard library has it, in `std/{file}`")).fix_at(place, text)
        }
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
    Diagnostic::error("unknown-name", span, format!("unknown {form} `{word}`"))
        .here(format!("this is a kind of {form}, not the name of one"))
        .help(format!("declare one, and name it here: `{form} mine = {word}()`"))
}

/// A kind with its keys stands where the name of a declaration is expected.
pub fn kind_in_place(span: Span, form: &str, written: &str) -> Diagnostic {
    Diagnostic::error("unknown-name", span, format!("expected the name of a {form}, found a declaration of one"))
        .here("this is written in a declaration of its own")
        .help(format!("declare it: `{form} mine = {}`, and write `mine` here", cut(written)))
}

/// A list of names stands where one name is expected.
pub fn several_for_one(span: Span, form: &str, written: &[&str]) -> Diagnostic {
    let diagnostic = Diagnostic::error("wrong-type", span, format!("expected the name of one {form}, found a list"));
    match (form, written) {
        (_, [only]) => diagnostic.fix(*only),
        ("adversary", _) => diagnostic
            .here("the pedestrians are trained with one adversary")
            .help(format!("`evaluate {{ adversaries: [{}] }}` evaluates them with several", written.join(", "))),
        _ => diagnostic.help(format!("for several, write a `matrix` over a parameter of the type `{form}`")),
    }
}

/// A pose has no heading.
pub fn missing_heading(span: Span, written: &[&str]) -> Diagnostic {
    Diagnostic::error("wrong-type", span, "expected a pose, found a point")
        .here("a pose has a heading, too")
        .fix(format!("({}, 0 deg)", written.join(", ")))
}

/// A declaration is never used.
pub fn unused(span: Span, form: &str, name: &str) -> Diagnostic {
    Diagnostic::warning("unused", span, format!("{form} `{name}` is never used"))
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
