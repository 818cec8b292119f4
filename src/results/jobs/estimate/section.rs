use super::picture::likelihoods;
use super::table::doubts;
use crate::jobs::Said;
use crate::report::Findings;
use crate::report::table::{Column, Place, Section, Selection, Table, Value};
use compile::Estimation;
use search::likelihood::{Estimate, Likelihood, encounters_needed};
use verdict::Blame;

/// How likely failures are; `None` without an estimate.
pub fn estimates(found: &Findings<'_>) -> Option<Section> {
    let ended: Vec<(&Estimation, &Estimate)> = found.finished.found().collect();
    if ended.is_empty() {
        return None;
    }
    let notes = vec![
        "The probability is that of an encounter: a start that the `spawn` draws, with a pedestrian who walks by itself as stated. It says nothing of how often such \
         encounters occur; events per hour or per 1,000 km need a number of encounters, which the scenario states or not. In brackets the 95 % interval; where an \
         event was never seen, the one-sided 95 % bound."
            .into(),
        bounds(),
    ];
    Some(Section {
        id: "estimates",
        name: "Estimates",
        title: "How likely failures are in an encounter",
        figures: vec![likelihoods(&ended)],
        tables: vec![table(&ended)],
        notes,
        ..Section::default()
    })
}

/// What each estimate says of faults.
pub fn answer(found: &Findings<'_>) -> Vec<Said> {
    let said = |(job, estimate): (&Estimation, &Estimate)| {
        let Estimation { policy, pedestrian, town, requirement, .. } = job;
        let what = if requirement.is_empty() { "a fault".into() } else { format!("a breach of {requirement}") };
        let faults = estimate.of(Blame::Fault);
        let fails = faults.seen > 0 && requirement.is_empty();
        let found = match faults {
            none if none.seen == 0 => {
                format!(
                    "none in {} encounters; with 95 % confidence below 1 in {}",
                    estimate.encounters,
                    rounded(1.0 / none.high)
                )
            }
            some => format!("{}, an interval of 95 %", one_in(some)),
        };
        let text = format!("{policy} in {town}, {what} in an encounter with {pedestrian}: {found}");
        Said { driver: policy.clone(), text, fails }
    };
    found.finished.found().map(said).collect()
}

fn table(results: &[(&Estimation, &Estimate)]) -> Table {
    let exposed = [(0, "faults per hour"), (1, "faults per 1,000 km")];
    let exposed = exposed.into_iter().filter(|(unit, _)| results.iter().any(|(job, _)| job.exposure[*unit].is_some()));
    let events = ["any failure", "preventable", "fault"].into_iter().zip(Blame::ALL);
    let shown = Selection::new()
        .text("driver", |(job, _): &(&Estimation, &Estimate)| job.policy.clone())
        .text("town", |(job, _)| job.town.clone())
        .text("pedestrian", |(Estimation { pedestrian, requirement, .. }, _)| match requirement.is_empty() {
            true => pedestrian.clone(),
            false => format!("{pedestrian} ({requirement})"),
        })
        .each(events, |(name, _)| Column::number(*name), |(_, event), (_, found)| one_in(found.of(*event)))
        .number("encounters", |(_, found)| found.encounters)
        .each(
            exposed,
            |(_, name)| Column::number(*name),
            |(unit, _), (job, found)| Some(rate(found.of(Blame::Fault), job.exposure[*unit]?)),
        )
        .text("doubts", |(job, found)| match doubts(job, found).as_slice() {
            [] => "none".into(),
            doubts => Value::warning(doubts.join("; ")),
        });
    Table { place: Place::Everywhere, ..shown.table(results) }
}

/// How many encounters a wanted bound needs.
fn bounds() -> String {
    let needed =
        |bound: f64| format!("1 in {}: {} encounters", rounded(1.0 / bound), rounded(encounters_needed(bound) as f64));
    format!(
        "To bound an event that is never seen, with 95 % confidence, below {}.",
        [1e-3, 1e-4, 1e-5, 1e-6].map(needed).join("; ")
    )
}

/// `1 in 17,000 (9,000 to 40,000)`.
fn one_in(likelihood: &Likelihood) -> String {
    let Likelihood { probability, low, high, seen, .. } = *likelihood;
    if seen == 0 {
        return format!("none; below 1 in {}", rounded(1.0 / high));
    }
    let far = if low > 0.0 { rounded(1.0 / low) } else { "never".into() };
    format!("1 in {} ({} to {far})", rounded(1.0 / probability), rounded(1.0 / high))
}

fn rate(fault: &Likelihood, encounters: f64) -> String {
    let of = |share: f64| format!("{:.2e}", share * encounters);
    if fault.seen == 0 {
        format!("below {}", of(fault.high))
    } else {
        format!("{} ({}..{})", of(fault.probability), of(fault.low), of(fault.high))
    }
}

/// A number to two digits, with commas.
fn rounded(number: f64) -> String {
    if number < 10.0 {
        return format!("{number:.1}");
    }
    let power = libm::pow(10.0, libm::log10(number).floor() - 1.0);
    let whole = ((number / power).round() * power) as u64;
    let digits = whole.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probability_is_one_in_a_round_number() {
        let likelihood = Likelihood {
            event: Blame::Fault,
            probability: 5.9e-5,
            low: 2.5e-5,
            high: 1.13e-4,
            relative_error: Some(0.2),
            seen: 10,
        };
        assert_eq!(one_in(&likelihood), "1 in 17,000 (8,800 to 40,000)");
        assert_eq!(
            one_in(&Likelihood { seen: 0, probability: 0.0, low: 0.0, high: 0.003, ..likelihood }),
            "none; below 1 in 330"
        );
        assert_eq!(rounded(1.234), "1.2");
        assert_eq!(rounded(1_234_567.0), "1,200,000");
    }
}
