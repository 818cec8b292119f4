use super::{NOT_DONE, section};
use crate::report::Findings;
use crate::report::render::{Column, FAULT, LEFT_OUT, Section, Table, Value};

/// Who the careful human of a fault is.
const HUMAN: &str = "Two careful humans in place of the driver, one of them 0.4 s faster, both avoid a fault with 0.1 m to spare from the instant at which the danger begins. \
     The careful human is that of UN Regulation 157, annex 3: 0.4 s to evaluate the risk, 0.75 s to react, 0.6 s to full braking, and no harder than this car can brake.";

/// The question of the campaign, its drivers, and what must be known first.
pub fn scope(found: &Findings<'_>) -> Section {
    let campaign = found.campaign;
    let mut lead = vec![campaign.docs.join("\n")];
    lead.extend(found.cautions.iter().map(|caution| format!("**{caution}.**")));
    lead.extend(found.doubts.iter().map(|doubt| format!("**{doubt}.**")));
    lead.push(format!("{FAULT} {HUMAN}"));
    lead.push(LEFT_OUT.into());
    let row = |driver: &compile::Driver| {
        let sensors = driver.sensors.clone().unwrap_or_else(|| "none: it perceives exactly and without delay".into());
        let documented = campaign.words.iter().find(|word| word.form == "driver" && word.name == driver.name);
        let docs = documented.map_or_else(String::new, |word| word.docs.clone());
        let changed = if driver.changed.is_empty() { "none".into() } else { driver.changed.join(", ") };
        let words = [driver.kind.into(), changed, sensors, docs, driver.surrogate.into()];
        std::iter::once(Value::from(&driver.name)).chain(words.map(Value::from)).collect()
    };
    let drivers = Table {
        title: "Drivers".into(),
        head: ["driver", "kind", "keys other than the defaults", "sensors", "what it is", "as a surrogate"]
            .map(Column::text)
            .into(),
        rows: campaign.drivers.iter().map(row).collect(),
        ..Table::default()
    };
    section("scope", "Scope and assumptions", lead, vec![drivers])
}

/// What was required, where, and what came.
pub fn requirements(found: &Findings<'_>, made: &[Section]) -> Section {
    let of_campaign = found.campaign.requirements.iter();
    let row = |named: &world::requirement::NamedRequirement| {
        let docs = found.campaign.words.iter().find(|word| word.form == "requirement" && *word.name == *named.name);
        vec![Value::from(&*named.name), docs.map_or_else(String::new, |word| word.docs.clone()).into()]
    };
    let named = Table {
        head: ["requirement", "what it says"].map(Column::text).into(),
        rows: of_campaign.map(row).collect(),
        ..Table::default()
    };
    let of = |id: &str| made.iter().find(|section| section.id == id);
    let results = of("requirements");
    let lead = match (results, named.rows.is_empty()) {
        (Some(results), _) => results.lead.clone(),
        (None, true) => {
            vec![format!("{NOT_DONE} The campaign names no requirement other than that there is no collision.")]
        }
        (None, false) => vec![format!(
            "{NOT_DONE} No evaluation judged these requirements. Searches look for violations of their `goal` alone, which are among the failures above."
        )],
    };
    let named = (!named.rows.is_empty()).then_some(named);
    let results = of("protocol").into_iter().chain(results).flat_map(Section::tables_of_report).cloned();
    let tables: Vec<Table> = named.into_iter().chain(results).collect();
    section("requirements", "From requirement to scenario to result", lead, tables)
}

/// What is modelled, after which source, and how far that was compared.
const MODELS: [[&str; 3]; 9] = [
    [
        "car",
        "kinematic bicycle; drive and brakes of the engine that CARLA 0.9 uses",
        "data of CARLA's vehicles and of PhysX 3",
    ],
    ["pedestrian's body", "a disc with limits of acceleration and turning", "recorded walking; Euro NCAP's targets"],
    ["natural pedestrian", "waits for gaps, crosses, hesitates", "recorded crossings; the Highway Capacity Manual"],
    ["roads", "lanes, junctions, signs, lights of OpenDRIVE, flat", "ASAM OpenDRIVE 1.4 to 1.8"],
    ["traffic lights", "fixed cycles", "CARLA's controllers"],
    ["perception", "exact, or with the errors of the named sensors", "the scenario's `sensors`"],
    ["sight", "lines of sight from the driver's eye past buildings and parked cars", "geometry"],
    ["careful human", "evaluates, reacts, brakes", "UN R157, annex 3"],
    ["injury", "risk of severe injury by the speed of the car", "Tefft 2013"],
];

/// The models and their sources.
pub fn models() -> Section {
    let table = Table {
        head: ["what", "how", "after"].map(Column::text).into(),
        rows: MODELS.iter().map(|row| row.map(Value::from).into()).collect(),
        ..Table::default()
    };
    section("models", "What is modelled, and from which source", Vec::new(), vec![table])
}
