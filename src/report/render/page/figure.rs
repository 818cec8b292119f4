use std::fmt::Write;

use super::markup::escape;
use super::palette;

/// A picture of small panels side by side, made once: the page shows it in its colours, a file in fixed ones.
#[derive(Debug, Clone, Default)]
pub struct Figure {
    /// Its name, which is the file's without extension.
    pub name: String,
    /// What it shows, in one line.
    pub title: String,
    /// Class of a swatch and what it stands for.
    pub legend: Vec<(String, String)>,
    /// What several panels use.
    pub defs: String,
    /// The panels, in reading order.
    pub panels: Vec<Panel>,
}

/// A panel of a figure.
#[derive(Debug, Clone, Default)]
pub struct Panel {
    /// What stands above it.
    pub title: String,
    /// What it says to somebody who does not see it.
    pub says: String,
    /// Width and height of its own units.
    pub size: (f64, f64),
    /// Its shapes, in SVG.
    pub body: String,
}

/// Room for a panel's title in a file.
const TITLE: f64 = 20.0;
/// Between panels in a file.
const GAP: f64 = 18.0;

/// About what a letter takes of a line.
const LETTER: f64 = 6.2;

impl Panel {
    /// The panel within a page.
    fn to_html(&self) -> String {
        let (width, height) = self.size;
        format!(
            "<div class=\"panel\"><h4>{}</h4><svg viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" role=\"img\" \
             aria-label=\"{}\">{}</svg></div>",
            escape(&self.title),
            escape(&self.says),
            self.body
        )
    }
}

impl Figure {
    /// The figure within a page.
    pub fn to_html(&self) -> String {
        let mut html = String::from("<figure>");
        if !self.defs.is_empty() {
            let _ = write!(html, "<svg class=\"defs\" aria-hidden=\"true\"><defs>{}</defs></svg>", self.defs);
        }
        if !self.legend.is_empty() {
            html.push_str("<div class=\"legend\">");
            for (class, text) in &self.legend {
                let _ = write!(html, "<span>{}{}</span>", swatch(class), escape(text));
            }
            html.push_str("</div>");
        }
        html.push_str("<div class=\"panels\">");
        self.panels.iter().for_each(|panel| html.push_str(&panel.to_html()));
        let _ = write!(
            html,
            "</div><figcaption>{} <a href=\"{}.svg\">SVG</a></figcaption></figure>",
            escape(&self.title),
            escape(&self.name)
        );
        html
    }

    /// The figure as a file that stands alone.
    pub fn to_svg(&self) -> String {
        let columns = self.panels.len().clamp(1, 3);
        let width = self.panels.iter().fold(0.0, |most: f64, panel| most.max(panel.size.0));
        let height = self.panels.iter().fold(0.0, |most: f64, panel| most.max(panel.size.1)) + TITLE;
        let rows = self.panels.len().div_ceil(columns);
        let top = if self.legend.is_empty() { 34.0 } else { 58.0 };
        let legend: f64 = self.legend.iter().map(|(_, text)| entry(text)).sum();
        let words = (LETTER * 1.15 * self.title.chars().count() as f64).max(legend) + 2.0 * GAP;
        let all = ((columns as f64 * (width + GAP) + GAP).max(words), top + rows as f64 * (height + GAP));
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w:.0} {h:.0}\" width=\"{w:.0}\" height=\"{h:.0}\" \
             class=\"panel\">\n<title>{title}</title>\n<style>{}</style>\n<defs>{}</defs>\n\
             <rect width=\"{w:.0}\" height=\"{h:.0}\" fill=\"#fff\"/>\n\
             <text class=\"ink name\" x=\"{GAP}\" y=\"22\">{title}</text>\n",
            palette::fixed(),
            self.defs,
            title = escape(&self.title),
            w = all.0,
            h = all.1,
        );
        let mut x = GAP;
        for (class, text) in &self.legend {
            let _ = writeln!(
                svg,
                "<g transform=\"translate({x:.0} 36)\">{}</g><text class=\"ink\" x=\"{:.0}\" y=\"46\">{}</text>",
                mark(class),
                x + 18.0,
                escape(text)
            );
            x += entry(text);
        }
        for (place, panel) in self.panels.iter().enumerate() {
            let (column, row) = ((place % columns) as f64, (place / columns) as f64);
            let _ = writeln!(
                svg,
                "<g transform=\"translate({:.0} {:.0})\"><text class=\"ink name\" y=\"12\">{}</text>\
                 <svg y=\"{TITLE}\" width=\"{:.0}\" height=\"{:.0}\">{}</svg></g>",
                GAP + column * (width + GAP),
                top + row * (height + GAP),
                escape(&panel.title),
                panel.size.0,
                panel.size.1,
                panel.body
            );
        }
        svg.push_str("</svg>\n");
        svg
    }
}

/// What an entry of a legend takes of a line.
fn entry(text: &str) -> f64 {
    34.0 + LETTER * text.chars().count() as f64
}

/// A swatch of a legend within a page.
pub fn swatch(class: &str) -> String {
    format!(
        "<svg class=\"swatch\" viewBox=\"0 0 14 12\" width=\"14\" height=\"12\" aria-hidden=\"true\">{}</svg>",
        mark(class)
    )
}

/// A line for a class that strokes, a box for one that fills.
fn mark(class: &str) -> String {
    if class.starts_with('s') {
        format!("<path class=\"line {class}\" d=\"M1 6H13\"/>")
    } else {
        format!("<rect class=\"{class}\" x=\"1\" y=\"1\" width=\"12\" height=\"10\" rx=\"2\"/>")
    }
}
