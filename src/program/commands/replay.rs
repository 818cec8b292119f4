mod all;

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::episode::{Named, RepeatArgs, resolved};
use crate::cli::console;
use crate::cli::failure::{failed, misused, unwritten};
use crate::cli::input::session;
use crate::exit_code::{Ended, ExitCode};
use crate::session::{
    Causes, ChangedProgram, EpisodeName, EpisodePath, Error, RepeatOptions, Repeated, Session, reasons,
};
pub use all::{ReplayAllOptions, ReplayedReport, Retrained};
use results::failure::no_verdict;
use results::report::{self, Narrative, StoredReport};
use verdict::JudgedDegree;
use verdict::cause::{Cause, MAX_RUNS, Need, Questions, RunLimit, TurnedBy, needed, part_of, unit_of};
use world::sim::time_of;

pub const EXAMPLES: &str = "\
Examples:
  falsify replay 1a2b3c4d:17                 repeat an episode of a report in reports/, describe it
  falsify replay nightly/first_look/1a2b3c4d:17
                                             of that report, as `--report nightly/first_look` does
  falsify failures --names --top 5 | falsify replay -
                                             the five worst failures of reports/
  falsify replay 1a2b3c4d:17 --ticks way.csv
                                             also write every tick as a table, .csv or .parquet
  falsify replay 1a2b3c4d:17 --shrunk        the same failure with the fewest commands of the pedestrian
  falsify replay --all reports/first_look --sample 100
                                             100 episodes of a report, every column compared byte for byte
  falsify replay --all reports/first_look --trainings
                                             all of them, and train every pedestrian again

`falsify failures` lists the names of failures; they are also in failures.csv (`run_id`, `number`).

Exit codes: 0 it is as in the report   2 no such episode, or a file is missing   3 errors in a scenario
  6 a file cannot be written   8 it differs from the report, or a scenario file has changed";

/// Options of `falsify replay`.
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// Episodes, or failures of searches; a path before the name is that of the report. `-` reads names from the input, one a line.
    #[arg(required_unless_present = "all", conflicts_with = "all", value_name = "[PATH/]RUN:EPISODE", value_parser = str::parse::<Named>)]
    pub names: Vec<Named>,
    /// The report, or the folder of reports, of names without a path.
    #[arg(long, default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR")]
    pub report: PathBuf,
    /// A whole report instead.
    #[command(flatten)]
    pub all: ReplayAllOptions,
    /// Options of the repetition.
    #[command(flatten)]
    pub repeat: RepeatArgs,
    /// Write every tick as a table; the end of the name says whether as .csv or .parquet.
    #[arg(long, value_name = "FILE", value_parser = table_file, conflicts_with = "all", display_order = 16)]
    pub ticks: Option<PathBuf>,
    /// Print one JSON object, for programs.
    #[arg(long, conflicts_with = "all", display_order = 17)]
    pub json: bool,
    /// Explain the failure also if the driver is a program, which drives some hundred episodes for it.
    #[arg(long, conflicts_with = "all", display_order = 19)]
    pub why: bool,
    /// Maximum number of episodes for --why, and for --shrunk.
    #[arg(long, default_value_t = MAX_RUNS, conflicts_with = "all", value_name = "N", display_order = 20)]
    pub max_runs: u32,
    /// Repeat the failure with the fewest commands, as `falsify shrink` finds it.
    #[arg(long, conflicts_with = "all", display_order = 18)]
    pub shrunk: bool,
}

fn table_file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let known = path.extension().is_some_and(|extension| extension == "csv" || extension == "parquet");
    if known { Ok(path) } else { Err("the name must end in .csv or .parquet".into()) }
}

/// Options of [`Session::replay`].
#[derive(Debug, Clone)]
pub struct ReplayOptions {
    /// The episode, or the failure of a search.
    pub name: EpisodeName,
    /// A report, or a folder of reports.
    pub report: PathBuf,
    /// Options of the repetition.
    pub repeat: RepeatOptions,
}

/// An episode of a report that was repeated.
#[derive(Debug, Clone)]
pub struct Replay {
    pub report: StoredReport,
    pub episode: Repeated,
    /// The programs that are not, or need not be, those of the report.
    pub programs: Vec<ChangedProgram>,
}

impl Session {
    /// Repeats an episode of a report and compares it with the report.
    ///
    /// # Errors
    /// No report has it, scenario files cannot be compiled or are not those that were run, or a file of the report is damaged.
    pub fn replay(&self, options: &ReplayOptions) -> Result<Replay, Error> {
        let report = self.find(&options.report, options.name)?;
        report.check_for_repetition()?;
        let source = self.reopen(report, &options.repeat)?;
        let episode = source.repeat(options.name)?;
        let programs = source.changed_programs();
        Ok(Replay { report: source.report, episode, programs })
    }
}

