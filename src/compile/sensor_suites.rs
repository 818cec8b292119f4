//! Sensor suites of published drivers, as defaults of the keys of `sensors`. None of the figures was fitted to an outcome.
//!
//! "Documented" figures are in the agent's code or configuration. "Prior" ones are guesses with a stated basis; no measured
//! curve of either network's misses was found.

use std::f64::consts::PI;

use world::av::sensors::{Seam, Sector};

/// A kind of sensors.
pub struct Suite {
    /// Its word.
    pub name: &'static str,
    /// One or two sentences for the reference.
    pub doc: &'static str,
    /// Keys that differ from the form's defaults: the value, and the sentence for the reference with its source.
    pub figures: &'static [(&'static str, &'static str, &'static str)],
    /// The covered sectors.
    pub sectors: &'static [Sector],
    /// The directions in which more is missed.
    pub seams: &'static [Seam],
}

const fn sector(half_degrees: f64) -> Sector {
    Sector { facing: 0.0, width: half_degrees * PI / 90.0, range: None }
}

const fn seam(degrees: f64) -> Seam {
    Seam { facing: degrees * PI / 180.0, width: 6.0 * PI / 180.0, miss: 0.3 }
}

pub const SUITES: &[Suite] = &[
    Suite {
        name: "interfuser_suite",
        doc: "The eyes of InterFuser (opendilab/InterFuser 14ca80e): three cameras and a scanner on a map of 20 m by 20 m, 98 degrees to either side (documented).",
        figures: &[
            ("ahead", "18 m", "Its object map ends there (documented)."),
            ("behind", "2 m", "Its object map ends there (documented)."),
            ("aside", "10 m", "Its object map ends there (documented)."),
            ("eye", "1.3 m", "Place of its cameras (documented)."),
            ("update_rate", "10 Hz", "Its map is refreshed on even steps of 20 Hz (documented)."),
            ("latency", "0 s", "It runs synchronously (documented); real time would be 0 to 0.3 s."),
            ("least_visible", "0.3", "Share that must be visible (prior, 0.1 to 0.6)."),
            ("near", "10 m", "Distance up to which `miss_near` holds (prior)."),
            ("far", "18 m", "Distance from which `miss_far` holds: the end of its map (prior)."),
            ("miss_near", "0.02", "Rate of misses near by (prior, 0 to 0.1)."),
            ("miss_far", "0.15", "Rate of misses at the end of its map (prior, 0.05 to 0.4)."),
            ("miss_correlation", "0.3 s", "Correlation time of misses (prior, 0.1 to 1 s)."),
            ("position_noise", "0.15 m", "Standard deviation of the position (prior, 0 to 0.4 m)."),
            ("velocity_noise", "0.4 m/s", "Standard deviation of the speed (prior, 0 to 0.8 m/s)."),
            ("heading_noise", "15 deg", "Standard deviation of the heading (prior, 5 to 40 deg)."),
            ("noise_correlation", "0.3 s", "Correlation time of errors (assumed to be that of misses)."),
            (
                "speed_pull",
                "0.5",
                "Share of `walking_speed` in the believed speed: the network sees single frames (form from its issues 25 and 44, value prior).",
            ),
            ("confusion", "0.01", "Share of time for which a pedestrian is taken for a vehicle (prior, 0 to 0.1)."),
            ("confusion_correlation", "0.3 s", "Correlation time of that (assumed to be that of misses)."),
            ("false_alarms", "0.1 / 60 s", "0.1 a minute (prior, 0 to 2; its issues 25, 62, 76)."),
        ],
        sectors: &[sector(98.0)],
        seams: &[],
    },
    Suite {
        name: "lav_suite",
        doc: "The eyes of LAV (dotchen/LAV 12540bd): three cameras over 92 degrees to either side that meet at 30 degrees, and a scanner (documented).",
        figures: &[
            ("ahead", "70 m", "Its bird's-eye map ends there (documented)."),
            ("behind", "10 m", "Its bird's-eye map ends there (documented)."),
            ("aside", "40 m", "Its bird's-eye map ends there (documented)."),
            ("eye", "1.5 m", "Place of its cameras (documented)."),
            (
                "latency",
                "0.05 s",
                "Latency of its brake classifier (prior, 0 to 0.3 s; it runs on every tick of 20 Hz).",
            ),
            ("least_visible", "0.3", "Share that must be visible (prior, 0.1 to 0.6)."),
            ("near", "5 m", "Distance up to which `miss_near` holds (prior)."),
            ("far", "8.6 m", "Distance from which `miss_far` holds: where its training labels begin (prior)."),
            ("miss_near", "0.05", "Rate of misses near by (prior, 0 to 0.2)."),
            ("miss_far", "0.2", "Rate of misses far away (prior, 0.05 to 0.5)."),
            ("miss_correlation", "0.3 s", "Correlation time of misses (prior)."),
            ("velocity_noise", "0.5 m/s", "Standard deviation of the speed in its second version (prior)."),
            ("heading_noise", "30 deg", "Standard deviation of the heading (prior)."),
            ("noise_correlation", "0.3 s", "Correlation time of errors (assumed to be that of misses)."),
            ("confusion", "0.15", "Share of time for which a pedestrian is taken for a vehicle (prior, 0 to 0.5)."),
            ("confusion_correlation", "1 s", "Correlation time of that (prior, 0.5 to 2 s)."),
            ("confused_as", "both", "Its brake classifier and its vehicle map are separate channels (documented)."),
            ("confused_width", "0.75 m", "Width of that vehicle (prior: half of it 0.25 to 0.5 m)."),
            ("false_alarms", "0.2 / 60 s", "0.2 a minute (prior for its second version, 0 to 2)."),
        ],
        sectors: &[sector(92.0)],
        seams: &[seam(30.0), seam(-30.0)],
    },
    Suite {
        name: "behavior_agent_suite",
        doc: "What CARLA's BehaviorAgent has for eyes: the simulator's list of actors, exact and through walls (documented). It looks at vehicles within 45 m and pedestrians within 10 m itself.",
        figures: &[("range", "50 m", "More than the agent's own reach, so nothing is lost (documented: 45 m).")],
        sectors: &[],
        seams: &[],
    },
];
