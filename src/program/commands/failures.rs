use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::episode::RepeatArgs;
use super::run::quoted;
use crate::cli::console;
use crate::cli::failure::failed;
use crate::cli::input::session;
use crate::exit_code::{Ended, ExitCode};
use crate::session::{Causes, EpisodeName, Error, Notice, Session};
use results::failure::Failure;
use results::report::{self, ListedFailure, StoredReport};
use verdict::Label;
use verdict::cause::{MAX_RUNS, Shrunk, around};
use world::av::Weakness;

/// Number of failures that a table shows by default.
const SHOWN: usize = 20;

pub const EXAMPLES: &str = "\
Examples:
  falsify failures                           the worst failures of reports/, fault ones first
  falsify failures reports/first_look --driver behavior --verdict preventable --top 5
                                             the five worst preventable ones of a driver
  falsify failures reports/first_look --top 3 --why
                                             the three worst ones, and why they happened
  falsify failures reports/first_look --distinct
                                             each finding once, with how many failures shrink to it
  falsify failures reports/first_look --distinct --names --top 5 | falsify replay - --shrunk
                                             repeat five findings with the fewest commands
  falsify failures reports/first_look --format csv > failures.csv
                                             all of them as a table

Exit codes: 0 done, also when there is none   2 no report";

/// Options of `falsify failures`.
#[derive(Debug, Clone, Args)]
pub struct FailuresArgs {
    /// Reports, or folders of reports.
    #[arg(value_name = "REPORT")]
    pub reports: Vec<PathBuf>,
    /// A report, or a folder of reports, where none is named.
    #[arg(long, default_value = "reports", env = "FALSIFY_OUT", value_name = "DIR", conflicts_with = "reports")]
    pub report: PathBuf,
    /// Only failures with one of these verdicts: fault, foreseeable, preventable, contested, machine_preventable, unpreventable,
    /// bump, violation, no_verdict.
    #[arg(long, value_delimiter = ',', value_name = "VERDICT", value_parser = verdict)]
    pub verdict: Vec<String>,
    /// Only failures of these drivers.
    #[arg(long, value_delimiter = ',', value_name = "NAME")]
    pub driver: Vec<String>,
    /// Only failures that these pedestrians or searches found.
    #[arg(long, value_delimiter = ',', value_name = "NAME")]
    pub found_by: Vec<String>,
    /// Only failures whose kind has all of these words, as front,occluded,cruise.
    #[arg(long, value_delimiter = ',', value_name = "WORDS")]
    pub kind: Vec<String>,
    /// Only violations of these requirements of the campaign.
    #[arg(long, value_delimiter = ',', value_name = "NAME")]
    pub requirement: Vec<String>,
    /// The number of failures; a table has 20 without it, other forms have all.
    #[arg(long, value_name = "N")]
    pub top: Option<usize>,
    /// Merge failures of a driver that shrink to the same kind with the same number of commands: the first of each, with how many there are.
    #[arg(long)]
    pub distinct: bool,
    /// Say why each listed failure happened: what the driver lacks, and which setting turns it.
    #[arg(long, conflicts_with = "names")]
    pub why: bool,
    /// Maximum number of episodes for each failure, for --why and for --distinct.
    #[arg(long, default_value_t = MAX_RUNS, value_name = "N")]
    pub max_runs: u32,
    /// Options for repeating failures, which --distinct and --why need.
    #[command(flatten)]
    pub repeat: RepeatArgs,
    /// Form of the list.
    #[arg(long, value_enum, default_value_t = Form::Table, value_name = "FORMAT")]
    pub format: Form,
    /// Print one `REPORT/RUN:EPISODE` a line, for other commands.
    #[arg(long, conflicts_with = "format")]
    pub names: bool,
}

/// The form of a list of failures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Form {
    /// A table for people.
    Table,
    /// One JSON object a line.
    Json,
    /// Comma-separated values.
    Csv,
}

impl Default for FailuresArgs {
    /// All failures of `reports`, the worst first.
    fn default() -> Self {
        Self {
            reports: Vec::new(),
            report: "reports".into(),
            verdict: Vec::new(),
            driver: Vec::new(),
            found_by: Vec::new(),
            kind: Vec::new(),
            requirement: Vec::new(),
            top: None,
            distinct: false,
            why: false,
            max_runs: MAX_RUNS,
            repeat: RepeatArgs::default(),
            format: Form::Table,
            names: false,
        }
    }
}

/// The words that may be verdicts.
fn verdicts() -> impl Iterator<Item = &'static str> {
    ["fault", "foreseeable", "violation", "no_verdict"].into_iter().chain(Label::ALL.map(Label::name))
}

fn verdict(text: &str) -> Result<String, String> {
    let known: Vec<&str> = verdicts().collect();
    if known.contains(&text) { Ok(text.into()) } else { Err(format!("write one of {}", known.join(", "))) }
}