pub fn replay(options: &ReplayArgs) -> Ended {
    let session = session(options.repeat.allow_external);
    let repeat = &options.repeat.repeat;
    if let Some(folder) = &options.all.report {
        let report = StoredReport::open(folder).map_err(|error| failed(error.into()))?;
        let replayed = session.replay_all(report, &options.all, repeat).map_err(failed)?;
        return Ok(all::tell(&replayed));
    }
    let episodes = resolved(&options.names)?;
    if episodes.len() > 1 && options.ticks.is_some() {
        return Err(misused("--ticks writes one file, so it takes one episode"));
    }
    let mut ended = ExitCode::Done;
    for (number, EpisodePath { report, name }) in episodes.into_iter().enumerate().take_while(|_| !console::closed()) {
        if number > 0 && !options.json {
            console::say("");
        }
        let report = report.unwrap_or_else(|| options.report.clone());
        let which = ReplayOptions { name, report, repeat: repeat.clone() };
        ended = ended.or(replay_one(&session, &which, options).unwrap_or_else(|code| code));
    }
    Ok(ended)
}

fn replay_one(session: &Session, which: &ReplayOptions, options: &ReplayArgs) -> Ended {
    let mut replay = session.replay(which).map_err(failed)?;
    if options.shrunk {
        let shrunk = replay.episode.shrink(options.max_runs).map_err(failed)?;
        replay.episode = replay.episode.replaced_by(shrunk);
    }
    let episode = &replay.episode;
    if let Some(path) = &options.ticks {
        let table = report::ticks(which.name.run, which.name.number, &episode.scenario, &episode.trace);
        report::write_table(path, &table).map_err(unwritten)?;
    }
    let narrative = report::narrative(&episode.scenario, &episode.trace, &episode.judged);
    let cause = match options.why {
        true => Causes::new(session, 1, options.max_runs).of(episode),
        false => episode.cause(Questions::OfCopied, RunLimit::default()),
    };
    let needs = episode.incident.as_ref().map_or_else(Vec::new, verdict::cause::needs);
    if options.json {
        console::say(&as_json(&replay, &narrative, cause.as_ref(), &needs).to_string());
    } else {
        tell(&replay, &narrative, cause.as_ref(), &needs, options);
    }
    if episode.differences.is_empty() { Ok(ExitCode::Done) } else { Err(ExitCode::Differs) }
}

/// Prints the result for people.
fn tell(replay: &Replay, narrative: &Narrative, cause: Option<&Cause>, needs: &[Need], options: &ReplayArgs) {
    let Replay { report, episode: repeated, programs } = replay;
    let manifest = report.manifest();
    let smoke = if manifest.smoke { ", a trial of the machinery" } else { "" };
    console::say(&format!("{}  {}", repeated.name, repeated.title));
    console::say(&format!("of {}, seed {}{smoke}\n", report.folder().display(), manifest.seed));
    let paragraph = |text: &str| console::say(&format!("{}\n", console::wrapped(text).trim_end()));
    if let Some(cause) = cause {
        paragraph(&cause.sentence());
        if cause.is_cut && cause.fault.is_none() {
            paragraph("`--max-runs` raises the limit.");
        }
        if !cause.faculties.is_empty() {
            paragraph(&format!("{} {}", cause.last_chances(), cause.perfected()));
        }
        cause.setting.iter().for_each(|turned| paragraph(&turned.cost()));
        cause.world.iter().for_each(|turned| paragraph(&format!("{} {}", turned.text(), turned.cost())));
    }
    if cause.is_none() && repeated.incident.is_some() && repeated.differences.is_empty() {
        let (needed, path) = (manifest.call.replay_options(), report.folder().join(repeated.name.to_string()));
        paragraph(&match options.why {
            true => "No cause is found: the failure does not happen again with the same commands.".into(),
            false => {
                format!("Why it failed is asked of a program by `falsify replay --why {needed}{}`.", path.display())
            }
        });
    }
    if !needs.is_empty() {
        paragraph(&needed(needs));
    }
    paragraph(&narrative.short);
    for (time, text) in &narrative.events {
        console::say(console::wrapped(&format!("{time:7.2} s  {text}")).trim_end());
    }
    if !narrative.verdict.is_empty() {
        console::say("");
        narrative.verdict.iter().for_each(|line| console::say(console::wrapped(line).trim_end()));
    }
    console::say("");
    if repeated.differences.is_empty() {
        let digest = repeated.judged.outcome.digest;
        console::say(&match options.shrunk {
            true => format!("digest {digest:016x}; before it was shrunk it was as in the report, in every column"),
            false => format!("digest {digest:016x}: as in the report, in every column"),
        });
        return;
    }
    console::fail(&format!("{} differs from the report", repeated.name));
    for difference in &repeated.differences {
        console::say(&format!("  {} was {}, and is {}", difference.column, difference.stored, difference.again));
    }
    match &repeated.divergence {
        Some(divergence) => console::say(&format!("it diverges {divergence}")),
        None => console::say("where it starts to differ is unknown"),
    }
    let edited = report.changed_files().unwrap_or_default();
    reasons(report, programs, &edited).iter().for_each(|reason| console::say(&format!("possible reason: {reason}")));
}

