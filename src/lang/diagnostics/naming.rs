//! Wrong names: forms, kinds, keys, declarations, parameters, settings.

use super::{Offering, cut, one, quoted};
use base::diagnostic::{Diagnostic, Span};
use base::signature::Param;

diagnostics! {
    param_cycle(name: &str) = error("param-cycle", "the parameter `{name}` depends on itself")
        .help("give one parameter of the cycle a value that names none of the others");
    reserved_name(name: &str) = error("reserved-name", "`{name}` is already a variable of formulas").help("give the parameter another name");
    reserved_word(name: &str) = error("reserved-name", "`{name}` is already a word of the language")
        .help("give the parameter another name: it would replace the word wherever that is written");
    bad_setting(reason: &str) = error("bad-setting", "this setting cannot be read: {reason}")
        .help("write `name=value` for a parameter, or `declaration.key=value`");
    repeated_setting(path: &str, first: Span) = error("bad-setting", "`{path}` is set twice").label(first, "first set here");
    idle_axis(name: &str, campaign: &str) = warning("unused", "`{name}` has no effect on campaign `{campaign}`")
        .here("all its combinations give the same results");
    too_many_combinations(found: usize, limit: usize) = error("too-many-combinations", "this makes {found} combinations; at most {limit} are run");
    missing_kind(form: &str, kinds: &[&str]) = error("missing-kind", "{} needs a kind", one(form))
        .help(format!("write `{form} name = kind(…)`; the kinds are {}", quoted(kinds.iter().copied())));
    missing_name(form: &str) = error("missing-name", "this {form} has no name").help(format!("write `{form} name …`"));
    duplicate_key(word: &str, first: Span) = error("duplicate-key", "`{word}` is given twice").label(first, "first given here");
    named_argument(key: &str) = error("named-argument", "functions take no keys such as `{key}`").help("write the arguments in order, without keys");
    repeated_block(owner: &str, word: &str, first: Span) = error("repeated-block", "`{owner}` takes one block `{word}`")
        .label(first, "the first is here");
    unexpected_clause(owner: &str) = error("unexpected-clause", "`on` clauses are not allowed inside `{owner}`").help("they belong inside a `reward`");
    duplicate_declaration(form: &str, name: &str, first: Span) = error("duplicate-declaration", "there are two declarations of {form} `{name}`")
        .label(first, "the other is here");
    kind_for_name(form: &str, word: &str) = error("unknown-name", "unknown {form} `{word}`")
        .here(format!("this is a kind of {form}, not the name of one"))
        .help(format!("declare one, and name it here: `{form} mine = {word}()`"));
    kind_in_place(form: &str, written: &str) = error("unknown-name", "expected the name of a {form}, found a declaration of one")
        .here("this is written in a declaration of its own")
        .help(format!("declare it: `{form} mine = {}`, and write `mine` here", cut(written)));
    unused(form: &str, name: &str) = warning("unused", "{form} `{name}` is never used");
    long_name(limit: usize) = error("too-long", "this name has more than {limit} letters").help("files of the report are named after it");
    long_combination(name: &str, limit: usize) = error("too-long", "a combination's name would have more than {limit} letters: `{}`", cut(name))
        .help("give its parameters shorter names, or fewer of them");
    unknown_type(word: &str, known: &[&str]) = error("unknown-type", "unknown type `{}`", cut(word)).offering(word, known);
    unknown_form(word: &str, forms: &[&str]) = error("unknown-form", "unknown declaration `{}`", cut(word)).offering(word, forms);
    unknown_key(owner: &str, word: &str, keys: &[&str]) = error("unknown-key", "`{owner}` has no key `{}`", cut(word)).offering(word, keys);
    no_training(trains: Span) = error("missing-key", "`campaign` needs the key `training`")
        .label(trains, "pedestrians are trained here")
        .help("`training` is the name of a training, and says how they are trained");
    unknown_import(word: &str, path: &str, known: &[&str]) = error("unknown-import", "`{path}` declares no `{}`", cut(word)).offering(word, known);
    unknown_setting(word: &str, known: &[&str]) = error("unknown-setting", "unknown parameter or declaration `{}`", cut(word)).offering(word, known);
    unknown_name(form: &str, word: &str, known: &[&str]) = error("unknown-name", "unknown {form} `{}`", cut(word)).offering(word, known);
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

/// The word after `=` is not a kind of this form.
pub fn unknown_kind(span: Span, form: &str, word: &str, kinds: &[&str]) -> Diagnostic {
    if kinds.is_empty() {
        let message = format!("{} has no kinds and derives from no other", one(form));
        let help = format!(
            "write `{form} NAME {{ … }}` with its keys; `falsify explain {}` shows those of a shipped one",
            cut(word)
        );
        return Diagnostic::error("unknown-kind", span, message).help(help);
    }
    Diagnostic::error("unknown-kind", span, format!("unknown kind `{}` of {form}", cut(word))).offering(word, kinds)
}

/// Keys without default are not given; there is at least one.
pub fn missing_keys(span: Span, owner: &str, params: &[&Param]) -> Diagnostic {
    let of = |param: &Param| format!("`{}`: {} It is {}.", param.name, param.doc, one(param.ty.describe()));
    let several = if params.len() == 1 { "key" } else { "keys" };
    let names = quoted(params.iter().map(|param| param.name));
    let missing = Diagnostic::error("missing-key", span, format!("`{owner}` needs the {several} {names}"));
    params.iter().fold(missing, |missing, param| missing.help(of(param)))
}

/// A value in parentheses has no key.
pub fn bare_argument(span: Span, written: &str, keys: &[&str]) -> Diagnostic {
    let diagnostic = Diagnostic::error("bare-argument", span, "this value has no key");
    match keys {
        [] => diagnostic.help("no key is allowed here"),
        keys => diagnostic.help(format!("write `key: {}`, with one of {}", cut(written), quoted(keys.iter().copied()))),
    }
}

/// A block may not stand here.
pub fn unknown_block(span: Span, owner: &str, word: &str, blocks: &[&str]) -> Diagnostic {
    let message = format!("`{owner}` has no block `{}`", cut(word));
    if blocks.is_empty() {
        return Diagnostic::error("unknown-block", span, message).here("no blocks are allowed here");
    }
    Diagnostic::error("unknown-block", span, message).offering(word, blocks)
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
pub fn other_form(span: Span, form: &str, word: &str, other: &str, known: &[&str]) -> Diagnostic {
    let diagnostic = Diagnostic::error("unknown-name", span, format!("unknown {form} `{}`", cut(word)))
        .here(format!("this is {}", one(other)));
    let help = |known: &[&str]| format!("known here: {}", quoted(known.iter().copied()));
    if known.is_empty() { diagnostic } else { diagnostic.help(help(known)) }
}
