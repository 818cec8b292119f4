//! Judged recordings: which encounters there are, how severe each is, and what is told of them.

use std::fmt;

use serde_json::{Value as Json, json};

use super::ReferenceAnswers;
use super::render::{Column, Selection, Value};
use crate::record::{Table, TableReference, entries};
use verdict::{Answer, Encountered, Finding, Reference, RestsOn, Sensitivity, Verdict};

/// A car and a pedestrian of a recording, judged.
#[derive(Debug, Clone)]
pub struct JudgedMeeting {
    pub car: String,
    pub pedestrian: String,
    /// The time of the recording at which that of the two begins (s).
    pub begins: f64,
    pub found: Encountered,
    /// What published drivers do in it; empty without a touch.
    pub answers: Vec<Answer>,
    /// How much its verdict rests on what nobody knows exactly; `None` without a touch.
    pub sensitivity: Option<Sensitivity>,
}

/// A car and a pedestrian of a recording that cannot be judged.
#[derive(Debug, Clone)]
pub struct Unjudged {
    pub car: String,
    pub pedestrian: String,
    pub reason: String,
}

impl fmt::Display for Unjudged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "car {}, pedestrian {} cannot be judged: {}", self.car, self.pedestrian, self.reason)
    }
}

/// The encounters of a recording, the worst first, and the pairs that cannot be judged.
#[derive(Debug, Clone, Default)]
pub struct JudgedRecording {
    pub encounters: Vec<JudgedMeeting>,
    pub unjudged: Vec<Unjudged>,
}

impl JudgedMeeting {
    /// The verdict; `None` without a touch, and where the recording does not tell.
    pub fn told(&self) -> Option<&Verdict> {
        self.found.told()
    }

    /// Whether nobody can tell: of a touch, or of a recording that ends on the way to one.
    fn is_open(&self) -> bool {
        self.found.ends_before.is_some() || self.found.touch.is_some() && self.told().is_none()
    }

    /// The time of the touch in the recording (s); `None` without one.
    pub fn touch(&self) -> Option<f64> {
        self.found.touch.map(|touch| self.begins + touch)
    }

    /// What it is called on a page.
    pub fn title(&self) -> String {
        format!("car {}, pedestrian {}", self.car, self.pedestrian)
    }

    /// The drivers in it; `None` without a touch.
    pub fn answers(&self) -> Option<ReferenceAnswers<'_>> {
        self.touch().map(|touch| ReferenceAnswers { answers: &self.answers, touch })
    }

    /// The worse the less: a fault, another preventable touch, one that nobody can judge, other touches, then those without one, the nearest first.
    fn rank(&self) -> (u8, f64) {
        let found = &self.found;
        let least = found.near_miss.min_ttc.unwrap_or(f64::INFINITY);
        match (found.touch, self.told()) {
            _ if self.is_open() => (2, 0.0),
            (None, _) => (4, least),
            (Some(_), None) => (2, 0.0),
            (Some(_), Some(verdict)) if verdict.is_fault() => (0, -verdict.impact_speed),
            (Some(_), Some(verdict)) if verdict.is_preventable() => (1, -verdict.impact_speed),
            (Some(_), Some(verdict)) => (3, -verdict.impact_speed),
        }
    }

    /// Sorts by severity, the worst first.
    pub fn sort(all: &mut [Self]) {
        let key = |one: &Self| (one.rank(), one.begins);
        all.sort_by(|one, other| {
            let ((rank, speed), begins) = key(one);
            let ((other_rank, other_speed), other_begins) = key(other);
            rank.cmp(&other_rank).then(speed.total_cmp(&other_speed)).then(begins.total_cmp(&other_begins))
        });
    }

    /// The word for its verdict.
    pub fn word(&self) -> &'static str {
        match (self.found.touch, self.told()) {
            _ if self.is_open() => "cannot tell",
            (None, _) => "no touch",
            (Some(_), None) => "cannot tell",
            (Some(_), Some(verdict)) => verdict.word(),
        }
    }

    /// An object, with the names of the table of episodes; what does not apply is null.
    pub fn to_json(&self) -> Json {
        let (found, verdict) = (&self.found, self.told());
        let avoided = verdict.map(|verdict| {
            let of = |reference: Reference| (reference.name(), json!(verdict.trial(reference).is_avoided()));
            Reference::ALL.map(of).into_iter().collect::<std::collections::BTreeMap<_, _>>()
        });
        let car = &found.scenario.cast.ego().blueprint;
        let cannot_tell = self.is_open().then_some("cannot_tell");
        json!({
            "car": self.car,
            "pedestrian": self.pedestrian,
            "begins_s": self.begins,
            "touch_s": self.touch(),
            "impact_speed_mps": verdict.map(|verdict| verdict.impact_speed),
            "side": verdict.map(|verdict| verdict.side.name()),
            "verdict": verdict.map(|verdict| verdict.label.name()).or(cannot_tell),
            "begins_late_s": found.begins_late,
            "counts_as": verdict.map(|verdict| verdict.class().name()),
            "foreseeable": verdict.map(|verdict| verdict.foreseeable),
            "fault": verdict.map(Verdict::is_fault),
            "warning_s": verdict.map(|verdict| verdict.warning),
            "rests_on": verdict.and_then(|verdict| verdict.rests_on).map(RestsOn::name),
            "avoided_by": avoided,
            "drivers": self.answers().map(|answers| answers.to_json()),
            "least_gap_m": found.least_gap,
            "ends_before_s": found.ends_before,
            "min_ttc_s": found.near_miss.min_ttc,
            "pet_s": found.near_miss.pet,
            "variations": self.sensitivity.map(|sensitivity| sensitivity.variations),
            "avoided_in": self.sensitivity.map(|sensitivity| sensitivity.avoided),
            "findings": found.findings.iter().map(Finding::to_string).collect::<Vec<_>>(),
            "car_length_m": 2.0 * car.half_length,
            "car_width_m": 2.0 * car.half_width,
            "full_brake_mps2": car.full_brake,
        })
    }
}

