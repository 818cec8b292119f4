use super::section;
use crate::report::render::{Section, Selection, Table, Value};
use crate::report::{Manifest, ProgramRecord, ScenarioFile};

/// Versions, digests, and the command that repeats everything.
pub fn provenance(manifest: &Manifest) -> Section {
    let mut lead = vec![
        format!(
            "falsify {}, code {}, seed {}, vector instructions {}. The same files, seed and version give the same numbers.",
            manifest.version, manifest.code, manifest.seed, manifest.vector_instructions
        ),
        format!("`{}`", manifest.command()),
    ];
    if !manifest.complete {
        lead.push("**The campaign is not complete: it was stopped, something failed, or it reached a limit.**".into());
    }
    if manifest.errors > 0 {
        lead.push(format!("**In {} episodes a program failed. No number includes them.**", manifest.errors));
    }
    let files = Selection::new()
        .text("file", |file: &ScenarioFile| file.path.clone())
        .text("BLAKE3", |file| Value::code(&file.blake3));
    let files = Table { title: "Files read".into(), ..files.table(&manifest.files) };
    type File<'a> = (&'a ProgramRecord, &'a str, &'a str);
    let of_programs = manifest.programs.iter().flat_map(|program| {
        let none = program.files.is_empty().then_some((program, "none declared", "–"));
        program.files.iter().map(move |(file, digest)| (program, file.as_str(), digest.as_str())).chain(none)
    });
    let rows: Vec<File<'_>> = of_programs.collect();
    let programs = Selection::new()
        .text("program", |(program, ..): &File<'_>| program.name.clone())
        .text("version", |(program, ..)| match program.version.as_str() {
            "" => "none stated".into(),
            version => version.to_owned(),
        })
        .text("file", |(_, file, _)| (*file).to_owned())
        .text("BLAKE3", |(.., digest)| Value::code(*digest));
    let programs = Table { title: "Programs that drive or walk".into(), ..programs.table(&rows) };
    let tables = [files, programs].into_iter().filter(|table| !table.rows.is_empty());
    section("provenance", "Versions and digests", lead, tables.collect())
}
