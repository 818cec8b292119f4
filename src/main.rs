//! falsify
fn main() {}
