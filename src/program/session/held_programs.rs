use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use results::report::{ProgramRecord, StoredReport};
use tempfile::TempDir;
use world::av::Fault;
use world::av::external::{Link, Opener, Program};

/// Starts the programs of a report as they were: from the copies that the report holds, where their files have changed since.
pub(super) struct HeldPrograms {
    inner: Arc<dyn Opener>,
    report: StoredReport,
    /// For each program its words, and its copy once it is known whether one is needed.
    programs: Vec<(Vec<String>, ProgramRecord, OnceLock<Option<TempDir>>)>,
}

impl HeldPrograms {
    /// Those of a report, and all others as they are.
    pub fn new(report: &StoredReport, inner: Arc<dyn Opener>) -> Self {
        let held = report.manifest().programs.iter().filter(|record| record.is_held);
        let program = |record: &ProgramRecord| {
            let words = Program::parse(&record.command, PathBuf::new()).ok()?.words;
            Some((words, record.clone(), OnceLock::new()))
        };
        Self { inner, report: report.clone(), programs: held.filter_map(program).collect() }
    }

    /// The names of the programs whose copies are used.
    pub fn used(&self) -> Vec<String> {
        let used = self.programs.iter().filter(|(.., copy)| copy.get().is_some_and(Option::is_some));
        used.map(|(_, record, _)| record.name.clone()).collect()
    }

    /// The program in the folder of its copy, if it has changed.
    fn placed(&self, program: &Program) -> Program {
        let known = self.programs.iter().find(|(words, ..)| *words == program.words);
        let copy = known.and_then(|(_, record, copy)| {
            let is_same = || self.inner.digests(program).is_ok_and(|now| now == record.files);
            copy.get_or_init(|| if is_same() { None } else { self.report.program_copy(record) }).as_ref()
        });
        match copy {
            Some(copy) => Program { folder: copy.path().to_path_buf(), ..program.clone() },
            None => program.clone(),
        }
    }
}

impl Opener for HeldPrograms {
    fn find(&self, program: &Program) -> Result<(), String> {
        self.inner.find(&self.placed(program))
    }

    fn digests(&self, program: &Program) -> Result<BTreeMap<String, String>, String> {
        self.inner.digests(&self.placed(program))
    }

    fn open(&self, program: &Program) -> Result<Box<dyn Link>, Fault> {
        self.inner.open(&self.placed(program))
    }
}
