use crate::report::grouped::grouped;
use crate::report::render::table::{Section, Selection, Value};
use crate::report::{CastFailure, Findings};
use verdict::cause::needed_names;

/// Which actors the listed failures need; `None` of a campaign without a cast or without a failure.
pub fn cast(found: &Findings<'_>) -> Option<Section> {
    let mut groups = grouped(&found.cast_failures, |each| needed_names(&each.needs));
    groups.sort_by_key(|members| std::cmp::Reverse(members.len()));
    let shown = Selection::new()
        .text("needs", |members: &Vec<&CastFailure>| match needed_names(&members[0].needs) {
            names if names.is_empty() => "none of them alone".into(),
            names => names,
        })
        .number("failures", Vec::len)
        .number("faults", |members| members.iter().filter(|each| each.failure.fault).count())
        .text("the first", |members| Value::failure(members[0].failure.name()));
    (!groups.is_empty()).then(|| Section {
        id: "cast",
        name: "Actors",
        title: "Which actors failures need",
        lead: vec![share_of_two(&found.cast_failures)],
        tables: vec![shown.table(&groups)],
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
