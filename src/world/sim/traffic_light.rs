use road::TrafficLight;

/// The colour of a traffic light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightColour {
    /// Go.
    Green,
    /// Red follows soon.
    Yellow,
    /// Stop.
    Red,
}

/// Duration of each colour during a light's turn; the other lights of its group are red in the meantime.
///
/// # Source
/// CARLA `Traffic/TrafficLightController.h`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightCycle {
    /// Green (s).
    pub green: f64,
    /// Yellow (s).
    pub yellow: f64,
    /// Red before the next one's turn (s).
    pub red: f64,
}

impl Default for LightCycle {
    fn default() -> Self {
        Self { green: 10.0, yellow: 3.0, red: 2.0 }
    }
}

impl LightCycle {
    /// The length of one turn (s).
    pub fn turn(&self) -> f64 {
        self.green + self.yellow + self.red
    }

    /// The clock of all groups at this time (s) after their first turns started.
    pub fn clock(&self, time: f64) -> LightClock {
        let within = |turns: usize| {
            let period = self.turn() * turns.max(1) as f64;
            time - period * (time / period).floor()
        };
        LightClock { cycle: *self, time, within: std::array::from_fn(within) }
    }
}

/// A time in the cycles of all groups. Every light is queried at every tick, so the division is done once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightClock {
    cycle: LightCycle,
    time: f64,
    /// Time within the cycle of a group (s), by its number of turns.
    within: [f64; 5],
}

impl LightClock {
    /// The time since the first turns of all groups started (s).
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The clock this time (s) later.
    pub fn after(&self, time: f64) -> Self {
        self.cycle.clock(self.time + time)
    }

    /// The time after which a light shows the same colours again (s).
    pub fn period(&self, light: &TrafficLight) -> f64 {
        self.cycle.turn() * f64::from(light.turns.max(1))
    }

    pub fn colour(&self, light: &TrafficLight) -> LightColour {
        let turns = light.turns.max(1) as usize;
        let turn = self.cycle.turn();
        let within = self.within.get(turns).copied().unwrap_or_else(|| {
            let period = turn * turns as f64;
            self.time - period * (self.time / period).floor()
        });
        let since = within - turn * f64::from(light.turn);
        if since < 0.0 || since >= self.cycle.green + self.cycle.yellow {
            LightColour::Red
        } else if since < self.cycle.green {
            LightColour::Green
        } else {
            LightColour::Yellow
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use road::RoadIndex;
    use road::geometry::{OrientedBox, Pose};

    #[test]
    fn lights_of_a_group_take_turns() {
        let light = |turn| TrafficLight {
            signal: String::new(),
            group: 0,
            turn,
            turns: 3,
            road: RoadIndex(0),
            stop: Pose::default(),
            trigger: OrientedBox::new(Pose::default(), 1.5, 1.0),
        };
        let colour = |turn, time| LightCycle::default().clock(time).colour(&light(turn));
        assert_eq!(colour(0, 0.0), LightColour::Green);
        assert_eq!(colour(0, 10.0), LightColour::Yellow);
        assert_eq!(colour(0, 13.0), LightColour::Red);
        assert_eq!(colour(1, 15.0), LightColour::Green);
        assert_eq!(colour(0, 45.0), LightColour::Green);
        for tenth in 0..450 {
            let open = (0..3).filter(|turn| colour(*turn, f64::from(tenth) / 10.0) != LightColour::Red);
            assert!(open.count() <= 1, "never two at once");
        }
    }
}
