//! What a driver gives for safety: its progress, and needless braking.

use std::io;
use std::path::Path;

use falsify::language::Catalog;
use falsify::results::Gate;
use falsify::session::{CampaignReport, Input, RunOptions, Session};

const SCENARIO: &str = r#"
edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/towns.scn"
driver creeper = cruise(limit_share: 0.3)
driver half = cruise(limit_share: 0.5)

episode brief { ticks: 300 traffic_lights: false }
spawn near { distance: 15 m .. 25 m }
campaign priced {
  vehicle: model3  body: suicidal  spawn: near  episode: brief  PRICE
  evaluate { towns: [harbour, village]  drivers: [creeper, half, blind, idm]  pedestrians: [natural]  episodes: 12 }
}
"#;

/// Runs the scenario with a further key of its campaign, and looks at the report.
fn run(key: &'static str, gates: &[&str], look: impl FnOnce(&CampaignReport)) {
    let session = Session::new(Catalog::builtin()).with_reader(move |path: &Path| match path.to_str() {
        Some("priced.scn") => Ok(SCENARIO.replace("PRICE", key)),
        _ => Err(io::Error::from(io::ErrorKind::NotFound)),
    });
    let out = tempfile::tempdir().unwrap();
    let gates = gates.iter().map(|gate| Gate::parse(gate).unwrap()).collect();
    let options = RunOptions {
        input: Input::file("priced.scn"),
        out: out.path().join("reports"),
        gates,
        ..RunOptions::default()
    };
    look(session.run(&options).unwrap().reports().next().unwrap());
}

#[test]
fn a_driver_that_hardly_moves_has_no_progress_and_is_told() {
    run("price: 12", &["progress < 0.4", "progress < 0.2", "needless_braking > 0"], |report| {
        let price = |name: &str| {
            let found = report.drivers.iter().find(|result| result.driver.name == name).unwrap();
            found.price.unwrap()
        };
        let near = |name: &str, wanted: f64, by: f64| {
            let progress = price(name).progress;
            assert!((progress - wanted).abs() < by, "{name}: {progress}");
        };
        // Bends and the start, at the speed of each driver, are shared.
        near("creeper", 0.3, 0.06);
        near("half", 0.5, 0.08);
        near("blind", 0.9, 0.08);
        assert!(price("idm").progress > 0.75);
        for blind in ["creeper", "half", "blind"] {
            let price = price(blind);
            assert_eq!(price.delayed, 0, "{blind} sees nobody");
            assert!(price.spared <= 24 && (price.spared > 0 || blind == "creeper"), "{blind}: {price:?}");
        }
        let summary = std::fs::read_to_string(report.folder.join("summary.md")).unwrap();
        assert!(summary.contains("creeper drives ") && summary.contains("few faults says little"), "{summary}");
        assert!(report.folder.join("prices.csv").is_file() && report.folder.join("prices.parquet").is_file());
        let fails = |gate: usize| report.gates[gate].1.iter().filter(|judged| judged.fails()).count();
        assert_eq!([0, 1].map(fails), [2, 0], "the two rows of creeper");
        assert!(
            report.manifest.answer.iter().any(|sentence| sentence.starts_with("idm ")),
            "{:?}",
            report.manifest.answer
        );
    });
}

#[test]
fn a_campaign_has_prices_unless_it_says_otherwise() {
    run("price: 0", &[], |report| {
        assert!(report.drivers.iter().all(|result| result.price.is_none()));
        assert!(!report.folder.join("prices.csv").exists());
    });
    // A tenth of 12 episodes in each of two towns.
    run("", &[], |report| {
        let prices = std::fs::read_to_string(report.folder.join("prices.csv")).unwrap();
        let starts = prices.lines().skip(1).map(|line| line.split(',').nth(3).unwrap());
        assert_eq!(starts.collect::<Vec<_>>(), ["1"; 8], "{prices}");
        assert!(report.drivers.iter().all(|result| result.price.is_some()));
        assert_eq!(report.since, None);
    });
}