impl JudgedRecording {
    /// An object with all encounters, and all pairs that cannot be judged.
    pub fn to_json(&self) -> Json {
        let unjudged =
            |pair: &Unjudged| json!({ "car": pair.car, "pedestrian": pair.pedestrian, "reason": pair.reason });
        json!({
            "encounters": self.encounters.iter().map(JudgedMeeting::to_json).collect::<Vec<_>>(),
            "unjudged": self.unjudged.iter().map(unjudged).collect::<Vec<_>>(),
        })
    }
}

/// What is told of an encounter, a sentence each.
pub fn judgement_lines(each: &JudgedMeeting) -> Vec<String> {
    let found = &each.found;
    let mut lines = Vec::new();
    if found.step > found.scenario.episode.tick {
        let doubt = found.step / 2.0;
        lines.push(format!(
            "rows are {:.2} s apart: the motion between them is interpolated, and the touch is known to {doubt:.2} s",
            found.step
        ));
    }
    let Some(touch) = each.touch() else {
        lines.push(format!("no touch; the least distance is {:.2} m", found.least_gap));
        lines.extend(found.ends_before.map(|before| {
            format!(
                "it ends {before:.2} s before a touch, if both go on as they do: record for longer, or it tells nothing"
            )
        }));
        lines.extend(found.near_miss.min_ttc.map(|ttc| format!("the least time to collision is {ttc:.2} s")));
        lines.extend(found.near_miss.pet.map(|pet| format!("the post-encroachment time is {pet:.2} s")));
        return lines;
    };
    let Some(verdict) = each.told() else {
        lines.push(format!("touch after {touch:.2} s"));
        lines.push(match &found.undecided {
            Some(finding) if finding.decides() => {
                format!("verdict: cannot tell. It rests on what is damaged: {finding}")
            }
            Some(_) => "verdict: cannot tell. With as much noise again it is another".to_owned(),
            None => format!(
                "verdict: cannot tell. The danger was under way when the recording begins; give at least {} s more before it",
                (found.begins_late.unwrap_or(0.0) * 10.0).ceil() / 10.0
            ),
        });
        return lines;
    };
    lines.push(format!(
        "touch after {touch:.2} s at the {} of the car, which drives {:.2} m/s",
        verdict.side.name(),
        verdict.impact_speed
    ));
    lines.push(format!("verdict: {}", verdict.label.name()));
    let counts = if verdict.is_fault() { "counts" } else { "does not count" };
    let class = verdict.class();
    lines.push(format!("counts as {}: it {counts} against the driver, since {}", class.name(), class.reason()));
    lines.push(match verdict.warning + found.step >= touch - each.begins {
        true => "the danger started in the first row, or before it".to_owned(),
        false => format!("the danger started {:.2} s before the touch", verdict.warning),
    });
    if let Some(sensitivity) = each.sensitivity.filter(|sensitivity| sensitivity.variations > 0) {
        let [reaction, braking, margin] = [Sensitivity::REACTION, Sensitivity::BRAKING, Sensitivity::MARGIN];
        lines.push(format!(
            "a careful human avoids it in {:.0} % of {} variations: reaction {} to {} s, braking {} to {} m/s^2, {} to {} m to spare, the pedestrian {} m to all sides",
            sensitivity.percent(),
            sensitivity.variations,
            reaction.0,
            reaction.1,
            braking.0,
            braking.1,
            margin.0,
            margin.1,
            Sensitivity::OFFSET
        ));
    }
    lines
}

