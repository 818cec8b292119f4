//! The road network of a town.
