//! Tasks in a cache. Several folders for reports share it, on any file system, and none removes what another needs.

use std::path::Path;
use std::process::Output;
use std::time::Instant;

use crate::program::{command, error, falsify, falsify_with, report, said};

/// Writes a campaign of two trainings. Trained and random controllers are evaluated in one town, and the driver has a price: seven tasks.
fn write_campaign(folder: &Path) {
    let lib = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/lib");
    let text = format!(
        "edition 1\nimport \"{0}/paper.scn\"\nimport \"{0}/drivers.scn\"\nimport \"{0}/towns.scn\"\n\
         training quick = ppo(steps: 120, steps_per_update: 10, epochs: 1, environments: 2, hidden: [8])\n\
         campaign shared {{ vehicle: model3 body: suicidal spawn: ahead episode: thirty_seconds training: quick\n\
         train {{ towns: [harbour] drivers: [behavior] rewards: [r1, r2] runs: 1 }}\n\
         evaluate {{ towns: [village] drivers: [blind] pedestrians: [trained, random] episodes: 12 }} }}\n",
        lib.display()
    );
    std::fs::write(folder.join("shared.scn"), text).unwrap();
}

/// Runs the campaign, which must succeed.
fn run(folder: &Path, more: &[&str]) -> Output {
    let output = falsify(&[&["run", "shared.scn"], more].concat(), folder);
    assert!(output.status.success(), "{more:?}: {output:?}");
    output
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// The number of tasks in a cache.
fn tasks(cache: &Path) -> usize {
    report(&cache.join("tasks")).len()
}

#[test]
fn folders_for_reports_share_a_cache_and_none_takes_away_what_another_wants() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write_campaign(here);
    run(here, &["--out", "alone"]);
    run(here, &["--out", "one", "--cache", "cache"]);
    let second = run(here, &["--out", "two", "--cache", "cache"]);
    assert!(error(&second).contains("7 of 7 tasks were there already"), "{}", error(&second));
    let wanted = report(&here.join("alone/shared"));
    for out in ["one", "two"] {
        assert!(report(&here.join(out).join("shared")) == wanted, "{out} has other bytes");
        assert_eq!(names(&here.join(out)), [".falsify", "shared"]);
        assert_eq!(
            names(&here.join(out).join(".falsify")),
            ["README.txt", "learning", "lock"],
            "no tasks, and no drafts any more"
        );
    }
    assert_eq!(names(&here.join("cache")), ["README.txt", "campaigns", "claims", "lock", "tasks"]);

    // Each folder has its own campaigns.
    let status = |arguments: &[&str]| falsify(&[&["status"], arguments].concat(), here);
    assert!(said(&status(&["--out", "one", "--cache", "cache"])).contains("shared: finished"));
    let without = status(&["--out", "one"]);
    assert!(without.status.code() == Some(2) && error(&without).contains("--cache"), "{without:?}");
    assert_eq!(status(&["--out", "three", "--cache", "cache"]).status.code(), Some(2));
    let list = said(&falsify(&["run", "--list", "shared.scn", "--out", "three", "--cache", "cache"], here));
    assert!(list.contains("0 of 7 tasks to run, 7 to reuse"), "{list}");

    // The other folder still needs the tasks that one folder no longer needs.
    let other = ["--out", "two", "--cache", "cache", "--seed", "7", "--replace"];
    let replaced = said(&run(here, &other));
    assert!(replaced.replace("\n  ", " ").contains("the report that this one replaces (seed 1) said: "), "{replaced}");
    assert_eq!(tasks(&here.join("cache")), 14);
    let prune = |more: &[&str]| {
        let output = falsify(&[&["status", "--out", "two", "--cache", "cache", "--prune"], more].concat(), here);
        assert!(output.status.success(), "{output:?}");
        said(&output)
    };
    let told = prune(&[]);
    assert!(told.contains("removed 0 tasks") && told.contains("campaign shared of `"), "{told}");
    assert_eq!(tasks(&here.join("cache")), 14);
    std::fs::remove_dir_all(here.join("one")).unwrap();
    let told = prune(&[]);
    assert!(told.contains("removed 0 tasks") && told.contains("--prune --gone removes their tasks"), "{told}");
    let told = prune(&["--gone"]);
    assert!(told.contains("removed 7 tasks"), "{told}");
    assert_eq!(tasks(&here.join("cache")), 7);
    let again = run(here, &other);
    assert!(error(&again).contains("7 of 7 tasks were there already"), "{}", error(&again));
    let told = prune(&["--gone"]);
    assert!(told.contains("removed 0 tasks") && !told.contains("of `"), "{told}");
}

