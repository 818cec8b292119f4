use super::super::sections::{place, who};
use crate::report::grouped::grouped;
use crate::tables::{Cell, Cells};

/// A cell with its name on the page.
#[derive(Debug, Clone)]
pub struct Named<'a> {
    pub cell: &'a Cell,
    /// The controller, with what distinguishes it from the others.
    pub who: String,
    /// The place and the driver.
    pub place: String,
    /// Number of the colour of the controller: the same in all figures.
    pub colour: usize,
}

/// Names the cells of a page and gives controllers their colours.
pub fn named(cells: &Cells) -> Vec<Named<'_>> {
    let mut all: Vec<Named<'_>> = Vec::new();
    let mut learners: Vec<String> = Vec::new();
    for cell in cells.iter() {
        let who = who(cell, cells);
        let place = format!("{} · {}", place(cell, cells), cell.key.policy);
        let colour = match cell.key.controller.as_str() {
            "random" => 6,
            "intercept" => 2,
            "homing" => 4,
            _ => {
                let number = learners.iter().position(|other| *other == who).unwrap_or(learners.len());
                if number == learners.len() {
                    learners.push(who.clone());
                }
                [0, 1, 3, 5, 4, 2][number % 6]
            }
        };
        all.push(Named { cell, who, place, colour });
    }
    all
}

/// The places of a page in order of appearance, each with its cells.
pub fn places<'a, 'b>(cells: &'b [Named<'a>]) -> Vec<(&'b str, Vec<&'b Named<'a>>)> {
    let places = grouped(cells, |cell| &cell.place).into_iter();
    places.map(|members| (members[0].place.as_str(), members)).collect()
}
