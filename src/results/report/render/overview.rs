//! The overview of several reports: a table and curves over numeric parameters, as a page and for a terminal.

use maud::html;

use super::page::{document, paragraph, percent};
use super::sections::{average, failed_starts, injury, injury_scale, searcher};
use super::svg::{Chart, Curve, Figure, Panel, SERIES, short};
use super::table::{Column, Table, Value};
use crate::report::overview::{Found, Overview, OverviewRow};
use crate::report::{Cell, DriverResult, Variant};

/// How to read the tables.
const READING: &str = "A row is a controller of the pedestrian, or a falsifier, in a town against a driver. Rates are shares of all episodes: the mean over runs \
± one standard deviation. Variants of a matrix meet the same starts. A row with `any` is the same in all reports. `overview.csv` has the same numbers, and intervals.";

pub fn overview_page(overview: &Overview<'_>, version: &str) -> String {
    let figures = curves(overview);
    let body = html! {
        header.top {
            p.kind { "falsify · overview" }
            h1 { "Overview" }
            p.meta { (reports(overview)) " reports · falsify " (version) }
            button #theme type="button" hidden { "Dark" }
        }
        main #main {
            section #table {
                h2 { "What was found" }
                @for line in doubtful(overview) { (paragraph(&line)) }
                @for table in tables(overview) { (table.to_html()) }
                (paragraph(READING))
            }
            @if !figures.is_empty() {
                section #curves {
                    h2 { "Rates over a parameter" }
                    @for figure in &figures { (figure.to_html()) }
                }
            }
        }
    };
    document("Overview", version, &body, false)
}

pub fn overview_for_terminal(overview: &Overview<'_>) -> String {
    let tables: Vec<String> = tables(overview).iter().map(|table| table.to_terminal(80)).collect();
    let doubts: String = doubtful(overview).iter().map(|line| format!("\n{}", line.replace("**", ""))).collect();
    tables.join("\n") + &doubts
}

/// What a reader must know before rows are compared: trainings that are in doubt, and that the best of many rows is the best by chance, too.
fn doubtful(overview: &Overview<'_>) -> Vec<String> {
    let in_doubt: Vec<String> = overview
        .variants
        .iter()
        .filter(|variant| !variant.doubts.is_empty())
        .map(|variant| format!("`{}`", variant.report))
        .collect();
    let mut lines = Vec::new();
    if !in_doubt.is_empty() {
        lines.push(format!(
            "**There are doubts about the trainings of {} of {} reports:** {}. Their own pages say which.",
            in_doubt.len(),
            reports(overview),
            in_doubt.join(", ")
        ));
    }
    if reports(overview) > 2 {
        lines.push(
            "The greatest of many rates is too high by chance: test two reports with `falsify compare` before one is called better.".into(),
        );
    }
    lines
}

fn reports(overview: &Overview<'_>) -> usize {
    overview.variants.len()
}

