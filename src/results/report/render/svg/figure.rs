use maud::{Markup, PreEscaped, html};

use super::{Digits, Document, px};
use crate::report::FIGURES;

/// A picture of panels side by side.
#[derive(Debug, Clone, Default)]
pub struct Figure {
    /// Its name: the file name without extension. Empty if there is no file of it.
    pub name: String,
    /// Its content, in one line.
    pub title: String,
    /// More lines on how to read it.
    pub notes: Vec<String>,
    /// Classes of swatches and their meanings.
    pub legend: Vec<(String, String)>,
    /// Shapes that several panels use.
    pub defs: Option<Markup>,
    /// Panels in a row of the file; 0 for the usual three.
    pub columns: usize,
    /// The panels, in reading order.
    pub panels: Vec<Panel>,
}

/// A panel of a figure.
#[derive(Debug, Clone)]
pub struct Panel {
    /// Its heading.
    pub title: String,
    /// Its content, for readers who do not see it.
    pub says: String,
    /// Width and height in its own units.
    pub size: (f64, f64),
    /// Its shapes, in SVG.
    pub body: Markup,
}

/// Room for a panel's title in a file.
const TITLE: f64 = 20.0;
/// Between panels in a file.
const GAP: f64 = 18.0;
/// Height of a line of words in a file.
const LINE: f64 = 17.0;
/// Approximate width of a letter.
const LETTER: f64 = 6.2;

impl Panel {
    /// The panel within a page.
    fn to_html(&self) -> Markup {
        let (width, height) = (Digits(self.size.0, 0), Digits(self.size.1, 0));
        html! {
            div.panel {
                h4 { (self.title) }
                svg viewBox={ "0 0 " (width) " " (height) } width=(width) role="img" aria-label=(self.says) { (self.body) }
            }
        }
    }
}

impl Figure {
    /// The figure within a page.
    pub fn to_html(&self) -> Markup {
        html! {
            figure {
                @if let Some(defs) = &self.defs {
                    svg.defs aria-hidden="true" { defs { (defs) } }
                }
                @if !self.legend.is_empty() {
                    div.legend {
                        @for (class, text) in &self.legend { span { (swatch(class)) (text) } }
                    }
                }
                div.panels { @for panel in &self.panels { (panel.to_html()) } }
                figcaption {
                    (self.title) " "
                    @for note in &self.notes { (note) " " }
                    @if !self.name.is_empty() { a href=(self.file()) { "SVG" } }
                }
            }
        }
    }

    /// The path of its own file in a report.
    pub fn file(&self) -> String {
        format!("{FIGURES}/{}.svg", self.name)
    }

    /// The words beside that file: its caption.
    pub fn caption(&self) -> String {
        let words = std::iter::once(&self.title).chain(&self.notes).map(|line| line.replace('`', ""));
        words.collect::<Vec<_>>().join(" ") + "\n"
    }

    /// The figure in its own file, without its caption.
    pub fn to_svg(&self) -> String {
        let columns = self.panels.len().clamp(1, if self.columns == 0 { 3 } else { self.columns });
        let wide = self.panels.iter().fold(0.0, |most: f64, panel| most.max(panel.size.0));
        let width = (columns as f64 * (wide + GAP) + GAP).max(420.0);
        let mut top = 0.0;
        let mut entries = Vec::new();
        let mut x = GAP;
        for (class, text) in &self.legend {
            let takes = 34.0 + LETTER * text.chars().count() as f64;
            // An entry that does not fit starts a new line.
            if entries.is_empty() || x + takes > width {
                (x, top) = (GAP, top + LINE + 2.0);
            }
            entries.push((x, top, class, text));
            x += takes;
        }
        top += 14.0;
        let rows: Vec<f64> = self
            .panels
            .chunks(columns)
            .map(|row| row.iter().fold(0.0, |most: f64, panel| most.max(panel.size.1)) + TITLE + GAP)
            .collect();
        let height = top + rows.iter().sum::<f64>();
        let place = |number: usize| {
            let (row, column) = (number / columns, number % columns);
            (GAP + column as f64 * (wide + GAP), top + rows[..row].iter().sum::<f64>())
        };
        let body = html! {
            @if let Some(defs) = &self.defs { defs { (defs) } }
            @for (x, y, class, text) in entries {
                g transform={ "translate(" (px(x)) " " (px(y - 10.0)) ")" } {
                    (mark(class))
                    text.ink x="20" y="10" { (text) }
                }
            }
            @for (number, panel) in self.panels.iter().enumerate() {
                @let (x, y) = place(number);
                g transform={ "translate(" (px(x)) " " (px(y)) ")" } {
                    text.ink.name y="12" { (panel.title) }
                    svg y=(TITLE) width=(px(panel.size.0)) height=(px(panel.size.1)) { (panel.body) }
                }
            }
        };
        Document { title: &self.title, view: [0.0, 0.0, width.ceil(), height.ceil()], width: width.ceil(), style: "" }
            .with(&body)
    }
}

/// A swatch of a legend within a page.
fn swatch(class: &str) -> Markup {
    html! { svg.swatch viewBox="0 0 14 12" width="14" height="12" aria-hidden="true" { (mark(class)) } }
}

/// A line for a class that strokes, a box for one that fills.
fn mark(class: &str) -> Markup {
    html! {
        @if class.starts_with('s') {
            path class={ "line " (class) } d="M1 6H13" {}
        } @else {
            rect class=(class) x="1" y="1" width="12" height="10" rx="2" {}
        }
    }
}

impl Default for Panel {
    fn default() -> Self {
        Self { title: String::new(), says: String::new(), size: (0.0, 0.0), body: PreEscaped(String::new()) }
    }
}
