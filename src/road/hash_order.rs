use std::collections::BTreeSet;

/// The bucket counts of a libstdc++ hash table as it grows; each step about doubles it.
///
/// # Source
/// libstdc++, `__detail::_Prime_rehash_policy`: the first prime from its list that is at least twice the last one.
const BUCKETS: [u32; 16] =
    [13, 29, 59, 127, 257, 541, 1109, 2357, 5087, 10273, 20753, 42043, 85229, 172_933, 351_061, 712_697];

/// The order in which an `unordered_map` of libstdc++ returns whole numbers that were inserted one after the other.
///
/// CARLA stores roads and the connections of a junction in such maps. This is therefore the order of its topology and of
/// the branches at a fork. Returns indices into `keys`; repeated numbers are dropped.
pub(super) fn hash_order(keys: impl IntoIterator<Item = u32>) -> Vec<usize> {
    let mut table = HashTable { items: Vec::new(), next: Vec::new(), first: None, before: vec![None] };
    let mut sizes = BUCKETS.iter();
    let mut known = BTreeSet::new();
    for (place, key) in keys.into_iter().enumerate() {
        if !known.insert(key) {
            continue;
        }
        if table.items.len() + 1 > table.before.len() || table.before.len() == 1 {
            // Beyond the list the order is that of the last size; no town is that large.
            table.grow(sizes.next().map_or(table.before.len(), |size| *size as usize));
        }
        table.items.push((key, place));
        table.next.push(None);
        table.put(table.items.len() - 1);
    }
    table.order().map(|item| table.items[item].1).collect()
}

/// A hash table whose items are one list, in which those of a bucket are neighbours.
struct HashTable {
    items: Vec<(u32, usize)>,
    /// The item after each.
    next: Vec<Option<usize>>,
    first: Option<usize>,
    /// For each bucket with items the item before its first one, if there is any.
    before: Vec<Option<Before>>,
}

#[derive(Clone, Copy)]
enum Before {
    Start,
    Item(usize),
}

impl HashTable {
    fn bucket(&self, item: usize) -> usize {
        self.items[item].0 as usize % self.before.len()
    }

    /// Puts an item before the others in its bucket, or before all items if its bucket is empty.
    fn put(&mut self, item: usize) {
        let bucket = self.bucket(item);
        match self.before[bucket] {
            Some(Before::Item(before)) => {
                self.next[item] = self.next[before];
                self.next[before] = Some(item);
            }
            Some(Before::Start) => {
                self.next[item] = self.first;
                self.first = Some(item);
            }
            None => {
                self.next[item] = self.first;
                self.first = Some(item);
                if let Some(next) = self.next[item] {
                    let bucket = self.bucket(next);
                    self.before[bucket] = Some(Before::Item(item));
                }
                self.before[bucket] = Some(Before::Start);
            }
        }
    }

    fn grow(&mut self, buckets: usize) {
        let order: Vec<usize> = self.order().collect();
        self.before = vec![None; buckets];
        self.first = None;
        for item in order {
            self.put(item);
        }
    }

    fn order(&self) -> impl Iterator<Item = usize> {
        std::iter::successors(self.first, |item| self.next[*item])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_numbers_come_back_last_first() {
        assert_eq!(hash_order([0, 1, 2, 7]), [3, 2, 1, 0]);
        assert_eq!(hash_order([5]), [0]);
        assert!(hash_order([]).is_empty());
    }

    /// The output of g++ 12 for the same insertions.
    #[test]
    fn numbers_share_buckets_and_the_table_grows() {
        let keys = [0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16];
        let order: Vec<u32> = hash_order(keys).into_iter().map(|place| keys[place]).collect();
        assert_eq!(order, [16, 15, 14, 0, 13, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12]);
        let keys = [1, 14, 27, 2, 2];
        let order: Vec<u32> = hash_order(keys).into_iter().map(|place| keys[place]).collect();
        assert_eq!(order, [2, 27, 14, 1]);
    }
}