/// Makes an object of the result, for programs.
fn as_json(replay: &Replay, narrative: &Narrative, cause: Option<&Cause>, needs: &[Need]) -> serde_json::Value {
    let Replay { report, episode: repeated, .. } = replay;
    let (outcome, verdict) = (&repeated.judged.outcome, repeated.judged.verdict);
    let events = narrative.events.iter().map(|(time, text)| json!({ "time_s": time, "text": text }));
    let differences = repeated.differences.iter().map(
        |difference| json!({ "column": difference.column, "stored": difference.stored, "again": difference.again }),
    );
    let scenario = &repeated.scenario;
    let degrees = scenario.requirements.iter().zip(&repeated.judged.degrees);
    let requirements: Vec<_> = degrees
        .map(|(named, JudgedDegree { degree, verdict })| {
            json!({
                "requirement": &*named.name,
                "violated": degree.is_violated(),
                "robustness": degree.robustness,
                "unit": unit_of(named),
                "scaled": named.requirement.is_scaled(),
                "instant_s": degree.instant(scenario.episode.tick).min(outcome.duration),
                "part": part_of(named, degree),
                "preventable": verdict.map(|verdict| verdict.preventable),
                "foreseeable": verdict.map(|verdict| verdict.foreseeable),
                "fault": verdict.map(|verdict| verdict.fault),
                "danger_s": verdict.map(|verdict| time_of(verdict.danger as usize, scenario.episode.tick)),
                "no_verdict": no_verdict(named),
            })
        })
        .collect();
    let commands = repeated.trace.decisions(0).iter();
    let commands = commands.map(|command| json!({ "heading_rad": command.heading, "speed_mps": command.speed }));
    let mut object = json!({
        "name": repeated.name.to_string(),
        "what": repeated.title,
        "cause": cause.map(cause_json),
        "short": narrative.short,
        "report": report.folder().display().to_string(),
        "seed": report.manifest().seed,
        "equal": repeated.differences.is_empty(),
        "differences": differences.collect::<Vec<_>>(),
        "divergence": repeated.divergence,
        "collision": outcome.is_collision(),
        "impact_speed_mps": outcome.impact_speed(),
        "episode_length_s": outcome.duration,
        "ticks": outcome.ticks,
        "least_gap_m": outcome.least_gap,
        "verdict": verdict.map(|verdict| verdict.label.name()),
        "fault": verdict.map(|verdict| verdict.is_fault()),
        "warning_s": verdict.map(|verdict| verdict.warning),
        "requirements": requirements,
        "digest": format!("{:016x}", outcome.digest),
        "events": events.collect::<Vec<_>>(),
        "commands": commands.collect::<Vec<_>>(),
    });
    if !needs.is_empty() {
        let actors = needs.iter().map(|need| json!({ "role": &*need.name, "needed": need.is_needed }));
        object["actors"] = actors.collect();
    }
    object
}

/// A cause as an object, for programs. Times are before the end of the failure.
fn cause_json(cause: &Cause) -> serde_json::Value {
    let turned = |turned: &Option<TurnedBy>| {
        turned.as_ref().map(|setting| {
        json!({ "key": setting.name, "unit": setting.unit, "from": setting.from, "to": setting.to, "cost": setting.cost() })
    })
    };
    json!({
        "sentence": cause.sentence(),
        "weakness": cause.weakness.name(),
        "amount": cause.amount,
        "side": cause.side,
        "enough": cause.enough.iter().map(|weakness| weakness.name()).collect::<Vec<_>>(),
        "full_braking_helps_s": cause.last[0],
        "comfortable_braking_helps_s": cause.last[1],
        "swerving_helps_s": cause.last[2],
        "in_sight_s": cause.seen,
        "reacts_s": cause.reacted,
        "brakes_s": cause.braked,
        "setting": turned(&cause.setting),
        "world": turned(&cause.world),
        "without": cause.without,
        "perfected": cause.faculties.iter().map(|(what, turns)| json!({ "what": what, "turns": turns })).collect::<Vec<_>>(),
        "tried": cause.tried.iter().map(|(what, turns)| json!({ "change": what, "turns": turns })).collect::<Vec<_>>(),
        "runs": cause.runs,
        "limit_reached": cause.is_cut && cause.fault.is_none(),
        "no_answer": cause.fault.map(|fault| fault.to_string()),
    })
}