#[test]
fn a_cache_may_be_the_cells_of_another_folder_and_is_left_whole() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write_campaign(here);
    run(here, &["--out", "old"]);
    let output = run(here, &["--out", "new", "--cache", "old/.falsify"]);
    assert!(error(&output).contains("7 of 7 tasks were there already"), "{}", error(&output));
    run(here, &["--out", "new", "--cache", "old/.falsify", "--seed", "2", "--replace"]);
    let pruned = said(&falsify(&["status", "--out", "new", "--cache", "old/.falsify", "--prune"], here));
    assert!(pruned.contains("removed 0 tasks"), "{pruned}");
    run(here, &["--out", "old", "--seed", "3", "--replace"]);
    // A cache that is the reports' own folder of tasks holds the same tasks under any spelling of its path.
    let named = run(here, &["--out", "old", "--seed", "3", "--cache", "new/../old/.falsify"]);
    assert!(error(&named).contains("7 of 7 tasks were there already"), "{}", error(&named));
    let pruned = said(&falsify(&["status", "--out", "old", "--prune"], here));
    assert!(pruned.contains("removed 7 tasks") && pruned.contains("campaign shared of `"), "{pruned}");
    assert_eq!(tasks(&here.join("old/.falsify")), 14);
}

#[test]
fn shards_may_leave_their_cells_in_caches() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write_campaign(here);
    run(here, &["--out", "whole"]);
    run(here, &["--out", "a", "--cache", "scratch", "--shard", "0/2"]);
    run(here, &["--out", "b", "--shard", "1/2"]);
    let merge = |from: [&str; 2]| {
        falsify(&["merge", "shared.scn", "--out", "merged", "--cache", "merging", "--from", from[0], from[1]], here)
    };
    let wrong = merge(["a", "b"]);
    assert_eq!(wrong.status.code(), Some(9), "{wrong:?}");
    assert!(error(&wrong).contains("there are no tasks in `a`"), "{}", error(&wrong));
    let merged = merge(["scratch", "b"]);
    assert!(merged.status.success(), "{merged:?}");
    assert!(report(&here.join("merged/shared")) == report(&here.join("whole/shared")), "it has other bytes");
}

