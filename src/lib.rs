//! falsify
pub mod diagnostic;
pub mod geometry;
pub mod lang;
pub mod seed;
pub mod signature;
pub mod units;
