//! A page about a recording: each encounter with its player, published drivers as ghosts, their speeds, and the table of all drivers.

use maud::{Markup, html};

use super::page::{OtherTrack, PlayerCard, Replay, document};
use super::svg::{fine, px};
use crate::failure::FailureClass;
use crate::report::{JudgedMeeting, judgement_lines};
use verdict::Answer;

/// The drivers that drive beside the recorded car.
const GHOSTS: [(&str, &str); 4] =
    [("cc", "#2a9d8f"), ("fsm", "#8a63d2"), ("r157_cc", "#d08c1d"), ("r152_aeb", "#6b7a8f")];
/// The most encounters with a player; the table has all.
const MOST: usize = 30;
/// Width and height of the speeds, and the room for their numbers (px).
const SIZE: (f64, f64) = (720.0, 200.0);
const EDGE: (f64, f64) = (36.0, 24.0);
/// Time before and after the touch that they show (s).
const BEFORE: f64 = 6.0;
const AFTER: f64 = 3.0;

/// The page about the encounters of the file with this name.
pub fn judgement_page(name: &str, all: &[JudgedMeeting]) -> String {
    let body = html! {
        header.top {
            p.kind { "falsify · judge" }
            h1 { (name) }
            p.lead { @match all.len() { 1 => "An encounter", many => { (many) " encounters, the worst first" } } ". Would a careful driver have avoided the touch?" }
            button #theme type="button" hidden { "Dark" }
            @if all.len() > MOST { p.warn { "Players of the first " (MOST) "; JSON and CSV have all." } }
        }
        main #main {
            @for (place, each) in all.iter().take(MOST).enumerate() { (encounter(place, each)) }
        }
    };
    document(name, env!("CARGO_PKG_VERSION"), &body, true)
}

fn encounter(place: usize, each: &JudgedMeeting) -> Markup {
    let sentence = |line: String| line[..1].to_uppercase() + &line[1..] + ".";
    let text: Vec<String> = judgement_lines(each).into_iter().map(sentence).collect();
    let mut replay = Replay::of_recording(&each.found, &text.join(" "));
    let ghosts = GHOSTS.iter().filter_map(|(name, _)| ghost(name, each, &replay));
    let ghosts: Vec<OtherTrack> = ghosts.collect();
    replay.others.extend(ghosts);
    let label = each.told().map(|verdict| verdict.label);
    let is_fault = each.told().is_some_and(verdict::Verdict::is_fault);
    let card = PlayerCard {
        title: each.title(),
        verdict: (FailureClass::new(label, is_fault), each.word()),
        place: String::new(),
        name: format!("meeting-{place}"),
    };
    html! {
        section {
            (card.to_html(&replay, None))
            @for finding in &each.found.findings { p.warn { (finding.to_string()) } }
            @if let (Some(answers), Some(touch)) = (each.answers(), each.found.touch) {
                (speeds(each, touch))
                p { b { (answers.count()) "." } }
                div.wide { (answers.table().to_html()) }
            }
        }
    }
}

/// A driver beside the recorded car, up to the touch.
fn ghost(name: &str, each: &JudgedMeeting, replay: &Replay) -> Option<OtherTrack> {
    let answer = each.answers.iter().find(|answer| answer.driver.name == name)?;
    let mut states = replay.ego.clone();
    let begins = begins(each, answer);
    for (tick, (pose, speed)) in answer.poses.iter().enumerate() {
        if let Some(state) = states.get_mut(begins + tick) {
            *state = replay.state(pose, *speed);
        }
    }
    Some(OtherTrack { name: name.to_owned(), is_pedestrian: false, half: replay.car, states })
}

/// The tick of the trace at which a driver begins.
fn begins(each: &JudgedMeeting, answer: &Answer) -> usize {
    let (touch, tick) = (each.found.touch.unwrap_or(0.0), each.found.scenario.episode.tick);
    ((touch - answer.begins) / tick).round().max(0.0) as usize
}

