//! Errors that prevent reading a file: signs, brackets, sizes, editions, imports.

use std::io::ErrorKind;

use super::super::{library, reason};
use base::diagnostic::{Diagnostic, Span};
use base::suggest::nearest;

/// A statement has no shape the grammar knows.
pub fn syntax(span: Span, text: String) -> Diagnostic {
    Diagnostic::error("syntax", span, "this statement cannot be read").here(text)
}

/// A bracket is never closed; a text that is not closed may have swallowed its partner.
pub fn unclosed_bracket(span: Span, bracket: char, unended: Option<Span>) -> Diagnostic {
    let diagnostic =
        Diagnostic::error("unclosed-bracket", span, format!("`{bracket}` is never closed")).here("opened here");
    unended.into_iter().fold(diagnostic, |said, text| said.label(text, "this text is not closed on its line"))
}

/// A closing bracket has no partner.
pub fn stray_bracket(span: Span) -> Diagnostic {
    Diagnostic::error("stray-bracket", span, "this bracket closes nothing")
        .help("remove it, or add the opening bracket")
}

/// The label of an opening bracket.
pub(crate) const OPENED: &str = "opened here";

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
        .here("write `edition 1` first, so that later versions of the language read the file the same way")
        .fix("edition 1\n")
}

/// The edition is not one this program reads.
pub fn unknown_edition(span: Span, edition: f64) -> Diagnostic {
    Diagnostic::error("unknown-edition", span, format!("edition {edition} is not known"))
        .here("this program reads edition 1")
        .fix("1")
}

/// The edition is given again, or late.
pub fn misplaced_edition(span: Span, first: Option<Span>) -> Diagnostic {
    let diagnostic =
        Diagnostic::error("misplaced-edition", span, "`edition` is allowed once, at the start of the file");
    match first {
        Some(first) => diagnostic.label(first, "first named here"),
        None => diagnostic.help("move it to the start of the file"),
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
