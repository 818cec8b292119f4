use serde_json::json;

use super::repeat::{self, Repeated, Source};
use super::repeat_args::ReplayOptions;
use super::{ExitCode, front};
use crate::report::{self, Narrative};

/// `falsify replay`
pub fn replay(options: &ReplayOptions) -> ExitCode {
    let repeated = repeat::find(&options.which)
        .and_then(|report| repeat::open(report, &options.which.repeat))
        .and_then(|source| source.repeat(options.which.name).map(|repeated| (source, repeated)));
    let (source, repeated) = match repeated {
        Ok(repeated) => repeated,
        Err(code) => return code,
    };
    let Repeated { name, scenario, outcome, trace, verdict, .. } = &repeated;
    if let Some(path) = &options.ticks {
        let table = report::ticks(name.run, name.number, scenario, trace);
        if let Err(error) = report::write_table(path, &table) {
            front::fail(&error.to_string());
            return ExitCode::WriteFailed;
        }
    }
    let narrative = report::narrative(scenario, outcome, trace, verdict.as_ref());
    if options.json {
        front::say(&as_json(&source, &repeated, &narrative).to_string());
    } else {
        tell(&source, &repeated, &narrative);
    }
    if repeated.differences.is_empty() { ExitCode::Done } else { ExitCode::Differs }
}

/// Tells it for people.
fn tell(source: &Source, repeated: &Repeated, narrative: &Narrative) {
    let manifest = source.report.manifest();
    let smoke = if manifest.smoke { ", a trial of the machinery" } else { "" };
    front::say(&format!("{}  {}", repeated.name, repeated.title));
    front::say(&format!("of {}, seed {}{smoke}\n", source.report.folder().display(), manifest.seed));
    for (time, text) in &narrative.events {
        front::say(&format!("{time:7.2} s  {text}"));
    }
    if !narrative.verdict.is_empty() {
        front::say("");
        narrative.verdict.iter().for_each(|line| front::say(line));
    }
    front::say("");
    if repeated.differences.is_empty() {
        front::say(&format!("digest {:016x}: as in the report, in every column", repeated.outcome.digest));
        return;
    }
    front::fail(&format!("{} came out differently", repeated.name));
    for difference in &repeated.differences {
        front::say(&format!("  {} was {}, and is {}", difference.column, difference.stored, difference.again));
    }
    match &repeated.parting {
        Some(parting) => front::say(&format!("it parts {parting}")),
        None => front::say("where it parts is not known; `falsify run --ticks failures` keeps what tells"),
    }
    repeat::reasons(manifest).iter().for_each(|reason| front::say(&format!("perhaps {reason}")));
}

/// Tells it for programs.
fn as_json(source: &Source, repeated: &Repeated, narrative: &Narrative) -> serde_json::Value {
    let outcome = &repeated.outcome;
    let events = narrative.events.iter().map(|(time, text)| json!({ "time_s": time, "text": text }));
    let differences = repeated.differences.iter().map(
        |difference| json!({ "column": difference.column, "stored": difference.stored, "again": difference.again }),
    );
    let commands = repeated.trace.decisions(0).iter();
    let commands = commands.map(|command| json!({ "heading_rad": command.heading, "speed_mps": command.speed }));
    json!({
        "name": repeated.name.to_string(),
        "what": repeated.title,
        "report": source.report.folder().display().to_string(),
        "seed": source.report.manifest().seed,
        "equal": repeated.differences.is_empty(),
        "differences": differences.collect::<Vec<_>>(),
        "parting": repeated.parting,
        "collision": outcome.is_collision(),
        "impact_speed_mps": outcome.impact_speed(),
        "episode_length_s": outcome.duration,
        "ticks": outcome.ticks,
        "least_gap_m": outcome.least_gap,
        "verdict": repeated.verdict.map(|verdict| verdict.label.name()),
        "warning_s": repeated.verdict.map(|verdict| verdict.warning),
        "digest": format!("{:016x}", outcome.digest),
        "events": events.collect::<Vec<_>>(),
        "commands": commands.collect::<Vec<_>>(),
    })
}
