//! Named random streams.
//!
//! A stream depends only on the path of names that leads to it: not on the order of calls and not on the number of threads.
//! Adding a task to a campaign therefore changes no other task.

mod stream;

pub use stream::Stream;

/// A node in the tree of random streams.
///
/// # Example
/// ```
/// use base::seed::Seed;
/// use rand::Rng;
/// let run = Seed::root(7).child("train").index(3);
/// assert_eq!(run.stream().next_u64(), run.stream().next_u64());
/// assert_ne!(run.stream().next_u64(), Seed::root(7).child("train").index(4).stream().next_u64());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seed([u8; 32]);

impl Seed {
    /// The root of the tree for a user's seed number.
    pub fn root(seed: u64) -> Self {
        Self(
            *blake3::Hasher::new_derive_key("falsify 2026 random streams")
                .update(&seed.to_le_bytes())
                .finalize()
                .as_bytes(),
        )
    }

    /// The branch with this name.
    pub fn child(&self, name: &str) -> Self {
        Self(*blake3::keyed_hash(&self.0, name.as_bytes()).as_bytes())
    }

    /// The branch with this number.
    pub fn index(&self, index: u64) -> Self {
        let mut bytes = [0; 9];
        bytes[0] = b'#';
        bytes[1..].copy_from_slice(&index.to_le_bytes());
        Self(*blake3::keyed_hash(&self.0, &bytes).as_bytes())
    }

    /// The node that a stream started at, so that its owner can branch off further streams.
    pub fn of(stream: &Stream) -> Self {
        Self(stream.seed())
    }

    /// The random stream at this node, from its start.
    pub fn stream(&self) -> Stream {
        Stream::at(self.0, 0)
    }

    /// The random stream at this node, of which every draw takes at least 64 bits.
    pub fn wide_stream(&self) -> Stream {
        self.stream().widened()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    #[test]
    fn a_number_and_its_digits_name_different_streams() {
        let root = Seed::root(0);
        assert_ne!(root.index(1), root.child("1"));
        assert_ne!(root.child("a").child("b"), root.child("b").child("a"));
        assert_ne!(Seed::root(1).stream().next_u64(), Seed::root(2).stream().next_u64());
    }

    #[test]
    fn a_stream_knows_its_node_even_when_it_has_been_drawn_from() {
        let node = Seed::root(3).child("policy");
        let mut stream = node.stream();
        stream.next_u64();
        assert_eq!(Seed::of(&stream), node);
    }
}
