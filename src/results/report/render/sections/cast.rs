use crate::report::render::table::{Column, Section, Table, Value};
use crate::report::{CastFailure, Findings};
use verdict::cause::needed_names;

/// Which actors the listed failures need; `None` of a campaign without a cast or without a failure.
pub fn cast(found: &Findings<'_>) -> Option<Section> {
    let mut groups: Vec<(String, Vec<&CastFailure>)> = Vec::new();
    for each in &found.cast_failures {
        let names = needed_names(&each.needs);
        match groups.iter_mut().find(|(known, _)| *known == names) {
            Some((_, members)) => members.push(each),
            None => groups.push((names, vec![each])),
        }
    }
    groups.sort_by_key(|(_, members)| std::cmp::Reverse(members.len()));
    let faults = |members: &[&CastFailure]| members.iter().filter(|each| each.failure.fault).count() as u64;
    let row = |(names, members): &(String, Vec<&CastFailure>)| {
        vec![
            if names.is_empty() { "none of them alone".into() } else { Value::text(names.clone()) },
            Value::Count(members.len() as u64),
            Value::Count(faults(members)),
            Value::failure(members[0].failure.name()),
        ]
    };
    let mut head = vec![Column::text("needs")];
    head.extend(["failures", "faults"].map(Column::number));
    head.push(Column::text("the first"));
    (!groups.is_empty()).then(|| Section {
        id: "cast",
        name: "Actors",
        title: "Which actors failures need",
        lead: vec![share_of_two(&found.cast_failures)],
        tables: vec![Table { head, rows: groups.iter().map(row).collect(), ..Table::default() }],
        notes: vec![
            "Each failure of the list was run again without each of the other actors in turn, with the same random numbers; it needs those without which it does \
             not happen. The table `actors` has where they were."
                .into(),
        ],
        ..Section::default()
    })
}

/// The share of failures that need two or more of the other actors, as a sentence.
pub fn share_of_two(failures: &[CastFailure]) -> String {
    let share = |fault: bool| {
        let of: Vec<_> = failures.iter().filter(|each| each.failure.fault || !fault).collect();
        let two = of.iter().filter(|each| each.needs_two()).count();
        (two, of.len())
    };
    let ((faults, all_faults), (two, all)) = (share(true), share(false));
    format!(
        "{faults} of {all_faults} listed faults, and {two} of {all} listed failures, need two or more actors beside the car under test."
    )
}
