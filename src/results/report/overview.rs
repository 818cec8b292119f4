//! Several reports of one call side by side: the variants of a matrix, and the campaigns of several files.

use polars::prelude::{DataFrame, NamedFrom, PolarsResult, Series};

use super::{Average, Cell, DriverResult, SearchCell};
use crate::record::{Column, Table};

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
}

/// A rate in the cell in which it is highest.
#[derive(Debug, Clone, PartialEq)]
pub struct HighestRate {
    /// The rate, mean over runs.
    pub rate: f64,
    /// Its 95 % interval: for evaluations Wilson's over the episodes of all runs, for searches Student's over runs, about further
    /// runs in that town. None for searches with fewer than four runs.
    pub interval: Option<(f64, f64)>,
    /// The place of the cell in the list of cells, or of searches.
    pub cell: usize,
}

/// A row of an overview: a driver in one of the reports.
#[derive(Debug, Clone)]
pub struct OverviewRow<'a> {
    /// The report.
    pub variant: &'a Variant<'a>,
    /// The value of each parameter; none where the campaign does not have it.
    pub values: Vec<Option<String>>,
    /// The driver, with its worst failure.
    pub result: &'a DriverResult,
    /// The highest rates over controllers and towns, in the order of [`OverviewRow::RATES`]; none without an evaluation.
    pub rates: [Option<HighestRate>; 3],
    /// The highest share of starts from which a search found a fault; none without a search.
    pub searched: Option<HighestRate>,
}

impl OverviewRow<'_> {
    /// The names of the rates.
    pub const RATES: [&'static str; 3] = ["fault", "preventable", "collision"];
    /// The name of the rate of searches.
    pub const SEARCHED: &'static str = "fault starts of searches";

    /// The rate at a place of [`OverviewRow::RATES`]; at the place after these that of searches.
    pub fn rate(&self, place: usize) -> Option<&HighestRate> {
        self.rates.get(place).unwrap_or(&self.searched).as_ref()
    }
}

