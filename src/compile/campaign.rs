use base::signature::{Form, Param, Signature, Type};
use base::units::Dimension;

/// The built-in controllers.
pub(super) const PEDESTRIANS: &[&str] = &["trained", "sampled", "random", "homing", "intercept", "natural", "scripted"];

/// The form `campaign`.
pub fn form() -> Form {
    let name = |form| Type::Reference(form);
    let names = |form| Type::List(Box::new(Type::Reference(form)));
    let count = |max| Type::Integer { min: 1, max };
    let spawn =
        || Param::optional("spawn", name("spawn"), "Where these episodes begin, instead of the campaign's `spawn`.");
    let train = Signature::new(
        "train",
        "Trains one pedestrian for every town, policy, reward and run.",
        vec![
            Param::required("towns", names("town"), "Towns to train in."),
            Param::required("policies", names("policy"), "Drivers to train against."),
            Param::required("rewards", names("reward"), "Rewards to train for."),
            Param::with_default("runs", count(10_000), "5", "Trainings of each, with different seeds."),
            Param::optional(
                "together",
                Type::Choice(&["policies", "towns", "all"]),
                "Trains one pedestrian against all `policies`, in all `towns`, or both, whose episodes alternate; without it each pair of town and driver has a pedestrian of its own.",
            ),
            spawn(),
        ],
    );
    let evaluate = Signature::new(
        "evaluate",
        "Tries every pedestrian in every town against every policy.",
        vec![
            Param::required("towns", names("town"), "Towns to try them in."),
            Param::required("policies", names("policy"), "Drivers to try them against."),
            Param::with_default(
                "episodes",
                count(1_000_000),
                "1_000",
                "Episodes of each, at most when there is a `halfwidth`; all pedestrians have the same starts.",
            ),
            Param::optional(
                "halfwidth",
                Type::Quantity { dimension: Dimension::RATIO, min: 0.000_5, max: 0.5 },
                "Stops a pedestrian when the 95 % interval of its collision rate is so narrow to either side, looking after 1,000 episodes, 2,000, 4,000 and so on; the looks share the 5 %.",
            ),
            Param::with_default(
                "pedestrians",
                Type::List(Box::new(Type::WordOrReference(PEDESTRIANS, "controller"))),
                "[trained, random]",
                "Which pedestrians walk: trained ones with the mean action of their policy (`trained`) or drawing from it (`sampled`), one that acts at random, one that walks straight at the ego (`homing`), one that walks to where it would meet the ego (`intercept`), one that crosses as recorded pedestrians do (`natural`), the target of a test (`scripted`), or a `controller` of the file. Only the first two need a `train` block.",
            ),
            Param::optional(
                "vehicles",
                names("vehicle"),
                "Models of car to try them against, instead of the campaign's `vehicle`.",
            ),
            Param::optional(
                "adversaries",
                names("adversary"),
                "Bodies and readings to try them with, instead of the campaign's `adversary`.",
            ),
            spawn(),
        ],
    );
    let matrix = Signature::new(
        "matrix",
        "Runs the campaign once for every combination of values: `name: [value, …]`, each the name of a `param`.",
        Vec::new(),
    );
    let search = Signature::new(
        "search",
        "Lets falsifiers look for failures, each with the same budget and the same starts.",
        vec![
            Param::required("towns", names("town"), "Towns to search in."),
            Param::required("policies", names("policy"), "Drivers to find failures of."),
            Param::required("falsifiers", names("falsifier"), "Who searches."),
            Param::with_default("budget", count(1_000_000_000_000), "1_000_000", "Simulator ticks that each may use."),
            Param::with_default("runs", count(10_000), "10", "Searches of each, with different seeds and starts."),
            Param::with_default(
                "episodes",
                Type::Integer { min: 0, max: 1_000_000 },
                "200",
                "Episodes in which the pedestrian that a falsifier returns is evaluated afterwards, outside the budget.",
            ),
            Param::optional("adversary", name("adversary"), "The pedestrian, instead of the campaign's `adversary`."),
            spawn(),
        ],
    );
    let params = vec![
        Param::required("vehicle", name("vehicle"), "The model of car under test."),
        Param::required("adversary", name("adversary"), "The pedestrian."),
        Param::required("spawn", name("spawn"), "Where episodes begin."),
        Param::required("episode", name("episode"), "How long they last."),
        Param::optional("training", name("training"), "How pedestrians are trained, where any are."),
        Param::optional("beside", names("published"), "Published figures to stand beside those of this campaign."),
    ];
    Form {
        name: "campaign",
        doc: "What is run: which pedestrians are trained, where they are evaluated, and which falsifiers are compared.",
        plain: Some(Signature {
            children: vec![matrix, train, evaluate, search],
            ..Signature::new("campaign", "", params)
        }),
        multiplies: true,
        kinds: Vec::new(),
    }
}
