//! Work on all threads of the present rayon pool.

use std::sync::atomic::{AtomicUsize, Ordering};

/// What a function makes of each item, in the order of the items.
///
/// Each thread takes one item after the other, so its stack holds one of them. A thread of rayon's iterators takes further items while it waits for the
/// other half of a join, one on top of the other, and long work on many items overflows its stack.
///
/// # Panics
/// As the function does.
pub fn map<T: Sync, R: Send>(items: &[T], of: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let take = |_: rayon::BroadcastContext<'_>| {
        let places = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        places.map_while(|place| Some((place, of(items.get(place)?)))).collect::<Vec<_>>()
    };
    let mut made: Vec<(usize, R)> = rayon::broadcast(take).into_iter().flatten().collect();
    made.sort_unstable_by_key(|(place, _)| *place);
    made.into_iter().map(|(_, made)| made).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    use std::cell::Cell;

    thread_local! {
        static HELD: Cell<u32> = const { Cell::new(0) };
    }

    #[test]
    fn a_thread_holds_one_item_at_a_time() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
        let items: Vec<u64> = (0..2_000).collect();
        // While a thread waits for the other half of a join, it takes what lies ready.
        let of = |item: &u64| {
            let held = HELD.replace(HELD.get() + 1) + 1;
            rayon::join(std::thread::yield_now, std::thread::yield_now);
            HELD.set(HELD.get() - 1);
            (*item, held)
        };
        let made = pool.install(|| map(&items, of));
        assert!(made.iter().zip(&items).all(|((made, held), item)| made == item && *held == 1));
        assert_eq!(made.len(), items.len());
    }
}
