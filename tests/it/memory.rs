//! The memory of a run has a bound, however many episodes it has.
#![cfg(target_os = "linux")]

use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use crate::program::command;

/// An evaluation of a driver that sees no pedestrians; an episode lasts a second.
fn scenario(episodes: u64) -> String {
    format!(
        r#"edition 1
import "std/paper.scn"
import "std/rewards.scn"
import "std/drivers.scn"
import "std/towns.scn"
episode second {{ ticks: 20  hold: 10 }}
campaign long {{
  vehicle: model3  body: suicidal  spawn: ahead  episode: second
  evaluate {{ towns: [harbour]  drivers: [blind]  pedestrians: [random]  episodes: {episodes} }}
}}
"#
    )
}

/// The most memory (MB) that a run has had. It is read while the run goes, so its last milliseconds are missing.
fn most_memory(episodes: u64, folder: &Path) -> f64 {
    let name = format!("{episodes}.scn");
    std::fs::write(folder.join(&name), scenario(episodes)).unwrap();
    let out = format!("out{episodes}");
    let mut run = command();
    run.args(["run", &name, "--threads", "1", "--progress", "none", "--out", &out]).current_dir(folder);
    let mut run = run.stdout(Stdio::null()).spawn().unwrap();
    let mut most = 0.0_f64;
    let status = loop {
        if let Some(status) = run.try_wait().unwrap() {
            break status;
        }
        let text = std::fs::read_to_string(format!("/proc/{}/status", run.id())).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.split_whitespace().next()).and_then(|number| number.parse().ok());
        most = most.max(kilobytes.unwrap_or(0.0) / 1024.0);
        std::thread::sleep(Duration::from_millis(5));
    };
    assert!(status.success(), "{episodes} episodes: {status}");
    most
}

#[test]
#[ignore = "a large sample, which `.ci/run` takes"]
fn a_long_run_has_a_bound() {
    let folder = tempfile::tempdir().unwrap();
    // A run stores single episodes of its first 100,000. A kilobyte for each of 200,000 would be 300 MB; a million episodes have had 153 MB.
    let most = most_memory(200_000, folder.path());
    assert!((20.0..220.0).contains(&most), "{most} MB");
}
