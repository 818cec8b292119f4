use crate::report::Manifest;

/// A difference between two reports besides their drivers, which a reader of the comparison must know.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Caveat {
    #[error(
        "made by different programs, {} and {}: a difference may be the program's",
        made_by(before),
        made_by(after)
    )]
    Program {
        /// Version and digest of the code of the first report.
        before: (String, String),
        /// The same of the second.
        after: (String, String),
    },
    #[error("both sides are the same runs of one report, or of a copy, which show nothing")]
    Same,
    #[error("the seeds are {before} and {after}")]
    Seed { before: u64, after: u64 },
    #[error("settings: {} before, {} after", list(before), list(after))]
    Settings { before: Vec<String>, after: Vec<String> },
    #[error("`{path}` differs")]
    File {
        /// Its path in the second report.
        path: String,
    },
    #[error("the report `{campaign}` {}", if *smoke { "is a smoke run" } else { "is not complete" })]
    Partial { campaign: String, smoke: bool },
    #[error(
        "trained pedestrians are those of each report: {trainings} of them were trained from other files or settings"
    )]
    Trainings {
        /// The number of trainings of the second report that the first does not have.
        trainings: usize,
    },
    #[error("only one side has {}, which is not compared: give it the same name on both sides", list(drivers))]
    LoneDrivers { drivers: Vec<String> },
    #[error("{before} runs of the first and {after} of the second have no partner")]
    Unmatched { before: usize, after: usize },
    #[error("{episodes} of {all} episodes have no equal start on the other side, and are left out")]
    Unpaired {
        episodes: u64,
        /// All episodes of the matched runs of both.
        all: u64,
    },
    #[error("episodes in error, which are left out, and of which nothing is known: {episodes}; the first is {first}")]
    Errors {
        episodes: u64,
        /// The name of the first, and why it failed.
        first: String,
    },
    #[error(
        "{searches} searches have other starts on the other side, or come from an earlier version, and are left out"
    )]
    SearchStarts { searches: u64 },
}

fn made_by((version, code): &(String, String)) -> String {
    format!("{version} (code {})", code.get(..8).unwrap_or(code))
}

fn list(all: &[String]) -> String {
    if all.is_empty() {
        "none".into()
    } else {
        all.iter().map(|each| format!("`{each}`")).collect::<Vec<_>>().join(", ")
    }
}

/// What the manifests of two reports say that differs.
pub(super) fn caveats(before: &Manifest, after: &Manifest) -> Vec<Caveat> {
    let mut found = Vec::new();
    let program = |manifest: &Manifest| (manifest.version.clone(), manifest.code.clone());
    if program(before) != program(after) {
        found.push(Caveat::Program { before: program(before), after: program(after) });
    }
    if before.seed != after.seed {
        found.push(Caveat::Seed { before: before.seed, after: after.seed });
    }
    if before.settings != after.settings {
        found.push(Caveat::Settings { before: before.settings.clone(), after: after.settings.clone() });
    }
    let name = |path: &str| path.rsplit(['/', '\\']).next().unwrap_or(path).to_string();
    for file in &after.files {
        let same: Vec<_> = before.files.iter().filter(|other| name(&other.path) == name(&file.path)).collect();
        if !same.is_empty() && same.iter().all(|other| other.blake3 != file.blake3) {
            found.push(Caveat::File { path: file.path.clone() });
        }
    }
    for manifest in [before, after].into_iter().filter(|manifest| !manifest.complete || manifest.smoke) {
        found.push(Caveat::Partial { campaign: manifest.campaign.clone(), smoke: manifest.smoke });
    }
    let is_new = |fingerprint: &str| before.trainings.iter().all(|other| other.fingerprint != *fingerprint);
    let trainings = after.trainings.iter().filter(|training| is_new(&training.fingerprint)).count();
    if trainings > 0 && !before.trainings.is_empty() {
        found.push(Caveat::Trainings { trainings });
    }
    found
}
