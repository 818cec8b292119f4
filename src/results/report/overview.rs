//! Several reports of one call side by side: the variants of a matrix, and the campaigns of several files.

use polars::prelude::{DataFrame, NamedFrom, PolarsResult, Series};

use super::{Doubt, DriverResult, SearchCell};
use crate::record::columns::WORLD;
use crate::record::{Column, Table, in_block};
use crate::tables::Cell;
use crate::tables::metrics::compared;
use compile::HERE;

/// The results of a report for an overview.
#[derive(Debug, Clone)]
pub struct Variant<'a> {
    /// The name of the report's folder, which is beside the overview.
    pub report: String,
    /// The settings of the campaign, as `name = value`.
    pub settings: &'a [String],
    pub cells: &'a [Cell],
    /// What was found about each driver.
    pub drivers: &'a [DriverResult],
    /// Means of its searches.
    pub searches: &'a [SearchCell],
    /// The doubts about its trainings.
    pub doubts: &'a [Doubt],
}

/// What a row of an overview is about.
#[derive(Debug, Clone, Copy)]
pub enum Found<'a> {
    /// A controller in a town against a driver.
    Evaluated(&'a Cell),
    /// A falsifier in a town against a driver.
    Searched(&'a SearchCell),
}

/// A row of an overview: a cell of one of the reports.
#[derive(Debug, Clone)]
pub struct OverviewRow<'a> {
    /// The report.
    pub variant: &'a Variant<'a>,
    /// The value of each parameter; `None` if the campaign does not have it.
    pub values: Vec<Option<String>>,
    pub found: Found<'a>,
}

impl<'a> OverviewRow<'a> {
    /// The name of the driver.
    pub fn driver(&self) -> &'a str {
        match self.found {
            Found::Evaluated(cell) => &cell.key.policy,
            Found::Searched(cell) => &cell.key.policy,
        }
    }

    pub fn town(&self) -> &'a str {
        match self.found {
            Found::Evaluated(cell) => &cell.key.town,
            Found::Searched(cell) => &cell.key.town,
        }
    }

    /// The simulator in which the car drove.
    pub fn world(&self) -> &'a str {
        match self.found {
            Found::Evaluated(cell) => &cell.key.world,
            Found::Searched(_) => HERE,
        }
    }

    /// Its report, block, car, body and simulator, which tell cells of one name apart.
    pub fn block_in_words(&self) -> String {
        let report = &self.variant.report;
        match self.found {
            Found::Evaluated(Cell { key, .. }) => {
                format!("{report}{}, {}, {}, {}", in_block(key.block), key.vehicle, key.adversary, key.world)
            }
            Found::Searched(cell) => format!("{report}{}", in_block(cell.key.block)),
        }
    }

    /// The controller with its reward, and with its training where that was elsewhere; or the falsifier.
    pub fn who(&self) -> String {
        match self.found {
            Found::Searched(cell) => cell.key.falsifier.clone(),
            Found::Evaluated(cell) => {
                let key = &cell.key;
                let is_home = (&key.town, &key.policy) == (&key.train_town, &key.train_policy);
                if is_home { format!("{} {}", key.controller, key.reward) } else { key.who() }
            }
        }
    }
}

/// The reports of a call side by side.
#[derive(Debug, Clone)]
pub struct Overview<'a> {
    /// The names of the settings that differ between the reports.
    pub parameters: Vec<&'a str>,
    pub variants: &'a [Variant<'a>],
    /// A row for each cell and each cell of searches of each report, in the order in which the reports were made.
    pub rows: Vec<OverviewRow<'a>>,
}

impl<'a> Overview<'a> {
    /// Puts reports side by side.
    pub fn new(variants: &'a [Variant<'a>]) -> Self {
        let mut parameters: Vec<&str> = Vec::new();
        for (name, _) in variants.iter().flat_map(|variant| variant.settings).filter_map(|setting| parts(setting)) {
            let first = variants.first().and_then(|variant| value(variant, name));
            if !parameters.contains(&name) && variants.iter().any(|variant| value(variant, name) != first) {
                parameters.push(name);
            }
        }
        let mut this = Self { parameters, variants, rows: Vec::new() };
        for variant in variants {
            let values = this.values(variant);
            let found = variant.cells.iter().map(Found::Evaluated).chain(variant.searches.iter().map(Found::Searched));
            this.rows.extend(found.map(|found| OverviewRow { variant, values: values.clone(), found }));
        }
        this
    }

    /// The value of each parameter in a report; `None` if its campaign does not have it.
    pub fn values(&self, variant: &Variant<'_>) -> Vec<Option<String>> {
        self.parameters.iter().map(|name| value(variant, name).map(str::to_string)).collect()
    }

    /// The overview as a table, with a column of text for each parameter at its end.
    ///
    /// # Errors
    /// Those of polars, for two parameters of one name.
    pub fn table(&self) -> PolarsResult<DataFrame> {
        let mut frame = columns().frame(&self.rows);
        for (place, name) in self.parameters.iter().enumerate() {
            let values: Vec<Option<&str>> = self.rows.iter().map(|row| row.values[place].as_deref()).collect();
            frame.with_column(Series::new((*name).into(), values).into())?;
        }
        Ok(frame)
    }
}

