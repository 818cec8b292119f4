use std::fmt;
use std::str::FromStr;

/// A set of numbers of starts. Its text lists ranges, as `0-31 40 42-45`.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct StartSet(
    /// First and last number of each range, in rising order; ranges do not touch.
    Vec<(u64, u64)>,
);

impl StartSet {
    /// The number of starts.
    pub fn count(&self) -> u64 {
        self.0.iter().map(|(first, last)| last - first + 1).sum()
    }

    /// The numbers, in rising order.
    pub fn iter(&self) -> impl Iterator<Item = u64> {
        self.0.iter().flat_map(|(first, last)| *first..=*last)
    }

    pub fn contains(&self, start: u64) -> bool {
        let after = self.0.partition_point(|(first, _)| *first <= start);
        after > 0 && self.0[after - 1].1 >= start
    }

    /// The starts that both sets have.
    pub fn common(&self, other: &Self) -> Self {
        let (mut own, mut others) = (self.0.iter().peekable(), other.0.iter().peekable());
        let mut common = Vec::new();
        while let (Some((first, last)), Some((other_first, other_last))) = (own.peek(), others.peek()) {
            let (low, high) = (*first.max(other_first), *last.min(other_last));
            if low <= high {
                common.push((low, high));
            }
            if last < other_last {
                own.next()
            } else {
                others.next()
            };
        }
        Self(common)
    }
}

/// Numbers in rising order.
impl FromIterator<u64> for StartSet {
    fn from_iter<I: IntoIterator<Item = u64>>(numbers: I) -> Self {
        let mut ranges: Vec<(u64, u64)> = Vec::new();
        for number in numbers {
            match ranges.last_mut() {
                Some((_, last)) if *last + 1 == number => *last = number,
                _ => ranges.push((number, number)),
            }
        }
        Self(ranges)
    }
}

impl fmt::Display for StartSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, (first, last)) in self.0.iter().enumerate() {
            let space = if place == 0 { "" } else { " " };
            if first == last { write!(f, "{space}{first}")? } else { write!(f, "{space}{first}-{last}")? }
        }
        Ok(())
    }
}

/// A text that is not a list of ranges in rising order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("it is not a list of numbers of starts")]
pub struct NoStartSet;

impl FromStr for StartSet {
    type Err = NoStartSet;

    fn from_str(text: &str) -> Result<Self, NoStartSet> {
        let range = |part: &str| {
            let (first, last) = part.split_once('-').unwrap_or((part, part));
            Some((first.parse::<u64>().ok()?, last.parse::<u64>().ok()?))
        };
        let ranges: Vec<(u64, u64)> = text.split_whitespace().map(range).collect::<Option<_>>().ok_or(NoStartSet)?;
        let rising = ranges.iter().all(|(first, last)| first <= last && *last < u64::MAX)
            && ranges.windows(2).all(|pair| pair[0].1 < pair[1].0);
        if rising { Ok(Self(ranges)) } else { Err(NoStartSet) }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn it_is_the_set_of_its_numbers(one in prop::collection::btree_set(0..60u64, 0..40), other in prop::collection::btree_set(0..60u64, 0..40)) {
            let (a, b): (StartSet, StartSet) = (one.iter().copied().collect(), other.iter().copied().collect());
            prop_assert_eq!(a.count(), one.len() as u64);
            prop_assert!((0..60).all(|start| a.contains(start) == one.contains(&start)));
            let common: BTreeSet<u64> = one.intersection(&other).copied().collect();
            let found = a.common(&b);
            prop_assert_eq!(found.count(), common.len() as u64);
            prop_assert!((0..60).all(|start| found.contains(start) == common.contains(&start)));
            prop_assert_eq!(a.to_string().parse(), Ok(a));
        }

        #[test]
        fn any_text_is_a_set_or_an_error(text in "[0-9 -]{0,12}") {
            if let Ok(set) = text.parse::<StartSet>() {
                prop_assert!(set.to_string().parse() == Ok(set));
            }
        }
    }

    #[test]
    fn its_text_is_short() {
        let set: StartSet = (0..32).chain([40]).chain(42..46).collect();
        assert_eq!(set.to_string(), "0-31 40 42-45");
        for wrong in ["3-1", "5 4", "1-3 3", "a", "-1", "1-18446744073709551615"] {
            assert_eq!(wrong.parse::<StartSet>(), Err(NoStartSet), "{wrong}");
        }
    }
}
