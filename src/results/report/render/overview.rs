//! The overview of several reports: a table and curves over numeric parameters, as a page and for a terminal.

use maud::html;

use super::page::{document, paragraph, percent};
use super::svg::{Chart, Curve, Figure, Panel, SERIES, short};
use super::table::{Column, Table, Value};
use crate::report::overview::{HighestRate, Overview, OverviewRow};

/// How to read the table.
const READING: &str = "Each rate is the highest over the controllers and towns of the report, a share of all episodes there, with Wilson's 95 % interval over these \
episodes. The highest of several rates is a little too high. Variants of a matrix meet the same starts. `overview.csv` has the same numbers.";

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
                (table(overview).to_html())
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
    table(overview).to_terminal(80)
}

fn reports(overview: &Overview<'_>) -> usize {
    let mut names: Vec<&str> = overview.rows.iter().map(|row| row.variant.report.as_str()).collect();
    names.dedup();
    names.len()
}

fn table(overview: &Overview<'_>) -> Table {
    let searched = overview.rows.iter().any(|row| row.result.searched.is_some());
    let evaluated = overview.rows.iter().any(|row| row.rates.iter().any(Option::is_some));
    // Without parameters only the reports tell the rows apart.
    let report = Column::text("report");
    let mut head = vec![if overview.parameters.is_empty() { report } else { report.page_only() }];
    head.extend(overview.parameters.iter().map(|name| Column::text(*name)));
    head.extend(["driver", "worst failure"].map(Column::text));
    if evaluated {
        let [fault, preventable, collision] = OverviewRow::RATES.map(|rate| Column::number(format!("{rate} (95 %)")));
        head.extend([fault, preventable, collision.page_only()]);
    }
    if searched {
        head.push(Column::text("found by searches"));
    }
    let row = |row: &OverviewRow<'_>| {
        let report = &row.variant.report;
        let mut values = vec![Value::Link(report.clone(), format!("{}/report.html", address(report)))];
        values.extend(row.values.iter().map(|value| Value::from(value.as_deref().unwrap_or("–"))));
        values.push(Value::from(&row.result.driver.name));
        values.push(Value::Text(match &row.result.worst {
            Some(found) => format!("{}, {:.1} m/s", found.word(), found.impact_speed),
            None => "no collision".into(),
        }));
        if evaluated {
            let rate = |found: &Option<HighestRate>| {
                let Some(found) = found else { return Value::Number(None, 2) };
                let episodes = row.variant.cells[found.cell].episodes;
                let failures = (found.rate * f64::from(episodes)).round() as u32;
                Value::or_count(
                    Value::Estimate(Some(found.rate), found.interval, 2),
                    Some(found.rate),
                    failures,
                    episodes,
                )
            };
            values.extend(row.rates.iter().map(rate));
        }
        if searched {
            values.push(match row.result.searched {
                Some(found) => format!("{} failures, {} fault", found.all, found.fault).into(),
                None => Value::from("–"),
            });
        }
        values
    };
    Table { head, rows: overview.rows.iter().map(row).collect(), ..Table::default() }
}

/// A folder's name in a relative address.
fn address(name: &str) -> String {
    let plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"-_.~=,+".contains(byte);
    name.bytes().map(|byte| if plain(&byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") }).collect()
}

/// A curve over a parameter: a driver with the values of all other parameters.
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
        let label = format!("{}{}", row.result.driver.name, others.collect::<String>());
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
    let titles = OverviewRow::RATES.into_iter().chain([OverviewRow::SEARCHED]).enumerate();
    let known = |rate: usize| lines.iter().flat_map(|line| &line.points).any(|(_, row)| row.rate(rate).is_some());
    let panels: Vec<Panel> =
        titles.filter(|(rate, _)| known(*rate)).map(|(rate, title)| panel(&lines, rate, title, x, &label)).collect();
    if panels.is_empty() {
        return None;
    }
    Some(Figure {
        name: String::new(),
        title: format!(
            "Highest rates over {name}, with 95 % intervals: Wilson's over episodes, Student's over the runs of searches, if there are four."
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
        most = known().fold(most, |most, (_, found)| most.max(found.interval.map_or(found.rate, |ends| ends.1)));
        let texts: Vec<String> = known().map(|(x, found)| format!("{} at {}", percent(found.rate), short(x))).collect();
        says.push(format!("{}: {}", line.label, texts.join(", ")));
        drawn.push(Curve {
            colour: number % SERIES,
            thin: false,
            points: known().map(|(x, found)| (x, found.rate)).collect(),
            band: known().map(|(_, found)| found.interval).collect::<Option<_>>().unwrap_or_default(),
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