/// The reports of a call side by side.
#[derive(Debug, Clone)]
pub struct Overview<'a> {
    /// The names of the settings that differ between the reports.
    pub parameters: Vec<&'a str>,
    /// A row for each driver of each report, in the order in which the reports were made.
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
        let row = |variant: &'a Variant<'a>, result: &'a DriverResult| {
            let highest = |rate: RateOf| highest(variant.cells, &result.driver.name, rate);
            OverviewRow {
                variant,
                values: parameters.iter().map(|name| value(variant, name).map(str::to_string)).collect(),
                result,
                rates: [
                    highest(|cell| (cell.fault.mean, cell.fault_interval)),
                    highest(|cell| (cell.preventable.mean, cell.preventable_interval)),
                    highest(|cell| (cell.collision.mean, cell.interval)),
                ],
                searched: highest_searched(variant.searches, &result.driver.name),
            }
        };
        let rows = variants.iter().flat_map(|variant| variant.drivers.iter().map(move |result| (variant, result)));
        let rows = rows.map(|(variant, result)| row(variant, result)).collect();
        Self { parameters, rows }
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
    let (text, number) = (Column::<String>::new, Column::<f64>::new);
    let mut table = Table::new("overview", "One row for each driver of each report of a call.")
        .column(text("report", "", "folder of the report").of(|row: &Row<'a>| row.variant.report.clone()))
        .column(text("policy", "", "name of the driving policy").of(|row: &Row<'a>| row.result.driver.name.clone()));
    let rates = [
        ["fault_rate", "fault_rate_wilson_low", "fault_rate_wilson_high", "fault_controller"],
        ["preventable_rate", "preventable_rate_wilson_low", "preventable_rate_wilson_high", "preventable_controller"],
        ["collision_rate", "collision_rate_wilson_low", "collision_rate_wilson_high", "collision_controller"],
    ];
    for (place, [rate, low, high, controller]) in rates.into_iter().enumerate() {
        let of = move |row: &Row<'a>| row.rates[place].clone();
        table = table
            .column(
                number(rate, "", "highest rate over controllers and towns")
                    .of(move |row: &Row<'a>| of(row).map(|found| found.rate)),
            )
            .column(
                number(low, "", "lower end of its 95 % interval (Wilson)")
                    .of(move |row: &Row<'a>| of(row).and_then(|found| found.interval).map(|ends| ends.0)),
            )
            .column(
                number(high, "", "upper end of its 95 % interval (Wilson)")
                    .of(move |row: &Row<'a>| of(row).and_then(|found| found.interval).map(|ends| ends.1)),
            )
            .column(text(controller, "", "the controller and the town of that rate").of(move |row: &Row<'a>| {
                of(row).map_or(String::new(), |found| row.variant.cells[found.cell].key.to_string())
            }));
    }
    let searched = |value: fn(&HighestRate) -> Option<f64>| move |row: &Row<'a>| row.searched.as_ref().and_then(value);
    table = table
        .column(
            number(
                "search_faults_start_rate",
                "",
                "share of starts from which a search found a fault, highest over falsifiers and towns",
            )
            .of(searched(|found| Some(found.rate))),
        )
        .column(
            number(
                "search_faults_start_rate_low",
                "",
                "lower end of its 95 % interval (Student, over runs in that town); missing for fewer than four",
            )
            .of(searched(|found| found.interval.map(|ends| ends.0))),
        )
        .column(
            number("search_faults_start_rate_high", "", "upper end of the same")
                .of(searched(|found| found.interval.map(|ends| ends.1))),
        )
        .column(text("search_falsifier", "", "the falsifier and the town of that rate").of(|row: &Row<'a>| {
            let cell = row.searched.as_ref().map(|found| &row.variant.searches[found.cell]);
            cell.map_or(String::new(), SearchCell::in_full)
        }));
    table
        .column(
            text("worst_failure", "", "verdict of the worst failure; empty without a collision")
                .of(|row: &Row<'a>| row.result.worst.as_ref().map_or(String::new(), |found| found.word().to_owned())),
        )
        .column(
            number("worst_impact_speed", "m/s", "speed of the car at its touch")
                .of(|row: &Row<'a>| row.result.worst.as_ref().map(|found| found.impact_speed)),
        )
        .column(
            text("worst_episode", "", "its name, `RUN:EPISODE`")
                .of(|row: &Row<'a>| row.result.worst.as_ref().map_or(String::new(), super::ListedFailure::name)),
        )
        .column(
            number("search_failures", "", "failures that searches found")
                .of(|row: &Row<'a>| row.result.searched.map(|found| found.all as f64)),
        )
        .column(
            number("search_faults", "", "fault ones of these")
                .of(|row: &Row<'a>| row.result.searched.map(|found| found.fault as f64)),
        )
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

/// A rate of a cell with its interval.
type RateOf = fn(&Cell) -> (Option<f64>, (f64, f64));

/// The cell of a driver in which a rate is highest, the first of equal ones.
fn highest(cells: &[Cell], driver: &str, rate: RateOf) -> Option<HighestRate> {
    let of_driver = cells.iter().enumerate().filter(|(_, cell)| cell.key.policy == driver);
    let mut found: Option<HighestRate> = None;
    for (cell, (mean, interval)) in of_driver.map(|(place, cell)| (place, rate(cell))) {
        if let Some(rate) = mean.filter(|mean| found.as_ref().is_none_or(|found| *mean > found.rate)) {
            found = Some(HighestRate { rate, interval: Some(interval), cell });
        }
    }
    found
}

/// The search cell of a driver with the highest share of fault starts, the first of equal ones.
fn highest_searched(cells: &[SearchCell], driver: &str) -> Option<HighestRate> {
    let mut found: Option<HighestRate> = None;
    for (cell, searched) in cells.iter().enumerate().filter(|(_, searched)| searched.key.policy == driver) {
        let Average { mean, interval, .. } = searched.fault_start_rate;
        if let Some(rate) = mean.filter(|mean| found.as_ref().is_none_or(|found| *mean > found.rate)) {
            found = Some(HighestRate { rate, interval, cell });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::CellKey;
    use crate::report::Spread;
    use base::signature::Arguments;
    use compile::Driver;

    #[test]
    fn parameters_are_the_settings_that_differ_and_rates_are_the_highest() {
        let driver = Driver {
            name: "a".into(),
            kind: "idm",
            settings: Arguments::default(),
            sensors: None,
            sensor_model: None,
            surrogate: "",
        };
        let drivers = [DriverResult { driver, worst: None, cell: Some(0), searched: None }];
        let cell = |town: &str, collision: f64| Cell {
            key: CellKey { policy: "a".into(), town: town.into(), ..CellKey::default() },
            collision: Spread { mean: Some(collision), sd: None },
            interval: (collision - 0.1, collision + 0.1),
            ..Cell::default()
        };
        let cells = [cell("x", 0.2), cell("y", 0.5), cell("z", 0.5)];
        let settings = [3, 8].map(|brake| vec!["same = 1".to_string(), format!("a.brake = {brake} m/s^2")]);
        let variants: Vec<Variant<'_>> = settings
            .iter()
            .map(|settings| Variant { report: "r".into(), settings, cells: &cells, drivers: &drivers, searches: &[] })
            .collect();
        let overview = Overview::new(&variants);
        assert_eq!(overview.parameters, ["a.brake"]);
        assert_eq!(overview.rows[1].values, [Some("8 m/s^2".to_string())]);
        let highest = overview.rows[0].rates[2].as_ref().unwrap();
        assert_eq!((highest.rate, highest.cell), (0.5, 1));
        assert_eq!(overview.rows[0].rates[0], None, "a rate without a value is none");
        assert_eq!((overview.rows[0].rate(2), overview.rows[0].rate(3)), (Some(highest), None));
        let table = overview.table().unwrap();
        assert_eq!(table.height(), 2);
        assert_eq!(table.column("a.brake").unwrap().str().unwrap().get(0), Some("3 m/s^2"));
    }
}
