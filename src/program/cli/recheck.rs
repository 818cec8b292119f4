use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::compare::{Form, refused, told};
use super::console;
use super::episode::RepeatOptions;
use super::exit_code::ExitCode;
use super::failure;
use super::input::session;
use crate::session::{DriverPair, RecheckOptions as Wanted};
use results::report::{self, Encounter, Gate, GateError, Met, Recheck};

/// The number of encounters in each list for people.
const SHOWN: usize = 10;

/// Shown after the help.
pub const EXAMPLES: &str = "\
Examples:
  falsify recheck reports/my new.scn         the drivers of new.scn in the failures of a report, and in a fixed list
  falsify recheck reports/my --driver v1=v2  another driver of the same report
  falsify recheck reports/my --set 'v1.margin=1 m' --driver v1
                                             a driver of the report with another key
  falsify recheck reports/my --allow-external
                                             a program that was edited since the report was made
  falsify recheck reports/my new.scn --fail-if 'still_faults > 0' --fail-if 'faults_new > 0'
                                             block what is not fixed, and what is new

Exit codes: 0 done   2 no report, or no such driver   3 errors in a scenario   5 a driver failed as a program
  7 a --fail-if condition is true";

/// Options of `falsify recheck`.
#[derive(Debug, Args)]
pub struct RecheckOptions {
    /// The old report.
    #[arg(value_name = "REPORT")]
    pub report: PathBuf,
    /// Scenario files whose campaigns have the new drivers and their cars; those of the report without any. Starts and pedestrians stay
    /// those of the report.
    #[arg(value_name = "FILE")]
    pub new: Vec<PathBuf>,
    /// A driver of the report and its new version, or one name for both; may be given several times. All drivers of equal names without it.
    #[arg(long, value_name = "OLD=NEW", value_parser = str::parse::<DriverPair>)]
    pub driver: Vec<DriverPair>,
    /// Give a parameter or a key of the new drivers another value, as `v1.margin=1 m`.
    #[arg(long, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
    /// The number of starts in each town from which both drivers meet 120 crossings; 0 leaves these out.
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=100_000))]
    pub starts: u32,
    /// Form of the output; `json` is one object.
    #[arg(long, value_enum, default_value_t = Form::Text, value_name = "FORMAT")]
    pub format: Form,
    /// Fail (exit code 7) when this is true of failures that were met again, as 'still_faults > 0', or of the fixed list in a town, as
    /// 'faults_new > 0'; may be given several times.
    #[arg(long, value_name = "CONDITION")]
    pub fail_if: Vec<String>,
    /// Options of the repetition of the report.
    #[command(flatten)]
    pub repeat: RepeatOptions,
}

/// `falsify recheck`
pub fn recheck(options: &RecheckOptions) -> ExitCode {
    let gates = match options.fail_if.iter().map(|text| parse(text)).collect::<Result<Vec<Condition>, _>>() {
        Ok(gates) => gates,
        Err(error) => return refused(&error, "recheck"),
    };
    let wanted = Wanted {
        report: options.report.clone(),
        files: options.new.clone(),
        settings: options.set.clone(),
        drivers: options.driver.clone(),
        starts: options.starts,
        repeat: options.repeat.repeat(),
    };
    let recheck = match session(options.repeat.allow_external).recheck(&wanted) {
        Ok(recheck) => recheck,
        Err(error) => return failure::failed(&error),
    };
    match options.format {
        Form::Text => console::say(report::recheck_for_terminal(&recheck, SHOWN, console::width()).trim_end()),
        Form::Json => console::say(&as_json(&recheck).to_string()),
    }
    match (judge(&gates, &recheck), recheck.errors()) {
        (ExitCode::Done, errors) if errors > 0 => {
            console::fail(&format!(
                "a driver or a controller failed as a program in {}; `falsify check -- DRIVER` tries a driver",
                console::count(errors as usize, "encounter")
            ));
            ExitCode::RunFailed
        }
        (code, _) => code,
    }
}

/// A condition on a recheck.
#[derive(Debug)]
struct Condition {
    gate: Gate,
    /// Whether it is about the fixed list instead of the failures of the report.
    crossings: bool,
}

fn parse(text: &str) -> Result<Condition, GateError> {
    match Gate::of_table(text, &report::rechecked_reference()) {
        Ok(gate) => Ok(Condition { gate, crossings: false }),
        Err(error) => match Gate::of_table(text, &report::crossed_reference()) {
            Ok(gate) => Ok(Condition { gate, crossings: true }),
            Err(_) => Err(error),
        },
    }
}

/// Judges a recheck and reports which conditions are true; returns the exit code.
fn judge(conditions: &[Condition], recheck: &Recheck) -> ExitCode {
    let mut code = ExitCode::Done;
    let failures: Vec<String> = recheck.failures.iter().map(report::rechecked_title).collect();
    let crossings: Vec<String> = recheck.crossings.iter().map(report::crossed_title).collect();
    for Condition { gate, crossings: about_crossings } in conditions {
        let (table, places, things) = match about_crossings {
            true => (report::crossed_table(&recheck.crossings), &crossings, "fixed list"),
            false => (report::rechecked_table(&recheck.failures), &failures, "failures"),
        };
        // A report without failures has none that could be there still.
        if !about_crossings && places.is_empty() {
            continue;
        }
        match told(gate, &gate.judge(&table), places, things, "recheck") {
            ExitCode::Usage => return ExitCode::Usage,
            ExitCode::GateFailed => code = ExitCode::GateFailed,
            _ => {}
        }
    }
    code
}

/// Makes an object of a recheck, for programs.
fn as_json(recheck: &Recheck) -> serde_json::Value {
    let met = |met: Met| json!({ "collision": met.is_collision(), "fault": met.fault, "impact_speed_mps": met.impact_speed, "error": met.error });
    let encounter = |each: &Encounter| (each.before.map(met), met(each.after));
    let notes: Vec<String> = recheck.notes.iter().map(ToString::to_string).collect();
    let failures = recheck.failures.iter().enumerate().flat_map(|(set, row)| {
        row.encounters.iter().map(move |each| {
            let (before, after) = encounter(each);
            json!({ "set": set, "name": each.name, "start": each.start, "before": before, "after": after })
        })
    });
    // Encounters that are a fault for no driver are many and say nothing.
    let crossings = recheck.crossings.iter().enumerate().flat_map(|(set, row)| {
        let told = row
            .encounters
            .iter()
            .filter(|each| each.is_error() || each.after.fault || each.fault_before() == Some(true));
        told.map(move |each| {
            let (before, after) = encounter(each);
            json!({ "set": set, "start": each.start, "crossing": each.crossing, "before": before, "after": after })
        })
    });
    json!({
        "report": recheck.report.display().to_string(),
        "files": recheck.files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>(),
        "notes": notes,
        "failures": report::json_rows(&report::rechecked_table(&recheck.failures)),
        "crossings": report::json_rows(&report::crossed_table(&recheck.crossings)),
        "failure_encounters": failures.collect::<Vec<_>>(),
        "crossing_encounters": crossings.collect::<Vec<_>>(),
    })
}