impl FailuresArgs {
    /// Whether a failure is listed. Bumps are listed only if `verdict` names them, and a violation at the touch of a collision only if
    /// `requirement` names it; else it is listed as the collision.
    fn allows(&self, failure: &Failure) -> bool {
        let among = |words: &[String], word: &str| words.is_empty() || words.iter().any(|each| each == word);
        let verdict = |word: &String| match (word.as_str(), &failure.violation) {
            ("fault", _) => failure.fault,
            ("foreseeable", _) => failure.foreseeable,
            ("violation", found) => found.is_some(),
            ("no_verdict", found) => found.as_ref().is_some_and(|found| found.preventable.is_none()),
            ("preventable", Some(found)) => found.preventable == Some(true),
            (_, Some(_)) => false,
            (label, None) => failure.verdict.is_some_and(|known| known.name() == label),
        };
        let violated = match &failure.violation {
            Some(violation) if self.requirement.is_empty() => !violation.at_collision,
            Some(violation) => self.requirement.contains(&violation.requirement),
            None => self.requirement.is_empty(),
        };
        let kind = failure.kind();
        let has = |word: &String| kind.split(", ").any(|part| part == word.replace('_', " "));
        (self.verdict.is_empty() && !failure.is_bump() || self.verdict.iter().any(verdict))
            && among(&self.driver, &failure.key.cell.policy)
            && among(&self.found_by, &failure.key.cell.controller)
            && self.kind.iter().all(has)
            && violated
    }
}

/// A failure, and the report that has it.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundFailure {
    /// The folder of the report.
    pub report: PathBuf,
    pub failure: Failure,
    /// Whether its driver sees no pedestrians.
    pub is_of_baseline: bool,
    /// The number of failures that shrink to it, itself included; 1 if they are not merged.
    pub merged: usize,
}

/// The words that reports have for a filter.
#[derive(Debug, Default)]
struct KnownWords {
    drivers: BTreeSet<String>,
    finders: BTreeSet<String>,
    kinds: BTreeSet<String>,
    requirements: BTreeSet<String>,
}

impl KnownWords {
    /// Adds those of a report with these failures.
    fn add(&mut self, report: &StoredReport, failures: &[Failure]) -> Result<(), Error> {
        for run in report.run_rows()? {
            self.drivers.insert(run.key.cell.policy);
            self.finders.insert(run.key.cell.controller);
        }
        for search in report.searches()? {
            self.drivers.insert(search.policy);
            self.finders.insert(search.falsifier);
        }
        self.requirements.extend(report.requirements()?);
        for failure in failures {
            self.kinds.extend(failure.kind().split(", ").map(|word| word.replace(' ', "_")));
        }
        Ok(())
    }

    /// Checks that the words of the options are known.
    ///
    /// # Errors
    /// The first word that no report has.
    fn check(&self, options: &FailuresArgs) -> Result<(), Error> {
        let parts = [
            ("driver", &options.driver, &self.drivers),
            ("pedestrian or search", &options.found_by, &self.finders),
            ("word of a kind", &options.kind, &self.kinds),
            ("requirement", &options.requirement, &self.requirements),
        ];
        // Without any failure there is no word of a kind.
        for (what, words, known) in
            parts.into_iter().filter(|(what, _, known)| !known.is_empty() || *what == "requirement")
        {
            if let Some(word) = words.iter().find(|word| !known.contains(&word.replace(' ', "_"))) {
                let known: Vec<&str> = known.iter().map(String::as_str).collect();
                let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
                return Err(Error::Usage(format!("no report has a {what} `{word}`; known are: {known}")));
            }
        }
        Ok(())
    }
}

impl Session {
    /// Lists the failures of reports, of evaluations and searches alike; those of drivers that see no pedestrians come last.
    ///
    /// # Errors
    /// No report is there, a table is damaged, or the options name a driver, a pedestrian or a kind that no report has.
    pub fn failures(&self, options: &FailuresArgs) -> Result<Vec<FoundFailure>, Error> {
        let mut found: Vec<FoundFailure> = Vec::new();
        let mut known = KnownWords::default();
        let one = std::slice::from_ref(&options.report);
        for folder in if options.reports.is_empty() { one } else { &options.reports } {
            for report in self.open_whole(folder)? {
                report.check_tables()?;
                let failures = report.failures()?;
                known.add(&report, &failures)?;
                let listed = failures.into_iter().filter(|failure| options.allows(failure));
                let baselines = &report.manifest().baselines;
                found.extend(listed.map(|failure| FoundFailure {
                    report: report.folder().to_path_buf(),
                    is_of_baseline: baselines.contains(&failure.key.cell.policy),
                    failure,
                    merged: 1,
                }));
            }
        }
        if found.is_empty() {
            known.check(options)?;
        }
        found.sort_by(|a, b| a.is_of_baseline.cmp(&b.is_of_baseline).then_with(|| a.failure.counts_more(&b.failure)));
        if options.distinct { self.merged(found, options) } else { Ok(found) }
    }

