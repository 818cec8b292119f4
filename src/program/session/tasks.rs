//! Runs tasks of a campaign while others listen: the observer of the session, and the files of growing learning curves.

use std::any::Any;
use std::sync::Arc;

use super::growing_curves::GrowingCurves;
use super::run::CampaignRun;
use super::{Event, Observer, Stop};
use base::seed::Seed;
use compile::{Campaign, Training};
use learn::UpdateLog;
use results::campaign::{self, Finished, Task};
use results::jobs::TrainingResult;
use results::store::CampaignStore;

impl CampaignRun<'_> {
    /// Runs tasks of the campaign until they are finished or the stop flag is raised.
    pub fn run_tasks(&self, tasks: &[Task], results: &CampaignStore<'_>) -> Finished {
        let Self { session, options, campaign, store, name, .. } = self;
        let listener = Listener {
            campaign,
            observer: session.observer.clone(),
            curves: GrowingCurves::new(store.learning(name), session.observer.clone()),
            stop: session.stop.clone(),
        };
        session.tell(Event::TasksBegun(campaign, tasks));
        let finished = campaign::run_tasks(campaign, tasks, &Seed::root(options.seed), results, &listener);
        session.tell(Event::TasksEnded);
        finished
    }
}

/// Passes all events to the observer and to the growing learning curves, and stops when the flag is raised.
struct Listener<'a> {
    campaign: &'a Campaign,
    observer: Arc<dyn Observer>,
    curves: GrowingCurves,
    stop: Arc<Stop>,
}

impl Listener<'_> {
    /// A candidate of a training begins with this learning curve.
    fn begin_curve(&self, task: Task, curve: &[UpdateLog]) {
        let plan = self.training(task);
        if let Some(folder) = self.curves.first_of(plan, curve) {
            self.observer.event(&Event::CurvesGrow(folder));
        }
        self.curves.restart(plan, task.part, curve);
    }

    fn training(&self, task: Task) -> &Training {
        self.campaign.jobs[task.job].of().expect("only trainings have curves")
    }
}

impl campaign::Observer for Listener<'_> {
    fn event(&self, event: &campaign::Event<'_>) {
        match *event {
            campaign::Event::Curve { task, curve, has_grown: true } => {
                self.curves.grow(self.training(task), task.part, curve);
            }
            campaign::Event::Curve { task, curve, has_grown: false } => self.begin_curve(task, curve),
            campaign::Event::Reused { task, result } => {
                if let Some(TrainingResult { result: Ok(trained), .. }) = (result as &dyn Any).downcast_ref() {
                    self.begin_curve(task, &trained.learning_curve);
                }
            }
            _ => {}
        }
        self.observer.event(&Event::Campaign(event));
    }

    fn stop(&self) -> bool {
        self.stop.is_asked()
    }
}
