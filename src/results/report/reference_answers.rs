//! What published drivers do in an encounter: one table, for a terminal, for a page and for machines.

use super::render::{Column, Selection, Table, Value};
use verdict::Answer;

/// The drivers of an encounter whose touch is at this time (s).
#[derive(Debug, Clone, Copy)]
pub struct ReferenceAnswers<'a> {
    pub answers: &'a [Answer],
    pub touch: f64,
}

impl ReferenceAnswers<'_> {
    /// The table as text for a terminal of this width (columns), and the count of those who avoid it.
    pub fn to_terminal(&self, width: u16) -> String {
        format!("{}{}\n", self.table().to_terminal(width), self.count())
    }

    /// The drivers who vote and avoid it, and all who vote.
    pub fn votes(&self) -> (usize, usize) {
        let voting = || self.answers.iter().filter(|answer| answer.driver.votes);
        (voting().filter(|answer| answer.trial.is_avoided()).count(), voting().count())
    }

    /// How many of the published drivers avoid it, of those who vote.
    pub fn count(&self) -> String {
        let (avoid, all) = self.votes();
        format!("{avoid} of {all} published drivers avoid it (those without a vote are not counted)")
    }

    /// A row for each driver; times count from the first instant.
    pub(crate) fn table(&self) -> Table {
        let at = |before: Option<f64>| Value::number(Answer::time(before, self.touch), 2);
        Selection::new()
            .column(Column::text("driver"), |answer: &Answer| Value::code(answer.driver.name))
            .text("source", |answer| Value::text(answer.driver.source))
            .text("trigger", |answer| Value::text(answer.driver.trigger))
            .number("at (s)", move |answer| at(answer.trigger))
            .number("TTC (s)", |answer| Value::number(answer.ttc.filter(|ttc| ttc.is_finite()), 2))
            .number("brakes (s)", move |answer| at(answer.brake))
            .number("hits (m/s)", |answer| Value::number(answer.trial.impact_speed, 1))
            .number("spare (m)", |answer| Value::number(answer.trial.is_avoided().then_some(answer.trial.least_gap), 2))
            .text("votes", |answer| Value::text(if answer.driver.votes { "yes" } else { "no" }))
            .table(self.answers)
    }

    /// An object for each driver; what does not apply is null.
    pub fn to_json(&self) -> Vec<serde_json::Value> {
        self.answers.iter().map(|answer| answer.to_json(self.touch)).collect()
    }
}
