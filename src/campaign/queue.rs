use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::Cell;

/// How long a worker without work waits before it looks whether it can help another.
const PATIENCE: Duration = Duration::from_millis(2);
/// How many of these waits it takes until cells in other hands are asked for again.
const ROUNDS: u32 = 20;

/// The cells that can be worked on, for several workers.
pub(super) struct Queue {
    cells: Mutex<Cells>,
    bell: Condvar,
}

struct Cells {
    ready: VecDeque<Cell>,
    /// Cells that another process works on.
    elsewhere: Vec<Cell>,
    /// Cells of which nobody has told the end, those that wait for others included.
    left: usize,
    rounds: u32,
    ended: bool,
}

/// What a worker is to do.
pub(super) enum Next {
    Work(Cell),
    /// Nothing is ready now.
    Wait,
    End,
}

impl Queue {
    /// Begins with cells that are ready, and a number of others that will be.
    pub fn new(ready: VecDeque<Cell>, later: usize) -> Self {
        let left = ready.len() + later;
        let cells = Cells { ready, elsewhere: Vec::new(), left, rounds: 0, ended: false };
        Self { cells: Mutex::new(cells), bell: Condvar::new() }
    }

    fn cells(&self) -> MutexGuard<'_, Cells> {
        self.cells.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives the next cell.
    pub fn next(&self) -> Next {
        let mut cells = self.cells();
        if cells.ended || cells.left == 0 {
            return Next::End;
        }
        cells.ready.pop_front().map_or(Next::Wait, Next::Work)
    }

    /// Waits for a moment, unless something happens before.
    pub fn wait(&self) {
        let cells = self.cells();
        let (mut cells, _) = self.bell.wait_timeout(cells, PATIENCE).unwrap_or_else(PoisonError::into_inner);
        cells.rounds += 1;
        if cells.rounds.is_multiple_of(ROUNDS) {
            let elsewhere = std::mem::take(&mut cells.elsewhere);
            cells.ready.extend(elsewhere);
        }
    }

    /// Puts a cell aside that another process works on.
    pub fn put_aside(&self, cell: Cell) {
        self.cells().elsewhere.push(cell);
    }

    /// Tells the end of a cell, and which others can be worked on for that; they come first.
    pub fn done(&self, released: &[Cell]) {
        let mut cells = self.cells();
        cells.left -= 1;
        for cell in released.iter().rev() {
            cells.ready.push_front(*cell);
        }
        drop(cells);
        self.bell.notify_all();
    }

    /// Sends all workers home.
    pub fn end(&self) {
        self.cells().ended = true;
        self.bell.notify_all();
    }
}
