/// How a feature is encoded and worded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// With a unit.
    Number(&'static str),
    /// As 0 or 1, with the words for a case in which it is false.
    Truth(&'static str),
}

/// A feature of a start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Feature {
    /// Its name for people.
    pub name: &'static str,
    /// Its encoding.
    pub scale: Scale,
}

/// Episodes: their starts, and whether they ended in the outcome to explain.
#[derive(Debug, Clone, PartialEq)]
pub struct Cases {
    /// The features of starts.
    pub features: Vec<Feature>,
    /// The features of each episode.
    pub rows: Vec<Vec<f64>>,
    /// The number of each episode. Equal numbers have equal starts, so they must not be in both the learning half and the test half.
    pub episodes: Vec<u32>,
    /// Whether each is a hit: it ended in the outcome to explain.
    pub hits: Vec<bool>,
}

impl Cases {
    /// The indices of the episodes with even numbers, and of those with odd ones.
    pub(super) fn halves(&self) -> (Vec<usize>, Vec<usize>) {
        (0..self.rows.len()).partition(|place| self.episodes[*place].is_multiple_of(2))
    }

    /// The number of hits among some episodes, and the number of these episodes.
    pub(super) fn count(&self, places: &[usize]) -> (u64, u64) {
        (places.iter().filter(|place| self.hits[**place]).count() as u64, places.len() as u64)
    }
}