/// The rates of controllers, those of falsifiers, and the worst failure of each driver; without those that would be empty.
fn tables(overview: &Overview<'_>) -> Vec<Table> {
    let of = |searched: bool| move |row: &&OverviewRow<'_>| matches!(row.found, Found::Searched(_)) == searched;
    let evaluated: Vec<_> = overview.rows.iter().filter(of(false)).collect();
    let searched: Vec<_> = overview.rows.iter().filter(of(true)).collect();
    let several = |name: fn(&OverviewRow<'_>) -> String| {
        let first = overview.rows.first().map(name);
        overview.rows.iter().any(|row| Some(name(row)) != first)
    };
    let (drivers, towns) = (several(|row| row.driver().to_string()), several(|row| row.town().to_string()));
    let place = |row: &OverviewRow<'_>| {
        let driver = drivers.then(|| Value::from(row.driver()));
        driver.into_iter().chain(towns.then(|| Value::from(row.town())))
    };
    let any = vec![Some("any".to_string()); overview.parameters.len()];
    let place_of =
        |row: &OverviewRow<'_>| first(row.variant, if is_same_everywhere(overview, row) { &any } else { &row.values });
    let repeated = |row: &&&OverviewRow<'_>| {
        !std::ptr::eq(row.variant, &overview.variants[0]) && is_same_everywhere(overview, row)
    };
    let mut place_head = Vec::new();
    place_head.extend(drivers.then(|| Column::text("driver")));
    place_head.extend(towns.then(|| Column::text("town")));
    let mut tables = Vec::new();
    if !evaluated.is_empty() {
        let mut head = head(overview);
        head.extend(place_head.clone());
        head.extend([Column::text("controller"), Column::number("runs").page_only(), Column::number("n")]);
        head.extend(["fault", "preventable", "collision"].map(Column::number));
        let row = |row: &&OverviewRow<'_>| {
            let Found::Evaluated(cell) = row.found else { unreachable!("the rows are those of cells") };
            let mut values = place_of(row);
            values.extend(place(row));
            values.extend([
                row.who().into(),
                Value::Count(cell.runs.into()),
                Value::Count((cell.episodes / cell.runs.max(1)).into()),
            ]);
            values.extend([cell.fault, cell.preventable, cell.collision].map(Value::Spread));
            values
        };
        let rows = evaluated.iter().filter(|row| !repeated(row)).map(row).collect();
        tables.push(Table { head, rows, ..Table::default() });
    }
    if !searched.is_empty() {
        let mut head = head(overview);
        head.extend(place_head.clone());
        head.push(Column::text("falsifier"));
        head.extend(["failed starts", "starts with a fault"].map(Column::text));
        let row = |row: &&OverviewRow<'_>| {
            let Found::Searched(cell) = row.found else { unreachable!("the rows are those of searches") };
            let mut values = place_of(row);
            values.extend(place(row));
            values.extend([searcher(cell).into(), failed_starts(cell), average(&cell.fault_start_rate, 3)]);
            values
        };
        let rows = searched.iter().filter(|row| !repeated(row)).map(row).collect();
        tables.push(Table { head, rows, ..Table::default() });
    }
    let mut head = head(overview);
    head.extend(["driver", "worst failure"].map(Column::text));
    head.push(Column::number("avoidable injury / 1,000"));
    head.push(Column::text("of the scale").page_only());
    let results =
        overview.variants.iter().flat_map(|variant| variant.drivers.iter().map(move |result| (variant, result)));
    let row = |(variant, result): (&Variant<'_>, &DriverResult)| {
        let mut values = first(variant, &overview.values(variant));
        values.push(Value::from(&result.driver.name));
        let own = injury(result, variant.cells);
        values.extend([Value::Text(result.worst_in_words()), Value::Number(own, 2)]);
        // The baseline of each report is its own.
        let scale = injury_scale(variant.drivers, variant.cells).zip(own);
        values.push(scale.map_or_else(|| "–".into(), |((of, whole), own)| format!("{:.2} {of}", own / whole).into()));
        values
    };
    tables.push(Table { head, rows: results.map(row).collect(), ..Table::default() });
    tables
}

/// Whether a row is equal in every report, in all that was measured but for the reward: no parameter changes its pedestrian, its driver or their town.
fn is_same_everywhere(overview: &Overview<'_>, row: &OverviewRow<'_>) -> bool {
    let like = |other: &&OverviewRow<'_>| match (row.found, other.found) {
        (Found::Evaluated(one), Found::Evaluated(other)) => {
            Cell { reward_sum: one.reward_sum, ..other.clone() } == *one
        }
        (Found::Searched(one), Found::Searched(other)) => one == other,
        _ => false,
    };
    let alike = overview.rows.iter().filter(like).count();
    !overview.parameters.is_empty() && overview.variants.len() > 1 && alike == overview.variants.len()
}

/// The columns that tell the reports apart.
fn head(overview: &Overview<'_>) -> Vec<Column> {
    // Without parameters only the reports tell the rows apart.
    let report = Column::text("report");
    let mut head = vec![if overview.parameters.is_empty() { report } else { report.page_only() }];
    head.extend(overview.parameters.iter().map(|name| Column::text(*name).key()));
    head
}

/// The values of these columns.
fn first(variant: &Variant<'_>, parameters: &[Option<String>]) -> Vec<Value> {
    let report = &variant.report;
    let link = Value::Link(report.clone(), format!("{}/report.html", address(report)));
    std::iter::once(link).chain(parameters.iter().map(|value| Value::from(value.as_deref().unwrap_or("–")))).collect()
}

