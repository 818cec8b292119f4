//! Conditions of `--fail-if` on the rows of tables.

use crate::cli::console;
use crate::cli::failure::misused;
use crate::exit_code::ExitCode;
use results::record::TableReference;
use results::report::{Gate, GateError, Judged};

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

    /// Lets rows pass that it cannot judge.
    pub fn allowing_unjudged(self, allow: bool) -> Self {
        Self { gate: self.gate.allowing_unjudged(allow), ..self }
    }

    /// Reads the conditions on a `whole`, which may let rows pass that they cannot judge.
    ///
    /// # Errors
    /// The exit code, after the reason has been printed.
    pub fn parse_all(
        texts: &[String],
        tables: &[TableReference; 2],
        whole: &str,
        allow_unjudged: bool,
    ) -> Result<Vec<Self>, ExitCode> {
        let refused = |error: GateError| match &error {
            GateError::Column { name, nearest, .. } => {
                let near = nearest.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?"));
                misused(format!(
                    "--fail-if: a {whole} has no column `{name}`{near} (`--format json` shows all of them)"
                ))
            }
            other => misused(format!("--fail-if: {other}")),
        };
        let parse = |text| Self::parse(text, tables).map(|condition| condition.allowing_unjudged(allow_unjudged));
        texts.iter().map(|text| parse(text).map_err(refused)).collect()
    }
}

/// Judges the two tables of a `whole`, reports which conditions are true, and returns the titles of the rows of which one is.
///
/// # Errors
/// The exit code, after the reason has been printed: a condition speaks of no row.
pub fn judge(
    conditions: &[Condition],
    [first, second]: [Subject<'_>; 2],
    whole: &str,
) -> Result<Vec<String>, ExitCode> {
    let mut failed = Vec::new();
    for Condition { gate, second: is_second } in conditions {
        let subject = if *is_second { &second } else { &first };
        if subject.is_idle {
            console::note(&format!("--fail-if {}: says nothing, there are no {}", gate.text(), subject.things));
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
        tell(gate, &judged, &subject.titles);
        let rows = subject.titles.iter().zip(&judged).filter(|(_, judged)| judged.fails());
        failed.extend(rows.map(|(title, _)| title.clone()));
    }
    Ok(failed)
}

/// Reports the rows of which a gate is true, or which it cannot judge, or that it passes.
pub fn tell(gate: &Gate, judged: &[Judged], titles: &[String]) {
    for (title, judged) in titles.iter().zip(judged) {
        if let Some(reason) = judged.reason(&format!(" in {title}")) {
            let tell = if judged.fails() { console::fail } else { console::warn };
            let mark = if judged.fails() { "\u{2717} " } else { "" };
            tell(&format!("{mark}--fail-if {}: {reason}", gate.text()));
        }
    }
    let fails = judged.iter().any(Judged::fails);
    let rows = judged.iter().filter(|judged| **judged != Judged::Elsewhere).count();
    let passed = judged
        .iter()
        .filter(|judged| matches!(judged, Judged::Passed(_) | Judged::Thin(_) | Judged::ThinPrice(_)))
        .count();
    let others = if rows > passed { format!(", and {} not judged", rows - passed) } else { String::new() };
    match passed {
        _ if fails || rows == 0 => {}
        0 => console::warn(&format!("--fail-if {}: says nothing, no row has a value", gate.text())),
        _ => {
            let nearest = gate.nearest(judged);
            let nearest = nearest.map(|(row, values)| format!("; nearest: {values} in {}", titles[row]));
            console::note(&format!(
                "\u{2713} --fail-if {}: passes, false in {}{others}{}",
                gate.text(),
                console::count(passed, "row"),
                nearest.unwrap_or_default()
            ));
        }
    }
}
