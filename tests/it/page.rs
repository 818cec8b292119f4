//! The page of a report, read as a file and opened in a browser.
//!
//! `FALSIFY_BROWSER` names the browser; the default is an installed Chromium or Chrome with a known name. The tests control
//! the browser through a pipe and open no port.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use needs::needs;
use serde_json::{Value, json};

use crate::program::command;

/// A campaign without training in which a pedestrian is hit. Its names and texts contain markup that must be escaped.
const SCENARIO: &str = r#"edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/towns.scn"

/// </script><script>throw 1</script> & "quotes" <img src=x onerror=alert(1)>
campaign page {
  vehicle: model3
  body: suicidal
  spawn: ahead
  episode: thirty_seconds
  training: short

  train {
    towns: [harbour]
    drivers: [blind]
    rewards: [r1]
    runs: 2
  }
  evaluate {
    towns: [harbour]
    drivers: [blind, idm]
    pedestrians: [trained, random, intercept]
    episodes: 20
  }
}

/// <b>Short</b>
training short = ppo(steps: 1_500, portable_bits: true)
"#;

/// A campaign without training, once for each speed of its car.
const MATRIX: &str = r#"edition 1
import "std/paper.scn"
import "std/drivers.scn"
import "std/towns.scn"

param share: number = 0.9
driver slow = cruise(limit_share: share)

campaign speeds {
  vehicle: model3
  body: suicidal
  spawn: ahead
  episode: thirty_seconds
  matrix { share: [0.3, 0.6, 0.9] }
  evaluate {
    towns: [harbour]
    drivers: [slow, idm]
    pedestrians: [intercept]
    episodes: 5
  }
}
"#;

/// Runs the campaign of a file and returns what it prints.
fn run(scenario: &str, name: &str, out: &Path) -> String {
    let file = out.join(name).with_extension("scn");
    std::fs::write(&file, scenario).unwrap();
    let run = command().arg("run").arg(&file).arg("--out").arg(out).output().unwrap();
    assert!(run.status.success(), "{run:?}");
    String::from_utf8_lossy(&run.stdout).into_owned()
}

#[test]
fn a_matrix_has_an_overview_that_leads_to_its_reports() {
    let out = tempfile::tempdir().unwrap();
    let said = run(MATRIX, "speeds", out.path());
    assert!(said.trim_end().ends_with("overview.html"), "{said}");
    let html = std::fs::read_to_string(out.path().join("overview.html")).unwrap();
    closed(&html, out.path());
    let rows = html.matches("/report.html\"").count();
    assert_eq!(rows, 12, "in two tables a row for each driver of each report");
    let table = std::fs::read_to_string(out.path().join("overview.csv")).unwrap();
    let head: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    assert_eq!(head.last(), Some(&"share"), "{head:?}");
    assert_eq!(table.lines().count(), 7);
}

#[needs(browser)]
#[test]
fn an_overview_fits_windows() {
    let out = tempfile::tempdir().unwrap();
    run(MATRIX, "speeds", out.path());
    let profile = tempfile::tempdir().unwrap();
    let mut tab = Tab::open(profile.path());
    tab.ask("Page.enable", json!({}));
    tab.ask("Page.navigate", json!({ "url": format!("file://{}", out.path().join("overview.html").display()) }));
    tab.wait("Page.loadEventFired");
    [1400, 1100, 390].into_iter().for_each(|width| fits(&mut tab, width));
}

#[test]
fn a_report_has_a_page_that_needs_nothing_else() {
    let out = tempfile::tempdir().unwrap();
    run(SCENARIO, "page", out.path());
    let folder = out.path().join("page");
    let html = std::fs::read_to_string(folder.join("report.html")).unwrap();
    stands_alone(&html, &folder);
    assert!(html.len() < 3_000_000, "{} bytes", html.len());
}

#[needs(browser)]
#[test]
fn the_page_of_a_report_moves() {
    let out = tempfile::tempdir().unwrap();
    run(SCENARIO, "page", out.path());
    opens(&out.path().join("page/report.html"));
}

