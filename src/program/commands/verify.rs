use std::path::PathBuf;

use clap::Args;

use super::episode::{Named, RepeatArgs, resolved};
use crate::cli::console;
use crate::cli::exit_code::{Ended, ExitCode};
use crate::cli::failure::{failed, misused};
use crate::cli::input::session;
use crate::session::{self, EpisodeName, EpisodePath, Reason, Repeated, VerifyReport, reasons};

/// The most differences that are shown.
const SHOWN: usize = 10;

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify verify reports/first_look          repeat 100 episodes, compare every column byte for byte
  falsify verify --all reports/first_look    all of them
  falsify verify reports/first_look/1a2b3c4d:17
                                             one episode
  falsify verify --trainings reports/first_look
                                             also train every pedestrian again

Exit codes: 0 all are equal   2 no report   3 errors in a scenario   8 something differs";

/// Options of `falsify verify`.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// A report; or `[PATH/]RUN:EPISODE`, to repeat these episodes and no others; `-` reads names from the input, one a line.
    #[arg(value_name = "REPORT", required_unless_present = "report")]
    pub what: Vec<String>,
    /// The report; with names of episodes, the report or folder of reports of names without a path.
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
    /// What is repeated.
    #[command(flatten)]
    pub verify: session::VerifyOptions,
    /// Options of the repetition.
    #[command(flatten)]
    pub repeat: RepeatArgs,
}

/// `falsify verify`
pub fn verify(options: &VerifyArgs) -> Ended {
    let wanted = options.wanted()?;
    let session = session(options.repeat.allow_external);
    let codes = wanted.iter().map(|wanted| session.verify(wanted).map_or_else(failed, |verified| tell(&verified)));
    Ok(codes.fold(ExitCode::Done, ExitCode::or))
}

impl VerifyArgs {
    /// Options for a session, one for each report.
    fn wanted(&self) -> Result<Vec<session::VerifyOptions>, ExitCode> {
        let one = |report: PathBuf, episodes: Vec<EpisodeName>| session::VerifyOptions {
            report,
            episodes,
            repeat: self.repeat.repeat.clone(),
            ..self.verify.clone()
        };
        let named: Result<Vec<Named>, _> = self.what.iter().map(|text| text.parse()).collect();
        let Ok(named) = named else {
            let [folder] = self.what.as_slice() else {
                return Err(misused("name one report, or episodes as [PATH/]RUN:EPISODE"));
            };
            return match &self.report {
                None => Ok(vec![one(folder.into(), Vec::new())]),
                Some(_) => Err(misused("the report is named twice, as REPORT and by --report")),
            };
        };
        if named.is_empty() {
            return Ok(self.report.iter().map(|report| one(report.clone(), Vec::new())).collect());
        }
        let elsewhere = self.report.clone().unwrap_or_else(|| "reports".into());
        let mut reports: Vec<session::VerifyOptions> = Vec::new();
        for EpisodePath { report, name } in resolved(&named)? {
            let report = report.unwrap_or_else(|| elsewhere.clone());
            match reports.iter_mut().find(|known| known.report == report) {
                Some(known) => known.episodes.push(name),
                None => reports.push(one(report, vec![name])),
            }
        }
        Ok(reports)
    }
}

/// Prints the result for people; returns the exit code.
fn tell(verified: &VerifyReport) -> ExitCode {
    let VerifyReport { repeated, different, .. } = verified;
    show(different);
    let equal = repeated - different.len();
    for file in &verified.changed_files {
        console::fail(&format!("`{file}` is not as it was written"));
    }
    let files = verified.report.manifest().report_files.len();
    if files > 0 {
        console::say(&format!("files of the report: {files}, {} changed", verified.changed_files.len()));
    } else {
        console::warn("the manifest lists no files of the report: it was cut, or is of an earlier version");
    }
    console::say(&match repeated {
        0 => "episodes and failures of searches: there are none to repeat".to_string(),
        _ => format!("episodes and failures of searches: {repeated} repeated, {equal} equal"),
    });
    if let Some(trainings) = &verified.trainings {
        for key in &trainings.different {
            console::fail(&format!("the training of {key} differs from the report"));
        }
        let equal = trainings.repeated - trainings.different.len();
        console::say(&format!("trainings: {} repeated, {equal} equal", trainings.repeated));
    }
    if verified.is_equal() {
        return ExitCode::Done;
    }
    // If only files differ, the program and the processor have nothing to do with it.
    let only_files = different.is_empty() && verified.trainings.as_ref().is_none_or(|again| again.different.is_empty());
    let all = reasons(&verified.report, &verified.programs, &verified.changed_files);
    let told = all.iter().filter(|reason| !only_files || matches!(reason, Reason::Edited { .. }));
    told.for_each(|reason| console::say(&format!("possible reason: {reason}")));
    ExitCode::Differs
}

fn show(different: &[Repeated]) {
    for repeated in different.iter().take(SHOWN) {
        let columns: Vec<&str> = repeated.differences.iter().map(|difference| difference.column.as_str()).collect();
        let divergence =
            repeated.divergence.as_ref().map_or(String::new(), |divergence| format!("; it diverges {divergence}"));
        console::fail(&format!("{} differs from the report: {}{divergence}", repeated.name, columns.join(", ")));
    }
    if different.len() > SHOWN {
        console::fail(&format!("… and {} more", different.len() - SHOWN));
    }
}
