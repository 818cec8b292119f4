use polars::prelude::{DataFrame, PolarsResult};

use crate::campaign::Task;
use crate::record::{Chunk, Chunks, RunKey, with_degrees};
use compile::{Campaign, Evaluation, Job, Planned};

/// All episodes of a campaign, run by run, so that only one run needs to be in memory.
#[derive(Clone, Copy)]
pub struct Episodes<'a> {
    campaign: &'a Campaign,
    chunks: &'a dyn Chunks,
}

impl<'a> Episodes<'a> {
    /// The episodes of a campaign that are stored in this store.
    pub fn new(campaign: &'a Campaign, chunks: &'a dyn Chunks) -> Self {
        Self { campaign, chunks }
    }

    /// The runs, in the plan's order: each one controller of one training in one town against one policy.
    pub fn runs(&self) -> impl Iterator<Item = Run<'a>> {
        let chunks = self.chunks;
        let run = move |(job, planned): (usize, &'a Job)| {
            let evaluation = planned.of()?;
            Some(Run { job, evaluation, key: RunKey::of(evaluation), chunks })
        };
        self.campaign.jobs.iter().enumerate().filter_map(run)
    }
}

/// The episodes of an evaluation.
#[derive(Clone)]
pub struct Run<'a> {
    /// Its place in the plan.
    pub job: usize,
    pub evaluation: &'a Evaluation,
    /// The key of its rows.
    pub key: RunKey,
    chunks: &'a dyn Chunks,
}

impl Run<'_> {
    /// Its episodes as a table, with their degrees in a campaign with requirements, at most [`CHUNK`](compile::CHUNK) rows at a time. Episodes that could not be run are in error.
    ///
    /// # Errors
    /// Those of polars; none for what [`encode`](crate::record::encode) wrote.
    pub fn parts(&self) -> impl Iterator<Item = PolarsResult<DataFrame>> {
        (0..self.evaluation.parts()).filter_map(|number| {
            let chunk = self.chunks.chunk(Task { job: self.job, part: number })?;
            let part = chunk.into_episodes(&self.key, self.evaluation.chunk(number));
            let completed = part.and_then(|mut part| {
                if !self.evaluation.scenario.requirements.is_empty() {
                    with_degrees(&mut part)?;
                }
                Ok(part)
            });
            completed.map(|part| (part.height() > 0).then_some(part)).transpose()
        })
    }

    /// All its episodes as a table.
    ///
    /// # Errors
    /// As [`Run::parts`].
    pub fn frame(&self) -> PolarsResult<DataFrame> {
        let mut whole = Chunk::empty().into_episodes(&self.key, 0..0)?;
        if !self.evaluation.scenario.requirements.is_empty() {
            with_degrees(&mut whole)?;
        }
        for part in self.parts() {
            whole.vstack_mut(&part?)?;
        }
        // Sums must not depend on the number of parts.
        whole.rechunk_mut();
        Ok(whole)
    }
}