/// Checks that need no browser.
fn stands_alone(html: &str, folder: &Path) {
    closed(html, folder);
    let data: Vec<&str> = html.split("<script type=\"application/json\"").skip(1).collect();
    assert!(!data.is_empty(), "no kind of failure can be played");
    for part in data {
        let text = part.split_once('>').unwrap().1.split("</script>").next().unwrap();
        let replay: Value = serde_json::from_str(text).unwrap();
        assert_eq!(replay["ego"].as_array().unwrap().len(), replay["person"].as_array().unwrap().len());
    }
    let files: Vec<PathBuf> =
        std::fs::read_dir(folder.join("figures")).unwrap().map(|entry| entry.unwrap().path()).collect();
    let is_svg = |path: &&PathBuf| path.extension().is_some_and(|end| end == "svg");
    assert!(files.iter().all(|path| path.with_extension("svg").is_file()), "a caption has a figure: {files:?}");
    for path in files.iter().filter(is_svg) {
        let svg = std::fs::read_to_string(path).unwrap();
        let read = roxmltree::Document::parse(&svg);
        assert!(read.is_ok(), "{}: {read:?}", path.display());
    }
    // Each thing has one word; the names of the scenario have those of the language.
    let said = html.split("<main").nth(1).unwrap().split("id=\"meaning\"").next().unwrap().to_lowercase();
    for word in ["controller", "falsifier", "adversar", "walker", "encounter", "contact", "policy", "policies"] {
        assert!(!said.contains(word), "the page says `{word}`");
    }
}

/// Whether all links of a page lead somewhere within its folder, nothing is loaded, and all elements are closed.
fn closed(html: &str, folder: &Path) {
    let mut ids = BTreeSet::new();
    for part in html.split(" id=\"").skip(1) {
        let id = part.split('"').next().unwrap();
        assert!(ids.insert(id.to_string()), "`{id}` is there twice");
    }
    for attribute in ["src=\"", "href=\""] {
        for part in html.split(attribute).skip(1) {
            let target = part.split('"').next().unwrap();
            match target.strip_prefix('#') {
                Some(id) => assert!(ids.contains(id), "nothing has the id `{id}`"),
                None => assert!(folder.join(target).is_file(), "`{target}` is no file of the report"),
            }
        }
    }
    for outside in ["url(", "@import", "fetch(", "XMLHttpRequest", "<img", "<link", "<iframe", "onerror=alert(1)>"] {
        assert!(!html.contains(outside), "the page holds `{outside}`");
    }
    balanced(html);
}

/// Whether all elements are closed, in order.
pub fn balanced(html: &str) {
    const VOID: [&str; 4] = ["meta", "br", "input", "!doctype"];
    let mut open: Vec<String> = Vec::new();
    let mut rest = html;
    while let Some(start) = rest.find('<') {
        let end = start + rest[start..].find('>').expect("a tag has an end");
        let tag = &rest[start + 1..end];
        let name: String =
            tag.trim_start_matches('/').chars().take_while(|c| !c.is_whitespace() && *c != '/').collect();
        rest = &rest[end + 1..];
        if tag.starts_with('/') {
            assert_eq!(open.pop().as_deref(), Some(name.as_str()), "</{name}> closes something else");
        } else if !tag.ends_with('/') && !VOID.contains(&name.as_str()) {
            // The content of these elements is not markup.
            if ["script", "style"].contains(&name.as_str()) {
                rest = &rest[rest.find(&format!("</{name}>")).unwrap()..];
            }
            open.push(name);
        }
    }
    assert!(open.is_empty(), "never closed: {open:?}");
}

fn browser() -> PathBuf {
    let named = std::env::var_os("FALSIFY_BROWSER").map(PathBuf::from);
    let path = std::env::var_os("PATH").unwrap_or_default();
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"];
    let known = std::env::split_paths(&path).flat_map(|folder| names.map(|name| folder.join(name)));
    named.into_iter().chain(known).find(|place| place.is_file()).expect("the test needs a browser")
}

