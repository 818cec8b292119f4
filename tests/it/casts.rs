//! A campaign with several pedestrians and cars, from its file to a page, and back from the name of a failure.

use std::path::Path;

use crate::program::{falsify, said};

/// The scenario of the page of the book about casts.
fn scenario() -> String {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/src/how-to/casts.md");
    let page = std::fs::read_to_string(page).unwrap();
    let (_, rest) = page.split_once("```scn\n").unwrap();
    rest.split_once("```").unwrap().0.replace("episodes: 200", "episodes: 40")
}

#[test]
fn a_cast_runs_to_a_page_and_a_failure_names_the_actors_that_it_needs() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    std::fs::write(here.join("family.scn"), scenario()).unwrap();
    let run = falsify(&["run", "family.scn"], here);
    assert_eq!(run.status.code(), Some(0), "{run:?}");
    let report = here.join("reports/family");
    let page = std::fs::read_to_string(report.join("report.html")).unwrap();
    for name in ["\"friend\"", "\"van\"", "\"follower\"", "\"crowd\""] {
        assert!(page.contains(name), "the page shows {name}");
    }
    let episodes = std::fs::read_to_string(report.join("episodes.csv")).unwrap();
    let hit = episodes.lines().skip(1).find(|line| line.contains(",collision,")).expect("somebody is hit");
    let mut cells = hit.split(',');
    let run_id = cells.next().unwrap();
    let head: Vec<&str> = episodes.lines().next().unwrap().split(',').collect();
    let place = head.iter().position(|name| *name == "episode").unwrap();
    let name = format!("{run_id}:{}", hit.split(',').nth(place).unwrap());
    let again = falsify(&["replay", &name], here);
    let text = said(&again);
    assert!(again.status.success() && text.contains("as in the report, in every column"), "{text}");
    assert!(text.contains("the pedestrian is `") && text.contains("It needs `"), "{text}");
    let json = said(&falsify(&["replay", &name, "--json"], here));
    let object: serde_json::Value = serde_json::from_str(&json).unwrap();
    let roles: Vec<&str> =
        object["actors"].as_array().unwrap().iter().map(|actor| actor["role"].as_str().unwrap()).collect();
    assert_eq!(roles, ["van", "follower", "child", "friend", "crowd", "crowd", "crowd"]);
}