#[test]
fn a_folder_that_is_no_cache_is_refused_and_left_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write_campaign(here);
    std::fs::write(here.join("file"), "mine").unwrap();
    std::fs::create_dir(here.join("thesis")).unwrap();
    std::fs::write(here.join("thesis/lock"), "mine").unwrap();
    std::fs::write(here.join("thesis/chapter.tex"), "mine").unwrap();
    for (cache, code, why) in [
        ("file", 2, "the cache `file` is a file"),
        ("file/below", 6, "cannot write to the folder `file/below`"),
        ("thesis", 2, "holds other things, such as `chapter.tex`"),
        ("out/cache", 2, "is in the folder for reports, `out`"),
        ("out", 2, "is in the folder for reports, `out`"),
        ("/proc/falsify", 6, "cannot write to the folder `/proc/falsify`"),
    ] {
        let output = falsify(&["run", "shared.scn", "--out", "out", "--cache", cache], here);
        assert_eq!(output.status.code(), Some(code), "{cache}: {output:?}");
        assert!(error(&output).contains(why), "{cache}: {}", error(&output));
        assert!(!here.join("out/shared").exists() && !here.join("out/shared-partial").exists());
    }
    assert_eq!(names(&here.join("thesis")), ["chapter.tex", "lock"]);
    assert_eq!(std::fs::read_to_string(here.join("thesis/lock")).unwrap(), "mine");
    let nowhere = falsify(&["status", "--out", "out", "--stored", "--cache", "nowhere"], here);
    assert!(nowhere.status.code() == Some(2) && error(&nowhere).contains("does not exist"), "{nowhere:?}");
    // A folder of one of our names with files of others is theirs.
    std::fs::create_dir_all(here.join("box/work-2026")).unwrap();
    std::fs::write(here.join("box/work-2026/a.tex"), "thesis").unwrap();
    std::fs::create_dir_all(here.join("files/tasks")).unwrap();
    std::fs::write(here.join("files/tasks/todo"), "mine").unwrap();
    for (cache, entry) in [("box", "work-2026"), ("files", "tasks")] {
        for command in [&["run", "shared.scn"][..], &["status", "--prune"]] {
            let output = falsify(&[command, &["--out", "out", "--cache", cache]].concat(), here);
            let why = format!("holds other things, such as `{entry}`");
            assert!(output.status.code() == Some(2) && error(&output).contains(&why), "{output:?}");
        }
    }
    assert!(here.join("box/work-2026/a.tex").exists() && here.join("files/tasks/todo").exists());
    // A folder whose creation as a cache was interrupted is accepted.
    std::fs::create_dir_all(here.join("begun/tasks")).unwrap();
    run(here, &["--out", "out", "--cache", "begun"]);
}

#[test]
#[cfg(unix)]
fn what_others_put_into_a_cache_stays() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write_campaign(here);
    run(here, &["--out", "out", "--cache", "cache"]);
    run(here, &["--out", "beside"]);
    let (task, wants) = ("0123456789abcdef0123456789abcdef", here.join("theirs/old.json"));
    std::fs::create_dir_all(here.join("theirs")).unwrap();
    std::fs::write(here.join("theirs").join(task), "mine").unwrap();
    let own = std::fs::read_dir(here.join("cache/campaigns")).unwrap().next().unwrap().unwrap().path();
    let known = std::fs::read_to_string(own.join("shared.json")).unwrap();
    std::fs::write(&wants, known.replace("/out\"", "/gone\"")).unwrap();
    for store in ["cache", "beside/.falsify"] {
        let store = here.join(store);
        std::fs::create_dir(store.join("work-2026")).unwrap();
        std::fs::write(store.join("work-2026/a.tex"), "thesis").unwrap();
    }
    for place in [&["--out", "out", "--cache", "cache"][..], &["--out", "beside"]] {
        let output = falsify(&[&["status", "--prune", "--gone"], place].concat(), here);
        assert!(output.status.success(), "{output:?}");
        assert!(said(&output).contains("removed 0 tasks"), "{output:?}");
        run(here, place);
    }
    assert!(here.join("theirs").join(task).exists() && wants.exists());
    assert!(["cache", "beside/.falsify"].iter().all(|store| here.join(store).join("work-2026/a.tex").exists()));
}

