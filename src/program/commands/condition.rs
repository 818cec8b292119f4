//! Conditions of `--fail-if` on the rows of tables.

use crate::cli::console;
use crate::cli::failure::misused;
use crate::exit_code::{Ended, ExitCode};
use results::record::TableReference;
use results::report::{self, Gate, GateError, Judged};

/// A condition on the columns of one of two tables.
pub struct Condition {
    gate: Gate,
    /// Whether it is about the second table.
    second: bool,
}

/// One of two tables that conditions are about.
pub struct Subject<'a> {
    /// Judges each row.
    pub judge: &'a dyn Fn(&Gate) -> Vec<Judged>,
    /// The names of the rows.
    pub titles: Vec<String>,
    /// What its rows are.
    pub things: &'static str,
    /// Whether no condition is about it.
    pub is_idle: bool,
}

impl Condition {
    /// Reads a condition.
    ///
    /// # Errors
    /// It has another form, or names no column of either table.
    pub fn parse(text: &str, [first, second]: &[TableReference; 2]) -> Result<Self, GateError> {
        match Gate::of_table(text, first) {
            Ok(gate) => Ok(Self { gate, second: false }),
            Err(error) => Gate::of_table(text, second).map(|gate| Self { gate, second: true }).map_err(|_| error),
        }
    }

    /// Reads the conditions on a `whole`.
    ///
    /// # Errors
    /// The exit code, after the reason has been printed.
    pub fn parse_all(texts: &[String], tables: &[TableReference; 2], whole: &str) -> Result<Vec<Self>, ExitCode> {
        let refused = |error: GateError| match &error {
            GateError::Column { name, nearest, .. } => {
                let near = nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?"));
                misused(format!(
                    "--fail-if: a {whole} has no column `{name}`{near} (`--format json` shows all of them)"
                ))
            }
            other => misused(format!("--fail-if: {other}")),
        };
        texts.iter().map(|text| Self::parse(text, tables).map_err(refused)).collect()
    }
}

/// Judges the two tables of a `whole` and reports which conditions are true.
pub fn judge(conditions: &[Condition], [first, second]: [Subject<'_>; 2], whole: &str) -> Ended {
    let mut code = ExitCode::Done;
    for Condition { gate, second: is_second } in conditions {
        let subject = if *is_second { &second } else { &first };
        if subject.is_idle {
            continue;
        }
        let judged = (subject.judge)(gate);
        if judged.iter().all(|judged| *judged == Judged::Elsewhere) {
            return Err(misused(format!(
                "--fail-if {}: it speaks of no {} of the {whole}",
                gate.text(),
                subject.things
            )));
        }
        if tell(gate, &judged, &subject.titles) {
            code = ExitCode::GateFailed;
        }
    }
    Ok(code)
}

/// Reports the rows of which a gate is true, or which it cannot judge; returns whether it fails.
pub fn tell(gate: &Gate, judged: &[Judged], titles: &[String]) -> bool {
    for (title, judged) in titles.iter().zip(judged) {
        let text = gate.text();
        match judged {
            Judged::Broken(values) => {
                console::fail(&format!("--fail-if {text}: {} in {title}", report::shown(values)));
            }
            Judged::TooFewRuns(few) => console::fail(&format!("--fail-if {text}: {few}, in {title}")),
            Judged::MissingEverywhere(column) => console::fail(&format!(
                "--fail-if {text}: there is no {column} in {title}, nor in any other row, so nothing was judged"
            )),
            Judged::TooFewStarts(starts) => console::fail(&format!(
                "--fail-if {text}: {starts} common starts are too few in {title}: even a failure in each of them would not make it true; run more episodes"
            )),
            Judged::TooFewSearched(starts) => console::fail(&format!(
                "--fail-if {text}: {} in {title} cannot show a share; give the search a larger `budget`",
                console::count(*starts as usize, "start")
            )),
            Judged::NothingEvaluated => {
                console::fail(&format!("--fail-if {text}: nothing was evaluated in {title}, so nothing can be judged"));
            }
            Judged::OffRoad(share) => console::fail(&format!(
                "--fail-if {text}: the driver left the road in {:.0} % of the episodes in {title}, so that nothing failed there is no merit of it; gate on `left_road_rate`, too",
                100.0 * share
            )),
            Judged::Thin(episodes) => console::warn(&format!(
                "--fail-if {text}: {} in {title} cannot show so low a rate: a single failure would have made it true; run more episodes",
                console::count(*episodes as usize, "episode")
            )),
            Judged::Missing(column) => {
                console::warn(&format!("--fail-if {text}: there is no {column} in {title}"));
            }
            Judged::Passed | Judged::Elsewhere => {}
        }
    }
    judged.iter().any(Judged::fails)
}
