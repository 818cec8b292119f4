//! How large the random samples of the tests are.

/// The number of samples: `all` if `FALSIFY_LARGE_SAMPLES` is set, as in a piece of `.ci/run`, otherwise `few`.
pub fn samples(few: usize, all: usize) -> usize {
    if std::env::var_os("FALSIFY_LARGE_SAMPLES").is_some() { all } else { few }
}
