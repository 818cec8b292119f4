mod picture;
mod section;
mod table;

use super::{Kind, Measurement};
use crate::campaign::{Part, TaskError};
use crate::report::Group;
use base::seed::Seed;
use compile::Estimation;
use search::likelihood;
use search::likelihood::{Encounters, Estimate, Likelihood, Limits};

pub(super) const KIND: Kind = Kind {
    doing: ["estimating", "estimated"],
    answer: section::answer,
    references: || vec![table::columns().reference()],
    tables: |found| {
        let rows: Vec<Row<'_>> = found
            .finished
            .found_if_any()?
            .into_iter()
            .flat_map(|(job, estimate): (&Estimation, &Estimate)| {
                estimate.likelihoods.iter().map(move |likelihood| Row { job, estimate, likelihood })
            })
            .collect();
        Some(vec![("estimates", table::columns().frame(&rows))])
    },
    section: Some((Group::Rates, section::estimates)),
    ..Kind::new::<Estimation>("estimate", "estimates", "estimate")
};

/// How likely an event is, as a row of the table.
struct Row<'a> {
    job: &'a Estimation,
    estimate: &'a Estimate,
    likelihood: &'a Likelihood,
}

impl Measurement for Estimation {
    type Found = Estimate;

    const KIND: &'static Kind = &KIND;

    fn budget(&self) -> u64 {
        self.budget
    }

    fn units_of(&self, found: Option<&Estimate>) -> u64 {
        found.map_or(0, |estimate| estimate.ticks)
    }

    fn note(&self, found: &Estimate) -> String {
        format!("{} encounters", found.encounters)
    }

    fn measure(&self, part: &Part<'_>) -> (Option<Estimate>, Option<TaskError>) {
        let limits = Limits {
            event: self.event,
            relative_error: self.relative_error,
            budget: self.budget,
            stop: &|| part.is_late(),
            progress: &|ticks| part.progress(ticks),
        };
        let make = || {
            let mut encounters = Encounters::new(&self.scenario, self.walker.walk_policy(), self.criterion);
            move |number: u64, seed: &Seed| encounters.run(number, seed)
        };
        let estimate = likelihood::estimate(&make, &self.drawn(part.seed), limits);
        if let Some(limit) = part.own_limit() {
            return (None, Some(limit));
        }
        match estimate {
            Estimate { stopped: true, .. } => (None, None),
            Estimate { counted: 0, .. } => (None, Some(TaskError::NoEncounter)),
            estimate => (Some(estimate), None),
        }
    }
}
