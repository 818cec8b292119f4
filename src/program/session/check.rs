use std::collections::BTreeMap;

use super::disk::{ReadFiles, Recording};
use super::{Error, Event, Input, Notice, Session};
use base::diagnostic::{Severity, Sources};
use compile::{Catalog, Compiled, Overrides, Plan, compile_with};
use lang::{Reader, library};
use results::report::FileRecord;

/// Files that were checked.
#[derive(Debug)]
pub struct Checked {
    /// The plan and the diagnostics.
    pub compiled: Compiled,
    /// The texts of the files.
    pub sources: Sources,
    /// A record of each file that was read; without its digest after [`Session::check`].
    pub records: Vec<FileRecord>,
    /// Contents of the files, by their paths; empty after [`Session::check`].
    contents: BTreeMap<String, Vec<u8>>,
    /// Towns for which a map is given.
    mapped: Vec<String>,
}

/// A plan that can be run.
#[derive(Debug)]
pub struct Planned {
    pub plan: Plan,
    /// A record of each file that was read.
    pub records: Vec<FileRecord>,
    /// The contents of the files that a report holds, by their paths.
    pub(crate) contents: BTreeMap<String, Vec<u8>>,
}

impl Checked {
    /// The plan of files without errors.
    ///
    /// # Errors
    /// [`Error::Scenario`] and [`Error::UnusedMap`].
    pub fn plan(&self) -> Result<&Plan, Error> {
        let plan = self.compiled.plan.as_ref().ok_or_else(|| Error::Scenario { errors: self.errors() })?;
        match self.mapped.iter().find(|town| !plan.has_town(town)) {
            None => Ok(plan),
            Some(town) => Err(Error::UnusedMap { town: town.clone() }),
        }
    }

    /// The number of diagnostics that are errors.
    pub fn errors(&self) -> usize {
        self.compiled.diagnostics.iter().filter(|each| each.severity == Severity::Error).count()
    }

    fn into_planned(self) -> Result<Planned, Error> {
        self.plan()?;
        let plan = self.compiled.plan.expect("the files have no errors");
        Ok(Planned { plan, records: self.records, contents: self.contents })
    }
}

impl Session {
    /// Reads, parses and checks scenario files. Errors in the scenarios are diagnostics of the result.
    ///
    /// # Errors
    /// [`Error::Unreadable`]; the observer then has the diagnostics of the other files.
    pub fn check(&self, input: &Input) -> Result<Checked, Error> {
        self.compile(&self.catalog, self.reader.as_ref(), input, Overrides { only_checked: true, ..input.overrides() })
    }

    /// Reads, checks and compiles scenario files for a run; the observer gets the diagnostics.
    ///
    /// # Errors
    /// [`Error::Unreadable`], [`Error::Scenario`] and [`Error::UnusedMap`].
    pub fn plan(&self, input: &Input) -> Result<Planned, Error> {
        self.plan_unless_told(input, &|_, _| false)
    }

    /// [`Session::plan`] for a run whose warnings may have been told: then the observer gets their number.
    pub(crate) fn plan_unless_told(
        &self,
        input: &Input,
        is_told: &dyn Fn(&Plan, &[FileRecord]) -> bool,
    ) -> Result<Planned, Error> {
        let checked = self.compile(&self.catalog, self.reader.as_ref(), input, input.overrides())?;
        let diagnostics = &checked.compiled.diagnostics;
        let is_told = !diagnostics.is_empty() && checked.plan().is_ok_and(|plan| is_told(plan, &checked.records));
        if is_told {
            self.notice(&Notice::ToldBefore { warnings: diagnostics.len() });
        } else {
            self.tell(Event::Diagnostics(diagnostics, &checked.sources));
        }
        checked.into_planned()
    }

    /// [`Session::plan`] with the files of a report, whose warnings its run has said: the observer gets the diagnostics only if one is an error.
    pub(crate) fn plan_again(&self, catalog: &Catalog, reader: &dyn Reader, input: &Input) -> Result<Planned, Error> {
        let checked = self.compile(catalog, reader, input, input.overrides())?;
        if checked.plan().is_err() {
            self.tell(Event::Diagnostics(&checked.compiled.diagnostics, &checked.sources));
        }
        checked.into_planned()
    }

    fn compile(
        &self,
        catalog: &Catalog,
        reader: &dyn Reader,
        input: &Input,
        overrides: Overrides,
    ) -> Result<Checked, Error> {
        let reader = Recording::new(reader, !overrides.only_checked);
        let mut left = input.files.clone();
        let mut unreadable = Vec::new();
        let (compiled, sources) = loop {
            let mut sources = Sources::default();
            match compile_with(&left, &overrides, catalog, &reader, &mut sources) {
                Ok(compiled) => break (compiled, sources),
                Err(error) => {
                    left.retain(|each| *each != error.path);
                    unreadable.push(error);
                }
            }
        };
        if !unreadable.is_empty() {
            // The diagnostics of the other files are still reported.
            self.tell(Event::Diagnostics(&compiled.diagnostics, &sources));
            return Err(Error::Unreadable { files: unreadable });
        }
        let of_library = sources.iter().filter(|(_, source)| library::holds(&source.path));
        let of_library = of_library.map(|(_, source)| reader.record(&source.path, source.text.as_bytes()));
        let of_library: Vec<FileRecord> = of_library.collect();
        let ReadFiles { mut records, contents } = reader.into_files();
        records.extend(of_library);
        let mapped = input.maps.iter().map(|(town, _)| town.clone()).collect();
        Ok(Checked { compiled, sources, records, contents, mapped })
    }
}
