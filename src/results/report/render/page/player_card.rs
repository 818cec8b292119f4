use maud::{Markup, PreEscaped, html};

use super::frames::frames;
use super::markup::{json, prose};
use super::{Players, Replay};
use crate::failure::FailureClass;
use verdict::Label;

/// A failure with its player.
#[derive(Debug, Clone, PartialEq)]
pub struct PlayerCard {
    pub title: String,
    /// How much it counts against the driver, and the word for it.
    pub verdict: (FailureClass, &'static str),
    /// The controller, the town and the driver.
    pub place: String,
    /// Its name, `RUN:EPISODE`.
    pub name: String,
}

impl PlayerCard {
    /// The card of a failure of which nothing but its recording is known.
    pub fn plain(name: &str, replay: &Replay) -> Self {
        let label = replay.verdict.and_then(Label::named);
        Self {
            title: format!("Failure {name}"),
            verdict: (FailureClass::new(label, false), label.map_or("not judged", |label| label.word(false))),
            place: String::new(),
            name: name.into(),
        }
    }

    /// The card with the player of this recording, and the command that repeats it, with these options.
    pub fn to_html(&self, replay: &Replay, options: Option<&str>) -> Markup {
        let id = Players::id(&self.name);
        html! {
            article.card id=(id) aria-labelledby={ (id) "-title" } {
                header {
                    h3 id={ (id) "-title" } { (self.title) }
                    (badge(self.verdict.0, self.verdict.1))
                }
                p { (prose(&replay.short)) }
                p.where { (self.place) }
                div.player data-replay={ (id) "-data" } {}
                (frames(replay, &format!("{id}-ground")))
                details {
                    summary { "Other drivers" @if options.is_some() { ", and the command" } }
                    (reference_drivers(replay))
                    @if let Some(options) = options { p.replay { code { "falsify replay " (options) (self.name) } } }
                }
                (self.data(replay))
            }
        }
    }

    /// What the player needs, with the words that it shows above the picture.
    pub fn data(&self, replay: &Replay) -> Markup {
        html! {
            script type="application/json" id={ (Players::id(&self.name)) "-data" } data-title={ (self.title) ", " (self.verdict.1) } data-short=(replay.short.replace('`', "")) {
                (PreEscaped(json(replay)))
            }
        }
    }
}

/// The word for a failure, in the colours of its class.
pub fn badge(class: FailureClass, word: &str) -> Markup {
    let colour = match class {
        FailureClass::Fault | FailureClass::Preventable => " preventable",
        FailureClass::Contested => " contested",
        _ => "",
    };
    html! { span class={ "verdict" (colour) } { (word) } }
}

/// The reference drivers that would have avoided it, in a line.
fn reference_drivers(replay: &Replay) -> Markup {
    html! {
        @if !replay.drivers.is_empty() {
            ul.drivers aria-label="Reference drivers" {
                @for (name, hit) in &replay.drivers {
                    @match hit {
                        None => li.avoids { b { (name) } " avoids it" },
                        Some(speed) => li.hits { b { (name) } (format!(" collides at {speed:.1} m/s")) },
                    }
                }
            }
        }
    }
}
