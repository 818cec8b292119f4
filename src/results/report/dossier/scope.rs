use super::{NOT_DONE, section};
use crate::report::grouped::grouped;
use crate::report::render::{Column, FAULT, LEFT_OUT, Section, Selection, Table};
use crate::report::{DistinctFailure, Findings};
use base::signature::{Distribution, short};
use compile::{Driver, Evaluation, Search};
use episode::requirement::NamedRequirement;
use episode::{EgoSpeed, Scenario};

/// Who the careful human of a fault is.
const HUMAN: &str = "Careful drivers in place of the driver avoid a fault, two careful humans, one of them 0.4 s faster, and the Fuzzy Safety Model, the humans with 0.1 m to spare, from the instant at which the danger begins. \
     The careful human has the times and the brake of UN Regulation 157, annex 3, behind an on-course gate after the FSM of the same annex: 0.4 s to evaluate the risk, 0.75 s to react, 0.6 s to full braking, and no harder than this car can brake. \
     The regulation was read in transcriptions and covers roads that are closed to pedestrians, so this use is an extrapolation; the gate that begins the \
     evaluation is `esmini`'s for pedestrians, with 0.5 m and 0.1 s of our choice.";
/// Where the figures are.
const TABLES: &str = "Rates are in the table `results` of the report, searches in `searches`, failures in `failures`, tests of a protocol in `protocol`, \
     requirements in `requirements`. What is merged, shrunk or explained, and the sections on coverage and numerical error, were computed for this page.";

/// The question of the campaign, its drivers, and what must be known first.
pub fn scope(found: &Findings<'_>) -> Section {
    let campaign = found.campaign;
    let mut lead = vec![campaign.docs.join("\n")];
    lead.extend(found.cautions.iter().map(|caution| format!("**{caution}.**")));
    lead.extend(found.doubts.iter().map(|doubt| format!("**{doubt}.**")));
    lead.push(format!("{FAULT} {HUMAN}"));
    lead.push(LEFT_OUT.into());
    lead.push(TABLES.into());
    let docs = |driver: &Driver| {
        let documented = campaign.words.iter().find(|word| word.form == "driver" && word.name == driver.name);
        documented.map_or_else(String::new, |word| word.docs.clone())
    };
    let shown = Selection::new()
        .text("driver", |driver: &Driver| driver.name.clone())
        .text("kind", |driver| driver.kind)
        .text("keys other than the defaults", |driver| match driver.changed.as_slice() {
            [] => "none".into(),
            changed => changed.join(", "),
        })
        .text("sensors", |driver| {
            driver.sensors.clone().unwrap_or_else(|| "none: it perceives exactly and without delay".into())
        })
        .text("what it is", docs)
        .text("as a surrogate", |driver| driver.surrogate);
    let drivers = Table { title: "Drivers".into(), ..shown.table(&campaign.drivers) };
    section("scope", "Scope and assumptions", lead, vec![drivers, varied(found)])
}

/// What differs between the starts of evaluations and searches, and how many there are.
fn varied(found: &Findings<'_>) -> Table {
    let evaluations = found.campaign.all::<Evaluation>();
    let evaluations =
        evaluations.map(|each| (each.controller.name(), format!("{} episodes", each.episodes), &each.scenario));
    let searches = found.campaign.all::<Search>();
    let searches = searches.map(|each| (each.key.falsifier.as_str(), format!("{} ticks", each.budget), &each.scenario));
    let rows = evaluations.chain(searches).map(|(name, amount, scenario)| (name.to_owned(), amount, starts(scenario)));
    let starts = ["bearing, °", "distance, m", "speed of the car, m/s", "car, m", "pedestrian, m/s", "friction"];
    let shown = Selection::new()
        .text("pedestrian or search", |equal: &Vec<(String, String, [String; 6])>| equal[0].0.clone())
        .text("each", |equal| equal[0].1.clone())
        .each(
            starts.into_iter().enumerate(),
            |(_, name)| Column::text(*name),
            |(number, _), equal| equal[0].2[*number].clone(),
        )
        .number("of these", Vec::len);
    Table {
        title: "What was varied".into(),
        notes: vec!["One of these is a pedestrian or search in a town against a driver, in one run; a search has its ticks as its budget.".into()],
        ..shown.table(&grouped(rows, Clone::clone))
    }
}

