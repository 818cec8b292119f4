//! No input takes the machine, no interruption panics, and nothing that cannot be read is called damaged. The limits are those of one process
//! of a shared machine: 700 MB of addresses and some seconds.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::program::{self, error, said};
use crate::samples::samples;
use needs::needs;

/// The most time that a command may take, in a debug build on a busy machine. It separates an answer from a hang.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs `falsify` in a folder under a limit of the shell, and fails when it takes too long.
pub fn limited(limit: &str, arguments: &[&str], folder: &Path) -> Output {
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("{limit}; exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_falsify")]).args(arguments);
    shell.envs(program::command().get_envs().filter_map(|(name, value)| Some((name, value?))));
    for (name, value) in program::command().get_envs() {
        if value.is_none() {
            shell.env_remove(name);
        }
    }
    let mut child = shell.current_dir(folder).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > PATIENCE {
            child.kill().unwrap();
            panic!("{arguments:?} takes more than {PATIENCE:?}");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap()
}

/// The same within 700 MB.
fn small(arguments: &[&str], folder: &Path) -> Output {
    limited("ulimit -v 700000", arguments, folder)
}

/// A map of one road with these pieces, length (m) and lanes.
fn map(pieces: &str, length: &str, lanes: &str) -> String {
    format!(
        r#"<OpenDRIVE><road id="1" length="{length}" junction="-1"><planView>{pieces}</planView><lanes><laneSection s="0"><right>{lanes}</right></laneSection></lanes></road></OpenDRIVE>"#
    )
}

const LANE: &str = r#"<lane id="-1" type="driving"><width a="3.5"/></lane>"#;
const LINE: &str = r#"<geometry s="0" x="0" y="0" hdg="0" length="100000"><line/></geometry>"#;