/// A stranger's folder may have links in place of any file or folder of ours. Nothing behind them is read, written or removed.
#[test]
#[cfg(unix)]
fn no_link_in_a_store_is_followed() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write_campaign(here);
    run(here, &["--out", "known"]);
    let store = here.join("known/.falsify");
    let task = report(&store.join("tasks")).into_keys().next().unwrap();
    let task = task.file_name().unwrap().to_str().unwrap().to_owned();
    std::fs::create_dir_all(here.join("home/sub")).unwrap();
    let precious = || {
        for name in ["file", "shared.json", "sub/shared.json", &task] {
            std::fs::write(here.join("home").join(name), "precious").unwrap();
        }
    };
    precious();
    let wanted = report(&here.join("home"));
    let in_tasks = format!("tasks/{}", &task[..2]);
    let places = [
        "",
        "lock",
        "claims",
        "claims/TASK",
        "README.txt",
        "campaigns",
        "campaigns/shared.json",
        "tasks",
        &in_tasks,
        &format!("{in_tasks}/{task}"),
        "learning",
        "learning/shared",
        "learning/shared/r1-harbour-behavior-0.csv",
        "work-abcdef",
        "work-abcdef/lock",
    ];
    for place in places {
        for target in ["file", "sub", "absent"] {
            let out = here.join("reports");
            let _ = std::fs::remove_dir_all(&out);
            let link = if place.is_empty() {
                out.join(".falsify")
            } else {
                out.join(".falsify").join(place.replace("TASK", &task))
            };
            std::fs::create_dir_all(link.parent().unwrap()).unwrap();
            std::os::unix::fs::symlink(here.join("home").join(target), &link).unwrap();
            for command in [
                &["run", "shared.scn"][..],
                &["run", "shared.scn", "--fresh"],
                &["run", "shared.scn", "--list"],
                &["run", "shared.scn", "--out", "other", "--cache", "reports/.falsify"],
                &["run", "shared.scn", "--shard", "1/2"],
                &["status"],
                &["status", "--stored"],
                &["status", "--prune", "--gone"],
                &["merge", "shared.scn", "--out", "merged", "--from", "reports"],
            ] {
                // A cache that the user names may be a link.
                if place.is_empty() && command.contains(&"--cache") {
                    continue;
                }
                let output = falsify(command, here);
                assert_eq!(output.status.code(), Some(2), "{place} to {target}: {command:?}: {output:?}");
                assert!(error(&output).contains("is a link"), "{place}: {output:?}");
            }
            assert!(report(&here.join("home")) == wanted, "{place} to {target}");
        }
    }
}

#[test]
fn a_result_of_another_task_is_not_used() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let text = "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
        spawn near { bearing: -30 deg .. 30 deg  distance: 7 m .. 25 m }\nepisode e { ticks: 120  hold: 10 }\n\
        campaign mine { vehicle: model3 body: plausible spawn: near episode: e\n\
        evaluate { towns: [harbour] drivers: [blind, idm] pedestrians: [intercept] episodes: 40 } }\n";
    std::fs::write(here.join("s.scn"), text).unwrap();
    let gate = ["run", "s.scn", "--fail-if", "collision_rate > 0.01 and driver == blind"];
    assert_eq!(falsify(&gate, here).status.code(), Some(7));
    let stored = report(&here.join("reports/.falsify/tasks"));
    let of = |driver: &str| {
        let has = |bytes: &[u8]| String::from_utf8_lossy(bytes).contains(&format!("against {driver}"));
        here.join("reports/.falsify/tasks").join(stored.iter().find(|(_, bytes)| has(bytes)).unwrap().0)
    };
    let copies = || std::fs::copy(of("idm"), of("blind")).unwrap();
    copies();
    let list = said(&falsify(&["run", "s.scn", "--list"], here));
    assert!(list.contains("of another task"), "{list}");
    let merged = falsify(&["merge", "s.scn", "--out", "merged", "--from", "reports"], here);
    assert_eq!(merged.status.code(), Some(9), "{merged:?}");
    assert!(error(&merged).contains("holds the result of another task, `evaluate"), "{merged:?}");
    let again = falsify(&gate, here);
    assert_eq!(again.status.code(), Some(7), "{again:?}");
    assert!(error(&again).contains("holds the result of another task, `evaluate"), "{}", error(&again));
    assert!(error(&again).contains("3 of 4 results were stored before"), "{}", error(&again));
    let fresh = falsify(&[&gate[..], &["--fresh"]].concat(), here);
    assert!(!error(&fresh).contains("stored before"), "{}", error(&fresh));
}

