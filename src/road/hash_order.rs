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
    let mut order: Vec<(u32, usize)> = Vec::new();
    let mut sizes = BUCKETS.iter();
    let mut buckets = 1;
    for (place, key) in keys.into_iter().enumerate() {
        if order.iter().any(|(other, _)| *other == key) {
            continue;
        }
        if order.len() + 1 > buckets as usize || buckets == 1 {
            // Beyond the list the order is that of the last size; no town is that large.
            buckets = sizes.next().copied().unwrap_or(buckets);
            let old = std::mem::take(&mut order);
            for each in old {
                put(&mut order, buckets, each);
            }
        }
        put(&mut order, buckets, (key, place));
    }
    order.into_iter().map(|(_, place)| place).collect()
}

/// Puts a number before the others in its bucket, or before all numbers if its bucket is empty.
fn put(order: &mut Vec<(u32, usize)>, buckets: u32, item: (u32, usize)) {
    let first = order.iter().position(|(key, _)| key % buckets == item.0 % buckets);
    order.insert(first.unwrap_or(0), item);
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
