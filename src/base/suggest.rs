//! "Did you mean".

/// Maximum length of a word that is compared with others (bytes): the work grows with the product of both lengths.
const MAX_LENGTH: usize = 64;

/// The known word most similar to a given one, if any is similar enough.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if word.len() > MAX_LENGTH {
        return None;
    }
    let lower = word.to_lowercase();
    let letters = letters(&lower);
    known
        .into_iter()
        .filter_map(|candidate| {
            let max_edits = 1 + candidate.len().min(word.len()) / 4;
            if candidate.len() > MAX_LENGTH || candidate.len().abs_diff(word.len()) > 4 * max_edits {
                return None;
            }
            let other = candidate.to_lowercase();
            // Each edit changes at most one letter, so most words need not be compared.
            let differ =
                |a: &Letters, b: &Letters| a.iter().zip(b).map(|(a, b)| a.saturating_sub(*b) as usize).sum::<usize>();
            let others = self::letters(&other);
            if differ(&letters, &others).max(differ(&others, &letters)) > max_edits {
                return None;
            }
            let distance = strsim::damerau_levenshtein(&lower, &other);
            // If no letter is left in common, it is another word. So is a word that differs only in its digits.
            (!numbered_otherwise(&lower, &other) && distance <= max_edits && distance < lower.len().max(other.len()))
                .then_some((candidate, distance))
        })
        .min_by_key(|(_, distance)| *distance)
        .map(|(candidate, _)| candidate)
}

/// Whether two words differ in their digits alone.
fn numbered_otherwise(a: &str, b: &str) -> bool {
    let is_digit = |c: char| c.is_ascii_digit();
    let letters = |word: &str| word.replace(is_digit, "");
    a != b && a.contains(is_digit) && b.contains(is_digit) && letters(a) == letters(b)
}

/// The number of occurrences of each letter; letters beyond ASCII share places.
type Letters = [u8; 128];

fn letters(word: &str) -> Letters {
    let mut counts = [0_u8; 128];
    word.chars().for_each(|letter| counts[letter as usize % 128] = counts[letter as usize % 128].saturating_add(1));
    counts
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
        assert_eq!(nearest("r3", ["r1", "r2"]), None);
        assert_eq!(nearest("model", ["model3"]), Some("model3"));
    }

    #[test]
    fn what_is_left_out_is_what_is_too_far() {
        let words = [
            "", "a", "ä", "ab", "ba", "abc", "acb", "cab", "reward", "rewrad", "drawer", "rewarded", "Äpfel", "aepfel",
        ];
        for word in words {
            let far = |other: &str| strsim::damerau_levenshtein(&word.to_lowercase(), &other.to_lowercase());
            let best = words
                .into_iter()
                .filter(|other| far(other) <= 1 + other.len().min(word.len()) / 4)
                .filter(|other| far(other) < word.to_lowercase().len().max(other.to_lowercase().len()))
                .min_by_key(|w| far(w));
            assert_eq!(nearest(word, words), best, "{word}");
        }
        let long = "a".repeat(1 << 20);
        assert_eq!(nearest(&long, [long.as_str()]), None);
    }
}
