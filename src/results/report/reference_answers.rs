//! What published drivers do in an encounter: one table, for a terminal, for a page and for machines.

use serde_json::json;

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

    /// How many of the published drivers avoid it.
    pub fn count(&self) -> String {
        let published: Vec<&Answer> = self.answers.iter().filter(|answer| answer.driver.is_published).collect();
        let avoid = published.iter().filter(|answer| answer.trial.is_avoided()).count();
        format!("{avoid} of {} published drivers avoid it", published.len())
    }

    /// A row for each driver; times count from the first instant.
    pub(crate) fn table(&self) -> Table {
        let at = |before: Option<f64>| Value::number(before.map(|before| (self.touch - before).max(0.0)), 2);
        Selection::new()
            .column(Column::text("driver"), |answer: &Answer| Value::code(answer.driver.name))
            .text("source", |answer| Value::text(answer.driver.source))
            .text("trigger", |answer| Value::text(answer.driver.trigger))
            .number("at (s)", move |answer| at(answer.trigger))
            .number("TTC (s)", |answer| Value::number(answer.ttc.filter(|ttc| ttc.is_finite()), 2))
            .number("brakes (s)", move |answer| at(answer.brake))
            .text("ends", |answer| {
                Value::text(match answer.trial.impact_speed {
                    None => format!("avoids, {:.2} m", answer.trial.least_gap),
                    Some(speed) => format!("hits, {speed:.1} m/s"),
                })
            })
            .table(self.answers)
    }

    /// An object for each driver; what does not apply is null.
    pub fn to_json(&self) -> Vec<serde_json::Value> {
        let at = |before: Option<f64>| before.map(|before| (self.touch - before).max(0.0));
        let object = |answer: &Answer| {
            json!({
                "driver": answer.driver.name,
                "source": answer.driver.source,
                "published": answer.driver.is_published,
                "trigger": answer.driver.trigger,
                "trigger_s": at(answer.trigger),
                "ttc_at_trigger_s": answer.ttc.filter(|ttc| ttc.is_finite()),
                "brake_s": at(answer.brake),
                "avoids": answer.trial.is_avoided(),
                "impact_mps": answer.trial.impact_speed,
                "spare_m": answer.trial.is_avoided().then_some(answer.trial.least_gap),
            })
        };
        self.answers.iter().map(object).collect()
    }
}
