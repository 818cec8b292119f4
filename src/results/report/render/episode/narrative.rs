use episode::requirement::NamedRequirement;
use episode::{Ending, Frame, LeftOut, Outcome, Pair, Scenario, Trace};
use verdict::cause::violated_part;
use verdict::{ContactSide, Judged, JudgedDegree, Label, NoVerdict, Reference, Verdict, ViolationVerdict};
use world::av::DrivingMode;

/// An action of the driver is an event if it lasts for at least this number of ticks, or to the end.
const LASTING: usize = 3;
/// A brake above this counts as braking.
pub(super) const BRAKING: f64 = 0.05;
/// A verdict tries no longer reaction time (s).
const MAX_REACTION: f64 = 5.0;
/// Most events of a narrative.
const MOST: usize = 40;

/// An episode in words.
#[derive(Debug, Clone, PartialEq)]
pub struct Narrative {
    /// What the driver did and did not do, in a sentence or two.
    pub short: String,
    /// The events in order: time (s) and text.
    pub events: Vec<(f64, String)>,
    /// The verdict and the result of each reference driver, one a line; empty without a collision.
    pub verdict: Vec<String>,
}

/// Describes an episode: its start, when the pedestrian is in sight, the driver's actions, the end, and whether it was avoidable.
pub fn narrative(scenario: &Scenario, trace: &Trace, judged: &Judged) -> Narrative {
    let (outcome, verdict) = (&judged.outcome, judged.verdict.as_ref());
    let (pair, dt) = (trace.main_pair(scenario), scenario.episode.tick);
    let frames: Vec<Frame> = pair.frames().collect();
    let time = |tick: usize| tick as f64 * dt;
    let mut events = vec![(0.0, start(&frames[0], &pair))];
    events.extend(cast(&pair).map(|text| (0.0, text)));
    let in_sight: Vec<bool> = frames.iter().map(|frame| pair.in_sight(frame)).collect();
    for (tick, seen) in in_sight.windows(2).enumerate() {
        if seen[0] != seen[1] {
            let what = if seen[1] { "the pedestrian comes into sight" } else { "the pedestrian goes out of sight" };
            let frame = &frames[tick + 1];
            events.push((time(tick + 1), format!("{what}, {:.1} m from the car", pair.gap(frame))));
        }
    }
    // The control before a frame was chosen one tick earlier.
    events.extend(actions(&frames).into_iter().map(|(tick, action)| (time(tick - 1), action)));
    if let Some(verdict) = verdict {
        let begun = (outcome.duration - verdict.warning).max(0.0);
        events.push((begun, format!("the danger starts, {:.2} s before the touch", verdict.warning)));
    }
    events.sort_by(|one, other| one.0.total_cmp(&other.0));
    if events.len() > MOST {
        let left_out = events.len() - MOST;
        events.drain(MOST / 2..MOST / 2 + left_out);
        let at = events[MOST / 2 - 1].0;
        events.insert(MOST / 2, (at, format!("… {left_out} more")));
    }
    events.push((outcome.duration, ending(outcome, &pair, &frames)));
    if let Some(reason) = outcome.left_out {
        let why = match reason {
            LeftOut::RunUp => "the driver did not reach its start in the run-up",
            LeftOut::OffRoad => "the car left the road before its driver could see a pedestrian",
            LeftOut::RoadEnd => "the car drove past the end of the road",
        };
        events.push((outcome.duration, format!("the episode is in no rate, since {why}")));
    }
    let mut insert = |instant: f64, text: String| {
        let place = events.partition_point(|(time, _)| *time <= instant);
        events.insert(place, (instant, text));
    };
    for (named, JudgedDegree { degree, verdict }) in violations(scenario, judged) {
        let instant = degree.instant(dt).min(outcome.duration);
        let text = format!("violates `{}`{}; {}", named.name, violated_part(named, degree), blame(named, *verdict));
        insert(instant, text);
        if let Some(verdict) = verdict {
            insert(time(verdict.danger as usize), format!("the danger of violating `{}` starts", named.name));
        }
    }
    Narrative {
        short: in_short(scenario, trace, judged),
        events,
        verdict: verdict.map(verdict_lines).unwrap_or_default(),
    }
}

