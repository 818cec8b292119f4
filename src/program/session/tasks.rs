//! Runs tasks of a campaign while others listen: the observer of the session, and the files of growing learning curves.

use std::path::Path;
use std::sync::Arc;

use super::event_files::EventFiles;
use super::growing_curves::GrowingCurves;
use super::{Event, Observer, RunOptions, Session, Stop};
use base::seed::Seed;
use compile::Campaign;
use results::campaign::{self, Finished, Task};
use results::store::{CampaignStore, Store};

impl Session {
    /// Runs tasks of a campaign until they are finished or the stop flag is raised.
    pub(super) fn run_tasks(
        &self,
        campaign: &Campaign,
        tasks: &[Task],
        options: &RunOptions,
        store: &Store,
        results: &CampaignStore<'_>,
    ) -> Finished {
        let name = options.report_name(campaign);
        let event_files = |folder: &Path| EventFiles::new(folder.join(&name), self.observer.clone());
        let listener = Listener {
            observer: self.observer.clone(),
            curves: GrowingCurves::new(store.learning(&name), self.observer.clone()),
            event_files: options.tensorboard.as_deref().map(event_files),
            stop: self.stop.clone(),
        };
        self.tell(Event::TasksBegun(campaign, tasks));
        let finished = campaign::run_tasks(campaign, tasks, &Seed::root(options.seed), results, &listener);
        self.tell(Event::TasksEnded);
        finished
    }
}

/// Passes all events to the observer and to the growing learning curves, and stops when the flag is raised.
struct Listener {
    observer: Arc<dyn Observer>,
    curves: GrowingCurves,
    event_files: Option<EventFiles>,
    stop: Arc<Stop>,
}

impl campaign::Observer for Listener {
    fn event(&self, event: &campaign::Event<'_>) {
        match *event {
            campaign::Event::CurveBefore { plan, curve, .. } => {
                if let Some(folder) = self.curves.first_of(plan, curve) {
                    self.observer.event(&Event::CurvesGrow(folder));
                }
                self.curves.restart(plan, curve);
                self.event_files.iter().for_each(|files| files.restart(plan, curve));
            }
            campaign::Event::Updated { plan, curve, .. } => {
                self.curves.grow(plan, curve);
                self.event_files.iter().for_each(|files| files.grow(plan, curve));
            }
            _ => {}
        }
        self.observer.event(&Event::Campaign(event));
    }

    fn stop(&self) -> bool {
        self.stop.is_asked()
    }
}
