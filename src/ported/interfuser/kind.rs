use super::{InterFuser, Settings, TrackerMode};
use base::signature::{Arguments, Param, Signature, Type};
use base::units::Dimension;

impl InterFuser {
    /// Its keys in a scenario.
    pub fn signature() -> Signature {
        // The tests of the planner are within an image of 36 m.
        let room = Type::Quantity { dimension: Dimension::LENGTH, min: 0.0, max: 36.0 };
        let margin = |name, default, doc| Param::with_default(name, room.clone(), default, doc);
        Signature::new(
            "interfuser",
            "InterFuser, a surrogate. Without `sensors` it sees everybody in its range, through walls too. Made for `mkz_2017` and ticks of 0.05 s.",
            vec![
                Param::with_default(
                    "tracker",
                    Type::Choice(&["published", "fixed_speed", "off"]),
                    "published",
                    "How speeds are corrected over time: as published, where they become about the heading in half turns; as was meant; or not at all.",
                ),
                Param::with_default(
                    "max_speed",
                    Type::positive(Dimension::SPEED),
                    "5 m/s",
                    "The greatest speed that it wants; it does not know speed limits.",
                ),
                margin("margin_ahead", "2.5 m", "Room that is added to half the car's length when its way is tested."),
                margin("margin_aside", "1.2 m", "Room that is added to half the car's width when its way is tested."),
                Param::with_default(
                    "overlap",
                    Type::share(),
                    "0.04",
                    "Share of the tested box that an actor must cover to be in the way.",
                ),
            ],
        )
        .made_for(0.05)
        .surrogate(
            "Exact: its published tracker, forecast, planner and controller, slips included. Assumed: its network, which is not run; the object map that it is trained to give is drawn from what is perceived. So its rates show the limits of the planner and not the mistakes of the network.",
        )
    }

    /// Makes one from checked arguments.
    pub fn from_arguments(arguments: &Arguments) -> Self {
        Self::new(&Settings {
            tracker: match arguments.choice("tracker") {
                "fixed_speed" => TrackerMode::FixedSpeed,
                "off" => TrackerMode::Off,
                _ => TrackerMode::Published,
            },
            max_speed: arguments.number("max_speed"),
            margin: [arguments.number("margin_ahead"), arguments.number("margin_aside")],
            overlap: arguments.number("overlap"),
            ..Settings::default()
        })
    }
}
