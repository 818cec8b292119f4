use maud::{Markup, PreEscaped, html};

use crate::report::render::svg::{FIGURE_CSS, properties};

/// The head of a page that needs no other file, with the style of all pages and what this one adds to it.
///
/// `scripts` is what may run, in the words of a content security policy; `generator` the program's version, if the page states it.
pub fn head(title: &str, generator: Option<&str>, scripts: &str, styles: &[&str]) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            meta name="viewport" content="width=device-width, initial-scale=1";
            meta http-equiv="Content-Security-Policy" content={ "default-src 'none'; style-src 'unsafe-inline'; script-src " (PreEscaped(scripts)) };
            @if let Some(version) = generator { meta name="generator" content={ "falsify " (version) }; }
            title { (title) }
            style {
                (PreEscaped(properties())) (PreEscaped(FIGURE_CSS)) (PreEscaped(include_str!("page.css")))
                @for style in styles { (PreEscaped(style)) }
            }
        }
    }
}

/// What may run on a page whose scripts are all its own.
pub const OWN_SCRIPTS: &str = "'unsafe-inline'";
