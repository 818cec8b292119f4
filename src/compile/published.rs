use super::plan::{Published, PublishedCell, PublishedFigure};
use base::diagnostic::Diagnostic;
use base::keys;
use base::signature::{DeclarationId, Form, Keys, Param, Type};
use base::units::Dimension;
use lang::diagnostics;
use lang::hir::{Block, Declaration, Program};

/// The published figures that can be compared with ours: the metric, the keys of mean and spread, and its description.
const FIGURES: [(&str, &str, &str, &str); 6] = [
    ("touch_rate", "touch", "touch_sd", "Collisions and bumps of all episodes."),
    ("front_rate", "front", "front_sd", "The share of these in the front sector."),
    ("collision_rate", "collision", "collision_sd", "Collisions of all episodes; the car moved."),
    ("episode_reward", "reward_mean", "reward_sd", "Reward of an episode."),
    ("episode_length_s", "length", "length_sd", "Length of an episode (s)."),
    ("impact_speed_mps", "impact_speed", "impact_speed_sd", "Speed of the car at a collision (m/s)."),
];
/// The description of the spreads in the reference.
const SPREAD: &str = "Sample standard deviation of that over the published runs.";

/// The metrics that published figures can be compared with.
pub fn published_columns() -> impl Iterator<Item = &'static str> {
    FIGURES.into_iter().map(|(column, ..)| column)
}

keys! {
    /// Figures that others have published, to stand beside those of a campaign that names them.
    pub struct PublishedKeys = "published" {
        /// Where the figures are from, for the report.
        source: String,
        /// How many trainings the figures are averaged over.
        runs: u32 as whole(1, 1_000_000) = "3",
    }
}

keys! {
    /// Figures of one cell of a published table, as they are printed.
    pub struct CellKeys = "cell" {
        /// Rewards that this cell is for.
        rewards: Vec<DeclarationId> as Reference("reward"),
        /// Towns that its pedestrians were tried in.
        towns: Vec<DeclarationId> as Reference("town"),
        /// Drivers that they were tried against.
        drivers: Vec<DeclarationId> as Reference("driver"),
    }
}

/// The form `published`.
pub fn form() -> Form {
    let figure = |name, ty, doc| Param::new::<Option<f64>>(name, ty, None, doc);
    let mut cells = CellKeys::signature();
    for (_, mean, spread, doc) in FIGURES {
        cells.params.push(figure(mean, Type::any(Dimension::RATIO), doc));
        cells.params.push(figure(spread, Type::non_negative(Dimension::RATIO), SPREAD));
    }
    Form::plain(PublishedKeys::signature().holding(vec![cells]))
}

/// The figures of a declaration.
pub fn lower(declaration: &Declaration, program: &Program, said: &mut Vec<Diagnostic>) -> Published {
    let PublishedKeys { source, runs } = declaration.block.keys();
    let cells = declaration.block.inside().map(|(block, keys)| cell(block, keys, program, said)).collect();
    Published { source, docs: declaration.docs.join(" "), runs, cells }
}

fn cell(block: &Block, keys: CellKeys, program: &Program, said: &mut Vec<Diagnostic>) -> PublishedCell {
    let given = |key| block.arguments.read::<Option<f64>>(key);
    for (_, mean, spread, _) in FIGURES {
        if given(spread).is_some() && given(mean).is_none() {
            let message = format!("`{spread}` is the spread of `{mean}`, which is not given");
            said.push(diagnostics::contradiction(block.place(spread), message));
        }
    }
    let names = |ids: Vec<DeclarationId>| ids.into_iter().map(|id| program.get(id).name.clone()).collect();
    let figure = |(column, mean, spread, _)| Some(PublishedFigure { column, mean: given(mean)?, sd: given(spread) });
    PublishedCell {
        rewards: names(keys.rewards),
        towns: names(keys.towns),
        policies: names(keys.drivers),
        figures: FIGURES.into_iter().filter_map(figure).collect(),
    }
}
