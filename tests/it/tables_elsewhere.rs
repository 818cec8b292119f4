//! The tables of a report can be read as `reports/README.md` shows.
//!
//! Needs a Python with polars, pandas, duckdb and pyarrow; `FALSIFY_PYTHON` names it (default `python3`). The test reports a missing package
//! and skips its part.

use std::path::Path;
use std::process::Command;

use crate::program::command;

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

#[test]
fn the_snippets_of_the_report_s_page_run() {
    let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/README.md")).unwrap();
    let snippets: Vec<(&str, &str)> = page
        .split("<!-- run: ")
        .skip(1)
        .map(|rest| {
            let (module, rest) = rest.split_once(" -->\n```python\n").expect("a snippet follows its mark");
            (module, rest.split("```").next().unwrap())
        })
        .collect();
    assert_eq!(snippets.iter().map(|(module, _)| *module).collect::<Vec<_>>(), ["polars", "pandas", "duckdb"]);
    let folder = tempfile::tempdir().unwrap();
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let file = folder.path().join("tables.scn");
    std::fs::write(&file, SCENARIO.replace("lib/", &format!("{}/lib/", scenarios.display()))).unwrap();
    let run = command().args(["run", "--out"]).arg(folder.path()).arg(&file).output().unwrap();
    assert!(run.status.success(), "{run:?}");
    let filter = "import pyarrow.parquet as pq, pyarrow.compute as pc, glob
for name in sorted(glob.glob('*.parquet')):
    table = pq.read_table(name)
    assert not any('view' in str(field.type) for field in table.schema), name
    if 'town' in table.column_names:
        print(name, table.filter(pc.field('town') == 'village').num_rows, pq.read_table(name, filters=[('town', 'in', ['village'])])['town'].unique(), table['policy'].type, 'r2')
";
    let python = std::env::var("FALSIFY_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    for (module, snippet) in snippets.into_iter().chain([("pyarrow", filter)]) {
        let has = Command::new(&python).args(["-c", &format!("import {module}")]).output();
        if !has.is_ok_and(|output| output.status.success()) {
            loud!("SKIPPED: `{python}` has no {module}; set FALSIFY_PYTHON");
            continue;
        }
        let output =
            Command::new(&python).args(["-c", snippet]).current_dir(folder.path().join("tables")).output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{module}: {}", String::from_utf8_lossy(&output.stderr));
        assert!(text.contains("village") && text.contains("r2"), "{module}: {text}");
    }
}
