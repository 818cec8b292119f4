//! A page about a recording: each encounter with its player, published drivers as ghosts, their speeds, and the table of all drivers.

use maud::{Markup, html};

use super::page::{OtherTrack, PlayerCard, Replay, document};
use super::svg::{Chart, Curve, Figure, short};
use crate::failure::FailureClass;
use crate::report::{JudgedMeeting, JudgedRecording, judgement_lines};
use verdict::Answer;

/// The drivers that drive beside the recorded car.
const GHOSTS: [&str; 4] = ["cc", "fsm", "r157_cc", "r152_aeb"];
/// The most encounters with a player; the table has all.
const MOST: usize = 30;
/// The size of the picture of speeds, and half of a mark, as a share of its width.
const SIZE: (f64, f64) = (338.0, 210.0);
const MARK: f64 = 0.012;
const DIAMOND: [(f64, f64); 5] = [(-1.0, 0.0), (0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)];
const CROSS: [(f64, f64); 5] = [(-1.0, -1.0), (1.0, 1.0), (0.0, 0.0), (-1.0, 1.0), (1.0, -1.0)];
/// Time before and after the touch that they show (s).
const BEFORE: f64 = 6.0;
const AFTER: f64 = 3.0;

/// The page about the encounters of the file with this name.
pub fn judgement_page(name: &str, recording: &JudgedRecording) -> String {
    let all = &recording.encounters;
    let body = html! {
        header.top {
            p.kind { "falsify · judge" }
            h1 { (name) }
            p.lead { @match all.len() { 1 => "An encounter", many => { (many) " encounters, the worst first" } } ". Would a careful driver have avoided the touch?" }
            button #theme type="button" hidden { "Dark" }
            @for pair in &recording.unjudged { p.warn { (pair.to_string()) } }
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
    let ghosts = GHOSTS.iter().filter_map(|name| ghost(name, each, &replay));
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
                (speeds(each, touch).to_html())
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

/// The speeds of the recorded car and of the ghosts; a diamond where each notices the pedestrian, a cross where it brakes.
fn speeds(each: &JudgedMeeting, touch: f64) -> Figure {
    let pair = each.found.trace.pair(&each.found.scenario, 0, 0);
    let tick = each.found.scenario.episode.tick;
    let x = ((touch - BEFORE).max(0.0), touch + AFTER);
    let within = |points: &mut Vec<(f64, f64)>| points.retain(|(time, _)| (x.0..=x.1).contains(time));
    let mut recorded: Vec<_> =
        pair.frames().enumerate().map(|(place, frame)| (place as f64 * tick, frame.ego.speed)).collect();
    within(&mut recorded);
    let most = 1.1 * recorded.iter().map(|(_, speed)| *speed).fold(1.0, f64::max);
    let mut curves = vec![Curve { thin: true, points: vec![(touch, 0.0), (touch, most)], ..Curve::default() }];
    for (place, name) in GHOSTS.iter().enumerate() {
        let Some(answer) = each.answers.iter().find(|answer| answer.driver.name == *name) else { continue };
        let time = |place: usize| touch - answer.begins + place as f64 * tick;
        let mut way: Vec<_> =
            answer.poses.iter().enumerate().map(|(place, (_, speed))| (time(place), *speed)).collect();
        within(&mut way);
        let mark = |before: Option<f64>, shape: [(f64, f64); 5]| {
            let at = touch - before?;
            let (_, speed) = way.iter().find(|(time, _)| *time >= at - tick / 2.0)?;
            Some(shape.map(|(right, up)| (at + right * MARK * (x.1 - x.0), speed + up * 1.6 * MARK * most)).to_vec())
        };
        let marks = [mark(answer.trigger, DIAMOND), mark(answer.brake, CROSS)].into_iter().flatten();
        let points: Vec<_> = marks.chain([way.clone()]).collect();
        curves.extend(points.into_iter().map(|points| Curve { colour: place + 1, points, ..Curve::default() }));
    }
    curves.push(Curve { points: recorded, ..Curve::default() });
    let chart = Chart { size: SIZE, x, y: (0.0, most), x_label: "time (s)".into(), y_text: short, x_text: short };
    let names = std::iter::once("recorded").chain(GHOSTS);
    Figure {
        title: "Speeds (m/s) of the recorded car and of four drivers.".into(),
        notes: vec!["Diamond: notices the pedestrian. Cross: brakes. Thin line: the touch.".into()],
        legend: names.enumerate().map(|(place, name)| (format!("s{place}"), name.into())).collect(),
        panels: vec![chart.panel("Speeds".into(), "Speeds over time".into(), &curves)],
        ..Figure::default()
    }
}