#[test]
fn a_setting_or_a_variable_names_the_cache() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    write_campaign(here);
    std::fs::write(here.join("falsify.toml"), "cache = \"from the file\"\n").unwrap();
    run(here, &[]);
    assert_eq!(tasks(&here.join("from the file")), 7);
    for place in [&["status"][..], &["status", "reports"], &["status", "reports/shared"]] {
        assert!(said(&falsify(place, here)).contains("shared: finished"), "{place:?}");
    }
    assert!(said(&falsify(&["status", "reports/shared", "--stored"], here)).contains("campaign shared: "));
    let nowhere = falsify(&["status", "shared.scn"], here);
    assert!(nowhere.status.code() == Some(2) && error(&nowhere).contains("no campaign was run for `shared.scn`"));
    assert!(said(&falsify(&["status", "--stored"], here)).contains("campaign shared: 7 of 7 tasks"));
    let variables = [("FALSIFY_CACHE", "of the variable")];
    let list = said(&falsify_with(&["run", "--list", "shared.scn"], here, &variables));
    assert!(list.contains("7 of 7 tasks to run, 0 to reuse"), "{list}");
}

/// A folder on another file system than this one, if one exists.
#[cfg(unix)]
fn elsewhere(here: &Path) -> Option<tempfile::TempDir> {
    use std::os::unix::fs::MetadataExt;
    let device = |path: &Path| std::fs::metadata(path).map(|data| data.dev()).ok();
    let candidates = ["/dev/shm", "/run/user/0", "/tmp", "/var/tmp", env!("CARGO_TARGET_TMPDIR")].map(Path::new);
    let mut others = candidates.into_iter().filter(|path| device(path).is_some() && device(path) != device(here));
    others.find_map(|path| tempfile::tempdir_in(path).ok())
}

#[test]
#[cfg(unix)]
fn cells_and_reports_may_be_on_two_file_systems_and_a_kill_leaves_whole_reports() {
    const KILLS: usize = 8;
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let other = elsewhere(here).unwrap_or_else(|| {
        loud!("only one file system can be written to here, so the test of two is one of two folders");
        tempfile::tempdir().unwrap()
    });
    write_campaign(here);
    let begun = Instant::now();
    run(here, &["--out", "alone"]);
    let time = begun.elapsed();
    let wanted = report(&here.join("alone/shared"));
    let there = other.path().to_str().unwrap();
    for (out, cache) in [("near", format!("{there}/tasks")), (&*format!("{there}/far"), "tasks".into())] {
        let mut kills = 0;
        loop {
            let mut command = command();
            command.args(["run", "shared.scn", "--checkpoint", "0.001", "--progress", "none", "--out", out, "--cache"]);
            let mut child = command.arg(&cache).current_dir(here).spawn().unwrap();
            if kills < KILLS {
                // The time of the kill is what this test varies. To wait for an event would let the program choose the time.
                std::thread::sleep(time.mul_f64((kills + 1) as f64 / (KILLS + 1) as f64));
                let _ = child.kill();
                kills += 1;
            }
            let ended = child.wait().unwrap().success();
            let place = here.join(out).join("shared");
            assert!(!place.exists() || report(&place) == wanted, "not all of it stands");
            if ended && kills == KILLS {
                break;
            }
        }
        assert!(report(&here.join(out).join("shared")) == wanted, "{out} has other bytes");
        assert_eq!(names(&here.join(out)), [".falsify", "shared"]);
    }
}

/// Two blocks with the same episodes share their task: what one of them made was not stored before.
#[test]
fn what_two_blocks_of_a_run_share_was_made_by_it() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"edition 1
import "std/pedestrians.scn"
import "std/drivers.scn"
import "std/towns.scn"
spawn near { bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }
episode e { ticks: 60  hold: 10 }
campaign c { vehicle: model3  body: pursuer  spawn: near  episode: e
  evaluate { towns: [harbour]  drivers: [idm]  pedestrians: [intercept]  episodes: 10 }
  evaluate { towns: [harbour]  drivers: [idm, blind]  pedestrians: [intercept]  episodes: 12 } }
"#;
    std::fs::write(folder.path().join("twice.scn"), text).unwrap();
    let run = falsify(&["run", "twice.scn"], folder.path());
    assert!(run.status.success() && !error(&run).contains("stored before"), "{}", error(&run));
    let again = falsify(&["run", "twice.scn"], folder.path());
    assert!(error(&again).contains("5 of 5 results were stored before"), "{}", error(&again));
}
