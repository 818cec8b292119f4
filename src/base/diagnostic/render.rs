use annotate_snippets::{AnnotationKind, Group, Level, Patch, Renderer, Snippet};

use super::{Diagnostic, Severity, SourceId, Sources, Span};

/// Whether drawings carry terminal colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour {
    /// Plain text.
    Never,
    /// ANSI escapes.
    Always,
}

/// Draws a diagnostic under its source line, with labels, advice and the repaired line.
pub fn render(diagnostic: &Diagnostic, sources: &Sources, colour: Colour) -> String {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let title = level.primary_title(&diagnostic.message).id(diagnostic.code);
    let offer = diagnostic.offer();
    let mut main = Group::with_title(title);
    for source in sources_in_order(diagnostic) {
        main = main.element(snippet(diagnostic, sources, source));
    }
    for help in &diagnostic.help {
        main = main.element(Level::HELP.message(help));
    }
    if diagnostic.fixes.len() > 1 {
        main = main.elements(offer.as_ref().map(|offer| Level::HELP.message(offer)));
    }
    let mut groups = vec![main];
    if let [fix] = diagnostic.fixes.as_slice() {
        let span = fix.span;
        let excerpt = Excerpt::new(sources, span.source, &[span]);
        let snippet = Snippet::source(excerpt.text)
            .line_start(excerpt.line)
            .path(sources.get(span.source).path.to_string_lossy())
            .patch(Patch::new(excerpt.range(span), fix.text.as_str()));
        groups.push(Group::with_title(Level::HELP.secondary_title("write it like this")).element(snippet));
    }
    let renderer = match colour {
        Colour::Never => Renderer::plain(),
        Colour::Always => Renderer::styled(),
    };
    renderer.render(&groups).to_string()
}

fn sources_in_order(diagnostic: &Diagnostic) -> Vec<SourceId> {
    let mut order = vec![diagnostic.primary.span.source];
    for label in &diagnostic.labels {
        if !order.contains(&label.span.source) {
            order.push(label.span.source);
        }
    }
    order
}

fn snippet<'a>(
    diagnostic: &'a Diagnostic,
    sources: &'a Sources,
    id: SourceId,
) -> Snippet<'a, annotate_snippets::Annotation<'a>> {
    let primary = Some(&diagnostic.primary).filter(|primary| primary.span.source == id);
    let labels = || diagnostic.labels.iter().filter(|label| label.span.source == id);
    let spans: Vec<Span> = primary.into_iter().chain(labels()).map(|label| label.span).collect();
    let excerpt = Excerpt::new(sources, id, &spans);
    let mut snippet = Snippet::source(excerpt.text).line_start(excerpt.line);
    snippet = snippet.path(sources.get(id).path.to_string_lossy());
    if let Some(primary) = primary {
        let mark = AnnotationKind::Primary.span(excerpt.range(primary.span));
        snippet = snippet.annotation(if primary.text.is_empty() { mark } else { mark.label(&primary.text) });
    }
    for label in labels() {
        snippet = snippet.annotation(AnnotationKind::Context.span(excerpt.range(label.span)).label(&label.text));
    }
    snippet
}

/// The lines of a source that a drawing needs: scanning a whole large file for each message takes long.
struct Excerpt<'a> {
    text: &'a str,
    /// The number of its first line, from 1.
    line: usize,
    /// Where it starts in the source.
    start: usize,
}

impl<'a> Excerpt<'a> {
    /// The lines from the one before the first span to the one after the last.
    fn new(sources: &'a Sources, id: SourceId, spans: &[Span]) -> Self {
        let text = sources.get(id).text.as_ref();
        let first = spans.iter().map(|span| span.start).min().unwrap_or(0);
        let last = spans.iter().map(|span| span.end).max().unwrap_or(0);
        let above = |byte: usize| text[..byte].rfind('\n');
        let start = above(first).and_then(above).map_or(0, |at| at + 1);
        let below = |byte: usize| text[byte..].find('\n').map(|at| byte + at + 1);
        let end = below(last).and_then(below).unwrap_or(text.len());
        let line = 1 + text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count();
        Self { text: &text[start..end], line, start }
    }

    fn range(&self, span: Span) -> std::ops::Range<usize> {
        span.start - self.start..span.end - self.start
    }
}