/// An episode in a sentence or two: whether the pedestrian was in sight, whether the driver braked, how fast the car was at the collision, and whether a careful human
/// avoids it; then what it violates, and whose fault that is.
pub fn in_short(scenario: &Scenario, trace: &Trace, judged: &Judged) -> String {
    let sentence = |(named, JudgedDegree { verdict, .. }): (&NamedRequirement, &JudgedDegree)| {
        format!(" The episode violates `{}`: {}.", named.name, blame(named, *verdict))
    };
    let violated: String = violations(scenario, judged).map(sentence).collect();
    how_it_ended(scenario, trace, judged) + &violated
}

fn how_it_ended(scenario: &Scenario, trace: &Trace, Judged { outcome, verdict, .. }: &Judged) -> String {
    let verdict = verdict.as_ref();
    let pair = trace.main_pair(scenario);
    let dt = scenario.episode.tick;
    let frames: Vec<Frame> = pair.frames().collect();
    let Ending::Touch { moving, impact_speed, .. } = outcome.ending else {
        return ending(outcome, &pair, &frames) + ".";
    };
    if !moving {
        return "A bump: the car stood, and the pedestrian walked into it.".into();
    }
    let unseen = frames.iter().rev().position(|frame| !pair.in_sight(frame));
    let sight = match unseen {
        None => "The pedestrian was in sight all the time.".into(),
        Some(0) => "The pedestrian was hidden until the collision.".into(),
        Some(ticks) => format!("The pedestrian was in sight for {:.1} s.", ticks as f64 * dt),
    };
    let brakes = |frame: &&Frame| frame.control.brake > BRAKING;
    let braked = frames.iter().rev().take_while(brakes).count();
    let danger = verdict.map_or(frames.len(), |verdict| (verdict.warning / dt).ceil() as usize + 1);
    let braked_before = frames.iter().rev().take(danger).any(|frame| brakes(&frame));
    let brake = match (braked, braked_before) {
        (0, false) => "did not brake".into(),
        (0, true) => "let go of the brake".into(),
        (ticks, _) => format!("braked for the last {:.1} s", ticks as f64 * dt),
    };
    let part = match verdict.map(|verdict| verdict.side) {
        Some(ContactSide::Side) => " with the car's flank",
        Some(ContactSide::Rear) => " with the car's rear",
        _ => "",
    };
    let careful = match verdict {
        Some(verdict) if verdict.is_preventable() => {
            let margins = Label::humans().map(|human| verdict.margin(human));
            format!(" A careful human avoids it with {:.1} m to spare.", margins[0].min(margins[1]))
        }
        Some(verdict) if verdict.label == Label::Contested => {
            " The reference drivers disagree whether it is avoidable.".into()
        }
        Some(verdict) if verdict.label == Label::MachinePreventable => " Only a machine avoids it.".into(),
        Some(_) => " No brake avoids it.".into(),
        None => String::new(),
    };
    format!("{sight} The driver {brake}; collision{part} at {impact_speed:.1} m/s.{careful}")
}

/// The violated requirements of an episode.
fn violations<'a>(
    scenario: &'a Scenario,
    judged: &'a Judged,
) -> impl Iterator<Item = (&'a NamedRequirement, &'a JudgedDegree)> {
    scenario.requirements.iter().zip(&judged.degrees).filter(|(_, judged)| judged.degree.is_violated())
}

