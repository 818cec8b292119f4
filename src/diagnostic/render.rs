use annotate_snippets::{AnnotationKind, Group, Level, Patch, Renderer, Snippet};

use super::{Diagnostic, Severity, SourceId, Sources};

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
    let mut main = Group::with_title(title);
    for source in sources_in_order(diagnostic) {
        main = main.element(snippet(diagnostic, sources, source));
    }
    for help in &diagnostic.help {
        main = main.element(Level::HELP.message(help));
    }
    let mut groups = vec![main];
    if let Some(fix) = &diagnostic.fix {
        let span = diagnostic.primary.span;
        let source = sources.get(span.source);
        let snippet = Snippet::source(&source.text)
            .path(source.path.to_string_lossy())
            .patch(Patch::new(span.start..span.end, fix.as_str()));
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
    let source = sources.get(id);
    let mut snippet = Snippet::source(&source.text).path(source.path.to_string_lossy());
    let primary = &diagnostic.primary;
    if primary.span.source == id {
        let mark = AnnotationKind::Primary.span(primary.span.start..primary.span.end);
        snippet = snippet.annotation(if primary.text.is_empty() { mark } else { mark.label(&primary.text) });
    }
    for label in diagnostic.labels.iter().filter(|label| label.span.source == id) {
        snippet = snippet.annotation(AnnotationKind::Context.span(label.span.start..label.span.end).label(&label.text));
    }
    snippet
}
