//! Diagnostics as JSON, one object each, for programs.

use serde::Serialize;

use super::{Diagnostic, Label, Lines, Severity, SourceId, Sources, Span};

/// A diagnostic in a form for programs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Record {
    /// `error` or `warning`.
    pub severity: Severity,
    /// The code, a word.
    pub code: &'static str,
    /// What is wrong, in one line.
    pub message: String,
    /// Where it is wrong.
    #[serde(flatten)]
    pub place: Place,
    /// The message at that place; may be empty.
    pub label: String,
    /// Other places that matter.
    pub labels: Vec<PlacedText>,
    /// Advice.
    pub help: Vec<String>,
    /// Texts that would repair the file at their places.
    pub fixes: Vec<PlacedText>,
}

/// A place in a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Place {
    /// The file as the user named it.
    pub file: String,
    /// Line of the first character, from 1.
    pub line: usize,
    /// Column of the first character, from 1, in characters.
    pub column: usize,
    pub end_line: usize,
    /// Column one past the last character.
    pub end_column: usize,
    /// First byte, from 0.
    pub byte_start: usize,
    /// One past the last byte.
    pub byte_end: usize,
}

/// A text with its place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlacedText {
    pub text: String,
    #[serde(flatten)]
    pub place: Place,
}

/// Diagnostics as records, in their order.
pub fn records(diagnostics: &[Diagnostic], sources: &Sources) -> Vec<Record> {
    let lines: Vec<Lines> = sources.iter().map(|(_, source)| Lines::new(&source.text)).collect();
    let ids: Vec<SourceId> = sources.iter().map(|(id, _)| id).collect();
    let place = |span: Span| {
        let index = ids.binary_search(&span.source).expect("a span lies in a source");
        let ((line, column), (end_line, end_column)) = lines[index].span(span);
        let source = sources.get(span.source);
        let (file, byte_start, byte_end) =
            (source.path.display().to_string(), source.mark + span.start, source.mark + span.end);
        Place { file, line, column, end_line, end_column, byte_start, byte_end }
    };
    let placed = |label: &Label| PlacedText { text: label.text.clone(), place: place(label.span) };
    let record = |each: &Diagnostic| Record {
        severity: each.severity,
        code: each.code,
        message: each.message.clone(),
        place: place(each.primary.span),
        label: each.primary.text.clone(),
        labels: each.labels.iter().map(placed).collect(),
        help: each.help.clone(),
        fixes: each.fixes.iter().map(|fix| PlacedText { text: fix.text.clone(), place: place(fix.span) }).collect(),
    };
    diagnostics.iter().map(record).collect()
}
