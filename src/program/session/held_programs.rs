use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use results::report::{ProgramCopy, ProgramRecord, StoredReport};
use world::av::Fault;
use world::av::external::{Link, Opener, Program};

/// Starts the programs of a report as they were: from the copies that the report holds, where their files have changed since.
pub(super) struct HeldPrograms {
    inner: Arc<dyn Opener>,
    report: StoredReport,
    programs: Vec<HeldProgram>,
}

struct HeldProgram {
    /// Its words and its folder.
    place: Program,
    record: ProgramRecord,
    /// Its copy, once it is known whether one is needed and can be run.
    copy: OnceLock<Option<ProgramCopy>>,
}

impl HeldPrograms {
    /// Those of a report, whose paths are now at the `place` of each, and all others as they are.
    pub fn new(report: &StoredReport, place: impl Fn(&str) -> PathBuf, inner: Arc<dyn Opener>) -> Self {
        let held = report.manifest().programs.iter().filter(|record| record.is_held);
        let program = |record: &ProgramRecord| {
            let place = Program::parse(&record.command, place(&record.folder)).ok()?;
            Some(HeldProgram { place, record: record.clone(), copy: OnceLock::new() })
        };
        Self { inner, report: report.clone(), programs: held.filter_map(program).collect() }
    }

    /// The names of the programs whose copies are used.
    pub fn used(&self) -> Vec<String> {
        let used = self.programs.iter().filter(|program| program.copy.get().is_some_and(Option::is_some));
        used.map(|program| program.record.name.clone()).collect()
    }

    /// The program in the folder of its copy, if it has changed and the copy can be run.
    fn placed(&self, program: &Program) -> Program {
        let in_copy = |copy: &ProgramCopy| Program { folder: copy.folder.clone(), ..program.clone() };
        let copy = self.programs.iter().find(|held| held.is(program)).and_then(|held| {
            let is_same = || self.inner.digests(program).is_ok_and(|now| now == held.record.files);
            let copied = || self.report.program_copy(&held.record, program);
            let can_run = |copy: &ProgramCopy| self.inner.find(&in_copy(copy)).is_ok();
            held.copy.get_or_init(|| if is_same() { None } else { copied().filter(can_run) }).as_ref()
        });
        copy.map_or_else(|| program.clone(), in_copy)
    }
}

impl HeldProgram {
    /// Whether a program is this one: the same words in the same folder, and files that it declares.
    fn is(&self, program: &Program) -> bool {
        let declares = |declared: &String| self.record.files.keys().any(|path| Path::new(path).starts_with(declared));
        let is_declared = |path: &String| program.files.iter().any(|declared| Path::new(path).starts_with(declared));
        (&self.place.words, &self.place.folder) == (&program.words, &program.folder)
            && program.files.iter().all(declares)
            && self.record.files.keys().all(is_declared)
    }
}

impl Opener for HeldPrograms {
    fn find(&self, program: &Program) -> Result<(), String> {
        self.inner.find(&self.placed(program))
    }

    fn digests(&self, program: &Program) -> Result<BTreeMap<String, String>, String> {
        self.inner.digests(&self.placed(program))
    }

    fn greets_as_before(&self, program: &Program, greeting: &str) -> bool {
        self.inner.greets_as_before(program, greeting)
    }

    fn asks(&self) -> bool {
        self.inner.asks()
    }

    fn open(&self, program: &Program) -> Result<Box<dyn Link>, Fault> {
        self.inner.open(&self.placed(program))
    }
}
