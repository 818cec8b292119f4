use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Time between two beats.
const BEAT: Duration = Duration::from_secs(1);

/// Shows again and again how far something is, on a thread of its own, until nobody else holds it: an episode may take minutes and tell of nothing.
pub fn heartbeat<T: Send + 'static>(shown: &Arc<Mutex<T>>, beat: fn(&mut T)) {
    let shown = Arc::downgrade(shown);
    let run = move || {
        loop {
            std::thread::sleep(BEAT);
            let Some(shown) = shown.upgrade() else { return };
            beat(&mut shown.lock().unwrap_or_else(PoisonError::into_inner));
        }
    };
    // Without a thread to spare there are fewer lines.
    let _ = std::thread::Builder::new().spawn(run);
}