/// The page in a browser: it logs nothing, requests nothing, and its players move.
fn opens(page: &Path) {
    let profile = tempfile::tempdir().unwrap();
    let mut tab = Tab::open(profile.path());
    for domain in ["Page", "Runtime", "Log", "Network"] {
        tab.ask(&format!("{domain}.enable"), json!({}));
    }
    tab.ask("Page.navigate", json!({ "url": format!("file://{}", page.display()) }));
    tab.wait("Page.loadEventFired");
    let players = tab.value("document.querySelectorAll('.player canvas.scene').length");
    assert!(players.as_u64().unwrap() > 0, "{players}");
    let show = "document.querySelector('.player .says').textContent";
    let picture = "document.querySelector('.player canvas.scene').toDataURL()";
    let (text, seen) = (tab.value(show), tab.value(picture));
    tab.value("document.querySelector('.player').scrollIntoView()");
    tab.value("document.querySelector('.player .play').click()");
    let moved = "new Promise((done) => { const until = performance.now() + 20000; const look = () => { \
         const bar = document.querySelector('.player input'); \
         if (Number(bar.value) > Number(bar.dataset.from) || performance.now() > until) done(Number(bar.value)); \
         else requestAnimationFrame(look); }; look(); })";
    tab.value(
        "(() => { const bar = document.querySelector('.player input'); bar.dataset.from = Number(bar.value) + 5; })()",
    );
    tab.value(moved);
    assert_ne!(tab.value(show), text, "the time does not change");
    assert_ne!(tab.value(picture), seen, "the picture does not change");
    let key = |key: &str| {
        format!(
            "document.querySelector('.player canvas.scene').dispatchEvent(new KeyboardEvent('keydown', {{ key: '{key}', bubbles: true }}))"
        )
    };
    tab.value(&key("Home"));
    tab.value(&key("ArrowRight"));
    assert_eq!(tab.value("Number(document.querySelector('.player input').value)"), json!(1), "keys step by a tick");
    tab.value("document.getElementById('theme').click()");
    let theme = tab.value("document.documentElement.dataset.theme");
    assert!(["dark", "light"].contains(&theme.as_str().unwrap_or_default()), "{theme}");
    // Rows are sorted by a click on a head, numbers from above first.
    let speeds = "[...document.querySelectorAll('.sortable tbody tr')].map((row) => Number(row.cells[2].textContent))";
    tab.value("document.querySelectorAll('.sortable th button')[2].click()");
    let sorted = tab.value(&format!("{speeds}.every((speed, row, all) => row === 0 || all[row - 1] >= speed)"));
    assert_eq!(sorted, json!(true), "{}", tab.value(speeds));
    [1400, 1100, 390].into_iter().for_each(|width| fits(&mut tab, width));
    plays_above_the_page(&mut tab);
    let unnamed = "[...document.querySelectorAll('button, input, select, svg[role=img], canvas[role=img]')]\
         .filter((e) => !(e.getAttribute('aria-label') || e.textContent.trim())).length";
    assert_eq!(tab.value(unnamed), json!(0), "something has no name for those who do not see it");
    let talked: Vec<&Value> = tab
        .heard
        .iter()
        .filter(|event| {
            let method = event["method"].as_str().unwrap_or_default();
            let url = event["params"]["request"]["url"].as_str().unwrap_or_default();
            ["Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded"].contains(&method)
                || (method == "Network.requestWillBeSent" && !url.ends_with("/report.html"))
        })
        .collect();
    assert!(talked.is_empty(), "{talked:#?}");
}

/// On a phone all sections are closed, and a link into one opens it. A link to a player plays it at once, below its title.
fn plays_above_the_page(tab: &mut Tab) {
    let metrics = json!({ "width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": true });
    tab.ask("Emulation.setDeviceMetricsOverride", metrics);
    tab.heard.retain(|event| event["method"] != json!("Page.loadEventFired"));
    tab.ask("Page.reload", json!({}));
    tab.wait("Page.loadEventFired");
    assert_eq!(tab.value("document.querySelectorAll('details.part[open]').length"), json!(0));
    let height = tab.value("document.documentElement.scrollHeight");
    assert!(height.as_u64().unwrap() <= 10_000, "the page is {height} px high on a phone");
    tab.value("document.querySelector('nav a[href=\"#results\"]').click()");
    let opened =
        "new Promise((done) => setTimeout(() => done(document.getElementById('results').parentElement.open), 300))";
    assert_eq!(tab.value(opened), json!(true), "a link opens its section");
    tab.value("document.querySelector('a.play').click()");
    let title = tab.value("document.querySelector('dialog[open] h3').textContent");
    assert!(title.as_str().unwrap().contains("collision at"), "{title}");
    let plays = "new Promise((done) => { const bar = document.querySelector('dialog .player input'), from = bar.value, until = performance.now() + 20000; \
         const look = () => { if (bar.value !== from || performance.now() > until) done(bar.value !== from); else requestAnimationFrame(look); }; look(); })";
    assert_eq!(tab.value(plays), json!(true), "it does not play");
    tab.value("document.querySelector('dialog header button').click()");
    assert_eq!(
        tab.value("new Promise((done) => setTimeout(() => done(document.querySelectorAll('dialog').length), 300))"),
        json!(0)
    );
}

