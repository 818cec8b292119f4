use polars::prelude::{Column, DataFrame};

use super::columns::Columns;
use super::{CellEvidence, Comparison, Figure, Quantiles, Transfer};
use crate::judge::Reference;
use crate::record::CellKey;
use crate::statistics::wilson;

/// What the table of cells holds beside its means, in the order of the cells.
pub fn cell_columns(cells: &[CellEvidence]) -> Vec<Column> {
    let mut columns = Columns::new(cells);
    for figure in Figure::ALL {
        let name = figure.name();
        columns.text(&format!("{name}_by_run"), |cell| by_run(&cell.between(figure).by_run));
        columns.number(&format!("{name}_iqm"), |cell| cell.between(figure).iqm);
        columns.interval(&format!("{name}_bootstrap"), |cell| cell.between(figure).bootstrap);
        columns.interval(&format!("{name}_student"), |cell| cell.between(figure).student);
    }
    quantiles(&mut columns, "impact_speed_mps", ["median", "p90", "p99"], |cell| &cell.impact_speed);
    let low = ["p01", "p10", "median"];
    columns.count("min_ttc_episodes", |cell| cell.min_ttc.n);
    quantiles(&mut columns, "min_ttc_s", low, |cell| &cell.min_ttc);
    columns.count("pet_episodes", |cell| cell.pet.n);
    quantiles(&mut columns, "pet_s", low, |cell| &cell.pet);
    for reference in Reference::ALL {
        let name = reference.name();
        columns.count(&format!("{name}_avoided_collisions"), |cell| cell.split(reference).0);
        columns.number(&format!("{name}_collision_rate"), |cell| {
            (cell.episodes > 0).then(|| cell.split(reference).1 as f64 / cell.episodes as f64)
        });
        columns.interval(&format!("{name}_collision_rate_wilson"), |cell| {
            Some(wilson(cell.split(reference).1, cell.episodes))
        });
    }
    columns.into_columns()
}

fn quantiles(columns: &mut Columns<CellEvidence>, name: &str, shares: [&str; 3], of: fn(&CellEvidence) -> &Quantiles) {
    for (place, share) in shares.into_iter().enumerate() {
        columns.number(&format!("{name}_{share}"), |cell| of(cell).at[place]);
    }
}

/// The figure of each run, `–` for one without.
fn by_run(values: &[Option<f64>]) -> String {
    let words = values.iter().map(|value| value.map_or("–".to_string(), |value| format!("{value:.4}")));
    words.collect::<Vec<_>>().join(" ")
}

/// Where somebody was tried.
fn place<T>(columns: &mut Columns<T>, prefix: &str, key: impl Fn(&T) -> &CellKey) {
    columns.text(&format!("{prefix}town"), |row| key(row).town.clone());
    columns.text(&format!("{prefix}policy"), |row| key(row).policy.clone());
}

/// Who was tried, with what.
fn who<T>(columns: &mut Columns<T>, key: impl Fn(&T) -> &CellKey) {
    columns.text("reward", |row| key(row).reward.clone());
    columns.text("train_town", |row| key(row).train_town.clone());
    columns.text("train_policy", |row| key(row).train_policy.clone());
    columns.text("pedestrian", |row| key(row).controller.clone());
}

fn body<T>(columns: &mut Columns<T>, key: impl Fn(&T) -> &CellKey) {
    columns.text("vehicle", |row| key(row).vehicle.clone());
    columns.text("adversary", |row| key(row).adversary.clone());
    columns.index("block", |row| key(row).block);
}

/// Comparisons as a table, one row each, in the order given. The columns are explained in `reports/README.md`.
pub fn comparison_table(comparisons: &[Comparison]) -> DataFrame {
    let mut columns = Columns::new(comparisons);
    who(&mut columns, |row| &row.first);
    place(&mut columns, "", |row| &row.first);
    body(&mut columns, |row| &row.first);
    columns.text("other_pedestrian", |row| row.second.controller.clone());
    columns.text("other_reward", |row| row.second.reward.clone());
    columns.text("figure", |row| row.figure.name().into());
    columns.count("runs", |row| row.runs[0]);
    columns.count("other_runs", |row| row.runs[1]);
    columns.count("paired_episodes", |row| row.episodes);
    columns.number("value", |row| Some(row.values[0]));
    columns.number("other_value", |row| Some(row.values[1]));
    columns.number("difference", |row| Some(row.difference));
    columns.interval("difference_bootstrap", |row| Some(row.bootstrap));
    columns.interval("difference_student", |row| row.student);
    columns.text("test", |row| row.test.name().into());
    columns.number("p", |row| row.p);
    columns.number("p_holm", |row| row.holm);
    columns.number("p_benjamini_hochberg", |row| row.benjamini_hochberg);
    columns.table()
}

/// Transfer gaps as a table, one row each, in the order given. The columns are explained in `reports/README.md`.
pub fn transfer_table(transfers: &[Transfer]) -> DataFrame {
    let mut columns = Columns::new(transfers);
    who(&mut columns, |row| &row.home);
    body(&mut columns, |row| &row.home);
    columns.text("changed", |row| row.change.name().into());
    place(&mut columns, "home_", |row| &row.home);
    place(&mut columns, "away_", |row| &row.away);
    columns.text("figure", |row| row.figure.name().into());
    columns.count("runs", |row| row.runs);
    columns.number("home_value", |row| Some(row.values[0]));
    columns.number("away_value", |row| Some(row.values[1]));
    columns.number("gap", |row| Some(row.gap));
    columns.interval("gap_bootstrap", |row| Some(row.bootstrap));
    columns.interval("gap_student", |row| row.student);
    columns.table()
}
