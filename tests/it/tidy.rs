//! Documents and code must agree.

use std::path::Path;

use compile::Catalog;

use crate::program::command;

fn read(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

#[test]
fn the_language_reference_is_up_to_date() {
    const MARK: &str = "<!-- generated -->\n";
    let page = read("grammar/README.md");
    let (written, printed) = page.split_once(MARK).expect("the reference has a mark before its generated part");
    let wanted = format!("\n{}", Catalog::builtin().reference());
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("grammar/README.md");
        std::fs::write(path, format!("{written}{MARK}{wanted}")).unwrap();
        return;
    }
    assert_eq!(printed, wanted, "run the test again with UPDATE_REFERENCE=1");
}

/// The columns of a table that `reports/README.md` describes, in its order.
pub fn explained(table: &str) -> Vec<String> {
    let page = read("reports/README.md");
    let (_, part) = page.split_once(&format!("\n### `{table}`\n")).unwrap_or_else(|| panic!("`{table}` has no part"));
    let part = part.split("\n### ").next().unwrap();
    // The names of metrics follow the columns of their table.
    let part = part.split("\n| metric |").next().unwrap();
    let cells = part.lines().filter_map(|line| line.strip_prefix("| `")?.split("` |").next());
    cells.flat_map(|cell| cell.split("`, `").map(str::to_string)).collect()
}

#[test]
fn the_tables_of_reports_have_the_columns_that_their_page_explains() {
    let out = tempfile::tempdir().unwrap();
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let output = command()
        .args(["run", "--smoke", "--out"])
        .arg(out.path())
        .args([scenarios.join("first_look.scn"), scenarios.join("studies/rivals.scn")])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let mut tables = std::collections::BTreeSet::new();
    for campaign in ["first_look", "rivals"] {
        for entry in std::fs::read_dir(out.path().join(format!("{campaign}-smoke"))).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_some_and(|end| end == "csv") {
                let text = std::fs::read_to_string(&path).unwrap();
                let table = path.file_stem().unwrap().to_string_lossy().into_owned();
                let columns: Vec<&str> = text.lines().next().unwrap().split(',').collect();
                assert_eq!(explained(&table), columns, "{table} of {campaign}");
                tables.insert(table);
            }
        }
    }
    let all = ["comparisons", "episodes", "explanations", "failure_modes", "learning_curve"];
    let more = [
        "metrics",
        "mode_counts",
        "reference_drivers",
        "results",
        "runs",
        "search_cells",
        "search_comparisons",
        "search_failures",
        "search_kinds",
        "searches",
        "transfer",
    ];
    assert!(tables.iter().eq(all.iter().chain(&more)), "{tables:?}");
}

#[test]
fn every_code_has_a_case_in_the_suite() {
    let folder = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lang/diagnostics")).unwrap();
    let source: String = folder.map(|file| std::fs::read_to_string(file.unwrap().path()).unwrap()).collect();
    let mut suite = String::new();
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/suite")).unwrap() {
        suite.push_str(&std::fs::read_to_string(entry.unwrap().path()).unwrap_or_default());
    }
    let codes = source.split('"').filter(|part| {
        let word = |c: char| c.is_ascii_lowercase() || c == '-';
        part.contains('-') && part.chars().all(word) && !part.starts_with('-') && !part.ends_with('-')
    });
    let mut missing: Vec<&str> = codes.filter(|code| !suite.contains(&format!("[{code}]"))).collect();
    missing.sort_unstable();
    missing.dedup();
    // A text in a test file cannot show this mistake: it would have to be megabytes long.
    missing.retain(|code| *code != "too-large");
    assert!(missing.is_empty(), "tests/suite has no case for {missing:?}");
}

/// Links between documents lead to files that exist; headings after `#` are not checked.
#[test]
fn links_between_documents_lead_somewhere() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut open = vec![top.join("docs"), top.join("reports"), top.join("grammar"), top.join("scenarios")];
    let mut documents = vec![top.join("README.md"), top.join("src/ARCHITECTURE.md")];
    while let Some(folder) = open.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                documents.push(path);
            }
        }
    }
    let (mut links, mut broken) = (0, Vec::new());
    for document in documents {
        let text = std::fs::read_to_string(&document).unwrap();
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = target.split('#').next().unwrap();
            if file.is_empty() || file.contains("://") || file.contains(char::is_whitespace) {
                continue;
            }
            links += 1;
            if !document.parent().unwrap().join(file).exists() {
                broken.push(format!("{}: {target}", document.display()));
            }
        }
    }
    assert!(links > 30 && broken.is_empty(), "{broken:#?}");
}
