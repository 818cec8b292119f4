use maud::{Markup, Render, html};

use super::{Digits, palette};

/// A picture in its own file.
#[derive(Debug, Clone)]
pub struct Document<'a> {
    pub title: &'a str,
    /// Left, top, width and height of the drawing, in the picture's own units.
    pub view: [f64; 4],
    /// Displayed width (px).
    pub width: f64,
    /// Rules in addition to those of figures. Colours are names of the palette.
    pub style: &'a str,
}

impl Document<'_> {
    /// The file.
    pub fn with(&self, body: &Markup) -> String {
        let [left, top, width, height] = self.view.map(|number| Digits(number, 1));
        let tall = Digits(self.width * self.view[3] / self.view[2], 0);
        let page = html! {
            svg xmlns="http://www.w3.org/2000/svg" viewBox={ (left) " " (top) " " (width) " " (height) } width=(Digits(self.width, 0)) height=(tall) class="panel" {
                title { (self.title) }
                style { (palette::fixed(palette::FIGURE_CSS)) (palette::fixed(self.style)) }
                rect class="paper" x=(left) y=(top) width=(width) height=(height) {}
                (body)
            }
        };
        // XML does not allow control characters, not even by their numbers.
        let mut text = page.render().into_string().replace(|c: char| c.is_control() && c != '\n', "\u{fffd}");
        text.push('\n');
        text
    }
}
