//! Errors that prevent reading a file: signs, brackets, sizes, editions, imports.

use std::io::ErrorKind;

use crate::library;
use base::diagnostic::{Diagnostic, Span};
use base::suggest::nearest;

diagnostics! {
    syntax(text: String) = error("syntax", "this statement cannot be read").here(text);
    stray_bracket() = error("stray-bracket", "this bracket closes nothing").help("remove it, or add the opening bracket");
    mismatched_bracket(opening: Span, bracket: char) = error("mismatched-bracket", "this does not close `{bracket}`").label(opening, OPENED);
    too_deep(limit: usize) = error("too-deep", "brackets nest deeper than {limit} levels");
    too_long(limit: usize) = error("too-long", "this expression has more than {limit} terms and signs");
    unclosed_comment() = error("unclosed-comment", "this comment is never closed").help("close it with `*/`");
    too_large(bytes: usize, limit: usize) = error("too-large", "the file has {bytes} bytes; at most {limit} are read");
    missing_edition() = error("missing-edition", "the file does not name its edition")
        .here("write `edition 1` first, so that later versions of the language read the file the same way")
        .fix("edition 1\n");
    unknown_edition(edition: f64) = error("unknown-edition", "edition {edition} is not known").here("this program reads edition 1").fix("1");
}

/// A bracket is never closed; a text that is not closed may have swallowed its partner.
pub fn unclosed_bracket(span: Span, bracket: char, unended: Option<Span>) -> Diagnostic {
    let diagnostic =
        Diagnostic::error("unclosed-bracket", span, format!("`{bracket}` is never closed")).here("opened here");
    unended.into_iter().fold(diagnostic, |said, text| said.label(text, "this text is not closed on its line"))
}

/// The label of an opening bracket.
pub(crate) const OPENED: &str = "opened here";

/// The edition is given again, or late.
pub fn misplaced_edition(span: Span, first: Option<Span>) -> Diagnostic {
    let diagnostic =
        Diagnostic::error("misplaced-edition", span, "`edition` is allowed once, at the start of the file");
    match first {
        Some(first) => diagnostic.label(first, "first named here"),
        None => diagnostic.help("move it to the start of the file"),
    }
}

/// The reason in words why a file cannot be read.
pub fn reason(error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => "there is no such file".into(),
        ErrorKind::PermissionDenied => "you may not read it".into(),
        ErrorKind::InvalidData if error.get_ref().is_none() => "it is not UTF-8 text".into(),
        ErrorKind::IsADirectory => "it is a folder".into(),
        _ => error.to_string(),
    }
}

/// An import leads to no file that can be read.
pub fn import_not_found(span: Span, path: &str, error: &std::io::Error) -> Diagnostic {
    let message = format!("cannot import `{path}`: {}", reason(error));
    let diagnostic = Diagnostic::error("import-not-found", span, message);
    let library: Vec<String> = library::names().map(|name| format!("std/{name}")).collect();
    match nearest(path, library.iter().map(String::as_str)) {
        Some(near) => diagnostic.here(format!("did you mean `{near}`?")).fix(format!("\"{near}\"")),
        None if error.kind() == ErrorKind::NotFound => {
            diagnostic.help("paths are relative to the folder of the file that imports")
        }
        None => diagnostic,
    }
}

/// Files import each other in a cycle; they are listed in order, from the one that is imported here again.
pub fn import_cycle(span: Span, path: &str, circle: &[String]) -> Diagnostic {
    const MAX_SHOWN: usize = 8;
    let diagnostic = Diagnostic::error("import-cycle", span, format!("`{path}` imports this file in turn"));
    let diagnostic = match circle {
        [] | [_] => diagnostic.here("a file cannot import itself"),
        files => {
            let mut shown: Vec<&str> = files.iter().take(MAX_SHOWN).map(String::as_str).collect();
            shown.extend((files.len() > MAX_SHOWN).then_some("…"));
            shown.push(&files[0]);
            diagnostic.help(format!("the cycle: {}", shown.join(" → ")))
        }
    };
    diagnostic.help("move what both need into a third file")
}
