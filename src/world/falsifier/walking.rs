use super::{
    Falsifier, Homing, Intercept, Natural, Random, RecordedWalking, Scripted, Simulator, TrainError, WalkPolicy,
};
use base::seed::Seed;
use base::signature::{Arguments, Param, Signature, Type};

/// A walk policy that does not learn, as a falsifier: it runs one episode from every start.
#[derive(Debug, Clone, Copy)]
pub struct Walking<W> {
    walker: W,
}

impl Walking<Random> {
    /// Its keys in a scenario.
    pub fn signature() -> Signature {
        Signature::new("random", "Draws every command uniformly: the floor that every search must beat.", Vec::new())
    }
}

impl Walking<Homing> {
    /// Its keys in a scenario.
    pub fn signature() -> Signature {
        Signature::new("homing", "Walks straight at the ego, as fast as it can.", Vec::new())
    }
}

impl Walking<Intercept> {
    /// Its keys in a scenario.
    pub fn signature() -> Signature {
        Signature::new("intercept", "Walks to where it would meet an ego that keeps its velocity.", Vec::new())
    }
}

impl Walking<Scripted> {
    /// Its keys in a scenario.
    pub fn signature() -> Signature {
        let doc = "Walks as the test of the spawn rule (`crossing_test`, `along_test`) or its path (`given_path`) states: the nominal case beside searches.";
        Signature::new("scripted", doc, Vec::new())
    }
}

impl Walking<Natural> {
    /// Its keys in a scenario.
    pub fn signature() -> Signature {
        Signature::new(
            "natural",
            "Crosses before the car as recorded pedestrians do. Its speed, its accepted gap, and its changes of speed and direction are drawn from their distributions.",
            vec![
                Param::with_default(
                    "changes",
                    Type::Choice(&["dut", "vru"]),
                    "dut",
                    "Recording of the changes of speed and direction within a second: DUT (beside cars on a campus), or VRU (an urban junction), where they are twice as large.",
                ),
                Param::with_default(
                    "heed",
                    Type::share(),
                    "100 percent",
                    "Share of the pedestrians that wait until the gap before the car is large enough for them; the others set off at once.",
                ),
            ],
        )
    }

    /// Makes one from checked arguments.
    pub fn natural(arguments: &Arguments) -> Self {
        let walking = if arguments.choice("changes") == "vru" { RecordedWalking::VRU } else { RecordedWalking::DUT };
        Self::new(Natural::new(walking, arguments.number("heed")))
    }
}

impl<W> Walking<W> {
    /// Makes a falsifier of a walk policy.
    pub fn new(walker: W) -> Self {
        Self { walker }
    }
}

impl<W: WalkPolicy + Clone + std::fmt::Debug + Send + Sync + 'static> Falsifier for Walking<W> {
    fn search(&self, simulator: &mut Simulator<'_>, seed: &Seed) -> Result<Option<Box<dyn WalkPolicy>>, TrainError> {
        let mut walker = self.walker.clone();
        for start in 0.. {
            if !simulator.begin(start) {
                break;
            }
            walker.begin(seed.index(start).stream());
            simulator.finish(|env, commands| walker.choose(env, commands));
        }
        Ok(Some(Box::new(walker)))
    }

    fn walk_policy(&self) -> Option<Box<dyn WalkPolicy>> {
        Some(Box::new(self.walker.clone()))
    }
}
