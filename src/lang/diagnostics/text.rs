//! Errors that prevent reading a file: signs, brackets, sizes, editions, imports.

use std::io::ErrorKind;

use super::super::foreign_names::kind_of_file;
use super::super::suggest::nearest;
use super::super::{library, reason};
use base::diagnostic::{Diagnostic, Span};

/// A statement has no shape the grammar knows.
pub fn syntax(span: Span, text: String) -> Diagnostic {
    Diagnostic::error("syntax", span, "this statement cannot be read").here(text)
}

/// A value ends with an operator.
pub fn open_end(span: Span) -> Diagnostic {
    syntax(span, "a value is missing after this".into())
}

/// A known mistake of syntax: what to report, and what to write instead.
pub fn mistake(span: Span, said: &str, meant: Option<&str>) -> Diagnostic {
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
        return diagnostic.here("a number contains no comma").fix(written.replace(',', "_"));
    }
    // That would be the same number again, with more digits than users write.
    if thousands && written.ends_with(",000") {
        return diagnostic.here("a number contains no comma").fix(written.replace(',', "_"));
    }
    if thousands {
        return diagnostic
            .here("a number contains no comma")
            .fix(written.replace(',', "_"))
            .fix(written.replace(',', "."));
    }
    diagnostic.here("the decimal point is `.`").fix(written.replace(',', "."))
}

/// A sum of a quantity and a negative one is written like a tolerance in print; `range` is the likely meaning, if it is known.
pub fn tolerance(span: Span, range: Option<String>) -> Diagnostic {
    let diagnostic = syntax(span, "write both ends: `-60 deg .. 60 deg`".into());
    range.into_iter().fold(diagnostic, Diagnostic::fix)
}

/// A comma without a blank is written where it may be a decimal comma.
pub fn comma_in_number(span: Span, written: &str) -> Diagnostic {
    let (whole, part) = written.split_once(',').unwrap_or((written, ""));
    Diagnostic::warning("two-numbers", span, format!("`{written}` are two numbers"))
        .here("the decimal point is `.`")
        .fix(format!("{whole}.{part}"))
        .fix(format!("{whole}, {part}"))
}

/// Several values are written without brackets.
pub fn unbracketed_list(span: Span, written: &str) -> Diagnostic {
    Diagnostic::error("syntax", span, "this statement cannot be read")
        .here("several values need brackets")
        .fix(format!("[{written}]"))
}

/// Two quantities are written without brackets: a range, or a list.
pub fn unbracketed_pair(span: Span, (low, high): (&str, &str)) -> Diagnostic {
    Diagnostic::error("syntax", span, "this statement cannot be read")
        .here("this is neither a range nor a list")
        .fix(format!("{low} .. {high}"))
        .fix(format!("[{low}, {high}]"))
}

/// A value follows the `=` of a declaration, where a kind is expected; it is a text with this path, or "" where it is something else.
pub fn value_for_kind(span: Span, (form, name): (&str, &str), path: &str) -> Diagnostic {
    let said = Diagnostic::error("syntax", span, "this statement cannot be read");
    if let Some(kind) = kind_of_file(path) {
        return said.here("a kind follows `=`").fix(format!("{form} {name} = {kind}"));
    }
    said.here(format!("write `{form} {name} = kind(key: value)`, or `{form} {name} {{ … }}`"))
        .help("for a value with a name, write `param name: type = value`")
}

/// A parameter has no type.
pub fn untyped_param(span: Span, name: &str, ty: Option<&str>) -> Diagnostic {
    let diagnostic =
        Diagnostic::error("syntax", span, "this statement cannot be read").here("a parameter needs a type");
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
        .help("remove it, or add the opening bracket")
}

/// A declaration has no opening brace for the one on its last line, or has a colon in its place.
pub fn missing_brace(span: Span) -> Diagnostic {
    Diagnostic::error("unclosed-bracket", span, "a `{` is missing")
        .here("the contents of a declaration need braces: `{ … }`")
        .fix(" {")
}

/// A declaration has neither brace; the indented lines below it are its intended contents.
pub fn missing_braces(span: Span) -> Diagnostic {
    Diagnostic::error("syntax", span, "this statement cannot be read")
        .here("the contents of a declaration need braces; indentation has no meaning")
        .help("open a brace here and close it after the indented lines")
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
        // `lib/paper.scn` is in the folder of the repository's scenarios, and nowhere else.
        ErrorKind::NotFound => {
            match library.iter().find(|file| path.replace('\\', "/").rsplit('/').next() == file.strip_prefix("std/")) {
                Some(file) => diagnostic.here("the standard library has it").fix(format!("\"{file}\"")),
                None => diagnostic.help("paths are relative to the folder of the file that imports"),
            }
        }
        ErrorKind::InvalidData => diagnostic.help("save it as UTF-8"),
        _ => diagnostic,
    }
}

/// Files import each other in a cycle; they are listed in order, from the one that is imported here again.
pub fn import_cycle(span: Span, path: &str, circle: &[String]) -> Diagnostic {
    const MOST: usize = 8;
    let diagnostic = Diagnostic::error("import-cycle", span, format!("`{path}` imports this file in turn"));
    let diagnostic = match circle {
        [] | [_] => diagnostic.here("a file cannot import itself"),
        files => {
            let mut shown: Vec<&str> = files.iter().take(MOST).map(String::as_str).collect();
            shown.extend((files.len() > MOST).then_some("…"));
            shown.push(&files[0]);
            diagnostic.help(format!("the cycle: {}", shown.join(" → ")))
        }
    };
    diagnostic.help("move what both need into a third file")
}
