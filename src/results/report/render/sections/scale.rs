use std::collections::{BTreeMap, BTreeSet};

use crate::record::CellKey;
use crate::report::{DriverResult, SearchCell, SearchFailures};
use crate::tables::metrics::AVOIDABLE_INJURY;
use crate::tables::{Cell, GOAL, Metric};

/// The scale of a campaign's rates: in each setting the rate of a driver that sees no pedestrians; without one, the highest rate of the others.
#[derive(Debug)]
pub struct Scale<'a> {
    drivers: &'a [DriverResult],
    cells: &'a [Cell],
    searches: &'a [SearchCell],
    blind: Option<&'a str>,
    /// The cells of each setting, by its key without a driver.
    settings: BTreeMap<CellKey, Vec<usize>>,
}

/// The avoidable injury of a driver for 1,000 episodes, in its worst cell; without any evaluation, of its searches. `None` of the cases of a test, which are
/// no sample of episodes.
pub fn injury(result: &DriverResult, cells: &[Cell]) -> Option<f64> {
    match result.cell.map(|cell| &cells[cell]) {
        Some(cell) => cell.value(&AVOIDABLE_INJURY).filter(|_| !cell.is_fixed_cases()).map(|injury| injury * 1000.0),
        None => result.searched.and_then(|found| found.injury_per_thousand),
    }
}

/// A figure of the searches of a driver.
pub type SearchedOf = fn(&SearchFailures) -> Option<f64>;

impl<'a> Scale<'a> {
    pub fn new(drivers: &'a [DriverResult], cells: &'a [Cell], searches: &'a [SearchCell]) -> Self {
        let mut blind = drivers.iter().filter(|result| result.driver.sees_no_pedestrians());
        let blind = blind.clone().find(|result| result.cell.is_some()).or_else(|| blind.next());
        let mut settings: BTreeMap<CellKey, Vec<usize>> = BTreeMap::new();
        for (place, cell) in cells.iter().enumerate() {
            settings.entry(setting(cell)).or_default().push(place);
        }
        Self { drivers, cells, searches, blind: blind.map(|result| result.driver.name.as_str()), settings }
    }

    /// The name of the driver that sees no pedestrians; `None` without one.
    pub fn blind(&self) -> Option<&'a str> {
        self.blind
    }

    /// Whose rate is the upper end, for the head of a column; `None` if nobody can be compared.
    pub fn name(&self) -> Option<&'a str> {
        self.blind.or_else(|| (self.drivers.len() > 1).then_some("worst"))
    }

    /// The drivers in the setting of a cell: the same town, controller and body.
    fn peers(&self, cell: &Cell) -> impl Iterator<Item = &'a Cell> {
        let places = self.settings.get(&setting(cell)).map_or(&[][..], Vec::as_slice);
        places.iter().map(|place| &self.cells[*place])
    }

    /// The ends of the scale in the setting of a cell: the lowest rate, and that of the driver that sees no pedestrians, or the highest; `None` for a driver
    /// that is alone there.
    pub fn ends(&self, cell: &Cell, metric: &Metric) -> Option<(f64, f64)> {
        let rates = || self.peers(cell).filter_map(|other| other.value(metric));
        let blind = self.peers(cell).find(|other| self.blind == Some(other.key.policy.as_str()));
        let top = match self.blind {
            Some(_) => blind.and_then(|blind| blind.value(metric))?,
            None => rates().fold(0.0, f64::max),
        };
        (rates().count() > 1).then(|| (rates().fold(top, f64::min), top))
    }

    /// The rate of a cell as a share of the upper end; `None` if that is 0.
    pub fn share(&self, cell: &Cell, metric: &Metric) -> Option<f64> {
        let (_, top) = self.ends(cell, metric).filter(|(_, top)| *top > 0.0)?;
        cell.value(metric).map(|mean| mean / top)
    }

    /// The head of a column of shares; `None` where nobody can be compared.
    pub fn head(&self) -> Option<String> {
        let name = self.name()?;
        Some(if self.blind.is_some() { format!("of {name}'s") } else { format!("of the {name}") })
    }

    /// The avoidable injury of a driver, as [`Scale::of_driver`].
    pub fn injury_of(&self, result: &DriverResult) -> Option<f64> {
        injury(result, self.cells)?;
        self.of_driver(result, &AVOIDABLE_INJURY, |searched| searched.injury_per_thousand)
    }

    /// A figure of a driver as a share of the upper end: in the setting of its worst cell, else of the drivers with the same searches. `None` where nothing can
    /// be compared.
    pub fn of_driver(&self, result: &DriverResult, metric: &Metric, searched: SearchedOf) -> Option<f64> {
        if let Some(cell) = result.cell {
            return self.share(&self.cells[cell], metric);
        }
        let value = |result: &DriverResult| searched(&result.searched?);
        let searches = |driver: &str| -> BTreeSet<_> {
            let own = self.searches.iter().filter(|cell| cell.key.policy == driver);
            own.map(|cell| (&cell.key.town, &cell.key.falsifier, cell.key.block, cell.text(&GOAL))).collect()
        };
        let own = searches(&result.driver.name);
        let peers = self.drivers.iter().filter(|other| searches(&other.driver.name) == own);
        let top = match self.blind {
            Some(blind) => peers.clone().filter(|other| other.driver.name == blind).find_map(value)?,
            None => peers.clone().filter_map(value).fold(0.0, f64::max),
        };
        (peers.count() > 1 && top > 0.0).then(|| value(result).map(|value| value / top)).flatten()
    }
}

