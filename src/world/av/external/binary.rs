//! The messages after the greeting as 64-bit floats, low byte first, with their length in bytes before them as `u32`.

use super::message::{Choice, Decision, Pedals, Revision};
use crate::av::view::{Kind, LaneAhead, View};
use crate::av::{DrivingMode, Fault};
use road::GiveWay;
use road::geometry::Pose;

/// Numbers of an action: id, throttle or acceleration, brake, steer or the angle of the front wheels.
const ACTION: usize = 4;

/// The greatest numbers of actors and route points of a world; with them every world takes the same number of bytes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Room {
    pub actors: usize,
    pub points: usize,
}

/// Appends a world to a request; the seed is −1 except at the start of an episode. From revision 2 on the ids of the actors and the lanes follow.
pub(super) fn write_world(
    out: &mut Vec<u8>,
    id: u32,
    tick: u32,
    seed: Option<u64>,
    view: &View,
    room: Room,
    revision: Revision,
) {
    let mut put = |number: f64| out.extend_from_slice(&number.to_le_bytes());
    let (light, distance) = view.light_numbers();
    let (sign, line) = view.sign.map_or((0.0, 0.0), |sign| {
        let kind = match sign.kind {
            GiveWay::Stop => 1.0,
            GiveWay::Yield => 2.0,
        };
        (kind, sign.distance)
    });
    put(f64::from(id));
    put(f64::from(tick));
    put(seed.map_or(-1.0, |seed| seed as f64));
    let Pose { x, y, yaw } = view.ego;
    [x, y, yaw, view.speed, view.speed_limit, light, distance, sign, line].into_iter().for_each(&mut put);
    put(view.actors.len() as f64);
    put(view.route.len() as f64);
    for place in 0..room.actors {
        let numbers = view.actors.get(place).map_or([0.0; 8], |seen| {
            let kind = match seen.kind {
                Kind::Pedestrian => 1.0,
                Kind::Vehicle => 2.0,
            };
            let Pose { x, y, yaw } = seen.pose;
            [kind, x, y, yaw, seen.velocity.x, seen.velocity.y, 2.0 * seen.half.x, 2.0 * seen.half.y]
        });
        numbers.into_iter().for_each(&mut put);
    }
    for place in 0..room.points {
        let numbers = view.route.get(place).map_or([0.0; 3], |pose| [pose.x, pose.y, pose.yaw]);
        numbers.into_iter().for_each(&mut put);
    }
    if revision < Revision::Second {
        return;
    }
    for place in 0..room.actors {
        put(view.actors.get(place).map_or(0.0, |seen| f64::from(seen.id)));
    }
    for place in 0..room.points {
        let numbers = view.lanes.get(place).map_or([0.0; 5], |ahead| {
            let LaneAhead { width, left, right, is_junction, speed_limit } = *ahead;
            [width, f64::from(left), f64::from(right), f64::from(u8::from(is_junction)), speed_limit]
        });
        numbers.into_iter().for_each(&mut put);
    }
}

/// Length in bytes of the answer for this number of worlds.
pub(super) fn answer_length(worlds: usize) -> usize {
    worlds * ACTION * size_of::<f64>()
}

/// Reads a driver's decisions for the requested worlds, in their order.
///
/// # Errors
/// The answer is for other worlds, or in another order.
pub(super) fn read_decisions(
    answer: &[u8],
    asked: &[u32],
    (control, is_angle): (Pedals, bool),
    decisions: &mut Vec<Decision>,
) -> Result<(), Fault> {
    decisions.clear();
    for (id, bytes) in asked.iter().zip(answer.as_chunks::<{ ACTION * size_of::<f64>() }>().0) {
        let [own, first, second, turn] = std::array::from_fn(|place| {
            f64::from_le_bytes(std::array::from_fn(|byte| bytes[place * size_of::<f64>() + byte]))
        });
        if own != f64::from(*id) {
            return Err(Fault::Answer("worlds in another order than asked"));
        }
        let pedals = match control {
            Pedals::Pedals => Choice::Pedals { throttle: first, brake: second },
            Pedals::Acceleration => Choice::Acceleration(first),
        };
        let (steer, wheel_angle) = if is_angle { (0.0, Some(turn)) } else { (turn, None) };
        decisions.push(Decision { pedals, steer, wheel_angle, mode: DrivingMode::Unknown }.finite()?);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A change of these numbers is a change of the protocol and needs a new version or description.
    #[test]
    fn a_world_is_written_as_the_protocol_says() {
        let view = View { light: None, ..View::example() };
        let numbers = |revision| {
            let (mut bytes, room) = (Vec::new(), Room { actors: 2, points: 2 });
            write_world(&mut bytes, 7, 0, Some(99), &view, room, revision);
            bytes.as_chunks().0.iter().map(|number| f64::from_le_bytes(*number)).collect::<Vec<_>>()
        };
        let first = numbers(Revision::First);
        assert_eq!(first[..8], [7.0, 0.0, 99.0, 1.0, 2.0, 0.5, 8.0, 10.0]);
        assert_eq!(first[8..14], [0.0, 0.0, 1.0, 12.5, 1.0, 1.0]);
        assert_eq!(first[14..22], [1.0, 12.0, 1.5, -1.5, 0.0, -1.25, 0.5, 0.5]);
        assert_eq!(first[22..], [[0.0; 8].as_slice(), &[3.0, 4.0, 0.25, 0.0, 0.0, 0.0]].concat());
        let second = numbers(Revision::Second);
        assert_eq!(second[..first.len()], first, "what is new comes last");
        assert_eq!(second[first.len()..], [3.0, 0.0, 3.5, 1.0, 0.0, 1.0, 8.5, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }
}
