use std::path::PathBuf;

use clap::Args;

use compile::Overrides;

/// Scenario files, and what replaces parts of them.
#[derive(Debug, Clone, Default, Args)]
pub struct Input {
    /// The scenario files.
    #[arg(skip)]
    pub files: Vec<PathBuf>,
    /// Take the roads of a town from an OpenDRIVE map instead; buildings are kept.
    #[arg(id = "map", long = "map", value_name = "TOWN=FILE", value_parser = town_and_file, help_heading = "Scenario")]
    pub maps: Vec<(String, PathBuf)>,
    /// Give a parameter or a key of a declaration another value, as `far=20 m` or `ppo_paper.steps=1000`. For several values of
    /// a parameter, write a `matrix` block in the campaign.
    #[arg(id = "set", long = "set", value_name = "NAME=VALUE", help_heading = "Scenario")]
    pub settings: Vec<String>,
}

impl Input {
    /// One file without replacements.
    pub fn file(path: impl Into<PathBuf>) -> Self {
        Self { files: vec![path.into()], ..Self::default() }
    }

    /// The replacements, for the compiler.
    pub(super) fn overrides(&self) -> Overrides {
        let maps = self.maps.iter().cloned().collect();
        Overrides { maps, settings: self.settings.clone(), ..Overrides::default() }
    }
}

fn town_and_file(text: &str) -> Result<(String, PathBuf), String> {
    let (town, file) = text.split_once('=').ok_or("write TOWN=FILE")?;
    Ok((town.to_string(), PathBuf::from(file)))
}
