use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::Task;

/// Time that a worker without work waits before it looks for a worker to help.
const WAIT: Duration = Duration::from_millis(2);
/// Number of these waits after which the queue again offers tasks that another process had.
const ROUNDS: u32 = 20;

/// The tasks that are ready, shared by several workers.
pub(super) struct Queue {
    tasks: Mutex<Tasks>,
    changed: Condvar,
}

struct Tasks {
    ready: VecDeque<Task>,
    /// Tasks that another process works on.
    elsewhere: Vec<Task>,
    /// The number of tasks that have not ended, including those that wait for others.
    left: usize,
    rounds: u32,
    ended: bool,
}

/// The instruction to a worker.
pub(super) enum Next {
    Work(Task),
    /// No task is ready now.
    Wait,
    End,
}

impl Queue {
    /// Starts with the tasks that are ready. `later` is the number of tasks that become ready later.
    pub fn new(ready: VecDeque<Task>, later: usize) -> Self {
        let left = ready.len() + later;
        let tasks = Tasks { ready, elsewhere: Vec::new(), left, rounds: 0, ended: false };
        Self { tasks: Mutex::new(tasks), changed: Condvar::new() }
    }

    fn tasks(&self) -> MutexGuard<'_, Tasks> {
        self.tasks.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the next task.
    pub fn next(&self) -> Next {
        let mut tasks = self.tasks();
        if tasks.ended || tasks.left == 0 {
            return Next::End;
        }
        tasks.ready.pop_front().map_or(Next::Wait, Next::Work)
    }

    /// Waits for a moment; a change of the queue ends the wait early.
    pub fn wait(&self) {
        let tasks = self.tasks();
        let (mut tasks, _) = self.changed.wait_timeout(tasks, WAIT).unwrap_or_else(PoisonError::into_inner);
        tasks.rounds += 1;
        if tasks.rounds.is_multiple_of(ROUNDS) {
            let elsewhere = std::mem::take(&mut tasks.elsewhere);
            tasks.ready.extend(elsewhere);
        }
    }

    /// Defers a task that another process works on.
    pub fn put_aside(&self, task: Task) {
        self.tasks().elsewhere.push(task);
    }

    /// Marks a task as done. The tasks that it releases come first in the queue.
    pub fn done(&self, released: &[Task]) {
        let mut tasks = self.tasks();
        tasks.left -= 1;
        for task in released.iter().rev() {
            tasks.ready.push_front(*task);
        }
        drop(tasks);
        self.changed.notify_all();
    }

    /// Ends all workers.
    pub fn end(&self) {
        self.tasks().ended = true;
        self.changed.notify_all();
    }
}
