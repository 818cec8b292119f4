use std::path::PathBuf;
use std::sync::Arc;

use super::{Disk, Event, Notice, Observer, Silent, Stop};
use compile::Catalog;
use lang::Reader;

/// What all calls share: the language, the reader of files, the observer, the stop flag and the current folder.
pub struct Session {
    pub(crate) catalog: Catalog,
    pub(crate) reader: Box<dyn Reader + Send + Sync>,
    pub(crate) observer: Arc<dyn Observer>,
    pub(crate) stop: Arc<Stop>,
    pub(crate) folder: PathBuf,
}

impl Default for Session {
    /// A session with the built-in language. Scenarios may not start programs.
    fn default() -> Self {
        Self::new(Catalog::builtin())
    }
}

impl Session {
    /// Reads files from the disk, without observer and stop flag, and with this language. The catalogue may have kinds of the caller,
    /// and an opener that lets scenarios start programs.
    pub fn new(catalog: Catalog) -> Self {
        Self {
            catalog,
            reader: Box::new(Disk),
            observer: Arc::new(Silent),
            stop: Arc::default(),
            folder: PathBuf::new(),
        }
    }

    /// The same with another reader of files.
    pub fn with_reader(self, reader: impl Reader + Send + Sync + 'static) -> Self {
        Self { reader: Box::new(reader), ..self }
    }

    /// The same with an observer.
    pub fn with_observer(self, observer: Arc<dyn Observer>) -> Self {
        Self { observer, ..self }
    }

    /// The same with the folder that its paths are relative to, which reports record, so that a later session finds the files again.
    pub fn with_folder(self, folder: PathBuf) -> Self {
        Self { folder, ..self }
    }

    /// The same with a flag that stops it.
    pub fn with_stop(self, stop: Arc<Stop>) -> Self {
        Self { stop, ..self }
    }

    /// Whether the user asked to stop.
    pub fn is_stopped(&self) -> bool {
        self.stop.is_asked()
    }

    /// Passes an event to the observer.
    pub(crate) fn tell(&self, event: Event<'_>) {
        self.observer.event(&event);
    }

    /// Passes a notice to the observer.
    pub(crate) fn notice(&self, notice: &Notice) {
        self.tell(Event::Notice(notice));
    }
}