    /// Finds the causes of failures of a list; a failure that cannot be repeated has none.
    fn explain(&self, listed: &mut [ListedFailure], options: &FailuresArgs) -> Result<(), Error> {
        let name = |each: &ListedFailure| Ok((each.report.clone(), EpisodeName::of_table(each.failure.name())?));
        let names: Vec<_> = listed.iter().map(name).collect::<Result<_, Error>>()?;
        let causes = Causes::new(self, names.len(), options.max_runs);
        let causes = self.each_repeated(&names, &options.repeat.repeat, |repeated| {
            let around = repeated.incident.as_ref().and_then(around);
            Ok(causes.of(&repeated).map(|cause| (cause, around)))
        })?;
        for (each, cause) in listed.iter_mut().zip(causes) {
            let (cause, around) = cause.ok().flatten().unzip();
            (each.cause, each.around) = (cause, around.flatten());
        }
        Ok(())
    }

    /// The first of failures that shrink to the same, with how many there are. One that cannot be repeated is not merged.
    fn merged(&self, found: Vec<FoundFailure>, options: &FailuresArgs) -> Result<Vec<FoundFailure>, Error> {
        let name = |each: &FoundFailure| Ok((each.report.clone(), EpisodeName::of_table(each.failure.name())?));
        let names: Vec<_> = found.iter().map(name).collect::<Result<_, Error>>()?;
        let shrunk = self.shrink(&names, &options.repeat.repeat, options.max_runs)?;
        let unrepeated = shrunk.iter().filter(|shrunk| shrunk.is_err()).count();
        let class = |each: &FoundFailure, shrunk: Result<Shrunk, Error>| {
            Some((each.report.clone(), each.failure.key.cell.policy.clone(), shrunk.ok()?.class()))
        };
        let classed = found.into_iter().zip(shrunk).map(|(each, shrunk)| {
            let class = class(&each, shrunk);
            (each, class)
        });
        let firsts = report::first_of_each(classed).into_iter();
        let merged = firsts.map(|(first, merged)| FoundFailure { merged, ..first }).collect();
        if unrepeated > 0 {
            self.notice(&Notice::Warning(format!(
                "{unrepeated} failures could not be repeated, so they are not merged"
            )));
        }
        Ok(merged)
    }
}

pub fn failures(options: &FailuresArgs) -> Ended {
    let session = session(options.repeat.allow_external);
    let found = session.failures(options).map_err(failed)?;
    let is_table = options.format == Form::Table && !options.names;
    let shown = options.top.unwrap_or(if is_table { SHOWN } else { usize::MAX });
    let all = found.len();
    let mut listed: Vec<ListedFailure> = found
        .into_iter()
        .take(shown)
        .map(|FoundFailure { report, failure, merged, .. }| ListedFailure {
            report,
            failure,
            merged: options.distinct.then_some(merged as u64),
            cause: None,
            around: None,
        })
        .collect();
    if options.why {
        session.explain(&mut listed, options).map_err(failed)?;
    }
    match options.format {
        _ if options.names => {
            listed.iter().for_each(|each| console::say(&each.report.join(each.failure.name()).display().to_string()));
        }
        Form::Table => tell(&listed, all),
        Form::Json => console::say_objects(&report::json_rows(&report::failure_list(&listed))),
        Form::Csv => console::say(report::csv_text(&report::failure_list(&listed)).trim_end()),
    }
    Ok(ExitCode::Done)
}

/// Prints a table for people, how much it leaves out, and how to see the first failure again.
fn tell(listed: &[ListedFailure], all: usize) {
    let Some(ListedFailure { report: folder, failure: first, merged, .. }) = listed.first() else {
        return console::say("no failure");
    };
    console::say(report::failures_for_terminal(listed, console::width()).trim_end());
    for ListedFailure { failure, cause, around, .. } in listed {
        let Some(cause) = cause else { continue };
        let around = around.as_ref().map(|around| format!(" {}", around.sentence())).unwrap_or_default();
        let trials = if cause.weakness == Weakness::NotFound { format!(" {}", cause.trials()) } else { String::new() };
        let text = format!("{}  {}{around}{trials}", failure.name(), cause.sentence());
        console::say("");
        console::say(console::wrapped(&text).trim_end());
    }
    if listed.iter().filter_map(|each| each.cause.as_ref()).any(|cause| cause.is_cut && cause.fault.is_none()) {
        console::say("`--max-runs` raises the limit of runs.");
    }
    if listed.len() < all {
        console::say(&format!("{} of {all} failures; --top N shows more", listed.len()));
    }
    if merged.is_some() {
        console::say("Each is as it was found; `falsify replay NAME --shrunk` shows what it shrinks to.");
    }
    let options = report::StoredReport::open(folder).map_or("", |report| report.manifest().call.replay_options());
    console::say(&format!("falsify replay {options}{}", quoted(&folder.join(first.name()).display().to_string())));
}
