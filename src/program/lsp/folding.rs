//! The parts of a text that an editor can fold: brackets, comments and imports over several lines.

use lsp_types::{FoldingRange, FoldingRangeKind};

use base::diagnostic::Lines;
use lang::tokens::{TokenKind, tokens};

/// A run of neighbouring lines of one kind.
struct Run {
    kind: FoldingRangeKind,
    first: u32,
    last: u32,
}

/// The parts of a text that can be folded, by their first line. A file that is not complete has some of them.
pub fn folding_ranges(text: &str) -> Vec<FoldingRange> {
    let lines = Lines::new(text);
    let line = |byte: usize| lines.utf16(byte).0;
    let (mut found, mut open, mut run) = (Vec::new(), Vec::new(), None);
    let mut is_first = true;
    for token in tokens(text) {
        let word = token.text(text);
        let (start, end) = (line(token.start), line(token.end));
        match token.kind {
            TokenKind::Blank => {
                is_first |= word.contains('\n');
                continue;
            }
            TokenKind::Open => open.push(start),
            TokenKind::Close => {
                // The line of the closing bracket stays in sight.
                let opened = open.pop().unwrap_or(start);
                found.extend((opened + 1 < start).then(|| range(opened, start - 1, None)));
            }
            TokenKind::BlockComment if start < end => found.push(range(start, end, Some(FoldingRangeKind::Comment))),
            _ => {}
        }
        let kind = match token.kind {
            TokenKind::LineComment | TokenKind::Doc => Some(FoldingRangeKind::Comment),
            TokenKind::Keyword if word == "import" => Some(FoldingRangeKind::Imports),
            _ => None,
        };
        if let Some(kind) = kind.filter(|_| is_first) {
            take(&mut run, kind, start, end, &mut found);
        }
        is_first = false;
    }
    end(run, &mut found);
    found.sort_by_key(|range| (range.start_line, range.end_line));
    found
}

/// Adds a line to the run, or ends it and begins another.
fn take(run: &mut Option<Run>, kind: FoldingRangeKind, start: u32, last: u32, found: &mut Vec<FoldingRange>) {
    match run {
        Some(run) if run.kind == kind && start <= run.last + 1 => run.last = last,
        _ => end(run.replace(Run { kind, first: start, last }), found),
    }
}

fn end(run: Option<Run>, found: &mut Vec<FoldingRange>) {
    found.extend(run.filter(|run| run.first < run.last).map(|run| range(run.first, run.last, Some(run.kind))));
}

fn range(start_line: u32, end_line: u32, kind: Option<FoldingRangeKind>) -> FoldingRange {
    FoldingRange { start_line, end_line, kind, ..FoldingRange::default() }
}
