use crate::record::CellKey;
use crate::report::{Cell, DriverResult, Rate};

/// The scale of a campaign's rates: in each setting the rate of a driver that sees no pedestrians; without one, the highest rate of the others.
#[derive(Debug, Clone, Copy)]
pub struct Scale<'a> {
    cells: &'a [Cell],
    blind: Option<&'a str>,
}

/// A rate of a cell.
pub type RateOf = fn(&Cell) -> &Rate;

impl<'a> Scale<'a> {
    pub fn new(results: &'a [DriverResult], cells: &'a [Cell]) -> Self {
        let blind = results.iter().find(|result| result.cell.is_some() && result.driver.sees_no_pedestrians());
        Self { cells, blind: blind.map(|result| result.driver.name.as_str()) }
    }

    /// The name of the driver that sees no pedestrians; `None` without one.
    pub fn blind(&self) -> Option<&'a str> {
        self.blind
    }

    /// Whose rate is the upper end, for the head of a column; `None` if nobody can be compared.
    pub fn name(&self) -> Option<&'a str> {
        let first = self.cells.first()?;
        let several = || self.cells.iter().any(|cell| cell.key.policy != first.key.policy);
        self.blind.or_else(|| several().then_some("worst"))
    }

    /// The drivers in the setting of a cell: the same town, controller and body.
    fn peers(&self, cell: &Cell) -> impl Iterator<Item = &'a Cell> {
        let key = cell.key.clone();
        self.cells.iter().filter(move |other| CellKey { policy: key.policy.clone(), ..other.key.clone() } == key)
    }

    /// The ends of the scale in the setting of a cell: the lowest rate, and that of the driver that sees no pedestrians, or the highest; `None` for a driver
    /// that is alone there.
    pub fn ends(&self, cell: &Cell, rate: RateOf) -> Option<(f64, f64)> {
        let rates = || self.peers(cell).filter_map(|other| rate(other).value);
        let blind = self.peers(cell).find(|other| self.blind == Some(other.key.policy.as_str()));
        let top = match self.blind {
            Some(_) => blind.and_then(|blind| rate(blind).value)?,
            None => rates().fold(0.0, f64::max),
        };
        (rates().count() > 1).then(|| (rates().fold(top, f64::min), top))
    }

    /// The rate of a cell as a share of the upper end; `None` if that is 0.
    pub fn share(&self, cell: &Cell, rate: RateOf) -> Option<f64> {
        let (_, top) = self.ends(cell, rate).filter(|(_, top)| *top > 0.0)?;
        rate(cell).value.map(|mean| mean / top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::signature::Arguments;
    use compile::Driver;

    #[test]
    fn a_rate_is_compared_with_the_blind_driver_of_its_setting() {
        let cell = |town: &str, policy: &str, fault| Cell {
            key: CellKey { town: town.into(), policy: policy.into(), ..CellKey::default() },
            fault: Rate::single(fault),
            ..Cell::default()
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
                sensors: None,
                sensor_model: None,
                surrogate: "",
            },
            worst: None,
            cell: Some(cell),
            searched: None,
            episodes: 100,
        };
        let results = [result("good", "idm", 0), result("blind", "cruise", 2)];
        let scale = Scale::new(&results, &cells);
        assert_eq!(scale.name(), Some("blind"));
        assert_eq!(scale.share(&cells[1], |cell| &cell.fault), Some(0.3 / 0.4));
        assert_eq!(scale.ends(&cells[1], |cell| &cell.fault), Some((0.1, 0.4)));
        assert_eq!(scale.share(&cells[3], |cell| &cell.fault), None, "nobody has a fault there");
        let others = Scale::new(&results[..1], &cells[..2]);
        assert_eq!(others.name(), Some("worst"));
        assert_eq!(others.ends(&cells[0], |cell| &cell.fault), Some((0.1, 0.3)));
        assert_eq!(Scale::new(&[], &cells[..1]).name(), None);
    }
}