#[test]
fn maps_that_are_too_large_are_refused_and_the_others_are_drawn_soon() {
    let place = tempfile::tempdir().unwrap();
    let lanes = |widths: &str| -> String {
        (1..=1000).map(|id| format!(r#"<lane id="-{id}" type="driving">{widths}</lane>"#)).collect()
    };
    let widths: String = (0..100).map(|step| format!(r#"<width sOffset="{step}.25" a="3"/>"#)).collect();
    let cubic = r#"<paramPoly3 pRange="normalized" aU="0" bU="1" cU="0" dU="0" aV="0" bV="0" cV="1" dV="0"/>"#;
    let pieces = |length: &str| -> String {
        (0..3000)
            .map(|s| format!(r#"<geometry s="{s}" x="0" y="0" hdg="0" length="{length}">{cubic}</geometry>"#))
            .collect()
    };
    let arcs: String = (0..100)
        .map(|id| format!(r#"<road id="{id}" length="1000000" junction="-1"><planView><geometry s="0" x="0" y="0" hdg="0" length="1000000"><arc curvature="0.01"/></geometry></planView><lanes><laneSection s="0"><right>{LANE}</right></laneSection></lanes></road>"#))
        .collect();
    let attributes: String = (0..100_000).map(|number| format!(r#" a{number}="""#)).collect();
    let spiral =
        r#"<geometry s="0" x="0" y="0" hdg="0" length="100000"><spiral curvStart="0" curvEnd="1e9"/></geometry>"#;
    for (name, text, refused) in [
        ("spiral", map(spiral, "100000", LANE), None),
        ("lanes", map(LINE, "100000", &lanes(r#"<width a="3.5"/>"#)), Some("metres of lanes")),
        ("widths", map(LINE, "100", &lanes(&widths)), Some("terms of lane widths")),
        ("long-cubics", map(&pieces("1e9"), "100", LANE), Some("no usable road")),
        ("cubics", map(&pieces("1e5"), "100", LANE), Some("places on curves")),
        ("arcs", format!("<OpenDRIVE>{arcs}</OpenDRIVE>"), Some("metres of lanes")),
        ("attributes", format!("<OpenDRIVE{attributes}/>"), Some("attributes of one element")),
        ("elements", format!("<OpenDRIVE>{}</OpenDRIVE>", "<a/>".repeat(5_000_000)), Some("nodes limit")),
        ("bends", map(&LINE.replace("<line/>", r#"<arc curvature="0.05"/>"#), "100000", LANE), None),
    ] {
        let file = format!("{name}.xodr");
        fs::write(place.path().join(&file), text).unwrap();
        let output = small(&["preview", &file], place.path());
        match refused {
            Some(reason) => {
                assert_eq!(output.status.code(), Some(3), "{name}: {output:?}");
                assert!(error(&output).contains(reason), "{name}: {}", error(&output));
            }
            None => {
                assert_eq!(output.status.code(), Some(0), "{name}: {output:?}");
                let page = fs::metadata(place.path().join(format!("{name}.preview.html"))).unwrap();
                assert!(page.len() < 20 << 20, "{name}: {} bytes", page.len());
            }
        }
    }
}

#[test]
fn scenarios_that_are_refused_cost_little() {
    let place = tempfile::tempdir().unwrap();
    let longest = 4 << 20;
    for (name, line) in [("editions", "edition 1\n"), ("junk", "§$%&? \n"), ("forms", "x a = b()\n")] {
        let text = line.repeat(longest / line.len());
        let file = format!("{name}.scn");
        fs::write(place.path().join(&file), text).unwrap();
        // Optimised this takes two seconds. The time is that of the processor, so other work on the machine does not count.
        let output = limited("ulimit -v 1000000; ulimit -t 20", &["check", &file], place.path());
        assert_eq!(output.status.code(), Some(3), "{name}: {:?}", output.status);
        assert!(error(&output).contains("more"), "{name}: {}", error(&output));
    }
}

#[test]
fn pipes_and_devices_are_refused_at_once() {
    let place = tempfile::tempdir().unwrap();
    assert!(Command::new("mkfifo").arg(place.path().join("pipe")).status().unwrap().success());
    fs::write(place.path().join("import.scn"), "edition 1\nimport \"pipe\"\n").unwrap();
    fs::write(place.path().join("map.scn"), "edition 1\ntown t = opendrive(file: \"pipe\")\n").unwrap();
    fs::write(place.path().join("model.scn"), "edition 1\ndriver p = onnx(model: \"pipe\")\n").unwrap();
    for arguments in [
        ["check", "pipe"],
        ["preview", "pipe"],
        ["fmt", "pipe"],
        ["check", "import.scn"],
        ["check", "map.scn"],
        ["check", "model.scn"],
        ["preview", "/dev/zero"],
        ["check", "/dev/zero"],
    ] {
        let output = small(&arguments, place.path());
        assert!(matches!(output.status.code(), Some(2 | 3)), "{arguments:?}: {output:?}");
        assert!(error(&output).contains("only regular files are read"), "{arguments:?}: {}", error(&output));
    }
}

#[test]
fn a_network_that_would_hang_or_abort_is_refused() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/onnx");
    let place = tempfile::tempdir().unwrap();
    for name in ["hang_185_bytes", "abort_132_bytes"] {
        let model = models.join(format!("{name}.onnx"));
        fs::write(place.path().join("a.scn"), format!("edition 1\ndriver p = onnx(model: \"{}\")\n", model.display()))
            .unwrap();
        let output = small(&["check", "a.scn"], place.path());
        assert_eq!(output.status.code(), Some(3), "{name}: {output:?}");
    }
}

#[test]
fn files_that_are_no_scenarios_are_not_quoted() {
    let place = tempfile::tempdir().unwrap();
    let inner = place.path().join("inner");
    fs::create_dir(&inner).unwrap();
    fs::write(place.path().join("secret"), "TOKEN=abc123\nroot:x:0:0\n").unwrap();
    std::os::unix::fs::symlink(place.path().join("secret"), inner.join("link.scn")).unwrap();
    for import in ["../secret", "link.scn", "/proc/self/environ"] {
        fs::write(inner.join("a.scn"), format!("edition 1\nimport \"{import}\"\n")).unwrap();
        for format in ["human", "json"] {
            let output =
                program::falsify_with(&["check", "a.scn", "--format", format], &inner, &[("SECRET", "abc123")]);
            let all = format!("{}{}", error(&output), said(&output));
            assert_eq!(output.status.code(), Some(3), "{all}");
            assert!(!all.contains("abc123") && !all.contains("root:x"), "{import}: {all}");
            assert!(all.contains("it is not a scenario"), "{all}");
        }
    }
}

/// A campaign of one training and two evaluations that takes a moment.
const SCENARIO: &str = r#"
edition 1
import "std/paper.scn"
import "std/rewards.scn"
import "std/drivers.scn"
import "std/towns.scn"
training quick = ppo(steps: 120, steps_per_update: 10, epochs: 1, environments: 2, hidden: [8])
campaign cut {
  vehicle: model3  body: suicidal  spawn: ahead  episode: thirty_seconds  training: quick
  train { towns: [harbour] drivers: [behavior] rewards: [r1] runs: 1 }
  evaluate { towns: [village] drivers: [blind] pedestrians: [trained, random] episodes: 12 }
}
"#;

fn campaign() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("cut.scn"), SCENARIO).unwrap();
    place
}

/// The file of the first task whose header has these words.
fn task(folder: &Path, words: &str) -> std::path::PathBuf {
    let folders = fs::read_dir(folder.join(".falsify/tasks")).unwrap().flatten();
    let mut files = folders.flat_map(|folder| fs::read_dir(folder.path()).unwrap().flatten()).map(|entry| entry.path());
    let has = |path: &std::path::PathBuf| String::from_utf8_lossy(&fs::read(path).unwrap()).contains(words);
    files.find(has).unwrap_or_else(|| panic!("no task of {words}"))
}

#[test]
fn episodes_without_their_training_make_a_partial_report() {
    let place = campaign();
    assert!(program::falsify(&["run", "cut.scn", "--out", "out"], place.path()).status.success());
    fs::remove_file(task(&place.path().join("out"), "train r1")).unwrap();
    let merged = program::falsify(&["merge", "cut.scn", "--partial", "--from", "out", "--out", "merged"], place.path());
    assert_eq!(merged.status.code(), Some(5), "{merged:?}");
    let report = place.path().join("merged/cut-partial");
    assert_eq!(fs::read_to_string(report.join("episodes.csv")).unwrap().lines().count(), 1 + 24);
    let limited = program::falsify(&["run", "cut.scn", "--out", "out", "--max-ticks", "1"], place.path());
    assert_eq!(limited.status.code(), Some(5), "{limited:?}");
}

#[test]
fn a_task_that_cannot_be_read_is_neither_damaged_nor_replaced() {
    let place = campaign();
    assert!(program::falsify(&["run", "cut.scn", "--out", "out"], place.path()).status.success());
    // The tests may run as a user who may read everything; a folder cannot be read as a file by any user.
    let file = task(&place.path().join("out"), "train r1");
    fs::remove_file(&file).unwrap();
    fs::create_dir(&file).unwrap();
    let output = program::falsify(&["run", "cut.scn", "--out", "out"], place.path());
    assert_eq!(output.status.code(), Some(6), "{output:?}");
    let text = error(&output);
    assert!(text.contains("cannot read") && text.contains("is left as it is") && !text.contains("damaged"), "{text}");
    assert!(file.is_dir());
    let list = program::falsify(&["run", "cut.scn", "--out", "out", "--list"], place.path());
    assert!(said(&list).contains("[run: unreadable]"), "{}", said(&list));
}

#[test]
fn under_any_limit_there_is_the_right_result_or_a_clear_error() {
    let place = campaign();
    let arguments = |out: &'static str| ["run", "cut.scn", "--threads", "1", "--progress", "none", "--out", out];
    assert!(limited("true", &arguments("free"), place.path()).status.success());
    let episodes = |out: &str| fs::read(place.path().join(out).join("cut/episodes.csv")).unwrap();
    let wanted = episodes("free");
    for limit in [
        "-n 4",
        "-n 6",
        "-n 12",
        "-n 31",
        "-n 40",
        "-v 60000",
        "-v 100000",
        "-v 200000",
        "-v 210000",
        "-v 250000",
        "-v 400000",
        "-v 700000",
    ] {
        let output = limited(&format!("ulimit {limit}"), &arguments("limited"), place.path());
        match output.status.code() {
            Some(0) => assert!(episodes("limited") == wanted, "{limit}"),
            Some(1 | 2 | 6) => {
                assert!(error(&output).contains("error:") && !error(&output).contains("bug"), "{limit}: {output:?}");
            }
            // The loader of the system needs files, too.
            Some(127) => assert!(error(&output).contains("loading shared libraries"), "{limit}: {output:?}"),
            // Without memory for its own start the system ends it.
            other => assert!(
                ["-v 60000", "-v 100000"].contains(&limit) || error(&output).contains("memory allocation"),
                "{limit}: {other:?} {output:?}"
            ),
        }
        let _ = fs::remove_dir_all(place.path().join("limited"));
    }
}

/// The superuser has no limit of processes, so the program runs as another user. As that user this test sees its own processes alone, since
/// no other has its number.
#[needs(another_user)]
#[test]
fn under_any_limit_of_processes_there_is_the_right_result_or_a_clear_error() {
    const USER: &str = "--reuid=3989654";
    let as_user = |words: &[&str]| Command::new("setpriv").args([USER, "--clear-groups"]).args(words).output();
    use std::os::unix::fs::PermissionsExt;
    let place = campaign();
    for path in [place.path().to_path_buf(), place.path().join("cut.scn")] {
        fs::set_permissions(path, fs::Permissions::from_mode(0o777)).unwrap();
    }
    // The folder of the build may be closed to the other user, and a copy of the program is not. A link needs no room.
    let program = place.path().join("falsify");
    if fs::hard_link(env!("CARGO_BIN_EXE_falsify"), &program).is_err() {
        fs::copy(env!("CARGO_BIN_EXE_falsify"), &program).unwrap();
    }
    let run = |limits: &str, out: &str| {
        let (folder, out) = (place.path().display().to_string(), place.path().join(out).display().to_string());
        let script =
            format!("cd {folder} && {limits} exec ./falsify run cut.scn --threads 2 --progress none --out {out}");
        as_user(&["timeout", "-s", "KILL", "60", "bash", "-c", &script]).unwrap()
    };
    let free = run("", "free");
    assert!(free.status.success(), "{free:?}");
    let episodes = |out: &str| fs::read(place.path().join(out).join("cut/episodes.csv")).unwrap();
    for limits in [
        "ulimit -u 3;",
        "ulimit -u 4;",
        "ulimit -u 5;",
        "ulimit -u 6;",
        "ulimit -u 7;",
        "ulimit -u 8;",
        "ulimit -u 7 -n 40;",
        "ulimit -u 6 -v 700000;",
        "ulimit -u 5 -v 700000 -n 40;",
    ] {
        let output = run(limits, "limited");
        match output.status.code() {
            Some(0) => assert!(episodes("limited") == episodes("free"), "{limits}"),
            Some(1 | 2 | 6) => {
                assert!(error(&output).contains("error:") && !error(&output).contains("bug"), "{limits}: {output:?}");
            }
            // Without memory the system ends it with its reason.
            other => assert!(error(&output).contains("memory allocation"), "{limits}: {other:?} {output:?}"),
        }
        let _ = fs::remove_dir_all(place.path().join("limited"));
    }
}

#[test]
fn verify_sees_every_file_of_a_report_and_survives_damaged_tables() {
    let place = campaign();
    assert!(program::falsify(&["run", "cut.scn", "--out", "out"], place.path()).status.success());
    let report = place.path().join("out/cut");
    let verify = || program::falsify(&["replay", "--all", "out/cut"], place.path());
    assert_eq!(verify().status.code(), Some(0), "{:?}", verify());
    for name in ["metrics.csv", "results.parquet", "summary.md", "report.html"] {
        let whole = fs::read(report.join(name)).unwrap();
        let mut damaged = whole.clone();
        let middle = damaged.len() / 2;
        damaged[middle] ^= 1;
        fs::write(report.join(name), &damaged).unwrap();
        let output = verify();
        assert_eq!(output.status.code(), Some(8), "{name}: {output:?}");
        assert!(error(&output).contains(&format!("`{name}` is not as it was written")), "{name}: {}", error(&output));
        fs::write(report.join(name), &whole).unwrap();
    }
    let whole = fs::read(report.join("episodes.parquet")).unwrap();
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    for _ in 0..40 {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mut damaged = whole.clone();
        // The description of the columns is at the end.
        let place = whole.len() - 1 - (state >> 33) as usize % (whole.len() / 2);
        damaged[place] = (state >> 8) as u8;
        fs::write(report.join("episodes.parquet"), &damaged).unwrap();
        let output = verify();
        let code = output.status.code();
        assert!(matches!(code, Some(2 | 8)) || code == Some(0) && damaged == whole, "byte {place}: {output:?}");
    }
}

/// A campaign against a program that is no driver.
fn with_driver(command: &str) -> tempfile::TempDir {
    let place = campaign();
    let text = format!(
        "edition 1\nimport \"std/paper.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
         driver mine = external(command: \"{command}\", timeout: 2 s)\n\
         campaign outside {{ vehicle: model3 body: suicidal spawn: ahead episode: thirty_seconds\n\
         evaluate {{ towns: [harbour] drivers: [mine] pedestrians: [random] episodes: 1 }} }}\n"
    );
    fs::write(place.path().join("outside.scn"), text).unwrap();
    place
}

#[test]
fn a_process_that_leaves_the_group_of_its_driver_ends_with_it() {
    let place = with_driver("sh driver.sh");
    // The second one keeps neither the group nor the environment, by which it could be known.
    let sleep = "sleep 4321.75 >/dev/null 2>&1 </dev/null &\n";
    let script = format!("setsid {sleep}env -i setsid {sleep}sleep 4321.75\n");
    fs::write(place.path().join("driver.sh"), script).unwrap();
    let output = program::falsify(&["run", "outside.scn", "--allow-external", "--out", "out"], place.path());
    assert_eq!(output.status.code(), Some(5), "{output:?}");
    let left = fs::read_dir("/proc").unwrap().flatten().filter(|entry| {
        let command = fs::read(entry.path().join("cmdline")).unwrap_or_default();
        command.windows(7).any(|part| part == b"4321.75") && !command.windows(6).any(|part| part == b"setsid")
    });
    assert_eq!(left.count(), 0);
}

#[test]
fn a_program_that_lacks_the_python_package_says_what_installs_it() {
    let place = with_driver("sh falsify_av.sh sumo");
    let text = "echo \"ModuleNotFoundError: No module named 'falsify_av'\" >&2\nexit 1\n";
    fs::write(place.path().join("falsify_av.sh"), text).unwrap();
    let output = program::falsify(&["run", "outside.scn", "--allow-external", "--out", "out"], place.path());
    assert_eq!(output.status.code(), Some(5), "{output:?}");
    assert!(error(&output).contains("not installed: `pip install './python[sumo]'` in a clone"), "{output:?}");
}

#[test]
fn a_check_needs_300_mb_of_addresses() {
    let limited =
        format!("ulimit -v 300000; exec {} check scenarios/studies/learning.scn", env!("CARGO_BIN_EXE_falsify"));
    let here = crate::repository();
    let output = std::process::Command::new("sh").args(["-c", &limited]).current_dir(here).output().unwrap();
    assert!(output.status.success(), "{output:?}");
}

#[test]
fn the_messages_of_a_driver_are_bounded() {
    let place = with_driver("sh driver.sh");
    fs::write(place.path().join("driver.sh"), "echo first >&2\nhead -c 20000000 /dev/zero | tr '\\0' x >&2\n").unwrap();
    let output = program::falsify(&["run", "outside.scn", "--allow-external", "--out", "out"], place.path());
    assert_eq!(output.status.code(), Some(5), "{:?}", output.status);
    let text = error(&output);
    assert!(text.contains("first") && text.contains("further messages of programs are left out"));
    assert!(text.len() < 3 << 19, "{} bytes", text.len());
}

#[test]
fn processes_with_one_cache_that_are_interrupted_end_in_order() {
    let place = campaign();
    assert!(program::falsify(&["run", "cut.scn", "--out", "free"], place.path()).status.success());
    let wanted = fs::read(place.path().join("free/cut/episodes.csv")).unwrap();
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    for turn in 0..samples(3, 12) {
        let start = |out: &str| {
            let mut command = program::command();
            command.args([
                "run",
                "cut.scn",
                "--out",
                out,
                "--cache",
                "cache",
                "--checkpoint",
                "0.001",
                "--threads",
                "1",
            ]);
            command.current_dir(place.path()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
        };
        let _ = fs::remove_dir_all(place.path().join("cache"));
        let (first, second) = (start("one"), start("two"));
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        // The time of the signal is what this test varies.
        std::thread::sleep(Duration::from_millis(20 + (state >> 33) % 400));
        let signal = if turn % 2 == 0 { "-INT" } else { "-TERM" };
        let _ = Command::new("kill").args([signal, &first.id().to_string()]).status().unwrap();
        for child in [first, second] {
            let output = child.wait_with_output().unwrap();
            assert!(matches!(output.status.code(), Some(0 | 130)) || output.status.code().is_none(), "{output:?}");
        }
        let output = program::falsify(&["run", "cut.scn", "--out", "one", "--cache", "cache"], place.path());
        assert!(output.status.success(), "{output:?}");
        assert!(fs::read(place.path().join("one/cut/episodes.csv")).unwrap() == wanted, "after {} signals", turn + 1);
    }
}

/// A driver that needs 50 ms for every tick, so that an update of the training takes minutes.
#[needs(python)]
#[test]
fn a_slow_training_answers_a_signal_and_its_limit() {
    let place = campaign();
    let driver = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/external/my_av.py");
    let driver = fs::read_to_string(driver).unwrap().replace("import json, math, sys", "import json, math, sys, time");
    let slow = driver.replace("for line in sys.stdin:\n", "for line in sys.stdin:\n    time.sleep(0.05)\n");
    assert!(slow.contains("time.sleep"));
    fs::write(place.path().join("slow.py"), slow).unwrap();
    let text = "edition 1\nimport \"std/paper.scn\"\nimport \"std/rewards.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
                driver mine = external(command: \"python3 slow.py\")\n\
                campaign outside { vehicle: model3 body: suicidal spawn: ahead episode: thirty_seconds training: ppo_paper\n\
                train { towns: [harbour] drivers: [mine] rewards: [r1] runs: 1 } }\n";
    fs::write(place.path().join("outside.scn"), text).unwrap();
    let start = |more: &[&str]| {
        let mut command = program::command();
        command.args(["run", "outside.scn", "--allow-external", "--out", "out"]).args(more);
        command.current_dir(place.path()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let begun = Instant::now();
    let limited = start(&["--task-time", "2"]).wait_with_output().unwrap();
    assert_eq!(limited.status.code(), Some(5), "{limited:?}");
    assert!(error(&limited).contains("not finished within the 2 s"), "{limited:?}");
    assert!(begun.elapsed() < Duration::from_secs(60), "{:?}", begun.elapsed());
    let child = start(&[]);
    std::thread::sleep(Duration::from_secs(3));
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    let asked = Instant::now();
    let stopped = child.wait_with_output().unwrap();
    assert_eq!(stopped.status.code(), Some(130), "{stopped:?}");
    assert!(asked.elapsed() < Duration::from_secs(60), "{:?}", asked.elapsed());
}

#[needs(python)]
#[test]
fn a_driver_that_joins_the_group_of_the_program_ends_with_it() {
    let place = with_driver("python3 driver.py");
    // It does not read, and does not end when its input is closed.
    let driver = "import os, time\nos.setpgid(0, os.getpgid(os.getppid()))\ntime.sleep(4322)\n";
    fs::write(place.path().join("driver.py"), driver).unwrap();
    let output = limited("true", &["run", "outside.scn", "--allow-external", "--out", "out"], place.path());
    assert_eq!(output.status.code(), Some(5), "{output:?}");
}

/// A name in bytes that are no UTF-8 is a name: the scenario runs, and the report says what it can.
#[test]
fn a_file_may_have_any_name() {
    use std::os::unix::ffi::OsStrExt;
    let place = tempfile::tempdir().unwrap();
    let name = std::ffi::OsStr::from_bytes(b"c\xff.scn");
    let text = "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
                spawn near { distance: 7 m .. 40 m }\nepisode e { ticks: 40 }\n\
                campaign c { vehicle: model3 body: pursuer spawn: near episode: e\n\
                evaluate { towns: [harbour] drivers: [idm] pedestrians: [intercept] episodes: 2 } }\n";
    fs::write(place.path().join(name), text).unwrap();
    for command in [&["run"][..], &["run", "--list"], &["check"], &["preview", "--once"], &["fmt", "--check"]] {
        let output = program::command().args(command).arg(name).current_dir(place.path()).output().unwrap();
        assert!(matches!(output.status.code(), Some(0 | 3)), "{command:?}: {output:?}");
        assert!(!error(&output).contains("panic"), "{}", error(&output));
    }
    let manifest = fs::read_to_string(place.path().join("reports/c/manifest.toml")).unwrap();
    assert!(manifest.contains("scenarios = [\"c"), "{manifest}");
}

/// The likeliest slip of a beginner: pedestrians are trained, and nothing says how.
#[test]
fn a_training_that_is_missing_is_one_message_in_all_commands() {
    let place = tempfile::tempdir().unwrap();
    let text = "edition 1\nimport \"std/pedestrians.scn\"\nimport \"std/drivers.scn\"\nimport \"std/towns.scn\"\n\
                import fault from \"std/rewards.scn\"\nspawn near { distance: 7 m .. 40 m }\nepisode e { ticks: 40 }\n\
                campaign c { vehicle: model3 body: pursuer spawn: near episode: e\n\
                train { towns: [harbour] drivers: [idm] rewards: [fault] }\n\
                evaluate { towns: [harbour] drivers: [idm] episodes: 2 } }\n";
    fs::write(place.path().join("c.scn"), text).unwrap();
    for command in
        [&["run", "c.scn"][..], &["run", "--list", "c.scn"], &["check", "c.scn"], &["preview", "--once", "c.scn"]]
    {
        let output = program::falsify(command, place.path());
        assert_eq!(output.status.code(), Some(3), "{command:?}: {output:?}");
        let said = error(&output);
        assert_eq!(said.matches("error[").count(), 1, "{said}");
        assert!(said.contains("`campaign` needs the key `training`"), "{said}");
    }
    let mut session = crate::language_server::Session::new();
    session.open("file:///c.scn", text);
    assert!(session.hold().iter().any(|reply| reply.to_string().contains("missing-key")));
}