/// Whose fault a violation is: a clause without an end.
fn blame(named: &NamedRequirement, verdict: Option<ViolationVerdict>) -> String {
    match verdict {
        Some(ViolationVerdict { fault: true, .. }) => "a fault: all careful drivers satisfy it".into(),
        Some(ViolationVerdict { preventable: true, foreseeable: false, .. }) => {
            "preventable, since all careful drivers satisfy it; the pedestrian did not move as people do".into()
        }
        Some(ViolationVerdict { preventable: true, .. }) => {
            "preventable, since all careful drivers satisfy it; the collision that decides is not a fault".into()
        }
        Some(_) => "not preventable: a careful human violates it as well".into(),
        None => match NoVerdict::of(&named.requirement) {
            Some(why) => format!("no verdict, since {}", why.reason()),
            None => "no verdict".into(),
        },
    }
}

fn start(first: &Frame, pair: &Pair<'_>) -> String {
    let (ego, pedestrian) = (&first.ego, first.pedestrian.pose.position());
    let away = (pedestrian - ego.pose.position()).norm();
    let sight = if pair.in_sight(first) { "in sight" } else { "hidden" };
    format!(
        "the car is at ({:.1}, {:.1}) m, {}; the pedestrian is {away:.1} m from its middle, {}, {sight}",
        ego.pose.x,
        ego.pose.y,
        speed(ego.speed),
        bearing(ego.pose.bearing_to(pedestrian)),
    )
}

fn speed(speed: f64) -> String {
    if speed <= 0.05 { "at rest".to_string() } else { format!("at {speed:.1} m/s") }
}

/// A bearing in words (rad, positive to the left).
fn bearing(bearing: f64) -> String {
    let degrees = bearing.to_degrees();
    match degrees.abs().round() {
        0.0 => "straight ahead".to_string(),
        size => format!("{size}° to the {}", if degrees > 0.0 { "left" } else { "right" }),
    }
}

/// The action of a driver: its mode, whether it brakes, whether the car stands.
fn action(frame: &Frame) -> (DrivingMode, bool, bool) {
    (frame.mode, frame.control.brake > BRAKING, frame.ego.speed <= 0.05)
}

/// The actions of the driver, each with its first tick.
fn actions(frames: &[Frame]) -> Vec<(usize, String)> {
    let mut actions = Vec::new();
    let (mut last, mut tick) = (None, 1);
    for same in frames[1..].chunk_by(|one, next| action(one) == action(next)) {
        let (begun, (mode, brakes, stands)) = (tick, action(&same[0]));
        tick += same.len();
        if (same.len() < LASTING && tick < frames.len()) || last == Some((mode, brakes, stands)) {
            continue;
        }
        last = Some((mode, brakes, stands));
        let braking = same.iter().map(|frame| frame.control.brake).fold(0.0, f64::max);
        let pedal = match (brakes, stands) {
            (true, true) => "stands, with the brake pressed".to_string(),
            (false, true) => "stands".to_string(),
            (true, false) => format!("brakes, up to {braking:.2} of the pedal"),
            (false, false) => "does not brake".to_string(),
        };
        // A program need not tell its mode.
        let mode = if mode == DrivingMode::Unknown { String::new() } else { format!("{}, ", mode.name()) };
        actions.push((begun, format!("driver: {mode}{pedal}, {}", speed(same[0].ego.speed))));
    }
    actions
}

fn ending(outcome: &Outcome, pair: &Pair<'_>, frames: &[Frame]) -> String {
    match outcome.ending {
        Ending::Touch { front, moving, impact_speed, bearing: at, .. } => {
            let side = if front { "the front sector" } else { "a side or the rear" };
            let (what, car) = if moving { ("collision", speed(impact_speed)) } else { ("bump", "at rest".to_string()) };
            let walking = frames.last().map_or(0.0, |last| last.pedestrian.speed());
            format!("{what} in {side}, {}; the car is {car}, the pedestrian walks at {walking:.1} m/s", bearing(at))
        }
        Ending::OtherContact { .. } => match pair.last_touch() {
            Some([first, second]) => format!("`{first}` and `{second}` touch"),
            None => "actors touch that are not the car and a pedestrian".to_string(),
        },
        Ending::Lost => "the episode ends early, as the scenario says".to_string(),
        Ending::Timeout => format!("the time limit is reached; the least gap was {:.2} m", outcome.least_gap),
        Ending::Error(_) | Ending::ControllerError(_) | Ending::WorldError(_) => outcome.error().unwrap_or_default(),
    }
}

