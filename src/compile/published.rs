use super::plan::{Published, PublishedCell, PublishedFigure};
use base::diagnostic::Diagnostic;
use base::signature::{DeclarationId, Form, Param, Signature, Type};
use base::units::Dimension;
use lang::diagnostics;
use lang::hir::{Block, Declaration, Program};

/// The published figures that can be compared with ours: the metric, the keys of mean and spread, and its description.
const FIGURES: [(&str, &str, &str, &str); 6] = [
    ("collision_rate", "collision", "collision_sd", "Collisions of all episodes."),
    ("front_rate", "front", "front_sd", "Frontal collisions of all collisions."),
    ("moving_rate", "moving", "moving_sd", "Collisions with a moving car of all episodes."),
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

/// The form `published`.
pub fn form() -> Form {
    let names = |form| Type::List(Box::new(Type::Reference(form)));
    let mut cell = vec![
        Param::required("rewards", names("reward"), "Rewards that this cell is for."),
        Param::required("towns", names("town"), "Towns that its pedestrians were tried in."),
        Param::required("policies", names("policy"), "Drivers that they were tried against."),
    ];
    for (_, mean, spread, doc) in FIGURES {
        cell.push(Param::optional(mean, Type::any(Dimension::RATIO), doc));
        cell.push(Param::optional(spread, Type::non_negative(Dimension::RATIO), SPREAD));
    }
    let params = vec![
        Param::required("source", Type::Text, "Where the figures are from, for the report."),
        Param::with_default(
            "runs",
            Type::Integer { min: 1, max: 1_000_000 },
            "3",
            "How many trainings the figures are averaged over.",
        ),
    ];
    let cells = Signature::new("cell", "Figures of one cell of a published table, as they are printed.", cell);
    let margins = FIGURES.map(|(_, mean, _, doc)| Param::optional(mean, Type::positive(Dimension::RATIO), doc));
    let margins = Signature::new(
        "margins",
        "For each figure, the difference that matters: ours is equivalent where the difference is shown to be smaller.",
        margins.into(),
    );
    Form {
        name: "published",
        doc: "Figures that others have published, to stand beside those of a campaign that names them.",
        plain: Some(Signature { children: vec![margins, cells], ..Signature::new("published", "", params) }),
        multiplies: false,
        kinds: Vec::new(),
    }
}

/// The figures of a declaration.
pub fn lower(declaration: &Declaration, program: &Program, said: &mut Vec<Diagnostic>) -> Published {
    let arguments = &declaration.block.arguments;
    let mut margins = declaration.block.nested("margins");
    let stated = margins.next();
    if let Some(second) = margins.next() {
        said.push(diagnostics::contradiction(second.head, "`margins` is given twice".to_string()));
    }
    Published {
        source: arguments.text("source").to_string(),
        docs: declaration.docs.join(" "),
        runs: arguments.integer("runs") as u32,
        cells: declaration.block.nested("cell").map(|block| cell(block, stated, program, said)).collect(),
    }
}

fn cell(block: &Block, margins: Option<&Block>, program: &Program, said: &mut Vec<Diagnostic>) -> PublishedCell {
    let arguments = &block.arguments;
    for (_, mean, spread, _) in FIGURES {
        if arguments.has(spread) && !arguments.has(mean) {
            let message = format!("`{spread}` is the spread of `{mean}`, which is not given");
            said.push(diagnostics::contradiction(block.place(spread), message));
        }
    }
    let name = |id: DeclarationId| program.get(id).name.clone();
    let names = |key| arguments.references(key).into_iter().map(name).collect();
    let given = |key| arguments.has(key).then(|| arguments.number(key));
    let margin = |mean| margins.filter(|block| block.arguments.has(mean)).map(|block| block.arguments.number(mean));
    let figure = |(column, mean, spread, _)| {
        Some(PublishedFigure { column, mean: given(mean)?, sd: given(spread), margin: margin(mean) })
    };
    PublishedCell {
        rewards: names("rewards"),
        towns: names("towns"),
        policies: names("policies"),
        figures: FIGURES.into_iter().filter_map(figure).collect(),
    }
}
