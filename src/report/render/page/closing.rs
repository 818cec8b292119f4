use std::collections::BTreeSet;
use std::fmt::Write;

use super::super::summary::LEFT_OUT;
use super::markup::escape;
use crate::compile::Campaign;
use crate::report::Manifest;

/// Who drives, what is what, and what the simulator leaves out.
pub fn meaning(campaign: &Campaign) -> String {
    let mut html = String::from("<section id=\"meaning\"><h2>What is what</h2><dl class=\"words\">");
    for driver in &campaign.drivers {
        let sensors = match &driver.sensors {
            Some(name) => format!("behind the sensors <code>{}</code>", escape(name)),
            None => "without sensors: exact and at once".into(),
        };
        let surrogate = if driver.surrogate.is_empty() { "" } else { " <b class=\"warn\">A surrogate.</b>" };
        let word = campaign.words.iter().find(|word| word.form == "policy" && word.name == driver.name);
        let docs = word.map_or(String::new(), |word| format!("{} ", prose(&word.docs)));
        let _ = write!(
            html,
            "<dt>{}</dt><dd>{docs}Driver <code>{}</code>, {sensors}.{surrogate}</dd>",
            escape(&driver.name),
            escape(driver.kind)
        );
    }
    let known = |name: &str| campaign.drivers.iter().any(|driver| driver.name == name);
    for word in campaign.words.iter().filter(|word| word.form != "policy" || !known(&word.name)) {
        let _ =
            write!(html, "<dt>{}</dt><dd><i>{}.</i> {}</dd>", escape(&word.name), escape(word.form), prose(&word.docs));
    }
    html.push_str("</dl>");
    let mut said = BTreeSet::new();
    for driver in campaign.drivers.iter().filter(|driver| !driver.surrogate.is_empty()) {
        if said.insert(driver.kind) {
            let _ = write!(
                html,
                "<p><b>Surrogate <code>{}</code>.</b> {}</p>",
                escape(driver.kind),
                prose(driver.surrogate)
            );
        }
    }
    let _ = write!(html, "<h3>What the simulator leaves out</h3><p>{}</p></section>", prose(LEFT_OUT));
    html
}

/// The data behind the page, and how it is made again.
pub fn data(manifest: &Manifest, files: &[String]) -> String {
    let mut html = String::from("<section id=\"data\"><h2>Data</h2><ul class=\"files\">");
    for (name, what) in WHAT {
        if files.iter().any(|file| file == name) {
            let _ = write!(html, "<li><a href=\"{name}\">{name}</a> {what}</li>");
        }
    }
    let known = |file: &str| WHAT.iter().any(|(name, _)| *name == file);
    let others = files.iter().filter(|file| !known(file) && [".csv", ".svg"].iter().any(|end| file.ends_with(end)));
    for file in others {
        let _ = write!(html, "<li><a href=\"{0}\">{0}</a></li>", escape(file));
    }
    html.push_str("</ul><h3>Made again</h3>");
    let _ = write!(html, "<pre><code>{}</code></pre>", escape(&command(manifest)));
    let _ = write!(
        html,
        "<p>falsify {}, vector instructions {}; the manifest tells how long it took. The same files, seed and version give the same numbers.</p>\
         <details><summary>Files read</summary><table><thead><tr><th>file</th><th>BLAKE3</th></tr></thead><tbody>",
        escape(&manifest.version),
        escape(&manifest.vector_instructions),
    );
    for file in &manifest.files {
        let short: String = file.blake3.chars().take(16).collect();
        let _ = write!(html, "<tr><td>{}</td><td><code>{short}…</code></td></tr>", escape(&file.path));
    }
    html.push_str("</tbody></table></details></section>");
    html
}

/// What makes the report again, for a shell.
fn command(manifest: &Manifest) -> String {
    let call = &manifest.call;
    let mut words = vec!["falsify".to_string(), "run".into()];
    words.extend(manifest.smoke.then(|| "--smoke".into()));
    words.extend(call.allow_external.then(|| "--allow-external".into()));
    words.push(format!("--seed {}", manifest.seed));
    for (option, values) in [("--map", &call.maps), ("--set", &call.set)] {
        words.extend(values.iter().map(|value| format!("{option} {}", quoted(value))));
    }
    words.extend(call.scenarios.iter().map(|file| quoted(file)));
    words.join(" ")
}

/// A word as a shell takes it for itself.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-=:+".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

/// The files of a report that a reader may want.
const WHAT: [(&str, &str); 12] = [
    ("summary.md", "the tables of this page as text"),
    ("cells.csv", "one row for each cell"),
    ("runs.csv", "one row for each run of a cell"),
    ("episodes.csv", "one row for each episode"),
    ("episodes.parquet", "the same, smaller"),
    ("failure_modes.csv", "the kinds of collisions"),
    ("comparisons.csv", "paired comparisons"),
    ("transfer.csv", "how much is lost in other towns"),
    ("explanations.csv", "what explains the failures"),
    ("learning_curve.csv", "one row for each update of each training"),
    ("search_cells.csv", "falsifiers compared"),
    ("manifest.toml", "version, seed, files and times"),
];

/// Text as scenarios and this program write it: backquotes mean code, two stars stress.
pub fn prose(text: &str) -> String {
    let mut html = String::new();
    for (place, part) in escape(text).split('`').enumerate() {
        let _ = if place % 2 == 1 {
            write!(html, "<code>{part}</code>")
        } else {
            write!(html, "{}", part.replace("**", ""))
        };
    }
    html
}
