use super::Entry;
use super::columns::{
    AVOIDABLE_INJURY, CONTACT_SIDE, COUNTS_AS, FAULT, FORESEEABLE, IN_SIGHT, LATEST_REACTION, PREVENTABLE_PROBABILITY,
    VERDICT, WALKED_INTO, WARNING,
};
use world::judge::Verdict;

/// The columns of the verdict on a collision, for a table whose rows may have one: the same in evaluations and in searches.
pub fn verdict_columns<'t, R>(verdict: impl Fn(&R) -> Option<Verdict> + Copy + 't) -> Vec<Entry<'t, R>> {
    let struck = move |row: &R| verdict(row).filter(|verdict| !verdict.is_bump());
    vec![
        VERDICT.of(move |row| verdict(row).map(|verdict| verdict.label.name())),
        FORESEEABLE.of(move |row| struck(row).map(|verdict| verdict.foreseeable)),
        FAULT.of(move |row| struck(row).map(|verdict| verdict.is_fault())),
        COUNTS_AS.of(move |row| verdict(row).map(|verdict| verdict.class().name())),
        AVOIDABLE_INJURY.of(move |row| struck(row).map(|verdict| verdict.avoidable_injury())),
        LATEST_REACTION.of(move |row| struck(row).and_then(|verdict| verdict.latest_reaction)),
        PREVENTABLE_PROBABILITY.of(move |row| struck(row).map(|verdict| verdict.preventable_probability())),
        CONTACT_SIDE.of(move |row| verdict(row).map(|verdict| verdict.side.name())),
        WALKED_INTO.of(move |row| struck(row).map(|verdict| verdict.walked_into)),
        WARNING.of(move |row| verdict(row).map(|verdict| verdict.warning)),
        IN_SIGHT.of(move |row| verdict(row).map(|verdict| verdict.sight.seen)),
    ]
}
