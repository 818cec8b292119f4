//! The moving world: vehicles, walkers and their contact, one tick at a time.
