use crate::road::TrafficLight;

/// What a traffic light shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightColour {
    /// Go.
    Green,
    /// About to turn red.
    Yellow,
    /// Stop.
    Red,
}

/// How long a light shows what, when it is its turn; the others of its group show red meanwhile.
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

    /// What a light shows so long (s) after its group's first turn began.
    pub fn colour(&self, light: &TrafficLight, time: f64) -> LightColour {
        let turn = self.turn();
        let period = turn * f64::from(light.turns.max(1));
        // Dividing is much cheaper than `rem_euclid`, and every light is asked at every tick.
        let since = time - period * (time / period).floor() - turn * f64::from(light.turn);
        if since < 0.0 || since >= self.green + self.yellow {
            LightColour::Red
        } else if since < self.green {
            LightColour::Green
        } else {
            LightColour::Yellow
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{OrientedBox, Pose};
    use crate::road::RoadIndex;

    #[test]
    fn lights_of_a_group_take_turns() {
        let light = |turn| TrafficLight {
            group: 0,
            turn,
            turns: 3,
            road: RoadIndex(0),
            stop: Pose::default(),
            trigger: OrientedBox::new(Pose::default(), 1.5, 1.0),
        };
        let cycle = LightCycle::default();
        assert_eq!(cycle.colour(&light(0), 0.0), LightColour::Green);
        assert_eq!(cycle.colour(&light(0), 10.0), LightColour::Yellow);
        assert_eq!(cycle.colour(&light(0), 13.0), LightColour::Red);
        assert_eq!(cycle.colour(&light(1), 15.0), LightColour::Green);
        assert_eq!(cycle.colour(&light(0), 45.0), LightColour::Green);
        for tenth in 0..450 {
            let open = (0..3).filter(|turn| cycle.colour(&light(*turn), f64::from(tenth) / 10.0) != LightColour::Red);
            assert!(open.count() <= 1, "never two at once");
        }
    }
}
