//! The tables of a report can be read as `reports/README.md` shows.
//!
//! Needs a Python with polars, pandas, duckdb and pyarrow; `FALSIFY_PYTHON` names it (default `python3`).

use std::path::Path;
use std::process::Command;

use crate::program::command;
use needs::needs;

const SCENARIO: &str = r#"
edition 1
import "lib/paper.scn"
import "lib/drivers.scn"
import "lib/towns.scn"
training short = ppo(steps: 600)
campaign tables {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: short
  train { towns: [harbour] drivers: [blind] rewards: [r1, r2] runs: 2 }
  evaluate { towns: [harbour, village] drivers: [blind] pedestrians: [trained, random] episodes: 8 }
}
"#;

/// The snippets of the page, by the module that they use.
fn snippets() -> Vec<(String, String)> {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/README.md")).unwrap();
    let parts = page.split("<!-- run: ").skip(1).map(|rest| {
        let (module, rest) = rest.split_once(" -->\n```python\n").expect("a snippet follows its mark");
        (module.to_owned(), rest.split("```").next().unwrap().to_owned())
    });
    parts.collect()
}

/// Runs a snippet in the report of a campaign.
fn runs(module: &str, snippet: &str) {
    let folder = tempfile::tempdir().unwrap();
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let file = folder.path().join("tables.scn");
    std::fs::write(&file, SCENARIO.replace("lib/", &format!("{}/lib/", scenarios.display()))).unwrap();
    let run = command().args(["run", "--out"]).arg(folder.path()).arg(&file).output().unwrap();
    assert!(run.status.success(), "{run:?}");
    let python = std::env::var("FALSIFY_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let output = Command::new(python).args(["-c", snippet]).current_dir(folder.path().join("tables")).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{module}: {}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("village") && text.contains("r2"), "{module}: {text}");
}

fn snippet_runs(module: &str) {
    let all = snippets();
    let (_, snippet) = all.iter().find(|(name, _)| name == module).expect("the page has it");
    runs(module, snippet);
}

#[test]
fn the_report_s_page_has_three_snippets() {
    assert_eq!(snippets().into_iter().map(|(module, _)| module).collect::<Vec<_>>(), ["polars", "pandas", "duckdb"]);
}

#[needs(module = "polars")]
#[test]
fn the_snippet_of_polars_runs() {
    snippet_runs("polars");
}

#[needs(module = "pandas")]
#[test]
fn the_snippet_of_pandas_runs() {
    snippet_runs("pandas");
}

#[needs(module = "duckdb")]
#[test]
fn the_snippet_of_duckdb_runs() {
    snippet_runs("duckdb");
}

#[needs(module = "pyarrow")]
#[test]
fn pyarrow_filters_the_tables() {
    runs(
        "pyarrow",
        "import pyarrow.parquet as pq, pyarrow.compute as pc, glob
for name in sorted(glob.glob('*.parquet')):
    table = pq.read_table(name)
    assert not any('view' in str(field.type) for field in table.schema), name
    if 'town' in table.column_names:
        print(name, table.filter(pc.field('town') == 'village').num_rows, pq.read_table(name, filters=[('town', 'in', ['village'])])['town'].unique(), table['policy'].type, 'r2')
",
    );
}
