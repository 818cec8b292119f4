/// How a feature is counted, and how it is worded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// In a unit.
    Number(&'static str),
    /// As 0 or 1, with what to say of a case in which it does not hold.
    Truth(&'static str),
}

/// A feature of a start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Feature {
    /// Its name for people.
    pub name: &'static str,
    /// How it is counted.
    pub scale: Scale,
}

/// Episodes: how they began, and whether they ended in what is to be explained.
#[derive(Debug, Clone, PartialEq)]
pub struct Cases {
    /// The features of starts.
    pub features: Vec<Feature>,
    /// The features of each episode.
    pub rows: Vec<Vec<f64>>,
    /// The number of each episode. Equal numbers begin the same, so they must not be learnt from and tested on both.
    pub episodes: Vec<u32>,
    /// Whether each is a hit: ended in what is to be explained.
    pub hits: Vec<bool>,
}

impl Cases {
    /// The places of the episodes with even numbers, and of those with odd ones.
    pub(super) fn halves(&self) -> (Vec<usize>, Vec<usize>) {
        (0..self.rows.len()).partition(|place| self.episodes[*place].is_multiple_of(2))
    }

    /// How many of some episodes are hits, and how many there are.
    pub(super) fn count(&self, places: &[usize]) -> (u64, u64) {
        (places.iter().filter(|place| self.hits[**place]).count() as u64, places.len() as u64)
    }
}
