use super::ChangedProgram;
use results::report::StoredReport;
use results::store::{CODE, vector_instructions};

/// A possible reason why an episode differs from its report.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Reason {
    #[error("another version: {then} then, {} now", env!("CARGO_PKG_VERSION"))]
    Version { then: String },
    #[error("another processor: `{then}` then, `{}` now; it changes trainings alone", vector_instructions())]
    Processor { then: String },
    #[error("a driver from outside that does not drive the same way twice; try `falsify check -- DRIVER`")]
    External,
    #[error("{program} since the report; `falsify recheck --allow-external {report}` lets it meet the same starts")]
    Program {
        program: ChangedProgram,
        /// The report, as the user names it.
        report: String,
    },
    #[error("the program was built from other sources")]
    Sources,
    #[error(
        "files of the report were edited or replaced after the run: {files}; `falsify run` of its scenario writes them again"
    )]
    Edited { files: String },
    #[error("this is a bug; the files, the program and the processor are the same")]
    Bug,
}

/// All possible reasons for differences from a report with these changed programs and these changed files; at least one.
pub fn reasons(report: &StoredReport, programs: &[ChangedProgram], files: &[String]) -> Vec<Reason> {
    /// Maximum number of files that are named.
    const NAMED: usize = 4;
    let manifest = report.manifest();
    let folder = report.folder().display();
    let changed = |program: &ChangedProgram| Reason::Program { program: program.clone(), report: folder.to_string() };
    let mut reasons = Vec::new();
    if !files.is_empty() {
        let named: Vec<&str> = files.iter().take(NAMED).map(String::as_str).collect();
        let more = if files.len() > NAMED { format!(" and {} more", files.len() - NAMED) } else { String::new() };
        reasons.push(Reason::Edited { files: format!("{}{more}", named.join(", ")) });
    }
    if manifest.version != env!("CARGO_PKG_VERSION") {
        reasons.push(Reason::Version { then: manifest.version.clone() });
    }
    if manifest.vector_instructions != vector_instructions() {
        reasons.push(Reason::Processor { then: manifest.vector_instructions.clone() });
    }
    reasons.extend(programs.iter().map(changed));
    if manifest.call.allow_external && programs.is_empty() {
        reasons.push(Reason::External);
    }
    if manifest.code != CODE {
        reasons.push(Reason::Sources);
    }
    if reasons.is_empty() {
        reasons.push(Reason::Bug);
    }
    reasons
}
