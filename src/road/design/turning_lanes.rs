use std::f64::consts::FRAC_PI_4;

/// A way out of a junction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Exit {
    /// The turn of the way (rad), positive to the left.
    pub turn: f64,
    /// Number of lanes that lead away, at least one.
    pub lanes: u32,
}

/// The ways of the lanes of one approach, at least one, through a junction: for each exit the pairs of lanes (of the approach, of the exit), counted from the
/// left, from 1 on.
///
/// The exits are given from the rightmost to the leftmost. The exit within 45 degrees of straight ahead that is most nearly so is *straight on*;
/// those before it are on the right, those after it on the left. Cars turn right from the rightmost lane into the rightmost lane, and left from
/// the leftmost into the leftmost. All lanes lead straight on as far as the exit has lanes for them; the others only turn. Where no exit is
/// straight on, the lanes are divided. Every lane of the approach has a way, and ways of one approach do not cross.
pub(super) fn lane_pairs(lanes: u32, exits: &[Exit]) -> Vec<Vec<(u32, u32)>> {
    let ahead = exits.iter().enumerate().filter(|(_, exit)| exit.turn.abs() < FRAC_PI_4);
    let straight = ahead.min_by(|(_, a), (_, b)| a.turn.abs().total_cmp(&b.turn.abs())).map(|(index, _)| index);
    let is_left = |index: usize, exit: &Exit| straight.map_or(exit.turn > 0.0, |straight| index > straight);
    let numbered = || exits.iter().enumerate().filter(|(index, _)| Some(*index) != straight);
    let (has_left, has_right) =
        (numbered().any(|(index, exit)| is_left(index, exit)), numbered().any(|(index, exit)| !is_left(index, exit)));
    // Lanes that have no lane straight on.
    let surplus = straight.map_or(0, |straight| lanes.saturating_sub(exits[straight].lanes));
    let none = std::ops::RangeInclusive::new(1, 0);
    // The last lane that turns left, the first one that turns right, and the lanes that lead straight on.
    let (left, right, on) = match (straight, has_left, has_right) {
        (None, true, true) => (lanes.div_euclid(2).max(1), lanes.div_euclid(2) + 1, none),
        (None, _, _) => (lanes, 1, none),
        (Some(_), true, _) => (surplus.max(1), lanes, surplus + 1..=lanes),
        (Some(_), false, true) => (0, (lanes - surplus + 1).min(lanes), 1..=lanes - surplus),
        (Some(_), false, false) => (0, lanes + 1, 1..=lanes),
    };
    let from_left = |lane: u32, exit: &Exit| (lane, lane.min(exit.lanes));
    let from_right = |lane: u32, last: u32, exit: &Exit| (lane, exit.lanes.saturating_sub(last - lane).max(1));
    let pairs = |(index, exit): (usize, &Exit)| {
        if Some(index) == straight {
            on.clone().map(|lane| from_right(lane, *on.end(), exit)).collect()
        } else if is_left(index, exit) {
            (1..=left).map(|lane| from_left(lane, exit)).collect()
        } else {
            (right..=lanes).map(|lane| from_right(lane, lanes, exit)).collect()
        }
    };
    exits.iter().enumerate().map(pairs).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use proptest::prelude::*;

    use super::*;

    const RIGHT: f64 = -FRAC_PI_2;
    const LEFT: f64 = FRAC_PI_2;

    fn pairs(lanes: u32, exits: &[(f64, u32)]) -> Vec<Vec<(u32, u32)>> {
        let exits: Vec<Exit> = exits.iter().map(|&(turn, lanes)| Exit { turn, lanes }).collect();
        lane_pairs(lanes, &exits)
    }

    #[test]
    fn one_lane_leads_everywhere() {
        assert_eq!(pairs(1, &[(RIGHT, 1), (0.0, 1), (LEFT, 1)]), [[(1, 1)], [(1, 1)], [(1, 1)]]);
        // Right and straight on into the rightmost lane, left into the leftmost.
        assert_eq!(pairs(1, &[(RIGHT, 2), (0.0, 3), (LEFT, 2)]), [[(1, 2)], [(1, 3)], [(1, 1)]]);
    }

    #[test]
    fn outer_lanes_turn_and_all_lead_straight_on() {
        let four = pairs(2, &[(RIGHT, 2), (0.0, 2), (LEFT, 2)]);
        assert_eq!(four, [vec![(2, 2)], vec![(1, 1), (2, 2)], vec![(1, 1)]]);
        assert_eq!(pairs(2, &[(0.3, 2), (LEFT, 1)]), [vec![(1, 1), (2, 2)], vec![(1, 1)]]);
        assert_eq!(pairs(3, &[(RIGHT, 1), (-0.3, 3)]), [vec![(3, 1)], vec![(1, 1), (2, 2), (3, 3)]]);
    }

    #[test]
    fn lanes_without_one_straight_on_turn_or_merge() {
        assert_eq!(pairs(2, &[(RIGHT, 1), (0.0, 1), (LEFT, 1)]), [[(2, 1)], [(2, 1)], [(1, 1)]]);
        assert_eq!(pairs(2, &[(RIGHT, 1), (0.0, 1)]), [[(2, 1)], [(1, 1)]]);
        assert_eq!(pairs(2, &[(0.0, 1)]), [[(1, 1), (2, 1)]]);
    }

    #[test]
    fn lanes_are_divided_at_the_foot_of_a_t() {
        assert_eq!(pairs(2, &[(RIGHT, 2), (LEFT, 2)]), [[(2, 2)], [(1, 1)]]);
        assert_eq!(pairs(3, &[(RIGHT, 2), (LEFT, 1)]), [vec![(2, 1), (3, 2)], vec![(1, 1)]]);
        assert_eq!(pairs(2, &[(LEFT, 1)]), [[(1, 1), (2, 1)]]);
        assert_eq!(pairs(2, &[(RIGHT, 3)]), [[(1, 2), (2, 3)]]);
    }

    proptest! {
        #[test]
        fn every_lane_has_a_way_and_no_two_cross(
            lanes in 1..=4u32,
            mut exits in prop::collection::vec((-2.6..2.6f64, 1..=4u32), 1..=3),
        ) {
            exits.sort_by(|a, b| a.0.total_cmp(&b.0));
            let found = pairs(lanes, &exits);
            for lane in 1..=lanes {
                prop_assert!(found.iter().flatten().any(|pair| pair.0 == lane), "{lane}: {found:?}");
            }
            for (ways, (_, out)) in found.iter().zip(&exits) {
                prop_assert!(!ways.is_empty() && ways.iter().all(|pair| (1..=*out).contains(&pair.1)), "{found:?}");
                prop_assert!(ways.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 <= pair[1].1), "{found:?}");
            }
            // An exit farther to the left takes lanes no farther to the right.
            let ends = |ways: &[(u32, u32)]| (ways.first().unwrap().0, ways.last().unwrap().0);
            for pair in found.windows(2) {
                let (right, left) = (ends(&pair[0]), ends(&pair[1]));
                prop_assert!(left.0 <= right.0 && left.1 <= right.1, "{found:?}");
            }
        }
    }
}
