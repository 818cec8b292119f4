//! Maps of towns and previews of scenarios: names, axes, places that a scenario takes, and a page that follows its file.

use std::path::Path;
use std::process::{Child, Stdio};

use falsify::session::{Input, Session};
use needs::needs;
use serde_json::{Value, json};

use crate::page::{Tab, balanced, fits};
use crate::program::command;

const SCENARIO: &str = "edition 1
import plausible from \"std/pedestrians.scn\"
import behavior, model3 from \"std/drivers.scn\"

town corner {
  street first { through: [(0 m, 0 m), (120 m, 0 m), (120 m, 90 m)] }
  building { corner: (20 m, 10 m)  opposite: (60 m, 30 m) }
}
spawn near { bearing: -60 deg .. 60 deg  distance: 7 m .. 40 m }
episode short { ticks: 100  hold: 10 }
method meet = intercept()
campaign walk {
  vehicle: model3
  body: plausible
  spawn: near
  episode: short
  search { towns: [corner]  drivers: [behavior]  methods: [meet]  budget: 2_000  runs: 1 }
}
";

/// Writes the towns of a scenario file as OpenDRIVE maps, `NAME.xodr`.
pub fn write_maps(file: &Path, folder: &Path) {
    let checked = Session::default().check(&Input::file(file)).unwrap();
    for named in &checked.plan().unwrap().towns {
        std::fs::write(folder.join(format!("{}.xodr", named.name)), export::town(&named.town).unwrap()).unwrap();
    }
}

fn once(folder: &Path, text: &str) -> (Option<i32>, String) {
    std::fs::write(folder.join("my.scn"), text).unwrap();
    let output = command().current_dir(folder).args(["preview", "my.scn", "--once"]).output().unwrap();
    (output.status.code(), std::fs::read_to_string(folder.join("my.preview.html")).unwrap())
}

#[test]
fn the_page_of_a_map_names_its_lanes() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("my.scn"), SCENARIO).unwrap();
    write_maps(&folder.path().join("my.scn"), folder.path());
    let drawn = command().current_dir(folder.path()).args(["preview", "corner.xodr"]).output().unwrap();
    assert!(drawn.status.success(), "{drawn:?}");
    let page = std::fs::read_to_string(folder.path().join("corner.preview.html")).unwrap();
    for title in ["lane −1 (driving), 3.5 m wide", "(sidewalk)", "obstacle at (40 m, 20 m, 0 deg), 40 m × 20 m"] {
        assert!(page.contains(title), "{title}");
    }
    let text = String::from_utf8(drawn.stdout).unwrap();
    assert!(text.contains("town corner") && text.contains("driving lanes   0."), "{text}");
    balanced(&page);
    assert!(!page.contains("id=\"follows\""), "a map follows nothing");
}

#[test]
fn a_preview_has_towns_starts_and_errors() {
    let folder = tempfile::tempdir().unwrap();
    let (code, page) = once(folder.path(), SCENARIO);
    assert_eq!(code, Some(0));
    balanced(&page);
    assert!(page.contains("no errors, 1 town"));
    assert!(page.contains("walk, spawn near: ") && page.contains(" of 300 starts accepted"));
    let (code, page) = once(folder.path(), &SCENARIO.replace("7 m .. 40 m", "7 s .. 40 m"));
    assert_eq!(code, Some(3));
    balanced(&page);
    assert!(page.contains("1 error, no town to show") && page.contains("error[wrong-unit]"), "{page}");
    let missing = command().current_dir(folder.path()).args(["preview", "none.scn", "--once"]).output().unwrap();
    assert_eq!(missing.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&missing.stderr).contains("none.scn"), "{missing:?}");
}