/// The ranges from which a scenario draws its starts, and what is the same in all of them.
fn starts(scenario: &Scenario) -> [String; 6] {
    let range = |values: &Distribution, unit: f64| {
        let (low, high) = values.support();
        let [low, high] = [low, high].map(|value| short((value * unit * 100.0).round() / 100.0));
        if low == high { low } else { format!("{low} to {high}") }
    };
    let Scenario { spawn, cast, episode, .. } = scenario;
    let (blueprint, walks) = (&cast.ego().blueprint, cast.pedestrian().action.speed);
    let is_given = spawn.target_walk.is_some() || spawn.given_path.is_some();
    let placed = |values: &Distribution, unit: f64| if is_given { "as given".into() } else { range(values, unit) };
    [
        placed(&spawn.bearing, 1_f64.to_degrees()),
        placed(&spawn.distance, 1.0),
        match (&spawn.ego_speed, spawn.test_speed) {
            (_, Some(speed)) => range(&Distribution::Constant(speed), 1.0),
            (EgoSpeed::Drawn(speeds), None) => range(speeds, 1.0),
            (EgoSpeed::Steady, None) => "its own".into(),
        },
        format!("{:.2} × {:.2}", 2.0 * blueprint.half_length, 2.0 * blueprint.half_width),
        placed(&Distribution::Uniform(walks.0, walks.1), 1.0),
        episode.friction.map_or_else(|| "as of the car".into(), short),
    ]
}

/// What was required, where, and what came.
pub fn requirements(found: &Findings<'_>, made: &[Section]) -> Section {
    let docs = |named: &NamedRequirement| {
        let documented =
            found.campaign.words.iter().find(|word| word.form == "requirement" && *word.name == *named.name);
        documented.map_or_else(String::new, |word| word.docs.clone())
    };
    let named = Selection::new()
        .text("requirement", |named: &NamedRequirement| named.name.to_string())
        .text("what it says", docs)
        .table(&*found.campaign.requirements);
    let of = |id: &str| made.iter().find(|section| section.id == id);
    let (protocol, results) = (of("protocol"), of("requirements"));
    let lead = match (results, named.rows.is_empty()) {
        (Some(results), _) => results.lead.clone(),
        (None, true) if protocol.is_some() => vec![
            "The limits of the protocol's tests are what is required. Some of them allow a collision, which is a failure in the section above all the same.".into(),
        ],
        (None, true) => {
            vec![format!("{NOT_DONE} The campaign names no requirement other than that there is no collision.")]
        }
        (None, false) => vec![format!(
            "{NOT_DONE} No evaluation judged these requirements. Searches look for violations of their `goal` alone, which are among the failures above."
        )],
    };
    let named = (!named.rows.is_empty()).then_some(named);
    let results = protocol.into_iter().chain(results).flat_map(|section| {
        let mut tables: Vec<Table> = section.tables_of_report().cloned().collect();
        tables.last_mut().into_iter().for_each(|last| last.notes.extend(section.notes.iter().cloned()));
        tables
    });
    let tables: Vec<Table> = named.into_iter().chain(results).collect();
    section("requirements", "From requirement to scenario to result", lead, tables)
}

/// What is modelled, after which source, and how far that was compared.
const MODELS: [[&str; 3]; 8] = [
    [
        "car",
        "kinematic bicycle; drive and brakes of the engine that CARLA 0.9 uses",
        "data of CARLA's vehicles and of PhysX 3",
    ],
    ["pedestrian's body", "a disc with limits of acceleration and turning", "recorded walking; Euro NCAP's targets"],
    [
        "natural pedestrian",
        "waits for gaps, crosses, hesitates; failures are shrunk towards it, and settings tried with it",
        "recorded crossings; the Highway Capacity Manual",
    ],
    ["roads", "lanes, junctions, signs, lights of OpenDRIVE, flat", "ASAM OpenDRIVE 1.4 to 1.8"],
    ["traffic lights", "fixed cycles", "CARLA's controllers"],
    ["perception", "exact, or with the errors of the named sensors", "the scenario's `sensors`"],
    ["sight", "lines of sight from the driver's eye past buildings and parked cars", "geometry"],
    ["careful human", "evaluates, reacts, brakes", "UN R157, annex 3, in transcriptions"],
];

/// The models that the campaign used, and their sources.
pub fn models(found: &Findings<'_>, shown: &[DistinctFailure]) -> Section {
    let is_used = |[what, ..]: &&[&str; 3]| match *what {
        "natural pedestrian" => !shown.is_empty() || found.cells.iter().any(|cell| !cell.is_fixed_cases()),
        "traffic lights" => found.campaign.towns.iter().any(|named| !named.town.traffic_lights.is_empty()),
        _ => true,
    };
    let shown = Selection::new().each(
        ["what", "how", "after"].into_iter().enumerate(),
        |(_, name)| Column::text(*name),
        |(number, _), model: &[&str; 3]| model[*number],
    );
    let table = shown.table(MODELS.iter().filter(is_used));
    section("models", "What is modelled, and from which source", Vec::new(), vec![table])
}
