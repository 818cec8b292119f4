//! Driving policies: what the car under test does with what it perceives.
