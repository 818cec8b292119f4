//! "Did you mean".

/// The known word most like a given one, if any is alike enough.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    known
        .into_iter()
        .map(|candidate| (candidate, strsim::damerau_levenshtein(&lower, &candidate.to_lowercase())))
        .filter(|(candidate, distance)| *distance <= 1 + candidate.len().min(word.len()) / 4)
        .min_by_key(|(_, distance)| *distance)
        .map(|(candidate, _)| candidate)
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn near_words_are_found_and_far_ones_are_not() {
        let known = ["reward", "spawn", "distance"];
        assert_eq!(nearest("rewrd", known), Some("reward"));
        assert_eq!(nearest("Distence", known), Some("distance"));
        assert_eq!(nearest("banana", known), None);
    }
}