/// A preview that runs until it is dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Waits for an expression to be true, for half a minute at most; the page may load itself again meanwhile.
fn becomes(tab: &mut Tab, expression: &str) {
    for _ in 0..300 {
        let params = json!({ "expression": format!("Boolean({expression})"), "returnByValue": true });
        if tab.ask("Runtime.evaluate", params)["result"]["value"] == json!(true) {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    panic!("never true: {expression}");
}

#[needs(browser)]
#[test]
fn a_page_follows_its_file_and_gives_places_that_a_scenario_takes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("my.scn");
    std::fs::write(&file, SCENARIO).unwrap();
    let running = command()
        .current_dir(folder.path())
        .args(["preview", "my.scn"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    let _running = Running(running.unwrap());
    for _ in 0..300 {
        if folder.path().join("my.preview.js").exists() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    let profile = tempfile::tempdir().unwrap();
    let mut tab = Tab::open(profile.path());
    tab.ask("Page.enable", json!({}));
    let page = folder.path().join("my.preview.html");
    tab.ask("Page.navigate", json!({ "url": format!("file://{}", page.display()) }));
    tab.wait("Page.loadEventFired");
    for width in [390, 1400, 1100] {
        fits(&mut tab, width);
    }
    // The pointer is over the lane in which cars drive east, 50 m from the start of the street.
    let on_lane = "(() => { const svg = document.querySelector('.map svg'); svg.scrollIntoView({ block: 'center', behavior: 'instant' }); \
         const at = new DOMPoint(50, 1.2).matrixTransform(svg.getScreenCTM()); return [at.x, at.y]; })()";
    let at = tab.value(on_lane);
    let pointer = |kind: &str, tab: &mut Tab| {
        let event = json!({ "type": kind, "x": at[0], "y": at[1], "button": "left", "clickCount": 1 });
        tab.ask("Input.dispatchMouseEvent", event);
    };
    pointer("mouseMoved", &mut tab);
    becomes(&mut tab, "document.querySelector('.here').textContent.includes('lane −1 (driving)')");
    pointer("mousePressed", &mut tab);
    pointer("mouseReleased", &mut tab);
    becomes(&mut tab, "document.querySelectorAll('.places code').length === 3");
    let copied = tab.value("[...document.querySelectorAll('.places code')].map((code) => code.textContent)");
    let copied: Vec<&str> = copied.as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(copied[0].starts_with("(50") || copied[0].starts_with("(49."), "{copied:?}");
    assert!(copied[1].ends_with(" m, -1.75 m, 0 deg)"), "{copied:?}");
    // The scenario with the piece of lane that was copied has no error, and the page shows it without another call.
    let changed = SCENARIO.replace("spawn near { ", &format!("spawn near {{ {} ", copied[2]));
    std::fs::write(&file, &changed).unwrap();
    becomes(
        &mut tab,
        "document.querySelectorAll('path.ego').length > 20 && document.querySelector('.meta').textContent.includes('no errors') && \
         [...document.querySelectorAll('g circle.ego')].every((start) => Math.abs(start.cx.baseVal.value - 55) < 6.5)",
    );
    // The page may be loading again: the place that was clicked is kept.
    becomes(&mut tab, "document.querySelectorAll('.places code').length === 3");
    // A mistake is shown beside the last maps, and its repair removes it.
    std::fs::write(&file, changed.replace("budget: 2_000", "budget: 2_000 m")).unwrap();
    becomes(
        &mut tab,
        "document.querySelector('#problems')?.textContent.includes('error[') && document.querySelectorAll('.map').length === 1",
    );
    std::fs::write(&file, SCENARIO).unwrap();
    becomes(&mut tab, "!document.querySelector('#problems') && document.querySelectorAll('.map').length === 1");
}

#[test]
fn what_a_map_has_and_no_driver_uses_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let sign = |id: usize| {
        let kind = [294, 306][id % 2];
        format!(r#"<signal id="{id}" s="{id}" t="-3" type="{kind}" orientation="+"/>"#)
    };
    let signs: String = (0..100).map(sign).collect();
    let map = format!(
        r#"<OpenDRIVE><road id="1" length="100" junction="-1"><planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView><lanes><laneSection s="0"><right><lane id="-1" type="driving"><width a="3.5"/></lane></right></laneSection></lanes><signals>{signs}</signals></road></OpenDRIVE>"#
    );
    std::fs::write(folder.path().join("signs.xodr"), map).unwrap();
    let drawn = command().current_dir(folder.path()).args(["preview", "signs.xodr"]).output().unwrap();
    let said = String::from_utf8(drawn.stdout).unwrap();
    assert!(drawn.status.success() && said.contains("warnings        2\n"), "{said}");
    assert!(said.contains("speed limits    30 km/h assumed on 100 of 100 m of driving lanes"), "{said}");
    assert!(said.contains("not used: 50 × stop line (signal type 294)"), "{said}");
    assert!(said.contains("not used: 50 × sign of a priority road (signal type 306)"), "{said}");
}
