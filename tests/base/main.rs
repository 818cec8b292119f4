//! Distributions, formulas and statistics: closed forms, properties and recordings.

mod recorded;

mod distributions;
mod formulas;
mod means;
mod numbers;
mod proportions;
mod samples;
