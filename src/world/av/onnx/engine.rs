use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use rten::{RunOptions, ThreadPool};

use crate::av::Fault;

/// The numbers of all worlds of a tick, and the network's answers to them.
#[derive(Default)]
pub(super) struct Batch {
    pub questions: Vec<Vec<Vec<f32>>>,
    pub answers: Vec<Result<Vec<f32>, Fault>>,
}

/// A thread on which a network runs.
///
/// The runtime has threads of its own. A caller on a thread of a campaign would start other tasks of the campaign while
/// it waits for them, and evaluations would nest in each other. This thread is therefore one of the runtime's, the only one of its
/// pool, and its caller waits. Every world is computed alone: in batches the last bits would depend on the other worlds. It starts with the first question: a check makes many drivers that never drive, and each thread reserves memory.
pub(super) struct Engine(Option<Starter>, Option<(Sender<Batch>, Receiver<Batch>)>);

type Starter = Box<dyn FnOnce() -> (Sender<Batch>, Receiver<Batch>) + Send>;

impl Engine {
    /// Makes one, whose thread ends when it is dropped. `decide` runs the network on the numbers of one world.
    pub fn new(decide: impl Fn(&[Vec<f32>], RunOptions) -> Result<Vec<f32>, Fault> + Send + 'static) -> Self {
        Self(Some(Box::new(|| start(decide))), None)
    }

    /// Answers the requests of a batch.
    pub fn answer(&mut self, batch: &mut Batch) {
        let gone = || Err(Fault::Answer("the network failed"));
        let count = batch.questions.len();
        let Self(starter, running) = self;
        *running = starter.take().map(|start| start()).or(running.take());
        let answered = running.as_ref().and_then(|(questions, answers)| {
            questions.send(std::mem::take(batch)).ok()?;
            answers.recv().ok()
        });
        match answered {
            Some(answered) => *batch = answered,
            None => batch.answers = (0..count).map(|_| gone()).collect(),
        }
    }
}

fn start(
    decide: impl Fn(&[Vec<f32>], RunOptions) -> Result<Vec<f32>, Fault> + Send + 'static,
) -> (Sender<Batch>, Receiver<Batch>) {
    let (questions, asked) = channel::<Batch>();
    let (given, answers) = channel();
    std::thread::spawn(move || {
        let pool = Arc::new(ThreadPool::with_num_threads(1));
        pool.clone().run(move || {
            for mut batch in asked {
                let options = || RunOptions::default().with_thread_pool(Some(pool.clone()));
                batch.answers.clear();
                batch.answers.extend(batch.questions.iter().map(|question| decide(question, options())));
                if given.send(batch).is_err() {
                    return;
                }
            }
        });
    });
    (questions, answers)
}
