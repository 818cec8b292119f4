//! Campaigns that are run in parts, merged, and inspected from outside.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use compile::{Campaign, Catalog, Job, compile};
use falsify::session::Disk;
use results::campaign::{self, Shard, Task, tasks};

use crate::program::{error, falsify, report, said};

/// A campaign that runs in a fraction of a second, with trainings, all kinds of evaluations and a search, and no prices: the shards are to divide the trainings.
fn write_campaign(folder: &Path) {
    let lib = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/lib");
    let text = format!(
        "edition 1\nimport \"{0}/paper.scn\"\nimport \"{0}/drivers.scn\"\nimport \"{0}/towns.scn\"\n\
         training short = ppo(steps: 600)\nmethod walk = homing()\n\
         campaign parts {{ vehicle: model3 body: suicidal spawn: ahead episode: thirty_seconds training: short price: 0\n\
         train {{ towns: [harbour] drivers: [behavior] rewards: [r1, r2] runs: 2 }}\n\
         evaluate {{ towns: [harbour, village] drivers: [blind] episodes: 12 }}\n\
         search {{ towns: [harbour] drivers: [blind] methods: [walk] budget: 2000 runs: 2 }} }}\n",
        lib.display()
    );
    std::fs::write(folder.join("parts.scn"), text).unwrap();
}

/// The task file in a folder that contains this description.
fn cell_file(out: &Path, what: &str) -> Option<PathBuf> {
    let folders = std::fs::read_dir(out.join(".falsify/tasks")).unwrap();
    let files = folders.flat_map(|folder| std::fs::read_dir(folder.unwrap().path()).unwrap());
    let told = |path: &PathBuf| String::from_utf8_lossy(&std::fs::read(path).unwrap()).contains(what);
    files.map(|file| file.unwrap().path()).find(told)
}

#[test]
fn shards_make_the_report_of_one_machine_and_whatever_is_missing_or_wrong_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write_campaign(here);
    let whole = falsify(&["run", "parts.scn", "--out", "whole"], here);
    assert!(whole.status.success(), "{whole:?}");
    for (shard, out) in [("0/3", "a"), ("2/3", "b")] {
        let output = falsify(&["run", "parts.scn", "--shard", shard, "--out", out], here);
        assert!(output.status.success(), "{output:?}");
        assert!(!here.join(out).join("parts").exists(), "a shard writes no report");
    }

    let merge = ["merge", "parts.scn", "--out", "merged", "--shards", "3", "--from", "a", "b", "c"];
    let output = falsify(&merge[..9], here);
    assert_eq!(output.status.code(), Some(9), "{output:?}");
    assert!(error(&output).contains("do again, of 3 shards: 1"), "{}", error(&output));
    assert!(!here.join("merged/parts").exists());

    assert!(falsify(&["run", "parts.scn", "--shard", "1/3", "--out", "c"], here).status.success());
    let output = falsify(&merge, here);
    assert!(output.status.success(), "{output:?}");
    let (whole, merged) = (report(&here.join("whole/parts")), report(&here.join("merged/parts")));
    let names: Vec<&PathBuf> = whole.keys().collect();
    assert_eq!(names, merged.keys().collect::<Vec<_>>());
    let other: Vec<&&PathBuf> = names.iter().filter(|name| whole[**name] != merged[**name]).collect();
    assert!(other.is_empty(), "{other:?} have other bytes");

    // A task whose copies are all damaged is missing. A task with two different results is accepted from neither folder.
    let search = "search walk in harbour against blind, run 1";
    let file = ["a", "b", "c"].iter().find_map(|out| cell_file(&here.join(out), search)).expect("one of them made it");
    let mut bytes = std::fs::read(&file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::remove_file(&file).unwrap();
    std::fs::write(&file, &bytes).unwrap();
    let mut again = merge;
    again[3] = "again";
    let output = falsify(&again, here);
    assert_eq!(output.status.code(), Some(9), "{output:?}");
    assert!(error(&output).contains(search) && error(&output).contains("is damaged"), "{}", error(&output));
}

#[test]
fn shards_of_one_folder_need_nothing_but_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write_campaign(here);
    let stopped = falsify(&["run", "parts.scn", "--shard", "0/2", "--tasks", "trainings"], here);
    assert!(stopped.status.success() && said(&stopped).contains("tasks are there"), "{stopped:?}");
    let status = falsify(&["status"], here);
    let text = said(&status);
    assert_eq!(status.status.code(), Some(9), "{text}");
    assert!(text.contains("parts: stopped") && text.contains("trainings   3 of 4 tasks, 75 %"), "{text}");
    assert!(text.contains("`falsify merge` names the shards that are missing"), "{text}");
    let finished = "the shard of `falsify run parts.scn --shard 0/2 --tasks trainings` is finished";
    assert!(text.contains(finished) && !text.contains("go on with"), "{text}");
    let left = "left for one thread, and the evaluations and searches, of which none is done yet";
    assert!(text.contains(left), "{text}");
    for shard in ["0/2", "1/2"] {
        assert!(falsify(&["run", "parts.scn", "--shard", shard], here).status.success());
    }
    assert!(said(&falsify(&["status"], here)).contains("parts: finished"));
    let merged = falsify(&["merge", "parts.scn", "--format", "json"], here);
    assert!(merged.status.success(), "{merged:?}");
    assert!(said(&merged).contains("\"event\":\"report_written\""), "{merged:?}");
    let json = said(&falsify(&["status", "--format", "json"], here));
    let status: serde_json::Value = serde_json::from_str(json.trim()).unwrap();
    assert_eq!((&status["state"], &status["processes"]), (&"finished".into(), &0.into()), "{json}");
}

