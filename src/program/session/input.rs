use std::path::PathBuf;

use compile::Overrides;

/// Scenario files, and what replaces parts of them.
#[derive(Debug, Clone, Default)]
pub struct Input {
    /// The scenario files.
    pub files: Vec<PathBuf>,
    /// OpenDRIVE maps that replace the roads of towns, each with the name of its town.
    pub maps: Vec<(String, PathBuf)>,
    /// Values of parameters and of keys of declarations, as `far=20 m` or `ppo_paper.steps=1000`.
    pub settings: Vec<String>,
}

impl Input {
    /// One file without replacements.
    pub fn file(path: impl Into<PathBuf>) -> Self {
        Self { files: vec![path.into()], ..Self::default() }
    }

    /// The replacements, for the compiler.
    pub(super) fn overrides(&self) -> Overrides {
        let (maps, settings) = (self.maps.iter().cloned().collect(), self.settings.clone());
        Overrides { maps, settings, ..Overrides::default() }
    }
}