/// A folder's name in a relative address.
fn address(name: &str) -> String {
    let plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"-_.~=,+".contains(byte);
    name.bytes().map(|byte| if plain(&byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") }).collect()
}

/// A curve over a parameter: a controller or a falsifier, with the values of all other parameters.
struct Line<'a> {
    label: String,
    points: Vec<(f64, &'a OverviewRow<'a>)>,
}

/// A figure for each parameter that has at least two numeric values, with a panel for each rate.
fn curves(overview: &Overview<'_>) -> Vec<Figure> {
    (0..overview.parameters.len()).filter_map(|place| figure(overview, place)).collect()
}

fn figure(overview: &Overview<'_>, place: usize) -> Option<Figure> {
    let mut lines: Vec<Line<'_>> = Vec::new();
    let mut units: Vec<&str> = Vec::new();
    for row in &overview.rows {
        let Some((x, unit)) = row.values[place].as_deref().and_then(number) else { continue };
        if !units.contains(&unit) {
            units.push(unit);
        }
        let others = row.values.iter().zip(&overview.parameters).enumerate().filter(|(other, _)| *other != place);
        let others = others.filter_map(|(_, (value, name))| Some(format!(", {name} = {}", value.as_ref()?)));
        let place = format!("{} in {} against {}", row.who(), row.town(), row.driver());
        let label = format!("{place}{}", others.collect::<String>());
        // Another file may have the same parameter: its points are a curve of their own.
        let open = |line: &&mut Line<'_>| line.label == label && line.points.iter().all(|(other, _)| *other != x);
        match lines.iter_mut().find(open) {
            Some(line) => line.points.push((x, row)),
            None => lines.push(Line { label, points: vec![(x, row)] }),
        }
    }
    lines.retain(|line| line.points.len() > 1);
    let [unit] = units[..] else { return None };
    if lines.is_empty() {
        return None;
    }
    lines.iter_mut().for_each(|line| line.points.sort_by(|a, b| a.0.total_cmp(&b.0)));
    let all = || lines.iter().flat_map(|line| &line.points).map(|point| point.0);
    let x = (all().fold(f64::MAX, f64::min), all().fold(f64::MIN, f64::max));
    let name = overview.parameters[place];
    let label = if unit.is_empty() { name.to_string() } else { format!("{name}, {unit}") };
    // Campaigns without evaluations have no rates of episodes, and those without searches none of starts.
    let titles = OverviewRow::RATES.into_iter().enumerate();
    let known = |rate: usize| lines.iter().flat_map(|line| &line.points).any(|(_, row)| row.rate(rate).is_some());
    let panels: Vec<Panel> =
        titles.filter(|(rate, _)| known(*rate)).map(|(rate, title)| panel(&lines, rate, title, x, &label)).collect();
    if panels.is_empty() {
        return None;
    }
    Some(Figure {
        name: String::new(),
        title: format!(
            "Rates over {name}. Bands: ± one standard deviation over runs, Wilson's 95 % interval for a single run; for searches Student's 95 % \
             interval over runs, lowest and highest of fewer than four."
        ),
        legend: lines.iter().enumerate().map(|(number, line)| (class(number), line.label.clone())).collect(),
        panels,
        ..Figure::default()
    })
}

/// The class of a curve's colour.
fn class(number: usize) -> String {
    format!("s{}", number % SERIES)
}

fn panel(lines: &[Line<'_>], rate: usize, title: &str, x: (f64, f64), label: &str) -> Panel {
    let mut most: f64 = 0.0;
    let mut says = Vec::new();
    let mut drawn = Vec::new();
    for (number, line) in lines.iter().enumerate() {
        let known = || line.points.iter().filter_map(|(x, row)| Some((*x, row.rate(rate)?)));
        if known().next().is_none() {
            continue;
        }
        most = known().fold(most, |most, (_, found)| most.max(found.band.1));
        let texts: Vec<String> = known().map(|(x, found)| format!("{} at {}", percent(found.rate), short(x))).collect();
        says.push(format!("{}: {}", line.label, texts.join(", ")));
        drawn.push(Curve {
            colour: number % SERIES,
            thin: false,
            points: known().map(|(x, found)| (x, found.rate)).collect(),
            band: known().map(|(_, found)| found.band).collect(),
        });
    }
    let chart = Chart {
        size: Chart::SMALL,
        x,
        y: (0.0, (most * 1.04).clamp(0.05, 1.0)),
        x_label: label.into(),
        x_text: short,
        y_text: percent,
    };
    drawn.reverse();
    chart.panel(title.to_string(), format!("{}.", says.join("; ")), &drawn)
}

/// A number with its unit, as `3 m/s`, `50_000` or `20 %`; none for anything else.
fn number(value: &str) -> Option<(f64, &str)> {
    let end = value.find(|c: char| !(c.is_ascii_digit() || "+-._e".contains(c))).unwrap_or(value.len());
    let (number, unit) = (value[..end].replace('_', ""), value[end..].trim());
    let number = number.parse().ok().filter(|number: &f64| number.is_finite())?;
    (!unit.contains("..") && !unit.contains(['(', '[', '"'])).then_some((number, unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_settings_are_numbers_with_units_or_none() {
        assert_eq!(number("3 m/s"), Some((3.0, "m/s")));
        assert_eq!(number("50_000"), Some((50_000.0, "")));
        assert_eq!(number("-0.5 rad"), Some((-0.5, "rad")));
        assert_eq!(number("0 m/s .. 2 m/s"), None);
        assert_eq!(number("behavior"), None);
        assert_eq!(number("(1 m, 2 m)"), None);
        assert_eq!(address("a=1 b"), "a=1%20b");
    }
}
