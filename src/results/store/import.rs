//! Merges the tasks of several stores.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::{Found, Id, Store, StoreError};
use crate::campaign::State;

/// What several stores have of a task, after the best version was imported.
#[derive(Debug, PartialEq)]
pub enum Taken {
    /// All of it is there.
    Whole,
    /// It failed, for this reason, and that result is stored.
    Failed(String),
    /// This number of updates, episodes or ticks is there.
    Part(u64),
    /// No store has it.
    Missing,
    /// A file in its place is damaged or of another task, as the text says, and no other store has it.
    Damaged(PathBuf, String),
    /// Two stores have different results.
    Differ(PathBuf, PathBuf),
}

impl Store {
    /// Imports the best version that other stores have of a task, whose full size is `amount`.
    ///
    /// # Errors
    /// A file of the task cannot be read, or the task cannot be written.
    pub fn take(&self, id: Id, amount: Option<u64>, others: &[Store]) -> Result<Taken, StoreError> {
        let mut best: Option<(&Store, Found)> = None;
        let mut damaged = None;
        for store in std::iter::once(self).chain(others) {
            let found = store.read(id)?;
            if let Found::Damaged(reason) = &found {
                damaged.get_or_insert_with(|| Taken::Damaged(store.path(id), reason.clone()));
            }
            if let (Some((first, Found::Whole(one, bytes))), Found::Whole(other, others)) = (&best, &found)
                && one.state == State::Finished
                && (one.state, one.done) == (other.state, other.done)
                && bytes != others
            {
                return Ok(Taken::Differ(first.path(id), store.path(id)));
            }
            if rank(&found) > best.as_ref().map_or((0, 0), |(_, found)| rank(found)) {
                best = Some((store, found));
            }
        }
        let Some((owner, Found::Whole(header, _))) = best else {
            return Ok(damaged.unwrap_or(Taken::Missing));
        };
        if !std::ptr::eq(owner, self) {
            self.bring(&owner.path(id), &self.path(id))?;
        }
        Ok(match header.state {
            State::Finished if amount.is_none_or(|amount| header.done >= amount) => Taken::Whole,
            State::Failed => Taken::Failed(header.error),
            State::Finished | State::Begun => Taken::Part(header.done),
        })
    }

    /// Imports a file of another store: as a link on the same file system, else as a copy.
    fn bring(&self, from: &Path, to: &Path) -> Result<(), StoreError> {
        let failed = |source| StoreError::File { path: to.to_path_buf(), source };
        let drafts = self.drafts()?;
        let put = || -> io::Result<()> {
            fs::create_dir_all(to.parent().expect("a file of the store is in a folder"))?;
            let draft = tempfile::Builder::new().make_in(&drafts, |path| {
                fs::hard_link(from, path).or_else(|_| fs::copy(from, path).map(|_| ()))?;
                fs::File::open(path)
            })?;
            draft.persist(to).map(|_| ()).map_err(|error| error.error)
        };
        put().map_err(failed)
    }
}

/// Finished before failed before started; more before less.
fn rank(found: &Found) -> (u8, u64) {
    match found {
        Found::Whole(header, _) => match header.state {
            State::Finished => (3, header.done),
            State::Failed => (2, header.done),
            State::Begun => (1, header.done),
        },
        Found::Nothing | Found::Damaged(_) => (0, 0),
    }
}