/// The speeds of the recorded car and of the ghosts; a circle where each notices the pedestrian, a dot where it brakes.
fn speeds(each: &JudgedMeeting, touch: f64) -> Markup {
    let pair = each.found.trace.pair(&each.found.scenario, 0, 0);
    let tick = each.found.scenario.episode.tick;
    let recorded: Vec<(f64, f64)> =
        pair.frames().enumerate().map(|(place, frame)| (place as f64 * tick, frame.ego.speed)).collect();
    let shown = |answer: &&Answer| GHOSTS.iter().any(|(name, _)| *name == answer.driver.name);
    let drawn: Vec<&Answer> = each.answers.iter().filter(shown).collect();
    let from = (touch - BEFORE).max(0.0);
    let most = recorded.iter().map(|(_, speed)| *speed).fold(1.0, f64::max) * 1.1;
    let x = |time: f64| EDGE.0 + (time - from) / (touch + AFTER - from) * (SIZE.0 - EDGE.0 - 8.0);
    let y = |speed: f64| SIZE.1 - EDGE.1 - speed / most * (SIZE.1 - EDGE.1 - 8.0);
    let is_shown = |time: f64| (from..=touch + AFTER).contains(&time);
    let line = |points: &[(f64, f64)]| {
        let within = points.iter().filter(|(time, _)| is_shown(*time));
        let places: Vec<String> =
            within.map(|(time, speed)| format!("{},{}", fine(x(*time)), fine(y(*speed)))).collect();
        places.join(" ")
    };
    let way = |answer: &Answer| -> Vec<(f64, f64)> {
        let start = touch - answer.begins;
        answer.poses.iter().enumerate().map(|(place, (_, speed))| (start + place as f64 * tick, *speed)).collect()
    };
    let at = |points: &[(f64, f64)], time: f64| {
        points
            .iter()
            .min_by(|one, other| (one.0 - time).abs().total_cmp(&(other.0 - time).abs()))
            .map_or(0.0, |point| point.1)
    };
    html! {
        figure {
            svg viewBox={ "0 0 " (SIZE.0) " " (SIZE.1) } role="img" aria-label="Speeds over time" {
                @for part in 0..=4 {
                    @let (speed, time) = (most * f64::from(part) / 4.0, from + (touch + AFTER - from) * f64::from(part) / 4.0);
                    text.muted x="0" y=(px(y(speed) + 4.0)) font-size="11" { (format!("{speed:.1}")) }
                    text.muted x=(px((x(time) - 10.0).min(SIZE.0 - 36.0))) y=(px(SIZE.1 - 6.0)) font-size="11" { (format!("{time:.1} s")) }
                }
                path d={ "M" (px(x(touch))) " 8V" (px(y(0.0))) } stroke="#c0392b" stroke-dasharray="4 3" {}
                polyline points=(line(&recorded)) fill="none" stroke="currentColor" stroke-width="2" {}
                @for answer in &drawn {
                    @let colour = GHOSTS.iter().find(|(name, _)| *name == answer.driver.name).map_or("", |(_, colour)| colour);
                    @let points = way(answer);
                    polyline points=(line(&points)) fill="none" stroke=(colour) stroke-width="1.5" {}
                    @if let Some(time) = answer.trigger.map(|before| touch - before).filter(|time| is_shown(*time)) {
                        circle cx=(px(x(time))) cy=(px(y(at(&points, time)))) r="4" fill="none" stroke=(colour) {}
                    }
                    @if let Some(time) = answer.brake.map(|before| touch - before).filter(|time| is_shown(*time)) {
                        circle cx=(px(x(time))) cy=(px(y(at(&points, time)))) r="3.5" fill=(colour) {}
                    }
                }
            }
            figcaption {
                "Speed (m/s) of the recorded car and of "
                @for (name, colour) in GHOSTS { span style={ "color:" (colour) } { (name) } " " }
                "(circle: notices the pedestrian, dot: brakes, dashes: the touch)"
            }
        }
    }
}