/// The encounters of a recording as text for a terminal of this width (columns).
pub fn meetings_for_terminal(all: &[JudgedMeeting], width: u16) -> String {
    let number = |value: Option<f64>| Value::number(value, 2);
    Selection::new()
        .text("car", |each: &JudgedMeeting| Value::code(&each.car))
        .text("pedestrian", |each| Value::code(&each.pedestrian))
        .text("verdict", |each| Value::text(each.word()))
        .number("touch (s)", move |each| number(each.touch()))
        .number("at (m/s)", move |each| number(each.told().map(|verdict| verdict.impact_speed)))
        .number("least TTC (s)", move |each| number(each.found.near_miss.min_ttc))
        .column(Column::number("gap (m)"), move |each| number(Some(each.found.least_gap)))
        .table(all)
        .to_terminal(width)
}

/// A car, a pedestrian, and how they meet or why that is not judged.
type Row<'a> = (&'a str, &'a str, Result<&'a JudgedMeeting, &'a str>);

/// A row for each pair, for CSV.
pub fn meetings_table(all: &JudgedRecording) -> polars::prelude::DataFrame {
    let table: Table<'_, Row<'_>> =
        Table::new("encounters", "One row for each pair.").columns(entries! { row: &Row<'_>;
            /// the car
            car: String = row.0.to_owned();
            /// the pedestrian
            pedestrian: String = row.1.to_owned();
            /// time of the touch in the recording, empty without one
            touch_s: f64 ["s"] = row.2.ok().and_then(JudgedMeeting::touch);
            /// its verdict; `not judged` if the recording of the two does not allow any
            verdict: String = row.2.map_or("not judged", JudgedMeeting::word);
            /// speed of the car at the touch
            impact_speed_mps: f64 ["m/s"] = row.2.ok().and_then(|each| Some(each.told()?.impact_speed));
            /// published drivers that avoid the touch, of those who vote
            votes_avoid: u64 = row.2.ok().and_then(|each| each.told().and(Some(each.answers()?.votes().0 as u64)));
            /// published drivers who vote
            votes: u64 = row.2.ok().and_then(|each| each.told().and(Some(each.answers()?.votes().1 as u64)));
            /// least time to collision
            min_ttc_s: f64 ["s"] = row.2.ok().and_then(|each| each.found.near_miss.min_ttc);
            /// post-encroachment time
            pet_s: f64 ["s"] = row.2.ok().and_then(|each| each.found.near_miss.pet);
            /// least distance
            least_gap_m: f64 ["m"] = row.2.ok().map(|each| each.found.least_gap);
            /// time from the end of the recording to a touch, if both keep their velocities
            ends_before_s: f64 ["s"] = row.2.ok().and_then(|each| each.found.ends_before);
            /// why it is not judged
            reason: String = row.2.err().unwrap_or_default().to_owned();
        });
    let judged = all.encounters.iter().map(|each| (&*each.car, &*each.pedestrian, Ok(each)));
    let unjudged = all.unjudged.iter().map(|pair| (&*pair.car, &*pair.pedestrian, Err(&*pair.reason)));
    table.frame(&judged.chain(unjudged).collect::<Vec<_>>())
}

/// What is counted of a recording.
#[derive(Debug, Clone, Copy)]
struct Counts {
    encounters: usize,
    /// `None` if a pair cannot be judged.
    touches: Option<u64>,
    /// `None` if a touch or a pair cannot be judged.
    preventable: Option<u64>,
    faults: Option<u64>,
    cannot_tell: usize,
}

/// The same, for conditions.
fn counted() -> Table<'static, Counts> {
    Table::new("recording", "One row.").columns(entries! { row: &Counts;
        /// encounters
        encounters: u64 = row.encounters as u64;
        /// encounters that end in a touch; missing if a pair cannot be judged
        touches: u64 = row.touches;
        /// touches that every careful driver avoids; missing if a touch or a pair cannot be judged
        preventable: u64 = row.preventable;
        /// touches that count against the driver; missing if a touch or a pair cannot be judged
        faults: u64 = row.faults;
        /// touches and pairs that cannot be judged, and recordings that end on the way to a touch
        cannot_tell: u64 = row.cannot_tell as u64;
    })
}

/// The columns of [`counted_table`].
pub fn counted_reference() -> TableReference {
    counted().reference()
}

/// What conditions judge: a row with the counts of a recording.
pub fn counted_table(all: &JudgedRecording) -> polars::prelude::DataFrame {
    let count = |is: &dyn Fn(&JudgedMeeting) -> bool| all.encounters.iter().filter(|each| is(each)).count();
    let touches = count(&|each| each.found.touch.is_some());
    let cannot_tell = count(&JudgedMeeting::is_open) + all.unjudged.len();
    let known =
        |is: &dyn Fn(&Verdict) -> bool| (cannot_tell == 0).then(|| count(&|each| each.told().is_some_and(is)) as u64);
    counted().frame(&[Counts {
        encounters: all.encounters.len() + all.unjudged.len(),
        touches: all.unjudged.is_empty().then_some(touches as u64),
        preventable: known(&Verdict::is_preventable),
        faults: known(&Verdict::is_fault),
        cannot_tell,
    }])
}
