use std::fmt::Write;

use super::frames::frames;
use super::markup::{escape, json, percent};
use super::replay::{Replay, verdict_named};

/// A kind of collision, with an example that can be played.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ModeCard {
    /// Where and against whom.
    pub place: String,
    /// Who walked.
    pub who: String,
    /// What kind it is, as a title.
    pub title: String,
    /// More about it, in a sentence or two.
    pub about: String,
    /// Whether the pedestrian was trained: these come first.
    pub trained: bool,
    /// Name of the verdict.
    pub verdict: &'static str,
    /// How many collisions are of this kind.
    pub failures: usize,
    /// Share of the collisions of the cell.
    pub share: f64,
    /// How fast the car usually was (m/s).
    pub impact_speed: f64,
    /// After how long it usually happens (s).
    pub length: f64,
    /// Name of the example, `RUN:EPISODE`.
    pub example: String,
    /// The example; none where it was not repeated.
    pub replay: Option<Replay>,
}

/// So many cards are seen at once; the others are folded away.
const SHOWN: usize = 6;

/// The kinds of collisions: a card with a player for those that were repeated, a table of all.
pub fn modes(cards: &[ModeCard]) -> String {
    if cards.is_empty() {
        return String::new();
    }
    let mut html = String::from(
        "<section id=\"modes\"><h2>Kinds of collisions</h2><p class=\"lead\">By where the car was hit, whether it moved, \
         who would have avoided it and what its driver was doing; within these by the last seconds before the touch. Each is played by \
         its most typical example. <span class=\"keys\">Space plays, arrows step by a tick, with shift by a second.</span></p>\
         <div class=\"cards\">",
    );
    let mut players = cards.iter().enumerate().filter_map(|(number, card)| Some((number, card, card.replay.as_ref()?)));
    for (number, card, replay) in players.by_ref().take(SHOWN) {
        self::card(&mut html, number, card, replay);
    }
    html.push_str("</div>");
    let mut players = players.peekable();
    if players.peek().is_some() {
        html.push_str("<details class=\"more\"><summary>More kinds to play</summary><div class=\"cards\">");
        players.for_each(|(number, card, replay)| self::card(&mut html, number, card, replay));
        html.push_str("</div></details>");
    }
    html.push_str(
        "<details class=\"all\"><summary>All kinds</summary><div class=\"wide\"><table><thead><tr><th>place</th><th>pedestrian</th><th>kind</th><th>verdict</th>\
         <th class=\"number\">collisions</th><th class=\"number\">share</th><th class=\"number\">impact m/s</th>\
         <th class=\"number\">after s</th><th>example</th></tr></thead><tbody>",
    );
    for card in cards {
        let _ = write!(
            html,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td><td class=\"number\">{:.1}</td>\
             <td class=\"number\">{:.1}</td><td><code>{}</code></td></tr>",
            escape(&card.place),
            escape(&card.who),
            escape(&card.title),
            verdict_named(card.verdict),
            card.failures,
            percent(card.share),
            card.impact_speed,
            card.length,
            escape(&card.example),
        );
    }
    html.push_str("</tbody></table></div></details></section>");
    html
}

fn card(html: &mut String, number: usize, card: &ModeCard, replay: &Replay) {
    let verdict = card.verdict;
    let _ = write!(
        html,
        "<article class=\"card\" id=\"mode-{number}\" aria-labelledby=\"mode-{number}-title\"><header><h3 id=\"mode-{number}-title\">{}</h3>\
         <span class=\"verdict {verdict}\">{}</span></header><p class=\"where\">{} · {}</p><p>{} of its collisions there, {}. {}</p>",
        escape(&card.title),
        verdict_named(verdict),
        escape(&card.who),
        escape(&card.place),
        card.failures,
        percent(card.share),
        escape(&card.about),
    );
    let _ = write!(
        html,
        "<div class=\"player\" data-replay=\"replay-{number}\"></div>{}{}<p class=\"replay\"><code>falsify replay {}</code></p>\
         <script type=\"application/json\" id=\"replay-{number}\">{}</script></article>",
        frames(replay, &format!("ground-{number}")),
        reference_drivers(replay),
        escape(&card.example),
        json(replay),
    );
}

/// Who would have avoided it, in a line.
fn reference_drivers(replay: &Replay) -> String {
    if replay.drivers.is_empty() {
        return String::new();
    }
    let mut html = String::from("<ul class=\"drivers\" aria-label=\"Reference drivers\">");
    for (name, hit) in &replay.drivers {
        let (text, class) = match hit {
            None => ("avoids it".to_string(), "avoids"),
            Some(speed) => (format!("hits at {speed:.1} m/s"), "hits"),
        };
        let _ = write!(html, "<li class=\"{class}\"><b>{}</b> {text}</li>", driver(name));
    }
    html + "</ul>"
}

/// A reference driver, for people.
fn driver(name: &str) -> &str {
    match name {
        "cc" => "careful human",
        "cc_2s" => "careful human, 2 s",
        "fsm" => "fuzzy safety",
        "rss" => "RSS",
        "ideal" => "ideal brake",
        "bound" => "0.85 g at once",
        other => other,
    }
}