/// Whether the page and each of its tables fit a window of this width (CSS pixels), with everything unfolded.
pub fn fits(tab: &mut Tab, width: u32) {
    let metrics = json!({ "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false });
    tab.ask("Emulation.setDeviceMetricsOverride", metrics);
    tab.value("document.querySelectorAll('details').forEach((details) => { details.open = true; })");
    let wider = "[document.documentElement, ...document.querySelectorAll('.wide')].filter((e) => e.scrollWidth > e.clientWidth) \
         .map((e) => `${e.closest('section')?.id}: ${e.scrollWidth} > ${e.clientWidth}, ${e.querySelector('thead')?.textContent}`)";
    assert_eq!(tab.value(wider), json!([]), "wider than a window of {width} px");
    // A table may end exactly at its frame and still be cut by the page.
    let cut = "[...document.querySelectorAll('td, th')].filter((e) => e.getBoundingClientRect().right > innerWidth + 1) \
         .map((e) => e.textContent.slice(0, 60))";
    assert_eq!(tab.value(cut), json!([]), "cut by a window of {width} px");
}

/// A tab of a browser that is controlled through its pipe; the browser ends when the value is dropped.
pub struct Tab {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    session: Option<String>,
    asked: u64,
    heard: Vec<Value>,
}

impl Tab {
    /// Starts the browser with an empty tab.
    pub fn open(profile: &Path) -> Self {
        // The browser reads from file descriptor 3 and writes to file descriptor 4; the shell connects our pipes to them.
        let mut child = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>&1"])
            .arg(browser())
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"])
            .arg("--remote-debugging-pipe")
            .arg(format!("--user-data-dir={}", profile.display()))
            .arg("about:blank")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (to, from) = (child.stdin.take().unwrap(), BufReader::new(child.stdout.take().unwrap()));
        let mut tab = Self { child, to, from, session: None, asked: 0, heard: Vec::new() };
        let target = tab.ask("Target.createTarget", json!({ "url": "about:blank" }))["targetId"].clone();
        let attached = tab.ask("Target.attachToTarget", json!({ "targetId": target, "flatten": true }));
        tab.session = Some(attached["sessionId"].as_str().unwrap().to_string());
        tab
    }

    fn read(&mut self) -> Value {
        let mut message = Vec::new();
        self.from.read_until(0, &mut message).unwrap();
        assert_eq!(message.pop(), Some(0), "the browser has ended");
        serde_json::from_slice(&message).unwrap()
    }

    /// The answer to a command of the DevTools protocol.
    pub fn ask(&mut self, method: &str, params: Value) -> Value {
        self.asked += 1;
        let mut message = json!({ "id": self.asked, "method": method, "params": params });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.to.write_all(message.to_string().as_bytes()).unwrap();
        self.to.write_all(&[0]).unwrap();
        loop {
            let answer = self.read();
            if answer["id"] == json!(self.asked) {
                assert!(answer["error"].is_null(), "{method}: {answer}");
                return answer["result"].clone();
            }
            self.heard.push(answer);
        }
    }

    /// Waits for an event of the page.
    pub fn wait(&mut self, method: &str) {
        while !self.heard.iter().any(|event| event["method"] == json!(method)) {
            let event = self.read();
            self.heard.push(event);
        }
    }

    /// The value of an expression that the page evaluates.
    pub fn value(&mut self, expression: &str) -> Value {
        let params = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let answer = self.ask("Runtime.evaluate", params);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }
}

impl Drop for Tab {
    fn drop(&mut self) {
        let _ = self.to.write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0");
        let _ = self.child.wait();
    }
}
