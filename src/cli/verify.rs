use std::path::PathBuf;

use clap::Args;

use super::episode::RepeatOptions;
use super::exit_code::ExitCode;
use super::input::session;
use super::{console, failure};
use crate::session::{self, Repeated, reasons};

/// The most differences that are shown.
const SHOWN: usize = 10;

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify verify reports/first_look          repeat 100 episodes, compare every column byte for byte
  falsify verify --all reports/first_look    all of them
  falsify verify --trainings reports/first_look
                                             also train every pedestrian again

Exit codes: 0 all are equal   2 no report   3 errors in a scenario   8 something differs";

/// Options of `falsify verify`.
#[derive(Debug, Args)]
pub struct VerifyOptions {
    /// A report.
    #[arg(value_name = "DIR")]
    pub report: PathBuf,
    /// Number of episodes and failures of searches to repeat.
    #[arg(long, default_value_t = 100, value_name = "N")]
    pub sample: usize,
    /// Repeat all of them.
    #[arg(long, conflicts_with = "sample")]
    pub all: bool,
    /// Train every pedestrian again, too, and compare its networks.
    #[arg(long)]
    pub trainings: bool,
    /// Seed of the sample.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Options of the repetition.
    #[command(flatten)]
    pub repeat: RepeatOptions,
}

/// `falsify verify`
pub fn verify(options: &VerifyOptions) -> ExitCode {
    let wanted = session::VerifyOptions {
        report: options.report.clone(),
        sample: (!options.all).then_some(options.sample),
        trainings: options.trainings,
        seed: options.seed,
        repeat: options.repeat.repeat(),
    };
    let verified = match session(options.repeat.allow_external).verify(&wanted) {
        Ok(verified) => verified,
        Err(error) => return failure::failed(&error),
    };
    let (repeated, different) = (verified.repeated, &verified.different);
    show(different);
    let equal = repeated - different.len();
    for file in &verified.changed_files {
        console::fail(&format!("`{file}` is not as it was written"));
    }
    let files = verified.report.manifest().report_files.len();
    if files > 0 {
        console::say(&format!("files of the report: {files}, {} changed", verified.changed_files.len()));
    } else {
        console::warn("the report is of an earlier version and has no digests of its own files");
    }
    console::say(&format!("episodes and failures of searches: {repeated} repeated, {equal} equal"));
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
    reasons(verified.report.manifest()).iter().for_each(|reason| console::say(&format!("possible reason: {reason}")));
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
