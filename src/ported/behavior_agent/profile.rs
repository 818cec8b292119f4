use base::choice;

choice! {
    /// The driving profile of the agent.
    ///
    /// # Source
    /// CARLA `agents/navigation/behavior_types.py`, the same in all releases.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
    pub enum Profile {
        /// Slower and with more distance.
        Cautious = "cautious",
        /// CARLA's default.
        #[default]
        Normal = "normal",
        /// Faster and with less distance.
        Aggressive = "aggressive",
    }
}

/// The figures of a profile, in CARLA's units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ProfileTraits {
    /// Its maximum speed (km/h).
    pub max_speed: f64,
    /// Its speed below the limit (km/h).
    pub below_limit: f64,
    /// Its speed below that of a vehicle that is too close (km/h).
    pub speed_decrease: f64,
    /// Shortest time to collision with the vehicle ahead (s).
    pub safety_time: f64,
    /// Minimum reach of the obstacle test (m).
    pub min_reach: f64,
    /// Gap below which it makes an emergency stop (m).
    pub braking_distance: f64,
}

/// Minimum speed when following another vehicle at a sufficient distance (km/h).
const MIN_SPEED: f64 = 5.0;

impl ProfileTraits {
    /// The speed when following another vehicle at a gap (m), before the limit caps it; speeds in km/h.
    pub fn following_speed(&self, gap: f64, own: f64, other: f64) -> f64 {
        let closing = ((own - other) / 3.6).max(1.0);
        let time = gap / closing;
        if time > 0.0 && time < self.safety_time {
            (other - self.speed_decrease).max(0.0)
        } else if time >= self.safety_time && time < 2.0 * self.safety_time {
            other.max(MIN_SPEED)
        } else {
            f64::INFINITY
        }
    }
}

impl Profile {
    pub(super) const fn traits(self) -> ProfileTraits {
        let (max_speed, below_limit, speed_decrease, min_reach, braking_distance) = match self {
            Self::Cautious => (40.0, 6.0, 12.0, 12.0, 6.0),
            Self::Normal => (50.0, 3.0, 10.0, 10.0, 5.0),
            Self::Aggressive => (70.0, 1.0, 8.0, 8.0, 4.0),
        };
        ProfileTraits { max_speed, below_limit, speed_decrease, safety_time: 3.0, min_reach, braking_distance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bolder_profiles_brake_later() {
        let gaps = Profile::ALL.map(|profile| profile.traits().braking_distance);
        assert!(gaps.is_sorted_by(|a, b| a > b));
    }

    #[test]
    fn behind_a_vehicle_the_speed_depends_on_the_time_to_collision() {
        let normal = Profile::Normal.traits();
        assert_eq!(normal.following_speed(2.9, 20.0, 20.0), 10.0, "at least 1 m/s of closing is assumed");
        assert_eq!(normal.following_speed(7.0, 27.0, 9.0), 0.0, "5 m/s of closing: 1.4 s, and no negative speed");
        assert_eq!(normal.following_speed(16.0, 27.0, 9.0), 9.0);
        assert_eq!(normal.following_speed(5.0, 3.0, 3.0), 5.0);
        assert_eq!(normal.following_speed(31.0, 27.0, 9.0), f64::INFINITY);
    }
}
