use std::sync::Arc;

use super::{Disk, Observer, Silent, Stop};
use crate::compile::Catalog;
use crate::lang::Reader;

/// What all calls share: the language, the files, who listens, and who may stop them.
pub struct Session {
    pub(super) catalog: Catalog,
    pub(super) reader: Box<dyn Reader + Send + Sync>,
    pub(super) observer: Arc<dyn Observer>,
    pub(super) stop: Arc<Stop>,
}

impl Default for Session {
    /// The built-in language, files of the disk, no observer, and no way to stop. Scenarios may not start programs.
    fn default() -> Self {
        Self { catalog: Catalog::builtin(), reader: Box::new(Disk), observer: Arc::new(Silent), stop: Arc::default() }
    }
}

impl Session {
    /// The same with another catalogue: with policies of the caller, or with an opener that lets scenarios start programs.
    pub fn with_catalog(self, catalog: Catalog) -> Self {
        Self { catalog, ..self }
    }

    /// The same with files that come from elsewhere than the disk.
    pub fn with_reader(self, reader: impl Reader + Send + Sync + 'static) -> Self {
        Self { reader: Box::new(reader), ..self }
    }

    /// The same with an observer.
    pub fn with_observer(self, observer: Arc<dyn Observer>) -> Self {
        Self { observer, ..self }
    }

    /// The same with a flag that stops it.
    pub fn with_stop(self, stop: Arc<Stop>) -> Self {
        Self { stop, ..self }
    }
}
