//! The simulated world: closed forms, properties, and recordings of independent programs.

mod sensor_noise;
mod reference_drivers;
mod walking;
mod vehicles;
mod levels;
