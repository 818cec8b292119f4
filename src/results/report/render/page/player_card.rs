use maud::{Markup, PreEscaped, html};

use super::frames::frames;
use super::markup::json;
use super::{Players, Replay};

/// A failure with its player.
#[derive(Debug, Clone, PartialEq)]
pub struct PlayerCard {
    pub title: String,
    /// The verdict: the name of its class, and in words.
    pub verdict: (&'static str, &'static str),
    /// The controller, the town and the driver.
    pub place: String,
    /// More about it, in a sentence or two.
    pub about: String,
    /// Its name, `RUN:EPISODE`.
    pub name: String,
}

impl PlayerCard {
    /// The card with the player of this recording, and the command that repeats it, with these options.
    pub fn to_html(&self, replay: &Replay, options: &str) -> Markup {
        let id = Players::id(&self.name);
        html! {
            article.card id=(id) aria-labelledby={ (id) "-title" } {
                header {
                    h3 id={ (id) "-title" } { (self.title) }
                    span class={ "verdict " (self.verdict.0) } { (self.verdict.1) }
                }
                p.where { (self.place) }
                p { (replay.short) }
                p.where { (self.about) }
                div.player data-replay={ (id) "-data" } {}
                (frames(replay, &format!("{id}-ground")))
                (reference_drivers(replay))
                p.replay { code { "falsify replay " (options) (self.name) } }
                script type="application/json" id={ (id) "-data" } { (PreEscaped(json(replay))) }
            }
        }
    }
}

/// The reference drivers that would have avoided it, in a line.
fn reference_drivers(replay: &Replay) -> Markup {
    html! {
        @if !replay.drivers.is_empty() {
            ul.drivers aria-label="Reference drivers" {
                @for (name, hit) in &replay.drivers {
                    @match hit {
                        None => li.avoids { b { (driver(name)) } " avoids it" },
                        Some(speed) => li.hits { b { (driver(name)) } (format!(" hits at {speed:.1} m/s")) },
                    }
                }
            }
        }
    }
}

/// A reference driver, for people.
fn driver(name: &str) -> &str {
    match name {
        "cc" => "careful human",
        "cc_attentive" => "attentive human",
        "fsm" => "fuzzy safety",
        "rss" => "RSS",
        "ideal" => "ideal brake",
        "bound" => "0.85 g at once",
        other => other,
    }
}