/// The names of the pedestrian and of the other actors; `None` if there are no others.
fn cast(pair: &Pair<'_>) -> Option<String> {
    let mut others: Vec<(String, u32)> = Vec::new();
    for other in pair.others() {
        let name = if other.is_parked { format!("`{}` (parked)", other.name) } else { format!("`{}`", other.name) };
        match others.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += 1,
            None => others.push((name, 1)),
        }
    }
    let named = others.iter().map(|(name, count)| if *count > 1 { format!("{count} of {name}") } else { name.clone() });
    let named: Vec<String> = named.collect();
    (!named.is_empty()).then(|| format!("the pedestrian is `{}`; others: {}", pair.pedestrian_name(), named.join(", ")))
}

/// The verdict and its reasons.
fn verdict_lines(verdict: &Verdict) -> Vec<String> {
    let meaning = match verdict.label {
        Label::Preventable => "a careful human would have avoided it",
        Label::Contested => "the reference drivers disagree",
        Label::MachinePreventable => "only a machine would have avoided it",
        Label::Unpreventable => "no brake avoids it",
        Label::Bump => "the car stood",
    };
    let foreseeable = if verdict.foreseeable { "; the pedestrian was foreseeable" } else { "" };
    let walked = match verdict.side {
        _ if !verdict.walked_into => "",
        ContactSide::Rear => "; the pedestrian ran into the rear",
        _ => "; the pedestrian walked into the side",
    };
    let mut lines = vec![format!("{}: {meaning}{foreseeable}{walked}", verdict.word())];
    if !verdict.is_bump() {
        let share = 100.0 * verdict.preventable_probability();
        lines.push(match verdict.latest_reaction {
            Some(latest) if latest >= MAX_REACTION => {
                format!("  a careful driver avoids it whatever its reaction time is, up to {latest:.0} s")
            }
            Some(latest) => {
                format!("  a careful driver must brake within {latest:.2} s of noticing it; {share:.0} % of drivers do")
            }
            None => "  a careful driver collides even without any reaction time".into(),
        });
    }
    lines.extend(verdict.follower.map(|follower| match follower.deceleration {
        None => "  the car behind runs into a careful human before it can stop".into(),
        Some(0.0) => "  the car behind need not brake when a careful human does".into(),
        Some(needed) => {
            let fares = if follower.touches() { "runs into a careful human" } else { "still stops" };
            format!("  the car behind {fares}: it needs {needed:.1} m/s², and has {:.1} m/s²", follower.limit)
        }
    }));
    lines.extend(reference_lines(verdict));
    lines
}

/// How each reference driver fares, a line each.
fn reference_lines(verdict: &Verdict) -> impl Iterator<Item = String> {
    Reference::ALL.into_iter().map(|reference| {
        let trial = verdict.trial(reference);
        let fared = match trial.impact_speed {
            None => format!("avoids it with {:.2} m to spare", trial.least_gap),
            Some(speed) => match verdict.reduction(reference) {
                less if less >= 0.05 => format!("collides at {speed:.1} m/s, {less:.1} m/s slower"),
                less if less <= -0.05 => format!("collides at {speed:.1} m/s, {:.1} m/s faster", -less),
                _ => format!("collides at {speed:.1} m/s, no slower"),
            },
        };
        format!("  {:<32} {fared}", format!("{} (`{}`)", reference.in_words(), reference.name()))
    })
}