#[test]
fn a_shard_that_there_is_none_of_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    write_campaign(folder.path());
    for (shard, why) in [("3/3", "counted from 0 to 2"), ("a/3", "INDEX/COUNT"), ("auto/3", "SLURM_ARRAY_TASK_ID")] {
        let output = falsify(&["run", "parts.scn", "--shard", shard], folder.path());
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert!(error(&output).contains(why), "{}", error(&output));
    }
    let nowhere = falsify(&["status", "--out", "nowhere"], folder.path());
    assert_eq!(nowhere.status.code(), Some(2));
}

fn planned(path: &str) -> Campaign {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let compiled = compile(&[path], &Catalog::builtin(), &Disk, &mut Default::default()).unwrap();
    compiled.plan.unwrap().campaigns.into_iter().next().unwrap()
}

#[test]
fn every_cell_falls_to_one_shard_with_what_it_needs_and_the_shards_are_alike() {
    let mut campaign = planned("scenarios/first_look.scn");
    // A search is a task of its own size, so the numbers of tasks would differ.
    campaign.jobs.retain(|job| !matches!(job, Job::Search(_)));
    for job in &mut campaign.jobs {
        if let Job::Evaluation(evaluation) = job {
            evaluation.episodes = 25_000;
        }
    }
    let is_training = |task: &Task| matches!(campaign.jobs[task.job], Job::Training(_));
    for count in [1, 2, 3, 7, 16, 1000] {
        let dealt: BTreeMap<Task, u32> = campaign::deal(&campaign, count).into_iter().collect();
        assert_eq!(dealt.len(), tasks(&campaign).count());
        let shards: Vec<Vec<Task>> =
            (0..count).map(|index| campaign::shard(&campaign, Shard { index, count })).collect();
        for (index, shard) in shards.iter().enumerate() {
            for task in shard {
                assert!(dealt[task] == index as u32 || is_training(task), "{task:?}");
                if let Some(job) = campaign.jobs[task.job].origin().needs {
                    assert!(shard.contains(&Task { job, part: 0 }));
                }
            }
        }
        // Only neighbouring shards repeat a training.
        let trained: usize = shards.iter().flatten().filter(|task| is_training(task)).count();
        assert!(
            trained < campaign.all::<compile::Training>().count() + count as usize,
            "{trained} trainings in {count} shards"
        );
        let most = shards.iter().map(Vec::len).max().unwrap();
        assert!(most <= dealt.len() / count as usize * 2 + 8, "{most} of {} tasks in one of {count}", dealt.len());
    }
}

/// Kubernetes' client is a script that keeps what it is given.
#[cfg(unix)]
#[test]
fn the_script_for_kubernetes_changes_no_image_and_keeps_the_folders_of_files() {
    use std::os::unix::fs::PermissionsExt;
    let place = tempfile::tempdir().unwrap();
    let client = place.path().join("kubectl");
    std::fs::write(&client, "#!/bin/sh\ncase $1 in apply) cat >>applied.yaml ;; esac\n").unwrap();
    std::fs::set_permissions(&client, std::fs::Permissions::from_mode(0o755)).unwrap();
    let call = |files: &[&str]| {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/cluster/kubernetes.sh");
        let path = format!("{}:{}", place.path().display(), std::env::var("PATH").unwrap());
        let mut command = std::process::Command::new(script);
        command.args(["falsify:0.1.16", "40"]).args(files).env("PATH", path).current_dir(place.path()).output().unwrap()
    };
    let output = call(&["a/mine.scn", "lib/streets.scn"]);
    assert!(output.status.success(), "{}", said(&output));
    let applied = std::fs::read_to_string(place.path().join("applied.yaml")).unwrap();
    for wanted in [
        "image: falsify:0.1.16\n",
        "completions: 40\n",
        "auto/40",
        "/scenarios/a/mine.scn]",
        "items: [{key: file0, path: a/mine.scn}, {key: file1, path: lib/streets.scn}]",
    ] {
        assert!(applied.contains(wanted), "{wanted} is not in {applied}");
    }
    assert!(!applied.contains("registry.example"), "{applied}");
    assert_eq!(call(&["../mine.scn"]).status.code(), Some(2));
}
