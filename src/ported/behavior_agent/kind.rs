use super::{AgentConfig, AtDestination, BehaviorAgent, Profile, Quirks, Release, WayFinding};
use base::signature::{Arguments, Param, Signature, Type};
use world::road::ForkRule;

const RELEASES: &[&str] = &["0.9.10.1", "0.9.11", "0.9.12", "0.9.13", "0.9.14", "0.9.15"];
const ROUTES: &[&str] = &["any_branch", "carla_wander", "destination"];
const PROFILES: &[&str] = &["cautious", "normal", "aggressive"];

impl BehaviorAgent {
    /// Its keys in a scenario.
    pub fn signature() -> Signature {
        let quirk = |name, doc| Param::with_default(name, Type::Boolean, "true", doc);
        Signature::new(
            "behavior_agent",
            "CARLA's BehaviorAgent, with its accidents; each can be switched off.",
            vec![
                Param::with_default(
                    "release",
                    Type::Choice(RELEASES),
                    "\"0.9.15\"",
                    "The release of CARLA; 0.9.10.1 drives as 0.9.11, 0.9.14 as 0.9.15.",
                ),
                Param::with_default("profile", Type::Choice(PROFILES), "normal", "How boldly it drives."),
                Param::with_default(
                    "route",
                    Type::Choice(ROUTES),
                    "any_branch",
                    "Which way it takes: any at each fork; at each fork as CARLA's planner without a destination does, which in Town01 and Town02 is always the first; or to a destination drawn anywhere in the town, by the route that CARLA's planner finds.",
                ),
                Param::with_default(
                    "at_destination",
                    Type::Choice(&["next", "stop"]),
                    "next",
                    "With `route: destination`, whether it drives on to a next destination, as in CARLA's example scripts, or brakes and stays.",
                ),
                quirk(
                    "half_length_twice",
                    "Half the ego's length is subtracted from distances that begin at the bumper (Q1).",
                ),
                quirk("lane_blind", "Actors outside the ego's lane are invisible (Q2)."),
                quirk("zigzag", "In junctions the route is compared as a zig-zag with holes (Q3)."),
                quirk("vehicles_for_walkers", "Without a walker near by, the walker step looks at vehicles (Q4)."),
                quirk("first_hit", "The first obstacle found counts, not the nearest (Q5)."),
                quirk("frozen_stop", "An emergency stop straightens the wheels and freezes the planner (Q6)."),
                quirk("blind_dead_ahead", "An actor exactly dead ahead is not seen (Q7)."),
                quirk("weak_brake", "An emergency stop uses half of the brake (Q8)."),
                quirk("rear_point", "An obstacle is measured at its back (Q10)."),
            ],
        )
        .made_for(0.05)
    }

    /// Makes one from checked arguments.
    pub fn from_arguments(arguments: &Arguments) -> Self {
        let on = |key: &str| arguments.boolean(key);
        Self::new(AgentConfig {
            release: match arguments.choice("release") {
                "0.9.10.1" | "0.9.11" => Release::V0_9_11,
                "0.9.12" => Release::V0_9_12,
                "0.9.13" => Release::V0_9_13,
                _ => Release::V0_9_15,
            },
            profile: match arguments.choice("profile") {
                "cautious" => Profile::Cautious,
                "aggressive" => Profile::Aggressive,
                _ => Profile::Normal,
            },
            way: match arguments.choice("route") {
                "carla_wander" => WayFinding::Wander(ForkRule::NamedTurn),
                "destination" => WayFinding::Destination(match arguments.choice("at_destination") {
                    "stop" => AtDestination::Stop,
                    _ => AtDestination::Next,
                }),
                _ => WayFinding::Wander(ForkRule::AnyBranch),
            },
            quirks: Quirks {
                half_length_twice: on("half_length_twice"),
                lane_blind: on("lane_blind"),
                zigzag: on("zigzag"),
                vehicles_for_walkers: on("vehicles_for_walkers"),
                first_hit: on("first_hit"),
                frozen_stop: on("frozen_stop"),
                blind_dead_ahead: on("blind_dead_ahead"),
                weak_brake: on("weak_brake"),
                rear_point: on("rear_point"),
            },
        })
    }
}