/// The columns of an overview, without those of the parameters.
fn columns<'t, 'a: 't>() -> Table<'t, OverviewRow<'a>> {
    type Row<'a> = OverviewRow<'a>;
    let number = Column::<f64>::new;
    let cell = |row: &Row<'a>| if let Found::Evaluated(cell) = row.found { Some(cell) } else { None };
    let searched = |row: &Row<'a>| if let Found::Searched(cell) = row.found { Some(cell) } else { None };
    let mut table = Table::<Row<'a>>::new(
        "overview",
        "One row for each cell of each report of a call: a pedestrian or a search in a town against a driver.",
    )
    .text("report", "folder of the report", |row| row.variant.report.clone())
    .text("driver", "name of the driver", |row| row.driver().to_string())
    .text("town", "name of the town", |row| row.town().to_string())
    .column(WORLD.of(|row: &Row<'a>| row.world().to_string()))
    .text("pedestrian", "the pedestrian; empty for a search", move |row| {
        cell(row).map_or(String::new(), |cell| cell.key.controller.clone())
    })
    .text("reward", "its reward; empty for a search", move |row| {
        cell(row).map_or(String::new(), |cell| cell.key.reward.clone())
    })
    .text("training", "town and driver of its training; empty without one", move |row| {
        let key = cell(row).map(|cell| &cell.key).filter(|key| key.is_trained());
        key.map_or(String::new(), |key| format!("{}, {}", key.train_town, key.train_policy))
    })
    .text("method", "the search; empty for a pedestrian", move |row| {
        searched(row).map_or(String::new(), |cell| cell.key.falsifier.clone())
    })
    .column(Column::<u64>::new("runs", "", "number of its runs").of(|row: &Row<'a>| match row.found {
        Found::Evaluated(cell) => u64::from(cell.runs()),
        Found::Searched(cell) => cell.runs as u64,
    }));
    for metric in compared().rev() {
        let name = metric.name;
        let of = move |row: &Row<'a>| cell(row).map(|cell| cell.rate(metric));
        let sd = number("", "", "its standard deviation over runs; missing for one");
        let low = number("", "", "lower end of its 95 % interval over starts (Wilson)");
        table = table
            .number(name, "mean over the runs", move |row| of(row)?.value)
            .column(sd.of(move |row: &Row<'a>| of(row)?.sd).named(format!("{name}_sd")))
            .column(low.of(move |row: &Row<'a>| Some(of(row)?.interval?.0)).named(format!("{name}_wilson_low")))
            .column(
                number("", "", "upper end of the same")
                    .of(move |row: &Row<'a>| Some(of(row)?.interval?.1))
                    .named(format!("{name}_wilson_high")),
            );
    }
    let average = move |of: fn(&SearchCell) -> Option<f64>| move |row: &Row<'a>| searched(row).and_then(of);
    table
        .number(
            "search_faults_start_rate",
            "share of starts from which the search found a fault",
            average(|cell| cell.fault_start_rate.value),
        )
        .number(
            "search_faults_start_rate_low",
            "lower end of its 95 % interval (Student, over runs in that town); missing for fewer than four",
            average(|cell| Some(cell.fault_start_rate.interval?.0)),
        )
        .number(
            "search_faults_start_rate_high",
            "upper end of the same",
            average(|cell| Some(cell.fault_start_rate.interval?.1)),
        )
        .number(
            "search_failed_starts",
            "starts from which it found a failure, mean over runs",
            average(|cell| cell.failed_starts.value),
        )
        .number("search_starts", "starts from which it searched, mean over runs", average(|cell| cell.starts.value))
}

/// A setting's name and value.
fn parts(setting: &str) -> Option<(&str, &str)> {
    setting.split_once('=').map(|(name, value)| (name.trim(), value.trim()))
}

/// The value of a setting; of a setting that is given twice the last.
fn value<'a>(variant: &Variant<'a>, name: &str) -> Option<&'a str> {
    variant
        .settings
        .iter()
        .rev()
        .filter_map(|setting| parts(setting))
        .find(|found| found.0 == name)
        .map(|found| found.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::CellKey;
    use crate::report::{Method, Rate};
    use crate::tables::metrics::COLLISION_RATE;

    #[test]
    fn each_controller_of_each_value_has_a_row_with_its_spread() {
        let cell = |controller: &str, collision: f64, sd: Option<f64>| {
            let key = CellKey {
                policy: "a".into(),
                town: "x".into(),
                controller: controller.into(),
                reward: "r".into(),
                world: "there".into(),
                ..CellKey::default()
            };
            let ends = Some((collision - 0.1, collision + 0.1));
            let rate = Rate { sd, ..Rate::single(collision) }.within(ends, Method::Wilson);
            Cell::example(key, &[], &[(&COLLISION_RATE, rate)])
        };
        let cells = [cell("trained", 0.2, Some(0.03)), cell("random", 0.5, None)];
        let settings = [3, 8].map(|weight| vec!["same = 1".to_string(), format!("weight = {weight}")]);
        let variants: Vec<Variant<'_>> = settings
            .iter()
            .map(|settings| Variant {
                report: "r".into(),
                settings,
                cells: &cells,
                drivers: &[],
                searches: &[],
                doubts: &[],
            })
            .collect();
        let overview = Overview::new(&variants);
        assert_eq!(overview.parameters, ["weight"]);
        assert_eq!(overview.rows.len(), 4, "two values, two controllers");
        assert_eq!(overview.rows[2].values, [Some("8".to_string())]);
        assert_eq!(overview.rows[3].who(), "random r");
        let table = overview.table().unwrap();
        assert_eq!(table.height(), 4);
        assert_eq!(table.column("weight").unwrap().str().unwrap().get(0), Some("3"));
        assert_eq!(table.column("world").unwrap().str().unwrap().get(0), Some("there"));
        assert_eq!(table.column("collision_rate_sd").unwrap().f64().unwrap().get(1), None);
    }
}