/// The key of a cell without its driver.
fn setting(cell: &Cell) -> CellKey {
    CellKey { policy: String::new(), ..cell.key.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Rate;
    use crate::tables::metrics::FAULT_RATE;
    use base::signature::Arguments;
    use compile::Driver;

    #[test]
    fn a_rate_is_compared_with_the_blind_driver_of_its_setting() {
        let cell = |town: &str, policy: &str, fault| {
            let key = CellKey { town: town.into(), policy: policy.into(), ..CellKey::default() };
            Cell::example(key, &[], &[(&FAULT_RATE, Rate::single(fault))])
        };
        let cells = [
            cell("a", "good", 0.1),
            cell("a", "bad", 0.3),
            cell("a", "blind", 0.4),
            cell("b", "good", 0.2),
            cell("b", "blind", 0.0),
        ];
        let result = |name: &str, kind, cell| DriverResult {
            driver: Driver {
                name: name.into(),
                kind,
                settings: Arguments::default(),
                changed: Vec::new(),
                sensors: None,
                sensor_model: None,
                surrogate: "",
            },
            worst: None,
            cell: Some(cell),
            searched: None,
            price: None,
            episodes: 100,
        };
        let results = [result("good", "idm", 0), result("blind", "cruise", 2)];
        let scale = Scale::new(&results, &cells, &[]);
        assert_eq!(scale.name(), Some("blind"));
        assert_eq!(scale.share(&cells[1], &FAULT_RATE), Some(0.3 / 0.4));
        assert_eq!(scale.ends(&cells[1], &FAULT_RATE), Some((0.1, 0.4)));
        assert_eq!(scale.share(&cells[3], &FAULT_RATE), None, "nobody has a fault there");
        // The worst cell of a driver is compared with the blind driver there, and not with its worst cell.
        let worst = DriverResult { cell: Some(3), ..results[0].clone() };
        let share = |result| scale.of_driver(result, &FAULT_RATE, |searched| searched.fault_start_rate);
        assert_eq!((share(&results[0]), share(&worst)), (Some(0.25), None));
        let pair = [result("good", "idm", 0), result("bad", "idm", 1)];
        let others = Scale::new(&pair, &cells[..2], &[]);
        assert_eq!(others.name(), Some("worst"));
        assert_eq!(others.ends(&cells[0], &FAULT_RATE), Some((0.1, 0.3)));
        assert_eq!(Scale::new(&[], &cells[..1], &[]).name(), None);
    }
}
